"""The mirror of the suite: what a teacher is worth to known students, one quality a module."""

from llf_teacher.suite.mirror.play import VERSION, TeacherCard, digest, take
from llf_teacher.suite.mirror.quality import Quality, all_qualities

__all__ = ["VERSION", "Quality", "TeacherCard", "all_qualities", "digest", "take"]
