"""Household lessons as sequences of observations, feedback and commands in words, for sequence models."""

import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import StudentEnv

_ENDING = 12  # last characters that identify a sentence, since voices add their frames before it
_FAR = 100
WORDS = 4096
"""Size of the vocabulary: 0 is padding, and a word has one of the other numbers, by its hash."""


class Sentences:
    """Chooses among paraphrases; a third of the sentences of each claim is reserved for the test.

    Args:
        test: whether to choose the reserved sentences.
        rng: draws a sentence; None: always the first one.
    """

    def __init__(self, test: bool, rng: np.random.Generator | None) -> None:
        self._test, self._rng = test, rng

    def __call__(self, templates: Sequence[str], **slots: Any) -> str:
        """A sentence; if all sentences end alike, any of them."""
        kept = sorted({template[-_ENDING:] for template in templates})[::3]
        allowed = [template for template in templates if (template[-_ENDING:] in kept) == self._test] or templates
        return allowed[int(self._rng.integers(len(allowed))) if self._rng else 0].format(**slots)


class ErrandTurn(NamedTuple):
    """What the student knows before a command, and the command."""

    seen: str
    """The response of the house to the last command."""
    heard: str
    """The teacher's feedback and advice."""
    commands: tuple[str, ...]
    """The admissible commands."""
    before: tuple[int, ...]
    """How often each of these was given in this episode."""
    last: str
    """The last command; empty at first."""
    done: str = ""
    """The command; empty until it is chosen."""


@dataclass
class Errand:
    """An episode."""

    task: str
    """The task, in the words of the house."""
    least: int
    """Least number of commands that solve it."""
    turns: list[ErrandTurn] = field(default_factory=list)
    success: bool = False

    @property
    def score(self) -> float:
        """The least number of commands divided by those that were given; 0 if the task was not solved."""
        return self.least / max(self.least, len(self.turns)) if self.success else 0.0


Choose = Callable[[Sequence[Errand]], Sequence[str]]
"""Gives the next commands of errands whose last turns have none."""


def play(houses: Sequence[tuple[StudentEnv, int]], choose: Choose) -> list[Errand]:
    """Play episodes side by side, each in its own environment with a seed, until all have ended."""
    errands, views, counts = [], [], [Counter[str]() for _ in houses]
    for env, seed in houses:
        observation, info = env.reset(seed=seed)
        seen, _, task = _answer(observation).rpartition("\n\n")
        errands.append(Errand(task, len(env.session.teacher.oracle.plan(env.session.moment.after, _FAR))))
        views.append((seen, observation["feedback"], tuple(info["admissible_commands"])))
    running = list(range(len(errands)))
    while running:
        for i in running:
            turns, (seen, heard, commands) = errands[i].turns, views[i]
            before = tuple(counts[i][command] for command in commands)
            turns.append(ErrandTurn(seen, heard, commands, before, turns[-1].done if turns else ""))
        for i, command in zip(tuple(running), choose([errands[i] for i in running]), strict=True):
            errands[i].turns[-1] = errands[i].turns[-1]._replace(done=command)
            counts[i][command] += 1
            observation, _, terminated, truncated, info = houses[i][0].step(command)
            views[i] = _answer(observation), observation["feedback"], tuple(info["admissible_commands"])
            errands[i].success = info["success"]
            if terminated or truncated:
                running.remove(i)
    return errands


def _answer(observation: Mapping[str, str]) -> str:
    """The response of the house, without its list of commands, which is in the info, too."""
    return observation["observation"].partition("\n\nAdmissible commands: ")[0]


def blundering(env: StudentEnv, mistakes: float, rng: np.random.Generator) -> Choose:
    """A student that knows the plan, gives a random command with probability `mistakes`, and ignores feedback."""

    def choose(errands: Sequence[Errand]) -> list[str]:
        (errand,) = errands
        commands = errand.turns[-1].commands
        anything = commands[rng.integers(len(commands))]
        if rng.random() < mistakes:
            return [anything]
        return [*env.session.teacher.oracle.plan(env.session.moment.after, 1)] or [anything]

    return choose


@lru_cache(maxsize=100_000)
def numbers(text: str) -> tuple[int, ...]:
    """The numbers of the words of a text, in order; punctuation marks are words, too."""
    for sign in ".,:;?!`":
        text = text.replace(sign, f" {sign} ")
    return tuple(1 + zlib.crc32(word.encode()) % (WORDS - 1) for word in text.lower().split())
