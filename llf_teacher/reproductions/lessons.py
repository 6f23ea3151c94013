"""Single episodes, for several rows, played as in studies."""

import math
from typing import Any

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from teachers.information import Gain


def regrets(
    id: str, *, student: str, teacher: str, seed: int, turns: int | None = None, **options: Any
) -> tuple[list[float], list[bool]]:
    """Regret and success of each turn of an episode.

    Args:
        id: the environment.
        student: its spec.
        teacher: the personality's spec.
        seed: of the episode.
        turns: greatest number; None: that of the family.
        options: of the world.
    """
    player = parse_student(student)
    env = make(id, teacher=teacher, max_turns=turns, text=player.text, **options)
    oracle = env.session.teacher.oracle
    policy = player.seat(env.family, env.session.world)
    played = [turn.moment for turn in play_turns(env, policy, seed)][1:]
    env.close()
    return [oracle.regret(moment) for moment in played], [moment.success for moment in played]


def informed(
    id: str, *, student: str, teacher: str, seed: int, turns: int, worlds: int, **options: Any
) -> tuple[list[float], Gain]:
    """Regret of each turn of an episode, and how much was said to the student.

    Args:
        id: the environment, whose worlds have a posterior.
        student: its spec.
        teacher: the personality's spec.
        seed: of the episode.
        turns: greatest number.
        worlds: number of worlds by which each claim is measured.
        options: of the world.
    """
    player = parse_student(student)
    env = make(id, teacher=teacher, max_turns=turns, text=player.text, **options)
    oracle, information = env.session.teacher.oracle, env.family.make_information(env.session.world, seed, worlds)
    lost, gain = [], Gain()
    for turn in play_turns(env, player.seat(env.family, env.session.world), seed):
        if turn.moment.turn:
            lost.append(oracle.regret(turn.moment))
        information.see(turn.moment)
        for atom, bits in zip(turn.atoms, information.hear(turn.atoms), strict=True):
            gain += Gain.of(atom.text, bits)
    env.close()
    return lost, gain


def total(values: list[float]) -> float:
    """The exact sum, which is the same in every version of Python."""
    return math.fsum(values)
