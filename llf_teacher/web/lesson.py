"""A lesson on the page, with its record and its film."""

from collections.abc import Iterable
from dataclasses import replace

from llf_teacher.episodes.live import Input, LiveLesson
from llf_teacher.episodes.record import Record
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.study import DRAWS
from llf_teacher.web.plan import Plan
from pz_envs.seats import STUDENT, TEACHER
from worlds.pictures.canvas import Frame

__all__ = ["PlannedLesson", "frames"]


class PlannedLesson(LiveLesson):
    """The lesson of a plan.

    Args:
        plan: the plan.

    Raises:
        ValueError: the student cannot play here.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        found = entry(plan.id)
        student = None if STUDENT in plan.people else parse_student(plan.student)
        settings = replace(
            plan.settings,
            speech=plan.settings.speech if TEACHER in plan.people else "message",
            text=student is None or student.text,
            render_mode="rgb_array",
            privileged_info=True,
            options={**found.options, **plan.options},
        )
        super().__init__(found, settings, plan.seed, plan.people, student, DRAWS if plan.bits else 0)

    def record(self) -> Record:
        """The record of the episode.

        Raises:
            ValueError: the episode is not over.
        """
        self.check_over()
        return Record(self.plan.spec(), self._recorder.episode(self.reads), tuple(self.rows))

    def check_over(self) -> None:
        """Check that the episode is over.

        Raises:
            ValueError: it is not.
        """
        if not self.over:
            raise ValueError("the episode is not over; play it to its end first")


def frames(plan: Plan, inputs: Iterable[Input], theme: str = "light") -> list[Frame]:
    """The frames of all turns of a lesson, with the truth; plays the episode again."""
    filmed = _Filmed(plan, theme)
    filmed.play_again(inputs)
    filmed.close()
    return filmed.frames


class _Filmed(PlannedLesson):
    """A lesson that stores a frame of each turn."""

    def __init__(self, plan: Plan, theme: str) -> None:
        self._theme = theme
        self.frames: list[Frame] = []
        super().__init__(plan)

    def _note(self) -> None:
        super()._note()
        self.frames.append(self.view.require_renderer().with_theme(self._theme).frame(self.view.description()))
