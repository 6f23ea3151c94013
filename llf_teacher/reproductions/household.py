"""Household lessons as sequences: what was seen, said and done, turn by turn, in words; for models of sequences."""

import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import StudentEnv

_ENDING = 12  # characters by which sentences are told apart, since voices put their frames before them
_FAR = 100
WORDS = 4096
"""Numbers of words: 0 is none, and each word has one of the others, by its hash."""


class Sentences:
    """Chooses among the paraphrases of what is said: of each claim a third of the sentences is kept for the test.

    Args:
        test: whether the sentences are those that are kept.
        rng: what draws; None: always the first sentence.
    """

    def __init__(self, test: bool, rng: np.random.Generator | None) -> None:
        self._test, self._rng = test, rng

    def __call__(self, templates: Sequence[str], **slots: Any) -> str:
        """A sentence; where all end alike, as some of the instruction do, any of them."""
        kept = sorted({template[-_ENDING:] for template in templates})[::3]
        allowed = [template for template in templates if (template[-_ENDING:] in kept) == self._test] or templates
        return allowed[int(self._rng.integers(len(allowed))) if self._rng else 0].format(**slots)


class ErrandTurn(NamedTuple):
    """What is known before a command, and the command."""

    seen: str
    """The answer of the house to the last command."""
    heard: str
    """What the teacher said of it, and of the next one."""
    commands: tuple[str, ...]
    """What can be done."""
    before: tuple[int, ...]
    """How often each of these was done in this episode."""
    last: str
    """The last command; empty at first."""
    done: str = ""
    """The command; empty if it is still to be chosen."""


@dataclass
class Errand:
    """An episode."""

    task: str
    """What is to be done, as the house says it."""
    least: int
    """Commands that it takes."""
    turns: list[ErrandTurn] = field(default_factory=list)
    success: bool = False

    @property
    def score(self) -> float:
        """The least number of commands as a share of those that were given; 0 if the task was not done."""
        return self.least / max(self.least, len(self.turns)) if self.success else 0.0


Choose = Callable[[Sequence[Errand]], Sequence[str]]
"""The next commands in errands whose last turns are open."""


def play(houses: Sequence[tuple[StudentEnv, int]], choose: Choose) -> list[Errand]:
    """Play episodes side by side, each in an environment of its own with a seed, until all have ended."""
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
    """What the house says, without its list of commands, which the info has, too."""
    return observation["observation"].partition("\n\nAdmissible commands: ")[0]


def blundering(env: StudentEnv, mistakes: float, rng: np.random.Generator) -> Choose:
    """A student who knows the way, and with probability `mistakes` does anything; it does not listen."""

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
    """The numbers of the words of a text, in their order; signs are words, too."""
    for sign in ".,:;?!`":
        text = text.replace(sign, f" {sign} ")
    return tuple(1 + zlib.crc32(word.encode()) % (WORDS - 1) for word in text.lower().split())
