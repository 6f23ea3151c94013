"""Graders: scores of episodes between a ceiling (the oracle) and a floor (silence), with a liar as canary.

`python -m llf_teacher.integrations.openenv.graders` prints a line for each environment, and exits with 1 if a score is
where it must not be. `--canaries FILE` writes the canary's actions. An episode's score is based on its regret, since in
some environments an unfinished task has the greatest reward.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from statistics import fmean

import typer

from llf_teacher.episodes.record import Record
from llf_teacher.registry import PREFIX
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from pz_envs.family import all_families

ROLES = {"ceiling": ("oracle", "oracle"), "floor": ("silent", "text_only"), "canary": ("mistake(eps=1)", "text_only")}
"""Teacher and student of each reference. In the last two the student does what the teacher's words say."""
HALF = 0.5
"""The canary's score must be below this: nearer to the floor than to the ceiling."""
SEEDS, TURNS = 3, 5
"""Number of episodes of a reference, and of turns in a written canary."""


def records(id: str, role: str, seeds: int = SEEDS, max_turns: int | None = None) -> Iterator[Record]:
    """The episodes of a reference."""
    teacher, student = ROLES[role]
    study = Study(ids=[id], teachers=[teacher], students=[student], seeds=seeds, max_turns=max_turns)
    return map(play, study.episodes())


def regrets(id: str, seeds: int = SEEDS) -> dict[str, float]:
    """The mean regret of each reference."""
    return {role: fmean(record.episode.regret for record in records(id, role, seeds)) for role in ROLES}


def score(regret: float, references: dict[str, float]) -> float:
    """The score of an episode by its regret: 1 at the ceiling, 0 at the floor, less than 0 below it."""
    ceiling, floor = references["ceiling"], references["floor"]
    return (floor - regret) / (floor - ceiling)


def canaries() -> Iterator[dict[str, object]]:
    """For each family a short episode of the canary: `id`, `seed`, `max_turns`, `actions` as text, total `reward`."""
    for family in all_families():
        id = f"{PREFIX}{family.showcase[0]}"
        (record,) = records(id, "canary", 1, TURNS)
        actions = [turn.action_words or turn.action for turn in record.turns[1:]]
        reward = record.episode.total_reward
        yield {"id": id, "seed": record.spec.seed, "max_turns": TURNS, "actions": actions, "reward": reward}


def main(arguments: list[str] | None = None) -> int:
    """Grade the environments, by default a showcase of each family."""
    parser = argparse.ArgumentParser(prog="python -m llf_teacher.integrations.openenv.graders")
    parser.add_argument("ids", nargs="*", help="ids of `llf list`")
    parser.add_argument("--canaries", type=Path, help="write the canary's actions to this file, and grade nothing")
    given = parser.parse_args(arguments)
    if given.canaries:
        given.canaries.write_text("".join(f"{json.dumps(each)}\n" for each in canaries()), "utf-8")
        return 0
    wrong = 0
    for id in given.ids or [f"{PREFIX}{family.showcase[0]}" for family in all_families()]:
        found = regrets(id)
        fine = found["ceiling"] < found["floor"] and score(found["canary"], found) < HALF
        wrong += not fine
        parts = (f"{role} {regret:.4g}" for role, regret in found.items())
        typer.echo(f"{'ok' if fine else 'WRONG'}  {id}: mean regret of {', '.join(parts)}")
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
