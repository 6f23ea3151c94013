"""Compare the behaviour of this installation with another: both play the same fresh episodes."""

from collections.abc import Iterator
from contextlib import closing
from typing import NamedTuple

from llf_teacher.tools.benchmark.measuring import Call, Player, Writer
from llf_teacher.tools.benchmark.speed import tree_of
from llf_teacher.tools.benchmark.timings import STUDENTS, Progress

_CHUNK = 25
"""Episodes in one call of a player."""


class Mismatch(NamedTuple):
    """The first turn in which two installations differ, with the text of each from shortly before the difference."""

    seed: int
    turn: int
    here: str
    there: str


class Equality(NamedTuple):
    """The comparison of one environment with one teacher."""

    id: str
    teacher: str
    episodes: int
    turns: int
    """Number of turns, resets included."""
    differing: int
    """Number of episodes that differ."""
    first: Mismatch | None


def compare(
    ids: list[str], teachers: list[str], other: str, episodes: int, turns: int, progress: Progress
) -> Iterator[Equality]:
    """Play fresh episodes of each environment and teacher here and in another installation.

    Every other episode has random actions, the others have advised ones. Observations with every word, rewards, ends,
    success and atoms (claims, number, order, and every value in them) are compared, floats to the last bit.

    Args:
        ids: ids of environments.
        teachers: specs of personalities.
        other: a folder with the packages, or a revision of this repository.
        episodes: number of episodes of each environment and teacher.
        turns: greatest number of turns of an episode.
        progress: called with a line about the next work.

    Raises:
        ValueError: `other` is neither a folder with the packages nor a revision.
    """
    with tree_of(other) as tree:
        for id in ids:
            writers = [Writer(id, student) for student in STUDENTS.values()]
            for teacher in teachers:
                call = Call("record", (id, teacher))
                with closing(Player(call)) as here, closing(Player(call, tree)) as there:
                    yield _compared(here, there, writers, (id, teacher), (episodes, turns), progress)


def _compared(
    here: Player,
    there: Player,
    writers: list[Writer],
    names: tuple[str, str],
    most: tuple[int, int],
    progress: Progress,
) -> Equality:
    episodes, turns = most
    played, differing, first = 0, 0, None
    for begun in range(0, episodes, _CHUNK):
        progress(f"{' with '.join(names)}: {begun} of {episodes} episodes")
        chosen = range(begun, min(begun + _CHUNK, episodes))
        scripts = [writers[each % len(writers)].episode(turns) for each in chosen]
        for (seed, _), mine, theirs in zip(scripts, here.play(scripts), there.play(scripts), strict=True):
            played += len(mine)
            if mine != theirs:
                differing += 1
                first = first or _mismatch(seed, mine, theirs)
    return Equality(*names, episodes, played, differing, first)


def _mismatch(seed: int, mine: list[str], theirs: list[str]) -> Mismatch:
    ended = "(over)"
    turn = next(
        (turn for turn, (a, b) in enumerate(zip(mine, theirs, strict=False)) if a != b), min(len(mine), len(theirs))
    )
    a, b = (texts[turn] if turn < len(texts) else ended for texts in (mine, theirs))
    begin = max(next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), 0) - 100, 0)
    return Mismatch(seed, turn, a[begin:][:300], b[begin:][:300])
