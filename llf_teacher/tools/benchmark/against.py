"""Whether this installation is slower than another one: both play the same fresh work in turns, in one run."""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from llf_teacher.registry import PREFIX
from llf_teacher.tools.benchmark.measuring import Call, Ratio, measure, ratio
from llf_teacher.tools.benchmark.tables import STUDENTS, Progress, blocks_of, steps_of
from pz_envs.family import Family

ALLOWED = 1.25
"""What is surely slower than this fails."""
_CALLS = {"all feedback": "a", "no feedback": "n"}


class Compared(NamedTuple):
    """One kind of work, here and there."""

    id: str
    work: str
    ratio: Ratio
    """Of the time here to the time there."""

    @property
    def slower(self) -> bool:
        """Whether the lower end of the interval is above what is allowed."""
        return self.ratio.low > ALLOWED


def compare(families: Sequence[Family], other: str, progress: Progress) -> Iterator[Compared]:
    """Steps of the families, with and without feedback, here and in another installation.

    What seems slower is played once more: intervals do not know that one process may be slower than its twin.

    Args:
        families: of which the first environment is played, random actions and advised ones.
        other: a folder that holds the packages, or a revision of the repository in which they lie.
        progress: is told what comes next.

    Raises:
        ValueError: that is neither.
    """
    with tree_of(other) as tree:
        for family in families:
            id = PREFIX + family.showcase[0]
            for name, student in STUDENTS.items():
                blocks = blocks_of(id, student, steps_of(family))
                for work, feedback_type in _CALLS.items():
                    progress(f"{id}, {name} actions, {work}")
                    call = Call("student", (id, feedback_type))
                    calls = {"here": (call, None), "there": (call, tree)}
                    for _ in range(2):  # in new processes each time
                        found = measure(calls, {"here": blocks, "there": blocks})
                        compared = Compared(id, f"{name} actions, {work}", ratio(found["here"], found["there"]))
                        if not compared.slower:
                            break
                    yield compared


@contextmanager
def tree_of(other: str) -> Iterator[Path]:
    """The folder of an installation's packages; a revision is checked out into a folder that goes away again."""
    folder = Path(other)
    if (folder / "llf_teacher").is_dir():
        yield folder.resolve()
        return
    git = shutil.which("git")
    home = Path(sys.modules["llf_teacher"].__path__[0]).parent
    packed = git and subprocess.run([git, "archive", "--format=zip", other], cwd=home, capture_output=True, check=False)  # noqa: S603
    if not packed or packed.returncode:
        said = packed.stderr.decode().strip() if packed else "git was not found"
        raise ValueError(
            f"{other!r} is neither a folder with the package llf_teacher in it nor a revision of {home} ({said}); "
            f"give one of these, such as HEAD~1"
        )
    with tempfile.TemporaryDirectory() as temporary:
        archive = Path(temporary) / "tree.zip"
        archive.write_bytes(packed.stdout)
        shutil.unpack_archive(archive, Path(temporary) / "tree")
        yield Path(temporary) / "tree"
