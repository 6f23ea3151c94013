"""A lesson assembled from its settings: a session and the views of its seats."""

import copy
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from pz_envs.frames import VIEW, EpisodeRenderer
from pz_envs.rewards import check_prices
from pz_envs.settings import Settings
from pz_envs.student_view import StudentView
from pz_envs.subject import Subject
from pz_envs.teacher_view import TeacherView
from pz_envs.text.actions import read_text, read_verbatim
from teachers.budget import Budget
from teachers.personality import Personality
from teachers.session import Read, Session
from teachers.teacher import Teacher
from worlds.pictures import TextPicture
from worlds.world import World

__all__ = ["Parts", "assemble"]


class Parts(NamedTuple):
    """A session with the views of its seats."""

    session: Session
    student_view: StudentView
    teacher_views: tuple[TeacherView, ...]


def assemble(
    subject: Subject,
    settings: Settings,
    *,
    personalities: Sequence[str | Personality | Teacher] = (),
    budget: Budget | None = None,
    instructs: bool | None = None,
) -> Parts:
    """The session for some settings, and its views.

    Args:
        subject: what is taught.
        settings: how.
        personalities: several teachers or their personalities, each with a budget of its own; empty: the settings'
        teacher.
        budget: a budget that the session shares with others; None: a new one, by the settings.
        instructs: as of `Session`; None: if the teacher chooses what to say.

    Raises:
        ValueError: a setting is not allowed.
    """
    own = settings.options
    visual = settings.visual and subject.visual
    world = subject.taught_world(**own, **({"visual": True} if visual else {}))
    check_prices(settings.ask_cost, settings.failure_reward, world.reward_range)
    drawn = settings.render_mode is not None or (settings.visual and not subject.visual)
    picture = subject.make_picture(world) if drawn else None
    image = _image_space(subject, world, picture, settings.text) if settings.visual else None
    max_turns = subject.turns(settings.max_turns)
    renderer = None
    if picture is not None:
        renderer = EpisodeRenderer(
            subject.name,
            picture,
            subject.oracle_class()(world.scratch),
            world.scratch(),
            max_turns=max_turns,
            theme=settings.theme,
            privileged=settings.privileged_info,
        )
    given = personalities or [settings.teacher]
    teachers = [_teacher(subject, world, each, settings) for each in given]
    session = Session(
        world,
        teachers,
        max_turns=max_turns,
        budgets=[budget or Budget(settings.cost, settings.budget) for _ in teachers],
        instructs=settings.speech != "message" if instructs is None else instructs,
        until_success=settings.until_success,
        repeated=subject.repeated,
        ask_cost=settings.ask_cost,
        failure_reward=settings.failure_reward,
        read=_reader(world, settings.text),
        observer=renderer,
    )
    student = StudentView(session, settings, image if settings.text else None, renderer)
    views = [TeacherView(session, settings.speech, settings.teacher_reward, i) for i in range(len(teachers))]
    return Parts(session, student, tuple(views))


def _teacher(subject: Subject, world: World[Any], teacher: str | Personality | Teacher, settings: Settings) -> Teacher:
    """The given teacher, or a new teacher with this personality."""
    if not isinstance(teacher, Teacher):
        return subject.make_teacher(world, teacher, **settings.wording)
    default = Settings().wording
    if changed := [name for name, value in settings.wording.items() if value != default.get(name)]:
        raise ValueError(
            f"{', '.join(changed)}: a given Teacher has its own; set it there, or give a personality as the teacher"
        )
    return teacher


def _reader(world: World[Any], text: bool) -> Read:
    """What reads the student's actions."""
    if text:
        return partial(read_text, world=world)
    return partial(read_verbatim if isinstance(world.action_space, spaces.Text) else _read_native, world=world)


def _read_native(action: Any, world: World[Any]) -> Any:
    """An action in the form of `World.legal`.

    Raises:
        ValueError: it is none; if it is a text, the message says how texts are read.
    """
    try:
        return world.legal(action)
    except ValueError as error:
        if not isinstance(action, str):
            raise
        raise ValueError(f"{error}; for actions in words make the environment with text=True") from None


def _image_space(subject: Subject, world: World[Any], picture: Any, text: bool) -> spaces.Space[Any]:
    """The space of the image beside the words: the world's own image, or its picture."""
    if subject.visual:
        return copy.deepcopy(world.observation_space["image"])  # type: ignore[index]  # it is a Dict
    if type(picture) is TextPicture:
        raise ValueError(f"visual=True is not supported by {subject.name}: it has no images; allowed: False")
    if not text:
        raise ValueError(
            f"visual=True is not supported by {subject.name} without text=True: its numbers have no image; set "
            "text=True, too, or render_mode='rgb_array' to draw frames"
        )
    return spaces.Box(0, 255, VIEW, np.uint8)
