"""Feedback types, which select kinds of feedback, and subsets of the kinds as numbers."""

from collections.abc import Iterable, Set
from typing import Any, TypeVar

import numpy as np

from teachers.atoms import KINDS, Atom, Claim, FeedbackType

Spoken = TypeVar("Spoken", Atom, Claim[Any])

SUBSETS = 2 ** len(KINDS)
"""Number of subsets of the kinds: bit i of a subset's number is kind i in the order r, hp, hn, fp, fn."""
BIT = {kind: 1 << i for i, kind in enumerate(KINDS)}
"""Per kind the number of the subset that contains only this kind."""
ALL, NONE, MIXED = "a", "n", "m"
_ALLOWED = (
    "'a' (all), 'n' (none), 'm' (a random subset each turn), or kinds among r, hp, hn, fp, fn, by code or by word "
    "(reward, praise, blame, advice, warning), as one string joined by '+', a set, a list or a tuple"
)


def parse_kinds(feedback_type: str | Iterable[str]) -> frozenset[FeedbackType]:
    """The kinds that a feedback type allows; `m` allows all.

    Raises:
        ValueError: it is not a feedback type.
    """
    if isinstance(feedback_type, str):
        if feedback_type in (ALL, MIXED):
            return frozenset(KINDS)
        if feedback_type == NONE:
            return frozenset()
        names: list[object] = list(feedback_type.split("+"))
    elif isinstance(feedback_type, set | frozenset | list | tuple):
        names = list(feedback_type)
    else:
        raise ValueError(f"feedback type {feedback_type!r} is not supported; allowed: {_ALLOWED}")
    for name in names:
        if name not in KINDS:
            raise ValueError(f"feedback type {feedback_type!r} names {name!r}; allowed: {_ALLOWED}")
    return frozenset(FeedbackType(str(name)) for name in names)


def format_kinds(feedback_type: str | Iterable[str]) -> str:
    """The canonical text of a feedback type: `a`, `n`, `m` or kinds in speaking order, joined by `+`."""
    kinds = parse_kinds(feedback_type)
    if isinstance(feedback_type, str) and feedback_type in (ALL, NONE, MIXED):
        return feedback_type
    return "+".join(kind for kind in KINDS if kind in kinds) or NONE


def draw_kinds(kinds: Set[FeedbackType], rng: np.random.Generator) -> frozenset[FeedbackType]:
    """A random non-empty subset, uniform; empty if `kinds` is empty."""
    ordered = [kind for kind in KINDS if kind in kinds]
    if not ordered:
        return frozenset()
    bits = int(rng.integers(1, 2 ** len(ordered)))
    return frozenset(kind for i, kind in enumerate(ordered) if bits >> i & 1)


def number_of(kinds: Iterable[FeedbackType]) -> int:
    """The number of a subset of the kinds."""
    return sum(BIT[kind] for kind in kinds)


def subset_of(claims: Iterable[Claim[Any]]) -> int:
    """The kinds of some claims, as a subset's number."""
    subset = 0
    for claim in claims:
        kind = claim.kind
        if kind is not None:
            subset |= BIT[kind]
    return subset


def of_subset(items: Iterable[Spoken], subset: int) -> list[Spoken]:
    """The claims or atoms whose kinds are in a subset, given by its number, and all without a kind, such as notices."""
    return [item for item in items if item.kind is None or subset & BIT[item.kind]]
