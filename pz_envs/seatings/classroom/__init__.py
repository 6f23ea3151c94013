"""A classroom: one teacher, many students, and never enough attention for all of them."""

from typing import Any

from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import Attention, refuse_messages
from pz_envs.seatings.classroom.env import MOST, ClassroomEnv
from pz_envs.seatings.tutoring import SEATING as TUTORING
from pz_envs.seats import TEACHER
from pz_envs.subject import Seating, Subject
from pz_envs.teacher_seat import Purse, is_count

__all__ = ["MOST", "SEATING", "Classroom", "ClassroomEnv"]


class Classroom(Seating):
    """One teacher and so many students."""

    def raw_env(
        self,
        subject: Subject,
        *,
        students: int = 8,
        attention: int = 1,
        speech: str = "kinds",
        same_world: bool = False,
        until_success: bool = True,
        cost: float = 0.01,
        attention_cost: float = 0.01,
        budget: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> ClassroomEnv:
        """One teacher and so many students, 1 to 64; see `ClassroomEnv`.

        One budget is for the whole class. Other arguments are those of `Tutoring.raw_env` for each of the students,
        `teacher`, `max_cycles`, `text`, `feedback_type`, `ask_cost`, ..., and the world's options.

        Raises:
            ValueError: an argument is not allowed.
        """
        if not is_count(students, MOST):
            raise ValueError(f"students must be an integer from 1 to {MOST}, got {students!r}")
        chosen = "kinds" if speech == "message" else speech
        purse = Purse(cost, budget)
        options |= {"until_success": until_success, "purse": purse, "render_mode": render_mode}
        desks = [TUTORING.raw_env(subject, speech=chosen, **options) for _ in range(students)]
        return ClassroomEnv(
            desks,
            attention=attention,
            speech=speech,
            same_world=same_world,
            attention_cost=attention_cost,
            render_mode=render_mode,
        )

    def parallel_env(
        self, subject: Subject, *, rule: str = "round_robin", speech: str = "kinds", **settings: Any
    ) -> ParallelSeats:
        """The students, who act at the same time; a scripted teacher shares out its attention by a rule.

        See `pz_envs.scripted.Attention` for the rules, and `pz_envs.parallel_seats.ParallelSeats`.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"`.
        """
        refuse_messages(speech)
        return ParallelSeats(self.seats(subject, speech=speech, **settings), {TEACHER: Attention(rule)})


SEATING = Classroom()
