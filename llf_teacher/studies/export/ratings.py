"""ratings: the teacher's rating of each action, as TAMER's trainers give them, with the truth beside."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.serialization import write_json_lines
from llf_teacher.studies.export.dialogue import action_text, facts
from llf_teacher.studies.results import Results
from teachers.atoms import HN, HP, Label, R

_SAME = 1e-9  # smaller regrets are rounding
_EQUAL = "common.NoDifference"
_SIGNS = {HP: 1, HN: -1}


class Rating(NamedTuple):
    """What a teacher said of an action when it was taken, and the truth."""

    rating: int | None
    """1: more praise than blame, -1: less, 0: as much, or no difference; None: the teacher did not say."""
    stated_reward: float | None
    """The reward that the teacher stated; None if it stated none."""
    true_rating: int
    """1 if the action lost nothing, else -1."""
    regret: float
    """What it lost, in the family's unit."""
    reward: float
    """What the world paid."""
    said: list[dict[str, Any]]
    """The verdicts and the rewards that were said, each with its label, and whether it holds."""


def rating_of(turn: dict[str, Any]) -> Rating:
    """The rating of the action of a turn, from the words that came right after it; placebos do not count.

    Late words are about an earlier action, and count for this one, as a trainer of people would take them.
    """
    verdicts = [each for each in turn["atoms"] if each["kind"] in _SIGNS and each["label"] != Label.PLACEBO]
    stated = [each for each in turn["atoms"] if each["kind"] == R and "reward" in each["fields"]]
    balance = sum(0 if each["claim"] == _EQUAL else _SIGNS[each["kind"]] for each in verdicts)
    names = ("kind", "text", "about_turn", "holds", "label")
    return Rating(
        rating=(balance > 0) - (balance < 0) if verdicts else None,
        stated_reward=stated[-1]["fields"]["reward"] if stated else None,
        true_rating=1 if turn["regret"] < _SAME else -1,
        regret=turn["regret"],
        reward=turn["reward"],
        said=[{name: each[name] for name in names} for each in (*verdicts, *stated)],
    )


def write(results: Results, path: Path) -> int:
    """Write the file; returns the number of turns."""
    return write_json_lines(path, _rows(results))


def _rows(results: Results) -> Iterator[dict[str, Any]]:
    for episode in results.rows():
        before, *turns = results.turns(episode["key"])
        for turn in turns:
            yield {
                **facts(episode),
                "turn": turn["turn"],
                "observation": before["observation"],
                "action": action_text(episode["id"], turn),
                **rating_of(turn)._asdict(),
            }
            before = turn
