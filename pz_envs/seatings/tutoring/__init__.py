"""Tutoring: a teacher and a student take turns over a world."""

import copy
from collections.abc import Iterable
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.numbers import Embed
from pz_envs.rewards import TeacherReward
from pz_envs.seatings.tutoring.env import TutoringEnv
from pz_envs.seatings.tutoring.words import words_space
from pz_envs.seats import check_flags
from pz_envs.subject import Seating, Subject
from pz_envs.teacher_seat import Purse
from teachers.personality import Personality
from teachers.phrasebook import Paraphrase
from teachers.teacher import Teacher
from teachers.voice import Voice
from worlds.world import World

__all__ = ["SEATING", "Tutoring", "TutoringEnv", "words_space"]


class Tutoring(Seating):
    """One teacher, one student."""

    def raw_env(
        self,
        subject: Subject,
        *,
        teacher: str | Personality | Teacher = "oracle",
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: Voice = "plain",
        paraphrase: Paraphrase = "random",
        max_cycles: int | None = None,
        render_mode: str | None = None,
        privileged_info: bool = False,
        theme: str = "light",
        speech: str = "message",
        text: bool = False,
        visual: bool = False,
        numbers: bool = False,
        embed: Embed | None = None,
        cost: float = 0.01,
        budget: int | None = None,
        purse: Purse | None = None,
        teacher_reward: str | TeacherReward = "student_reward",
        until_success: bool = False,
        ask_cost: float | None = None,
        failure_reward: float | None = None,
        **options: Any,
    ) -> TutoringEnv:
        """The bare AEC environment; see `TutoringEnv`. Other arguments are the world's options.

        With `speech="kinds"` or `"claims"` the personality `teacher` says what there is to choose from, with `message`
        it makes suggestions. A `Teacher` that is given as it is brings its own instruction, feedback, voice and
        paraphrase along. Frames show what the student may know; with `privileged_info` the truth as well, and whether
        what was said holds. `theme` is `light` or `dark`. With `visual` the world adds an image to what is observed,
        where it can; otherwise it is drawn, beside a text.

        Raises:
            ValueError: an argument is not allowed.
        """
        check_flags(privileged_info=privileged_info, visual=visual)
        world = subject.taught_world(**options, **({"visual": True} if visual and subject.visual else {}))
        picture = None if render_mode is None and (subject.visual or not visual) else subject.make_picture(world)
        image = _image_space(subject, world, picture, text) if visual else None
        settings: dict[str, Any] = {
            "instruction_type": instruction_type,
            "feedback_type": feedback_type,
            "voice": voice,
            "paraphrase": paraphrase,
        }
        if isinstance(teacher, Teacher):
            changed = [name for name, value in settings.items() if value != _DEFAULTS[name]]
            if changed:
                raise ValueError(
                    f"{', '.join(changed)}: a Teacher that is given as it is has its own; set it there, or give a "
                    "personality as the teacher"
                )
        else:
            teacher = subject.make_teacher(world, teacher, **settings)
        seated: dict[str, Any] = {
            "name": subject.name,
            "max_cycles": subject.max_turns if max_cycles is None else max_cycles,
            "repeated": subject.repeated,
            "render_mode": render_mode,
            "speech": speech,
            "text": text,
            "image": image if text else None,
            "numbers": numbers,
            "embed": embed,
            "cost": cost,
            "budget": budget,
            "purse": purse,
            "teacher_reward": teacher_reward,
            "until_success": until_success,
            "ask_cost": ask_cost,
            "failure_reward": failure_reward,
        }
        if picture is None:
            return TutoringEnv(world, teacher, **seated)
        from pz_envs.frames import Watch
        from pz_envs.seatings.tutoring.shown import ShownTutoring

        watch = Watch(
            subject.name,
            picture,
            subject.oracle_class()(world.scratch),
            world.scratch(),
            max_turns=seated["max_cycles"],
            theme=theme,
            privileged=privileged_info,
        )
        return ShownTutoring(world, teacher, watch=watch, **seated)


def _image_space(subject: Subject, world: World[Any], picture: Any, text: bool) -> spaces.Space[Any]:
    """The space of what is seen beside words: the world's own image, or its picture."""
    if subject.visual:
        return copy.deepcopy(world.observation_space["image"])  # type: ignore[index]  # a Dict, if it has images
    from pz_envs.frames import VIEW
    from worlds.pictures import TextPicture

    if type(picture) is TextPicture:
        raise ValueError(f"visual=True is not supported by {subject.name}: it has no images; allowed: False")
    if not text:
        raise ValueError(
            f"visual=True is not supported by {subject.name} without text=True: its numbers have no image; set "
            "text=True, too, or render_mode='rgb_array' to draw frames"
        )
    return spaces.Box(0, 255, VIEW, np.uint8)


_DEFAULTS = {"instruction_type": "b", "feedback_type": "a", "voice": "plain", "paraphrase": "random"}
SEATING = Tutoring()
