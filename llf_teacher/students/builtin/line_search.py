"""line_search: search over texts made of lines of equal words, using only the score."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import Lines, check_counts

_SYLLABLE = "la"


class _Policy(Policy["LineSearch"]):
    """The best pattern so far and the patterns still to try."""

    def begin(self) -> None:
        """Begin with the uniform patterns."""
        spec = self.spec
        self._uniform = [(count,) * length for count in spec.syllables for length in spec.lengths]
        self._best: tuple[int, ...] = ()
        self._score = self.world.reward_range[0]
        self._trial: tuple[int, ...] = ()
        self._line = -1
        self._counts: list[int] = []

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Evaluate the last pattern by its score, then write a text by the next pattern."""
        if self._trial:
            self._judge(info["reward"])
        self._trial = self._next()
        return "\n".join(" ".join([_SYLLABLE] * count) for count in self._trial)

    def _judge(self, score: float) -> None:
        if score > self._score:  # a line is right, or one more than before
            self._best, self._score = self._trial, score
            self._counts = []
        elif self._best and score < self._score:  # the line was right
            self._counts = []

    def _next(self) -> tuple[int, ...]:
        if not self._best and self._uniform:
            return self._uniform.pop(0)
        if not self._best or self._score >= self.world.reward_range[1]:
            return self._best or self._trial
        while not self._counts:
            self._line += 1
            if self._line == len(self._best):
                return self._best
            self._counts = [count for count in self.spec.syllables if count != self._best[self._line]]
        return (*self._best[: self._line], self._counts.pop(0), *self._best[self._line + 1 :])


@dataclass(frozen=True)
class LineSearch(Student):
    """Coordinate search on the number of lines and of syllables in each line.

    It tries texts of one length with the same number of syllables in each line until the score shows that a line is
    right; then it changes one line at a time and keeps a change that does not lower the score.
    """

    lengths: tuple[int, ...] = (3, 4, 5)
    """Numbers of lines to try, in this order."""
    syllables: tuple[int, ...] = (5, 7)
    """Numbers of syllables to try, in this order."""
    reads = "reward"
    searches = True
    suits = Lines
    policy = _Policy

    def __post_init__(self) -> None:
        for name in ("lengths", "syllables"):
            check_counts(name, getattr(self, name))
