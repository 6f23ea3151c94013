"""Compare the speed of this installation with another: both play the same fresh episodes alternately, in one run."""

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
from llf_teacher.tools.benchmark.timings import STUDENTS, Progress, blocks_of, steps_of
from pz_envs.family import Family

ALLOWED = 1.25
"""Default of the greatest accepted ratio of times; work is slower if the interval lies above it."""


class Speed(NamedTuple):
    """The speed of one kind of work, here and in the other installation."""

    id: str
    work: str
    ratio: Ratio
    """Time here divided by time there."""
    limit: float = ALLOWED

    @property
    def slower(self) -> bool:
        """Whether the lower end of the interval is above the limit."""
        return self.ratio.low > self.limit


def _work(id: str, student: str, everything: bool) -> dict[str, Call]:
    """The compared kinds of work, by name."""
    steps = {"all feedback": Call("student", (id, "a")), "no feedback": Call("student", (id, "n"))}
    others = {
        "raw_env": Call("seats", (id, "raw_env")),
        "TeacherEnv": Call("teacher", (id,)),
        "study": Call("study", (id, student)),
    }
    return steps | others if everything else steps


def compare_speed(
    families: Sequence[Family], other: str, progress: Progress, everything: bool = False, limit: float = ALLOWED
) -> Iterator[Speed]:
    """Compare steps with and without feedback, here and in another installation.

    Slower work is measured once more in new processes, because two processes of the same code can differ.

    Args:
        families: the first environment of each plays, with random actions and with advised ones.
        other: a folder with the packages, or a revision of this repository.
        progress: called with the name of the next work.
        everything: whether to compare `raw_env`, `TeacherEnv` and a study, too.
        limit: work is slower if the interval of its ratio of times lies above it.

    Raises:
        ValueError: `other` is neither a folder with the packages nor a revision.
    """
    with tree_of(other) as tree:
        for family in families:
            id = PREFIX + family.showcase[0]
            for name, student in STUDENTS.items():
                blocks = blocks_of(id, student, steps_of(family))
                for work, call in _work(id, student, everything).items():
                    progress(f"{id}, {name} actions, {work}")
                    calls = {"here": (call, None), "there": (call, tree)}
                    for _ in range(2):  # in new processes each time
                        found = measure(calls, {"here": blocks, "there": blocks})
                        compared = Speed(id, f"{name} actions, {work}", ratio(found["here"], found["there"]), limit)
                        if not compared.slower:
                            break
                    yield compared


@contextmanager
def tree_of(other: str) -> Iterator[Path]:
    """The folder with an installation's packages; a revision is unpacked into a temporary folder."""
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
            f"{other!r} is neither a folder with the package llf_teacher nor a revision of {home} ({said}); "
            "give one of these, such as HEAD~1"
        )
    with tempfile.TemporaryDirectory() as temporary:
        archive = Path(temporary) / "tree.zip"
        archive.write_bytes(packed.stdout)
        shutil.unpack_archive(archive, Path(temporary) / "tree")
        yield Path(temporary) / "tree"
