"""Teachers that learn from the effects of their advice when to correct an announced mistake, in many lifetimes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym.lifetime_statistics import HALF
from llf_teacher.reproductions.classes import ADVICE, COLUMN, moves_left, teacher_env
from worlds.batches import Bools, Floats, Ints

ROUNDS, ROWS = 4, 512
"""Rounds of learning, and lifetimes of a round."""
_FIRST, _EXPLORES, _KEPT = 0.1, 0.1, 0.9


class Choices(NamedTuple):
    """What a teacher with advice left observes of students that have announced a mistake; one value per row."""

    way: Floats
    """Moves from here to the treasure."""
    importance: Floats
    """Moves between the best and the worst next action."""
    episode: Floats
    """Share of the lifetime's episodes that have ended."""
    left: Floats
    """Remaining share of the budget."""


Policy = Callable[[Choices], Bools]
"""Gives per row whether to correct the mistake."""
Pay = Callable[[Choices], Floats] | None
"""Gives the teacher's reward for a piece of advice; None: the reward is the student's progress, turn by turn."""


class Lessons:
    """Lifetimes of students, each in its own world, until all have ended."""

    def __init__(
        self, id: str, seeds: Sequence[int], *, episodes: int, turns: int, budget: int, **options: Any
    ) -> None:
        self._env = teacher_env(id, len(seeds), episodes=episodes, turns=turns, budget=budget, **options)
        self._living = np.ones(len(seeds), bool)
        self.lost = np.zeros(len(seeds))
        """Moves wasted by each student."""
        self._observe(self._env.reset(seed=list(seeds))[0])

    def _observe(self, observation: Mapping[str, Any]) -> None:
        life, features = observation["lifetime"].astype(float), observation["features"].astype(float)
        may = (life[:, COLUMN["mistake"]] > 0) & (observation["action_mask"][:, ADVICE] > 0) & self._living
        self.rows: Ints = np.flatnonzero(may)
        """The rows with a decision."""
        life = life[self.rows]
        self.choices = Choices(
            moves_left(life), features[self.rows, 2], life[:, COLUMN["episode"]], features[self.rows, 3]
        )

    def step(self, corrects: Bools) -> None:
        """Play a turn of all lifetimes."""
        actions = np.zeros(len(self._living), np.int64)
        actions[self.rows] = np.where(corrects, ADVICE, 0)
        observation, reward, terminated, truncated, _ = self._env.step(actions)
        self.lost -= np.where(self._living, reward, 0.0)
        self._living &= ~(terminated | truncated)
        self._observe(observation)

    @property
    def over(self) -> bool:
        """Whether all lifetimes have ended."""
        return not self._living.any()

    def close(self) -> None:
        """Close the environments."""
        self._env.close()


def lived(policy: Policy, id: str, seeds: Sequence[int], **terms: Any) -> Floats:
    """The regret per episode of each lifetime; `terms` are arguments of `Lessons`."""
    lessons = Lessons(id, seeds, **terms)
    while not lessons.over:
        lessons.step(policy(lessons.choices))
    lessons.close()
    return lessons.lost / float(terms["episodes"])


def seen(choices: Choices) -> Floats:
    """The features of decisions, shape (rows, 10): the way, the episode, the budget, their products, and 1."""
    numbers = (choices.way / (choices.way + HALF), np.sqrt(choices.episode), choices.left)
    columns = 2 * np.stack(numbers, axis=1) - 1
    one, other = np.triu_indices(len(numbers))
    return np.hstack([np.ones((len(columns), 1)), columns, columns[:, one] * columns[:, other]])


def trained(id: str, pay: Pay, number: int, rounds: int = ROUNDS, rows: int = ROWS, **terms: Any) -> Policy:
    """A learned teacher, which corrects a mistake if a linear function of the features is above 0.

    After each round the function is fitted by least squares: the gain from a decision until the end, minus the mean
    gain with such features, against whether the mistake was corrected, minus the probability of that.

    Args:
        id: the environment.
        pay: the teacher's reward.
        number: of the training; different ones have no lifetime in common.
        rounds: rounds of learning.
        rows: lifetimes of a round.
        terms: arguments of `Lessons`.
    """
    rng, weights = np.random.default_rng(number), None
    size = seen(Choices(*np.ones((4, 1)))).shape[1]
    squares, products = np.eye(size), np.zeros(size)
    for done in range(rounds):
        first = (number * rounds + done) * rows
        lessons = Lessons(id, range(first, first + rows), **terms)
        decisions = _Decisions(rows)
        while not lessons.over:
            known = seen(lessons.choices)
            chance = np.full(len(known), _FIRST)
            if weights is not None:
                chance = np.where(known @ weights > 0, 1 - _EXPLORES, _EXPLORES)
            corrects = rng.random(len(known)) < chance
            decisions.add(lessons.rows, known, corrects - chance)
            before = lessons.lost.copy()
            if pay is not None:
                decisions.gained[lessons.rows] += corrects * pay(lessons.choices)
            lessons.step(corrects)
            if pay is None:
                decisions.gained -= lessons.lost - before
        lessons.close()
        known, drawn, gains = decisions.all()
        gains -= known @ np.linalg.lstsq(known, gains, rcond=None)[0]
        signed = known * drawn[:, None]
        squares, products = _KEPT * squares + signed.T @ signed, _KEPT * products + signed.T @ gains
        weights = np.linalg.solve(squares, products)
    learned = np.zeros(size) if weights is None else weights
    return lambda choices: seen(choices) @ learned > 0


class _Decisions:
    """The decisions of a round of lifetimes, and their gains."""

    def __init__(self, rows: int) -> None:
        self.gained = np.zeros(rows)
        """Gain of each lifetime so far."""
        self._rows, self._known, self._drawn, self._before = (
            list[Ints](),
            list[Floats](),
            list[Floats](),
            list[Floats](),
        )

    def add(self, rows: Ints, known: Floats, drawn: Floats) -> None:
        """Add decisions in these rows: their features, and whether they corrected, minus the probability of that."""
        self._rows.append(rows)
        self._known.append(known)
        self._drawn.append(drawn)
        self._before.append(self.gained[rows])

    def all(self) -> tuple[Floats, Floats, Floats]:
        """Features, draws, and the gains from each decision to the end."""
        rows = np.concatenate(self._rows)
        return (
            np.concatenate(self._known),
            np.concatenate(self._drawn),
            self.gained[rows] - np.concatenate(self._before),
        )
