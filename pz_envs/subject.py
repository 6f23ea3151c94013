"""What can be taught: what makes worlds, and teachers and seats for them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from pettingzoo.utils import wrappers

from pz_envs.learning import Learning

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.classroom import ClassroomEnv
    from pz_envs.panel import PanelEnv
    from pz_envs.rewards import TeacherReward
    from pz_envs.tutoring import TutoringEnv
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase, Phrasebook
    from teachers.teacher import Teacher
    from teachers.voice import Voice
    from worlds.world import World


class Subject(ABC):
    """What can be taught: it makes worlds, and teachers and seats for them."""

    name: str
    max_cycles: int
    """Turns of the student after which an episode is truncated."""
    repeated: bool
    """Whether success ends nothing: a one-step problem without state, asked again and again."""
    regret_unit: str
    """What regret counts, as in "extra moves"."""
    learning: Learning
    """What rewards alone teach."""
    visual: bool = False
    """Whether its worlds have an option `visual` that adds images to the observation."""

    @abstractmethod
    def make_world(self, **options: Any) -> "World":
        """A new world."""

    @abstractmethod
    def oracle_class(self) -> "Callable[[Callable[[], World]], Oracle]":
        """What makes an oracle of a function that makes scratch worlds."""

    @abstractmethod
    def phrasebook(self, voice: "Voice" = "plain") -> "Phrasebook":
        """The words of the teachers."""

    def taught_world(self, **options: Any) -> "World":
        """The world of new seats."""
        return self.make_world(**options)

    def serves(self, personality: "str | Personality") -> bool:
        """Whether the oracle can do what a personality needs."""
        from teachers.personality import parse_personality

        oracle = self.oracle_class()
        able = oracle if isinstance(oracle, type) else oracle(self.make_world().scratch)
        return parse_personality(personality).needs <= able.abilities()

    def make_teacher(
        self,
        world: "World",
        personality: "str | Personality" = "oracle",
        *,
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: "Voice" = "plain",
        paraphrase: "Paraphrase" = "random",
    ) -> "Teacher":
        """A teacher for such a world; arguments and errors as in `teachers.teacher.Teacher`."""
        from teachers.teacher import Teacher

        return Teacher(
            self.oracle_class()(world.scratch),
            self.phrasebook(voice),
            personality,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            paraphrase=paraphrase,
        )

    def raw_env(
        self,
        *,
        teacher: "str | Personality" = "oracle",
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: "Voice" = "plain",
        paraphrase: "Paraphrase" = "random",
        max_cycles: int | None = None,
        render_mode: str | None = None,
        speech: str = "message",
        text: bool = False,
        cost: float = 0.01,
        budget: int | None = None,
        teacher_reward: "str | TeacherReward" = "student_reward",
        until_success: bool = False,
        **options: Any,
    ) -> "TutoringEnv":
        """The bare AEC environment; see `pz_envs.tutoring.TutoringEnv`. Other arguments are the world's options.

        With `speech="kinds"` the personality `teacher` says which claims there are to choose from.
        """
        from pz_envs.tutoring import TutoringEnv

        world = self.taught_world(**options)
        tutor = self.make_teacher(
            world,
            teacher,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            voice=voice,
            paraphrase=paraphrase,
        )
        return TutoringEnv(
            world,
            tutor,
            name=self.name,
            max_cycles=self.max_cycles if max_cycles is None else max_cycles,
            repeated=self.repeated,
            render_mode=render_mode,
            speech=speech,
            text=text,
            cost=cost,
            budget=budget,
            teacher_reward=teacher_reward,
            until_success=until_success,
        )

    def env(self, **kwargs: Any) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order."""
        return wrappers.OrderEnforcingWrapper(self.raw_env(**kwargs))

    def parallel_env(self, **kwargs: Any) -> "ParallelEnv":
        """The parallel form: both seats act, the seat whose turn it is not is ignored."""
        from pettingzoo.utils.conversions import turn_based_aec_to_parallel

        return turn_based_aec_to_parallel(self.env(**kwargs))

    def raw_classroom_env(
        self,
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
    ) -> "ClassroomEnv":
        """One teacher and so many students, 1 to 64; see `pz_envs.classroom.ClassroomEnv`.

        Other arguments are those of `raw_env` for each of the students, `max_cycles`, `text`, `feedback_type`, ...
        """
        from pz_envs.classroom import MOST, ClassroomEnv
        from pz_envs.teacher_seat import is_count

        if not is_count(students, MOST):
            raise ValueError(f"students must be an integer from 1 to {MOST}, got {students!r}")
        desks = [self.raw_env(speech="kinds", until_success=until_success, **options) for _ in range(students)]
        return ClassroomEnv(
            desks,
            attention=attention,
            speech=speech,
            same_world=same_world,
            cost=cost,
            attention_cost=attention_cost,
            budget=budget,
            render_mode=render_mode,
        )

    def classroom_env(self, **kwargs: Any) -> "AECEnv":
        """The classroom with PettingZoo's check of the calling order."""
        return wrappers.OrderEnforcingWrapper(self.raw_classroom_env(**kwargs))

    def parallel_classroom_env(
        self, *, rule: str = "round_robin", speech: str = "kinds", **kwargs: Any
    ) -> "ParallelEnv":
        """The students of a classroom, who act at the same time; a scripted teacher shares out its attention by a rule.

        See `pz_envs.scripted.Attention` for the rules, and `pz_envs.parallel_seats.ParallelSeats`.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"`.
        """
        from pz_envs.parallel_seats import ParallelSeats
        from pz_envs.scripted import Attention
        from pz_envs.tutoring import TEACHER

        _check_scripted(speech)
        return ParallelSeats(self.raw_classroom_env(speech=speech, **kwargs), {TEACHER: Attention(rule)})

    def raw_panel_env(
        self,
        *,
        teachers: "Sequence[str | Personality]" = ("oracle", "oracle"),
        speech: str = "kinds",
        order: str = "fixed",
        cost: float = 0.01,
        budget: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> "PanelEnv":
        """Several teachers of these personalities and one student; see `pz_envs.panel.PanelEnv`.

        Other arguments are those of `raw_env`, `max_cycles`, `text`, `feedback_type`, ...
        """
        from pz_envs.panel import PanelEnv, check_teachers

        check_teachers(teachers)
        desk, *others = (self.raw_env(speech="kinds", teacher=teacher, **options) for teacher in teachers)
        return PanelEnv(
            desk,
            [each.tutor for each in (desk, *others)],
            speech=speech,
            order=order,
            cost=cost,
            budget=budget,
            render_mode=render_mode,
        )

    def panel_env(self, **kwargs: Any) -> "AECEnv":
        """The panel with PettingZoo's check of the calling order."""
        return wrappers.OrderEnforcingWrapper(self.raw_panel_env(**kwargs))

    def parallel_panel_env(self, *, speech: str = "kinds", **kwargs: Any) -> "ParallelEnv":
        """The student of a panel alone; each teacher says all that its personality would say.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"`.
        """
        from pz_envs.parallel_seats import ParallelSeats
        from pz_envs.scripted import Frank

        _check_scripted(speech)
        env = self.raw_panel_env(speech=speech, **kwargs)
        return ParallelSeats(env, {teacher: Frank() for teacher in env.teachers})


def _check_scripted(speech: str) -> None:
    """Check the speech of teachers that are scripted."""
    if speech == "message":
        raise ValueError(
            "speech 'message' has no parallel form, whose teachers are scripted; allowed: kinds; for messages take the "
            "AEC form, as it is or with policies of your own in pz_envs.parallel_seats.ParallelSeats"
        )
