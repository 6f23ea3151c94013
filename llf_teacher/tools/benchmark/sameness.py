"""Whether another installation says and does the same: both play the same fresh episodes."""

from collections.abc import Iterator
from contextlib import closing
from typing import NamedTuple

from llf_teacher.tools.benchmark.against import tree_of
from llf_teacher.tools.benchmark.measuring import Call, Player, Writer
from llf_teacher.tools.benchmark.tables import STUDENTS, Progress

_CHUNK = 25
"""Episodes that are played at a time."""


class Parting(NamedTuple):
    """The first turn at which two installations part."""

    seed: int
    turn: int
    here: str
    there: str


class Sameness(NamedTuple):
    """What was compared of one environment and one teacher."""

    id: str
    teacher: str
    episodes: int
    turns: int
    """Resets are counted."""
    differing: int
    """Episodes."""
    first: Parting | None


def same(
    ids: list[str], teachers: list[str], other: str, episodes: int, turns: int, progress: Progress, fast: bool = False
) -> Iterator[Sameness]:
    """Fresh episodes of each environment and teacher, of random actions and of advised ones in turns, here and there.

    Compared are observations with every word, rewards, ends, success and atoms: their claims, their number, their order
    and every value in them, floats to the last bit.

    Args:
        ids: of environments.
        teachers: specs of personalities.
        other: a folder that holds the packages, or a revision of the repository in which they lie.
        episodes: of each environment and teacher.
        turns: that an episode has at most.
        progress: is told what comes next.
        fast: whether what is here is played with the extra `fast`.

    Raises:
        ValueError: `other` is neither.
    """
    with tree_of(other) as tree:
        for id in ids:
            writers = [Writer(id, student) for student in STUDENTS.values()]
            for teacher in teachers:
                call = Call("record", (id, teacher))
                with closing(Player(call._replace(compiled=fast))) as here, closing(Player(call, tree)) as there:
                    yield _compared(here, there, writers, (id, teacher), (episodes, turns), progress)


def _compared(
    here: Player,
    there: Player,
    writers: list[Writer],
    names: tuple[str, str],
    most: tuple[int, int],
    progress: Progress,
) -> Sameness:
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
                first = first or _parting(seed, mine, theirs)
    return Sameness(*names, episodes, played, differing, first)


def _parting(seed: int, mine: list[str], theirs: list[str]) -> Parting:
    ended = "(over)"
    turn = next(
        (turn for turn, (a, b) in enumerate(zip(mine, theirs, strict=False)) if a != b), min(len(mine), len(theirs))
    )
    a, b = (texts[turn] if turn < len(texts) else ended for texts in (mine, theirs))
    begin = max(next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), 0) - 100, 0)
    return Parting(seed, turn, a[begin:][:300], b[begin:][:300])
