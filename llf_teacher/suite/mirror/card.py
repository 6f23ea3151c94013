"""A card of a teacher: that of the suite, in other words."""

from dataclasses import dataclass
from typing import ClassVar

from llf_teacher.suite.card import Card
from llf_teacher.suite.mirror.quality import all_qualities


@dataclass(frozen=True, kw_only=True)
class TeacherCard(Card):
    """What a teacher is worth to known students; `student` is the spec of the teacher."""

    role: ClassVar[str] = "teacher"
    about: ClassVar[str] = "what it is worth to known students"
    scale: ClassVar[str] = "0: nothing of it        1: as the reference"

    @classmethod
    def ability_of(cls, name: str) -> str:
        """What a teacher with the quality does."""
        return all_qualities()[name].ability
