"""Environments by their ids."""

from collections.abc import Iterable
from typing import Any

import gymnasium

from llf_teacher.gym.student_env import StudentEnv
from llf_teacher.registry import entry
from teachers.personality import Personality
from teachers.phrasebook import Paraphrase
from teachers.voice import Voice


def make(
    id: str,
    *,
    instruction_type: str = "b",
    feedback_type: str | Iterable[str] = "a",
    teacher: str | Personality | Any = "oracle",
    voice: Voice = "plain",
    paraphrase: Paraphrase = "random",
    visual: bool = False,
    **options: Any,
) -> StudentEnv:
    """The student's side of an environment, with a teacher in the other seat.

    Args:
        id: an id of `ids()`, or its alias `verbal-...`.
        instruction_type: `b` basic, `p` with hindsight on some tried actions, `c` complete.
        feedback_type: `a` all kinds, `n` none, `m` a random subset each turn, or kinds among r, hp, hn, fp,
            fn, as `"r+hp"`, a set, a list or a tuple.
        teacher: a personality's spec string, a `Personality`, a `Teacher`, or any policy with `reset(rng)` and
            `act(observation, info)` for the teacher's seat.
        voice: the tone: `plain`, `curt`, `socratic`, `warm`, the path of a voice of your own, or a function that
            rewrites a sentence.
        paraphrase: `"random"`, an index or a callable `(templates, **slots) -> str`.
        visual: ask for images: those of the world itself where it has any; with `text=True` an `image` beside the text,
            of every family that is drawn.
        options: `text`, `max_turns`, `privileged_info`, `render_mode` of `StudentEnv`, `failure_reward`, of a text that
            is no action (None: one that no student can live on), and the world's options.

    Raises:
        ValueError: an unknown id, or an argument that is not supported.
    """
    return gymnasium.make(
        entry(id).id,
        instruction_type=instruction_type,
        feedback_type=feedback_type,
        teacher=teacher,
        voice=voice,
        paraphrase=paraphrase,
        visual=visual,
        **options,
    )  # type: ignore[return-value]
