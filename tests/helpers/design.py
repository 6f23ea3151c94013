"""Which cases are played: about as many as there are families and personalities, not as their product.

A test is played in three sizes, each within the next. A size is a mark, for `pytest -m`:

- `smoke`: for a look at an installation, in two minutes. A few tests of each module in a folder of `tests`, one case of
  each, of a family that is cheap; what lies in `tests` itself or in `tests/repository` looks at the source tree, too.
- `quick`: what `pytest` plays. A test that crosses things says by `sampled` what each of its cases shows, such as a
  family and a personality, and plays a cover of them: cases that together show whatever there is to show, so that no
  family and no personality is left out of any test. The cases are drawn anew for each version of the package and apart
  for each test, so that pairs come round. Costly and slow families are drawn last: they get what nothing cheaper shows.
  A test of all environments that says nothing of the kind plays one of each family, with whatever else it crosses: the
  kits play them all.
- `full`: every case of every test, among them those that are marked so by hand and are played in no smaller size.

How long a case plays is a number of the size, too: `amount(40, full=800)` turns are 40, and 800 by `pytest -m full`.
"""

import random
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

import pytest

from llf_teacher.registry import PREFIX, Entry, entries
from pz_envs.family import all_families

TESTS = Path(__file__).parents[1]
SOURCES = (TESTS, TESTS / "repository")
"""Folders whose tests look at the source tree."""
FEW = 5
"""Tests of a module for a look."""
COSTLY = {"parking"}
"""Families of which a turn costs some hundred times that of most others; slow ones, by their declaration, cost more."""
KNOWN = {family.name: family for family in all_families()} | entries()
KNOWN |= {id.removeprefix(PREFIX): entry for id, entry in entries().items()}
SWEEP = 5
"""Families of environments among the cases of a test, from which on it is one of all environments."""
_size = ""


def set_size(marks: str) -> None:
    """Have amounts be those of a size, as `pytest -m` names it."""
    global _size
    _size = marks.strip()


def amount(few: Any, *, full: Any) -> Any:
    """How much of something is played, such as turns, episodes or examples: few, or by `pytest -m full` all of it."""
    return full if _size == "full" else few


def sampled(shown: Callable[..., Iterable[Hashable]]) -> pytest.MarkDecorator:
    """The mark of a test that plays a cover; `shown` takes what it needs of a case's parameters, by name."""
    return pytest.mark.sampled.with_args(shown)


def cover(shown: Sequence[Iterable[Hashable]], costs: Sequence[int], seed: str) -> list[int]:
    """The places of cases that together show all that is shown in any, each as cheaply as it can be."""
    order = random.Random(seed).sample(range(len(shown)), len(shown))
    seen: set[Hashable] = set()
    chosen = []
    for place in sorted(order, key=costs.__getitem__):
        if not seen.issuperset(shown[place]):
            seen.update(shown[place])
            chosen.append(place)
    return sorted(chosen)


def cost(case: pytest.Item) -> int:
    """How dear a case is: 2 if a family among its parameters is slow, 1 if one is costly, else 0.

    A parameter stands for a family by itself or its name, or by an environment or its id.
    """
    values = case.callspec.params.values() if hasattr(case, "callspec") else ()
    families = [getattr(each, "family", each) for each in map(known, values)]
    if any(getattr(family, "slow", False) for family in families):
        return 2
    return int(any(getattr(family, "name", "") in COSTLY for family in families))


def shown_by_families(cases: Sequence[pytest.Item]) -> list[set[Hashable]] | None:
    """What each case shows if their environments stand for families; None if these are not of all environments."""
    rows = [
        {name: known(value) for name, value in case.callspec.params.items()} if hasattr(case, "callspec") else {}
        for case in cases
    ]
    swept = {value.family.name for row in rows for value in row.values() if isinstance(value, Entry)}
    if len(swept) < SWEEP:
        return None
    return [
        {tuple((name, each.family.name if isinstance(each, Entry) else id(each)) for name, each in row.items())}
        for row in rows
    ]


def known(value: Any) -> Any:
    """The family or the environment of a name."""
    return KNOWN.get(value, value) if isinstance(value, str) else value


def mark_sizes(cases: Sequence[pytest.Item], version: str) -> None:
    """Mark each case with the sizes in which it is played."""
    tests: dict[str, list[pytest.Item]] = defaultdict(list)
    modules: dict[str, list[pytest.Item]] = defaultdict(list)
    for case in cases:
        if case.get_closest_marker("full") is None:
            tests[case.nodeid.partition("[")[0]].append(case)
        case.add_marker("full")
    for test, quick in tests.items():
        costs = [cost(case) for case in quick]
        if mark := quick[0].get_closest_marker("sampled"):
            (shown,) = mark.args
            names = signature(shown).parameters
            shows = [shown(**{name: case.callspec.params[name] for name in names}) for case in quick]
            places = cover(shows, costs, f"{version} {test}")
        elif shows := shown_by_families(quick):
            places = cover(shows, costs, f"{version} {test}")
        else:
            places = range(len(quick))
        for place in places:
            quick[place].add_marker("quick")
        fast = (quick[place] for place in places if not costs[place])
        if (first := next(fast, None)) and first.path.parent not in SOURCES:
            modules[test.partition("::")[0]].append(first)
    for module, firsts in modules.items():
        for case in random.Random(f"{version} {module}").sample(firsts, min(FEW, len(firsts))):
            case.add_marker("smoke")
