"""How well the strengths of traits are recovered from transcripts: a table of coverage by trait and environment."""

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from llf_teacher import __version__
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX, entry
from llf_teacher.students.parsing import TRAITS, parse_student
from llf_teacher.students.trait import Trait
from llf_teacher.studies.analysis.traits import StrengthEstimate, TurnsOf, chance_of, estimate, of_record
from llf_teacher.studies.execution.play import play
from llf_teacher.tools.markdown import table
from pz_envs.family import all_families

_TURNS = 20  # of an episode, at most
_FAMILIES, _FEW = 2, 5
Step = Callable[[], None]
"""Called after each run."""


class Recovered(NamedTuple):
    """The estimates of a trait's strength in one environment."""

    trait: Trait
    id: str
    estimates: tuple[StrengthEstimate, ...]
    """One a run."""

    @property
    def truth(self) -> float:
        """The strength with which the episodes were played."""
        return float(getattr(self.trait, self.trait.strength))

    @property
    def held(self) -> int:
        """Number of intervals that hold it."""
        return sum(each.low <= self.truth <= each.high for each in self.estimates)


def recoverable() -> list[Trait]:
    """The traits whose strength can be estimated, with a strength to be found."""
    made = [TRAITS[name]() for name in TRAITS.names]
    return [dataclasses.replace(one, **{one.strength: one.recovery.strength}) for one in made if one.recovery]


def transcripts(trait: Trait, id: str, seeds: Iterable[int]) -> list[TurnsOf]:
    """Episodes of a student with this trait, in the lessons where its strength shows.

    Args:
        trait: has a `recovery`, which says how lessons go.
        id: of the environment.
        seeds: one an episode.
    """
    where = trait.recovery
    if where is None:
        raise ValueError(f"the trait {trait} has no recovery, so that there are no lessons in which its strength shows")
    spec = EpisodeSpec(
        id=entry(id).id,
        teacher=where.teacher,
        student=str(parse_student(where.student) | trait),
        instruction_type=where.instruction_type,
        feedback_type=where.feedback_type,
        max_turns=_TURNS,
        seed=0,
        version=__version__,
    )
    return [of_record(play(spec._replace(seed=seed))) for seed in seeds]


def recover(trait: Trait, id: str, runs: int, episodes: int, step: Step = lambda: None) -> Recovered:
    """Play runs of episodes, and estimate the trait's strength from each run's transcripts.

    Args:
        trait, id: as of `transcripts`.
        runs: number of estimates.
        episodes: number of episodes for each; run i has seeds from `i * episodes` on.
        step: called after each run.
    """
    estimates = []
    for run in range(runs):
        estimates.append(estimate(trait, transcripts(trait, id, range(run * episodes, (run + 1) * episodes))))
        step()
    return Recovered(trait, entry(id).id, tuple(estimates))


def places(trait: Trait) -> tuple[str, ...]:
    """Environments in which a trait's strength is looked for: of the first families in which a few episodes show it."""
    found = (
        f"{PREFIX}{family.showcase[0]}" for family in all_families() if not family.version and not family.missing()
    )
    return tuple(islice((id for id in found if _shows(trait, id)), _FAMILIES))


def _shows(trait: Trait, id: str) -> bool:
    try:
        return not math.isnan(chance_of(id)) and bool(estimate(trait, transcripts(trait, id, range(_FEW))))
    except ValueError:  # a student that cannot play there, or transcripts that show nothing
        return False


def recoveries(runs: int, episodes: int, step: Step = lambda: None) -> Iterator[Recovered]:
    """Every trait that can be recovered, in its places; arguments as of `recover`."""
    for trait in recoverable():
        for id in places(trait):
            yield recover(trait, id, runs, episodes, step)


def as_table(found: list[Recovered]) -> str:
    """A Markdown table, with an exact 95 % interval of each coverage (Clopper & Pearson 1934)."""
    rows: list[tuple[Any, ...]] = []
    for each in found:
        runs = len(each.estimates)
        strengths = [one.strength for one in each.estimates]
        widths = [one.high - one.low for one in each.estimates]
        low, high = stats.binomtest(each.held, runs).proportion_ci()
        rows.append(
            (
                f"`{each.trait}`",
                each.id,
                f"{each.truth:g}",
                f"{np.mean(strengths):.3g}",
                f"{np.median(widths):.2g}",
                f"{each.held} of {runs}",
                f"{each.held / runs:.1%} ({low:.0%} to {high:.0%})",
            )
        )
    return table(
        ("trait", "environment", "strength", "mean estimate", "median width", "intervals that hold it", "share"), rows
    )
