"""For the tests of those who write teachers: `check_teacher(id, MyTeacher())`."""

from typing import Any

from llf_teacher.tools.audit import audit
from pz_envs.subject import Subject
from worlds.testing import require


def check_teacher(id: str | Subject, teacher: Any, **settings: Any) -> None:
    """A teacher keeps its promises: an honest one says nothing false, and none leaks.

    Args:
        id, teacher, settings: as `llf_teacher.tools.audit.audit` takes them.

    Raises:
        AssertionError: it does not; the message has what it said, and where.
    """
    found = audit(id, teacher, **settings)
    require(found.turns > 0 and found.checked > 0, f"{found.teacher} made no claim in {found.id}: nothing to check")
    examples = "".join(f"\n  {example}" for example in found.examples)
    require(not found.caught, f"{found.teacher} was caught in {found.id}:{examples}")
