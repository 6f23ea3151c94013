"""pass@k: how likely at least one of k samples of an episode succeeds."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from statistics import fmean
from typing import Any, NamedTuple


class Sampled(NamedTuple):
    """A cell of the average: the worlds of an environment with one teacher and one student."""

    id: str
    teacher: str
    student: str
    instruction_type: str
    feedback_type: str


def pass_at(k: int, rows: Iterable[Mapping[str, Any]]) -> dict[Sampled, float]:
    """The unbiased estimate of pass@k (Chen et al. 2021).

    Args:
        k: at most the number of samples.
        rows: episodes, as `llf_teacher.studies.load(path).rows()` gives them; success in any turn counts.

    Returns:
        Per cell the mean over its worlds, 0 to 1, in the order of the rows.

    Raises:
        ValueError: a world has fewer samples than k.
    """
    worlds: dict[Sampled, dict[int, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        cell = Sampled(*(row[name] for name in Sampled._fields))
        worlds[cell][row["seed"]].append(row["first_success"] is not None)
    for cell, seeds in worlds.items():
        least = min(map(len, seeds.values()))
        if not 1 <= k <= least:
            raise ValueError(f"k must be from 1 to {least}, the number of samples of each world of {cell}, got {k!r}")
    return {cell: fmean(_chance(k, won) for won in seeds.values()) for cell, seeds in worlds.items()}


def _chance(k: int, won: list[bool]) -> float:
    lost = len(won) - sum(won)
    return 1.0 - math.comb(lost, k) / math.comb(len(won), k)
