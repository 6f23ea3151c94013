"""The loop over a session: a policy in the student's seat plays an episode."""

from collections.abc import Iterator
from typing import Any

from llf_teacher.gym import StudentEnv
from teachers.seeds import Seeds
from teachers.session import Turn

__all__ = ["play_remaining_turns", "play_turns"]


def play_turns(
    env: StudentEnv, policy: Any, seed: int, options: dict[str, Any] | None = None, sample: int = 0
) -> Iterator[Turn]:
    """Play an episode. It stops at success, as in LLF-Bench's evaluation, unless the task is asked repeatedly.

    Args:
        env: the student's environment, with a teacher in the other seat.
        policy: has `reset(rng)` and `act(observation, info)`.
        seed: the episode's seed, for world, teacher and policy.
        options: options of the world's `reset`.
        sample: the number of the policy's random stream.

    Yields:
        The record of each turn, the opening first.
    """
    policy.reset(Seeds(seed).stream("student", sample))
    env.reset(seed=seed, options=options)
    yield from play_remaining_turns(env, policy)


def play_remaining_turns(env: StudentEnv, policy: Any) -> Iterator[Turn]:
    """Play the rest of an episode; yields the record of each turn, beginning with the last completed one."""
    session, view = env.session, env.student_view
    yield session.turn
    while not session.done:
        env.step(policy.act(view.observe(), view.info_for(policy)))
        yield session.turn
