"""The tree of seeds: every random stream of an episode, the same behind every door."""

from typing import Final

import numpy as np

STREAMS: Final = ("oracle", "personality", "mixing", "voice", "teacher", "student", "order", "class")
"""What has a stream of its own, beside the world: the parts of a teacher, policies in the seats of teacher and student,
the order of a panel's teachers, and who the students are: the seeds of a class, parameters that are drawn.
"""
TREE: Final = 2
"""Version of this tree: it goes up when a seed no longer gives the same streams. 1 was before a seed was one world."""
_BESIDE = 0x5EA75  # apart from what a world may spawn from the same seed
_NUMBER = {name: number for number, name in enumerate(STREAMS)}


class Seeds:
    """The random streams of an environment's episodes, beside the world's.

    The world's stream is not among them: it is that of the bare world after `reset(seed=seed)`, so that a seed is the
    same world wherever it is taught. Every stream is determined by the seed, its name, the number of the seat, and the
    number of episodes since the seed was given; no stream depends on how much has been drawn from another.

    Args:
        seed: a non-negative integer; None: one of the operating system's.
    """

    def __init__(self, seed: int | None = None) -> None:
        self._entropy = np.random.SeedSequence(seed).entropy
        self.episode = 0
        """Number of episodes that have begun since the seed was given."""

    def sequence(self, name: str, seat: int = 0) -> np.random.SeedSequence:
        """The seed of a stream of the present episode.

        Args:
            name: one of `STREAMS`.
            seat: which teacher or student, where there are several.
        """
        return np.random.SeedSequence(self._entropy, spawn_key=(_BESIDE, _NUMBER[name], seat, self.episode))

    def stream(self, name: str, seat: int = 0) -> np.random.Generator:
        """A stream of the present episode from its beginning; arguments as in `sequence`."""
        return np.random.default_rng(self.sequence(name, seat))
