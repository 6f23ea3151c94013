"""Single episodes, for several rows, played as in studies."""

import math
from collections.abc import Iterator
from typing import Any

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv, make
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy
from teachers.information import Bits
from teachers.session import Turn


def seated(id: str, student: str, teacher: str, turns: int | None, **options: Any) -> tuple[StudentEnv, Policy[Any]]:
    """An environment, and a student in its seat; arguments as of `regrets`."""
    player = parse_student(student)
    env = make(id, teacher=teacher, max_turns=turns, text=player.text, **options)
    return env, player.seat(env.family, env.session.world)


def judged(
    env: StudentEnv, policy: Policy[Any], seed: int, worlds: int = 0
) -> Iterator[tuple[Turn, float, tuple[Bits, ...]]]:
    """The turns of an episode, the opening first, each with its regret and with how much each of its atoms said.

    Args:
        env: which is closed at the end.
        policy: the student.
        seed: of the episode.
        worlds: number of worlds by which each claim is measured; 0: none is.
    """
    oracle = env.session.teacher.oracle
    information = env.family.make_information(env.session.world, seed, worlds) if worlds else None
    for turn in play_turns(env, policy, seed):
        bits: tuple[Bits, ...] = ()
        if information is not None:
            information.see(turn.moment)
            bits = information.hear(turn.atoms)
        yield turn, oracle.regret(turn.moment) if turn.moment.turn else 0.0, bits
    env.close()


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
    _, *played = judged(*seated(id, student, teacher, turns, **options), seed)
    return [lost for _, lost, _ in played], [turn.moment.success for turn, *_ in played]


def total(values: list[float]) -> float:
    """The exact sum, which is the same in every version of Python."""
    return math.fsum(values)
