"""preferences: pairs of trajectories with the teacher's preference, for reward models, with the truth beside."""

import math
import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.studies.export.ratings import rating_of
from llf_teacher.studies.results import Results
from teachers.spec import is_count, unknown

_GROUP = ("id", "teacher", "instruction_type", "feedback_type", "options", "max_turns")
_BY = ("verdicts", "rewards")
_SAME = 1e-9  # smaller differences are rounding


def write(
    results: Results, path: Path, *, length: int = 0, same_world: bool = False, by: str = "verdicts", seed: int = 0
) -> int:
    """Write the file; returns the number of pairs.

    Pairs are drawn from the trajectories of an environment with a teacher; each trajectory is in one pair. The label is
    1.0 if the teacher prefers the first, 0.0 if the second, 0.5 if neither. Pairs of which the teacher rated nothing
    are left out.

    Args:
        results: the store.
        path: the file.
        length: turns of a trajectory: episodes are cut, and what is shorter is left out; 0: whole episodes.
        same_world: whether both trajectories of a pair are in the world of the same seed.
        by: what the label compares: `verdicts`, the mean rating by praise and blame, or the sum of the `rewards` that
            the teacher stated.
        seed: of the draw of pairs.
    """
    if length != 0 and not is_count(length):
        raise ValueError(f"length must be a number of turns, or 0 for whole episodes, got {length!r}")
    if not isinstance(same_world, bool):
        raise ValueError(f"same_world must be True or False, got {same_world!r}")
    if by not in _BY:
        raise ValueError(unknown("value of by", by, _BY))
    if not isinstance(seed, int):
        raise ValueError(f"seed must be an integer, got {seed!r}")
    return write_json_lines(path, _pairs(results, length, same_world, by, seed))


def _pairs(results: Results, length: int, same_world: bool, by: str, seed: int) -> Iterator[dict[str, Any]]:
    groups: dict[tuple[Any, ...], list[tuple[dict[str, Any], int, int]]] = {}
    kept = ("key", "id", "family", "teacher", "student", "instruction_type", "feedback_type", "seed", "sample")
    for row in results.rows():
        if row["lessons"]:  # tests have no teacher
            continue
        group = (*(row[name] for name in _GROUP), row["seed"] if same_world else None)
        each = length or row["turns"]
        for begin in range(0, row["turns"] - each + 1, each) if each else ():
            groups.setdefault(group, []).append(({name: row[name] for name in kept}, begin, begin + each))
    rng = random.Random(seed)  # noqa: S311 (a draw of pairs)
    for trajectories in groups.values():
        rng.shuffle(trajectories)
        for one, other in zip(trajectories[::2], trajectories[1::2], strict=False):
            first, second = (_trajectory(results, *each, by) for each in (one, other))
            if first["rated"] or second["rated"]:
                label = _preference(first["score"], second["score"])
                truth = _preference(second["regret"], first["regret"])
                shared = ("id", "family", "teacher", "instruction_type", "feedback_type")
                yield {
                    **{name: one[0][name] for name in shared},
                    "first": first,
                    "second": second,
                    "label": label,
                    "true_label": truth,
                    "agrees": label == truth,
                }


def _preference(one: float, other: float) -> float:
    return 0.5 if abs(one - other) < _SAME else float(one > other)


def _score(given: Sequence[float | None], by: str) -> float:
    """What the teacher thought of a trajectory, by what it said of its actions."""
    known = [each for each in given if each is not None]
    return math.fsum(known) / (1 if by == "rewards" else max(1, len(known)))


def _trajectory(results: Results, episode: dict[str, Any], first: int, last: int, by: str) -> dict[str, Any]:
    """The turns of an episode between two observations; the names of lists are those of trajectories in `imitation`."""
    turns = results.turns(episode["key"])
    ratings = [rating_of(turn) for turn in turns[first + 1 : last + 1]]
    given = [each.rating if by == "verdicts" else each.stated_reward for each in ratings]
    return {
        **{name: episode[name] for name in ("key", "student", "seed", "sample")},
        "first_turn": first + 1,
        "obs": [turn["observation"] for turn in turns[first : last + 1]],
        "acts": [turn["action"] for turn in turns[first + 1 : last + 1]],
        "rews": [each.reward for each in ratings],
        "terminal": last == len(turns) - 1,
        "ratings": given,
        "rated": sum(each is not None for each in given),
        "score": _score(given, by),
        "regrets": [each.regret for each in ratings],
        "regret": sum(each.regret for each in ratings),
    }
