"""The strength of a student's trait, estimated from the turns of its episodes alone.

The student without the trait is taken to believe: it does what it was told last of a state, else what the instruction's
plan says, else it acts at random, as `obedient` and `text_only` do. Each trait gives the likelihood of an episode. The
estimate is the strength of the greatest likelihood; the interval has the strengths that a likelihood-ratio test at 5 %
does not reject (Wilks 1938).
"""

import itertools
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from scipy import stats

from llf_teacher.episodes.record import Record, turns_as_dicts
from llf_teacher.registry import entry
from llf_teacher.students.scene import Floats, HeardTurn
from llf_teacher.students.trait import Trait
from llf_teacher.studies.store import Store
from teachers.atoms import FN, FP, HN, HP

LEVEL = 0.95
"""Probability that an interval holds the true strength."""
_LIMIT = float(stats.chi2.ppf(LEVEL, 1)) / 2


class TurnsOf(NamedTuple):
    """The turns of an episode."""

    id: str
    turns: Sequence[Mapping[str, Any]]
    """As of `TurnRow`, with `action` and `atoms` decoded."""


class StrengthEstimate(NamedTuple):
    """A strength."""

    strength: float
    low: float
    """End of the interval; that of the compared strengths if the episodes show no bound."""
    high: float


def of_record(record: Record) -> TurnsOf:
    """The transcript of an episode that was played here."""
    turns = [
        {**turn, "action": None if turn.get("action") is None else json.loads(turn["action"])}
        for turn in turns_as_dicts(record.turns)
    ]
    return TurnsOf(record.spec.id, turns)


def of_store(store: Store, student: str) -> list[TurnsOf]:
    """The transcripts of a student's episodes in a study's store.

    Raises:
        ValueError: there are none.
    """
    rows = store.episodes()
    found = [TurnsOf(row["id"], store.turns(row["key"])) for row in rows if row["student"] == student]
    if not found:
        known = ", ".join(sorted({row["student"] for row in rows}))
        raise ValueError(f"{store.path} has no episode of the student {student!r}; allowed: {known or 'none'}")
    return found


def estimate(trait: Trait, transcripts: Iterable[TurnsOf]) -> StrengthEstimate:
    """The strength of a trait, and its interval.

    Args:
        trait: with its other parameters; its own strength has no effect.
        transcripts: of one student with this trait alone; their claims about actions are advice and plans.

    Raises:
        ValueError: a transcript has other claims about actions, a likelihood is unknown, or the transcripts show
            nothing of this trait.
    """
    strengths, total = trait.strengths, evidence(trait, transcripts)
    best = int(np.argmax(total))
    if np.isnan(total).any():
        raise ValueError(
            f"{trait.name} needs the probability that a random action is the advised one, which is unknown for texts; "
            "allowed: environments with discrete actions, or those of a box"
        )
    if np.ptp(total) == 0 or total[best] == -np.inf:
        raise ValueError(
            f"the transcripts show nothing of {trait.strength} of {trait.name}: its student must believe, and get "
            f"advice or plans, as in {trait.recovery}"
        )
    inside = np.flatnonzero(total >= total[best] - _LIMIT)
    above = total - total[best] + _LIMIT
    low, high = (_bound(strengths, above, int(at), by) for at, by in ((inside[0], -1), (inside[-1], 1)))
    return StrengthEstimate(float(strengths[best]), low, high)


def evidence(trait: Trait, transcripts: Iterable[TurnsOf]) -> Floats:
    """The log-likelihood of transcripts by the trait's strength, shape (strengths,); arguments as of `estimate`."""
    strengths = trait.strengths
    return sum((trait.log_likelihood(strengths, steps_of(each)) for each in transcripts), np.zeros_like(strengths))


def _bound(strengths: Floats, above: Floats, inside: int, by: int) -> float:
    """The strength between the last one inside and its neighbour outside at which the interval ends."""
    outside = inside + by
    if not 0 <= outside < len(strengths):
        return float(strengths[inside])
    share = above[inside] / (above[inside] - above[outside])  # 0 if the neighbour is impossible
    return float(strengths[inside] + share * (strengths[outside] - strengths[inside]))


def steps_of(transcript: TurnsOf) -> list[HeardTurn]:
    """The turns as a believing student would see them.

    Raises:
        ValueError: there are claims about actions that are no advice.
    """
    turns, chance = transcript.turns, chance_of(transcript.id)
    steps: list[HeardTurn] = []
    heard: dict[str, tuple[Any, int]] = {}  # by state, what was said last, and of which turn
    plan: list[Any] = []
    always: Any = None
    for turn, (row, after) in enumerate(itertools.pairwise(turns)):
        state, fresh, now = row["observation"], row["observation"] not in heard, False
        for atom in row["atoms"]:
            about = atom["about_turn"]
            if atom["action"] is None:
                continue
            if atom["kind"] in (HP, HN, FN):
                raise ValueError(
                    f"turn {turn} of {transcript.id} has a claim of kind {atom['kind']} about an action; allowed: "
                    "advice and plans; play lessons with feedback_type 'fp' or 'n', and instruction type 'b' or 'c'"
                )
            if atom["kind"] == FP:
                heard[turns[about]["observation"]] = atom["action"], about
                now |= about == turn
            elif (actions := atom["fields"].get("actions")) is not None:
                plan = actions
            else:
                always = atom["action"]
        planned = state not in heard and turn < len(plan)
        advised, said = heard.get(state, (plan[turn] if planned else always, 0))
        last = turns[turn]["action"] if turn else None
        steps.append(
            HeardTurn(after["action"], last, advised, said, now, fresh and not plan and always is None, planned, chance)
        )
    return steps


@cache
def chance_of(id: str) -> float:
    """The probability that a random action is a given one; NaN where it is unknown, as for texts."""
    found = entry(id)
    space = found.family.make_world(**found.options).action_space
    if isinstance(space, spaces.Discrete):
        return 1 / int(space.n)
    return 0.0 if isinstance(space, spaces.Box) else math.nan
