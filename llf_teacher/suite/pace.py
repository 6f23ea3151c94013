"""How long episodes take, measured from those that were played."""

from collections import Counter, deque
from collections.abc import Iterable
from typing import NamedTuple

from llf_teacher.episodes.record import EpisodeSpec

_RECENT = 16
"""Number of episodes whose speed counts, the latest: the speed of a machine changes."""

Key = tuple[str, str, bool]
"""What has a speed of its own: an environment, a student, and whether lessons precede the episode."""


class _Played(NamedTuple):
    """An episode that was measured."""

    seconds: float
    planned: int
    """The greatest number of turns, those of lessons included."""
    turns: int
    """The number of turns without lessons."""


class Pace:
    """The speed of episodes, and the time that those to come will take.

    Args:
        parallel: number of episodes at once.
    """

    def __init__(self, parallel: int) -> None:
        self.parallel = parallel
        self._recent: dict[Key, deque[_Played]] = {}

    def add(self, spec: EpisodeSpec, seconds: float, turns: int) -> None:
        """Take an episode into answers.

        Args:
            spec: the episode.
            seconds: how long it was played.
            turns: number of its turns, those of lessons not included.
        """
        self._recent.setdefault(_key(spec), deque(maxlen=_RECENT)).append(_Played(seconds, turns_of(spec), turns))

    def knows(self, spec: EpisodeSpec) -> bool:
        """Whether an episode of this kind was measured."""
        return _key(spec) in self._recent

    def turn_seconds(self, student: str) -> dict[str, float]:
        """The seconds of a turn of a student, by environment; turns after lessons are left out."""
        found = {id: known for (id, who, taught), known in self._recent.items() if who == student and not taught}
        return {
            id: sum(each.seconds for each in known) / sum(each.turns for each in known) for id, known in found.items()
        }

    def left(self, specs: Iterable[EpisodeSpec]) -> float:
        """The seconds that these episodes will take; kinds that were never measured count as free."""
        turns: Counter[Key] = Counter()
        for spec in specs:
            turns[_key(spec)] += turns_of(spec)
        return sum(number * self._of(key) for key, number in turns.items()) / self.parallel

    def _of(self, key: Key) -> float:
        """Seconds of a turn; before the first test after lessons, those of the same student without lessons."""
        known = self._recent.get(key) or self._recent.get((*key[:2], False)) or [_Played(0.0, 1, 1)]
        return sum(each.seconds for each in known) / sum(each.planned for each in known)


def turns_of(spec: EpisodeSpec) -> int:
    """The greatest number of turns of an episode, those of its lessons included."""
    return spec.max_turns * (1 + spec.lessons)


def _key(spec: EpisodeSpec) -> Key:
    return spec.id, spec.student, bool(spec.lessons)
