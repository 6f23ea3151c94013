"""Games: a house, the places of its objects, and a task.

They are read from ALFWorld's files or generated from a seed; in both cases as a problem in PDDL.
"""

import re
from typing import NamedTuple

from worlds.alfworld.facts import tasks

__all__ = ["CHANGING", "SPLITS", "TASKS", "Fact", "Game", "compose", "goal_pddl", "parse", "uncommented"]

Fact = tuple[str, ...]
"""A predicate and its arguments, in lower case, as in `("opened", "fridge_bar_...")`."""

SPLITS = ("all", "train", "valid_seen", "valid_unseen")
TASKS = (
    "pick_and_place_simple",
    "look_at_obj_in_light",
    "pick_clean_then_place_in_recep",
    "pick_heat_then_place_in_recep",
    "pick_cool_then_place_in_recep",
    "pick_two_obj_and_place",
)
"""The six types of tasks, named as in ALFRED."""
CHANGING = frozenset(
    {"atlocation", "objectatlocation", "inreceptacle", "opened", "checked", "holds", "holdsany"}
    | {"isclean", "ishot", "iscool", "ison", "istoggled", "issliced"}
)
"""The predicates that actions change."""


class Game(NamedTuple):
    """The constant part of an episode; shared by reference between snapshots."""

    task: str
    """One of `TASKS`."""
    target: str
    """Type of the object that the task is about, in lower case as all types here."""
    destination: str
    """Type of the receptacle to put it in; empty if the task is to look at it."""
    lamp: str
    """Type of the lamp to look at it under, or empty."""
    goal: str
    """The task in English."""
    kinds: tuple[tuple[str, str], ...]
    """All objects of the problem with their PDDL types, such as `receptacle`."""
    static: frozenset[Fact]
    """Facts that actions do not change."""
    start: frozenset[Fact]
    """Facts at the start that actions may change."""
    problem: str
    """The problem in PDDL."""
    law: tuple[tuple[str, str], ...] = ()
    """For each type of object, the type of receptacle where the town keeps it; empty without a town."""


def goal_pddl(task: str, words: dict[str, str]) -> str:
    """The goal of a task in PDDL, with these types in its slots."""
    return tasks()[task].goal.format(**words).replace("#", "-")


_COMMENT = re.compile(r";[^\n]*")
_SECTIONS = re.compile(r"\(:objects(?P<objects>[^()]*)\).*?\(:init(?P<init>.*)(?P<goal>\(:goal.*)", re.DOTALL)
_ATOM = re.compile(r"\(([^()=]+)\)")
_NUMBERS = ("distance", "total-cost")


def parse(problem: str, task: str, words: dict[str, str], goal: str) -> Game:
    """Make a game of a problem in PDDL.

    Args:
        problem: the problem.
        task: the type of its task.
        words: the types `obj`, `recep`, `toggle` and `mrecep` of the task, each possibly empty.
        goal: the task in English.

    Raises:
        ValueError: it is not a problem of this task.
    """
    found = _SECTIONS.search(uncommented(problem).lower())
    if found is None:
        raise ValueError("a PDDL problem must have :objects, :init and :goal, in this order")
    wanted = goal_pddl(task, words).lower()
    if found["goal"].split() != wanted.split():
        raise ValueError(f"the problem's goal is not the goal of the task {task!r} with {words}")
    kinds = re.findall(r"(\S+)\s+-\s+(\S+)", found["objects"])
    facts = [tuple(atom.split()) for atom in _ATOM.findall(found["init"])]
    facts = [fact for fact in facts if fact[0] not in _NUMBERS]
    return compose(problem, task, words, goal, kinds, facts)


def compose(
    problem: str, task: str, words: dict[str, str], goal: str, kinds: list[tuple[str, str]], facts: list[Fact]
) -> Game:
    """Make a game of a problem with its objects and facts, in lower case; for the other arguments see `parse`."""
    start = frozenset(fact for fact in facts if fact[0] in CHANGING)
    return Game(
        task,
        words["obj"].lower(),
        words["recep"].lower(),
        words["toggle"].lower(),
        goal,
        tuple(sorted(kinds)),
        frozenset(facts) - start,
        start,
        problem,
    )


def uncommented(code: str) -> str:
    """Remove comments from PDDL or a grammar."""
    return _COMMENT.sub("", code)
