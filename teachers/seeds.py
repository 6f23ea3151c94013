"""The tree of seeds: every random stream of an episode, the same behind every door."""

from typing import Final

import numpy as np

from worlds.batches.streams import Stream

STREAMS: Final = (
    "oracle",
    "personality",
    "mixing",
    "voice",
    "teacher",
    "student",
    "order",
    "class",
    "information",
    "choice",
)
"""The streams beside the world's: the parts of a teacher, the policies in the seats of teacher and student, the order
of a panel's teachers, the students of a class (their seeds and drawn parameters), the worlds that measure claims, and
the worlds that a personality uses to choose among claims.
"""
TREE: Final = 2
"""Version of this tree. It increases when the same seed gives other streams."""
_BESIDE = 0x5EA75  # apart from the streams that a world spawns from the same seed
_NUMBER = {name: number for number, name in enumerate(STREAMS)}


class Seeds:
    """The random streams of an environment's episodes, beside the world's.

    The world has its own stream, that of the bare world after `reset(seed=seed)`, so that one seed is one world
    everywhere. A stream depends on the seed, its name, the number of the seat, and the number of episodes
    since the seed was given, but not on draws from other streams.

    Args:
        seed: a non-negative integer; None takes one from the operating system.
    """

    def __init__(self, seed: int | None = None) -> None:
        self._entropy = np.random.SeedSequence(seed).entropy
        self.episode = 0
        """Number of episodes since the seed was given."""

    def sequence(self, name: str, seat: int = 0) -> np.random.SeedSequence:
        """The seed of a stream of the present episode.

        Args:
            name: one of `STREAMS`.
            seat: number of the teacher or student if there are several.
        """
        return np.random.SeedSequence(self._entropy, spawn_key=(_BESIDE, _NUMBER[name], seat, self.episode))

    def stream(self, name: str, seat: int = 0) -> np.random.Generator:
        """A stream of the present episode, from its start; arguments as in `sequence`."""
        return np.random.default_rng(self.sequence(name, seat))


def streams_beside(rng: np.random.Generator, count: int) -> list[np.random.Generator]:
    """Random streams derived from a generator's seed; its own draws and children do not change."""
    if isinstance(rng, Stream):
        return [*rng.streams_beside(count)]
    seed: np.random.SeedSequence = rng.bit_generator.seed_seq  # type: ignore[assignment]  # NumPy's stubs have its interface
    keys = [(*seed.spawn_key, _BESIDE, number) for number in range(count)]
    return [np.random.default_rng(np.random.SeedSequence(seed.entropy, spawn_key=key)) for key in keys]
