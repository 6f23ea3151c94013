"""Teachers who learn when to correct an announced mistake, many lifetimes at once, by what their advice came to."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym.lifetime import HALF
from llf_teacher.reproductions.classes import ADVICE, COLUMN, class_of, moves_left
from worlds.batches import Bools, Floats, Ints

ROUNDS, ROWS = 4, 512
"""How often a teacher changes its mind, and the lifetimes that it lives before each time."""
_FIRST, _EXPLORES, _KEPT = 0.1, 0.1, 0.9


class Choices(NamedTuple):
    """What a teacher sees of students who have announced a mistake, as long as it has advice left; one value a row."""

    way: Floats
    """Moves from here to the treasure."""
    importance: Floats
    """Moves between the best and the worst next action."""
    episode: Floats
    """Share of the lifetime's episodes that are over."""
    left: Floats
    """Share of the budget that is left."""


Policy = Callable[[Choices], Bools]
"""Whether to correct."""
Pay = Callable[[Choices], Floats] | None
"""What a piece of advice is worth to the teacher; None: it is paid by the student's progress, turn by turn."""


class Lessons:
    """Lifetimes of students, each in a world of its own, until all have ended."""

    def __init__(
        self, id: str, seeds: Sequence[int], *, episodes: int, turns: int, budget: int, **options: Any
    ) -> None:
        self._env = class_of(id, len(seeds), episodes=episodes, turns=turns, budget=budget, **options)
        self._living = np.ones(len(seeds), bool)
        self.lost = np.zeros(len(seeds))
        """Moves that each student has wasted."""
        self._look(self._env.reset(seed=list(seeds))[0])

    def _look(self, observation: Mapping[str, Any]) -> None:
        life, features = observation["lifetime"].astype(float), observation["features"].astype(float)
        may = (life[:, COLUMN["mistake"]] > 0) & (observation["action_mask"][:, ADVICE] > 0) & self._living
        self.rows: Ints = np.flatnonzero(may)
        """Those in which there is something to decide."""
        life = life[self.rows]
        self.choices = Choices(
            moves_left(life), features[self.rows, 2], life[:, COLUMN["episode"]], features[self.rows, 3]
        )

    def go_on(self, corrects: Bools) -> None:
        """A turn in all lifetimes."""
        actions = np.zeros(len(self._living), np.int64)
        actions[self.rows] = np.where(corrects, ADVICE, 0)
        observation, reward, terminated, truncated, _ = self._env.step(actions)
        self.lost -= np.where(self._living, reward, 0.0)
        self._living &= ~(terminated | truncated)
        self._look(observation)

    @property
    def over(self) -> bool:
        """Whether all have ended."""
        return not self._living.any()

    def close(self) -> None:
        """Close the environments."""
        self._env.close()


def lived(policy: Policy, id: str, seeds: Sequence[int], **terms: Any) -> Floats:
    """The regret per episode of each lifetime; `terms` are those of `Lessons`."""
    lessons = Lessons(id, seeds, **terms)
    while not lessons.over:
        lessons.go_on(policy(lessons.choices))
    lessons.close()
    return lessons.lost / float(terms["episodes"])


def seen(choices: Choices) -> Floats:
    """What a teacher reckons with, (rows, 10): the way, the episode, what is left, their products, and 1."""
    numbers = (choices.way / (choices.way + HALF), np.sqrt(choices.episode), choices.left)
    columns = 2 * np.stack(numbers, axis=1) - 1
    one, other = np.triu_indices(len(numbers))
    return np.hstack([np.ones((len(columns), 1)), columns, columns[:, one] * columns[:, other]])


def trained(id: str, pay: Pay, number: int, rounds: int = ROUNDS, rows: int = ROWS, **terms: Any) -> Policy:
    """A teacher that has learned: it corrects where that gains, by a linear function of what is seen.

    After each round of lifetimes it is found by least squares: what followed a decision until the end, less what
    followed such decisions on the average, against whether it was corrected, less how likely that was.

    Args:
        id: the environment.
        pay: what it is paid for.
        number: of the training; different ones have no lifetime in common.
        rounds: how often it learns.
        rows: lifetimes of a round.
        terms: those of `Lessons`.
    """
    rng, weights = np.random.default_rng(number), None
    size = seen(Choices(*np.ones((4, 1)))).shape[1]
    squares, products = np.eye(size), np.zeros(size)
    for done in range(rounds):
        first = (number * rounds + done) * rows
        lessons = Lessons(id, range(first, first + rows), **terms)
        told = _Told(rows)
        while not lessons.over:
            known = seen(lessons.choices)
            chance = np.full(len(known), _FIRST)
            if weights is not None:
                chance = np.where(known @ weights > 0, 1 - _EXPLORES, _EXPLORES)
            corrects = rng.random(len(known)) < chance
            told.add(lessons.rows, known, corrects - chance)
            before = lessons.lost.copy()
            if pay is not None:
                told.gained[lessons.rows] += corrects * pay(lessons.choices)
            lessons.go_on(corrects)
            if pay is None:
                told.gained -= lessons.lost - before
        lessons.close()
        known, drawn, gains = told.all()
        gains -= known @ np.linalg.lstsq(known, gains, rcond=None)[0]
        signed = known * drawn[:, None]
        squares, products = _KEPT * squares + signed.T @ signed, _KEPT * products + signed.T @ gains
        weights = np.linalg.solve(squares, products)
    learned = np.zeros(size) if weights is None else weights
    return lambda choices: seen(choices) @ learned > 0


class _Told:
    """Decisions of a round of lifetimes, and what came of them."""

    def __init__(self, rows: int) -> None:
        self.gained = np.zeros(rows)
        """By each lifetime so far."""
        self._rows, self._known, self._drawn, self._before = (
            list[Ints](),
            list[Floats](),
            list[Floats](),
            list[Floats](),
        )

    def add(self, rows: Ints, known: Floats, drawn: Floats) -> None:
        """Decisions in these rows: what was seen, and whether it was corrected, less how likely that was."""
        self._rows.append(rows)
        self._known.append(known)
        self._drawn.append(drawn)
        self._before.append(self.gained[rows])

    def all(self) -> tuple[Floats, Floats, Floats]:
        """What was seen, drawn, and gained from there to the end."""
        rows = np.concatenate(self._rows)
        return (
            np.concatenate(self._known),
            np.concatenate(self._drawn),
            self.gained[rows] - np.concatenate(self._before),
        )
