"""Single episodes that rows have in common, played as studies play them."""

import math
from typing import Any

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student


def regrets(
    id: str, *, student: str, teacher: str, seed: int, turns: int | None = None, **options: Any
) -> tuple[list[float], list[bool]]:
    """Regret and success of each turn of an episode.

    Args:
        id: the environment.
        student: its spec.
        teacher: the personality's spec.
        seed: of the episode.
        turns: at most; None: the family's number.
        options: the world's.
    """
    player = parse_student(student)
    env = make(id, teacher=teacher, max_turns=turns, text=player.text, **options)
    oracle = env.session.teacher.oracle
    policy = player.seat(env.family, env.session.world)
    played = [turn.moment for turn in play_turns(env, policy, seed)][1:]
    env.close()
    return [oracle.regret(moment) for moment in played], [moment.success for moment in played]


def total(values: list[float]) -> float:
    """Their sum, the same under every Python."""
    return math.fsum(values)
