"""What the teacher's seat is paid for: functions of a student's turn and the oracle, by name or one's own."""

from collections.abc import Callable

from teachers.atoms import Moment
from teachers.oracle import Oracle
from teachers.spec import unknown

TeacherReward = Callable[[Moment, Oracle], float]
"""The teacher's reward of a student's turn; what the teacher says is charged apart, by `cost`."""


def student_reward(moment: Moment, oracle: Oracle) -> float:
    """What the world paid the student, in the world's `reward_range`."""
    return moment.reward


def student_progress(moment: Moment, oracle: Oracle) -> float:
    """What the student's action lost against the best one, negated, in the family's unit of regret; 0 at best."""
    return -oracle.regret(moment)


def success_minus_cost(moment: Moment, oracle: Oracle) -> float:
    """1 when an episode ends in success, else 0: all that is charged is what was said."""
    return float(moment.over and moment.success)


TEACHER_REWARDS: dict[str, TeacherReward] = {
    function.__name__: function for function in (student_reward, student_progress, success_minus_cost)
}
"""Every named reward."""


def parse_teacher_reward(reward: str | TeacherReward) -> TeacherReward:
    """The function that a name stands for; a function stands for itself.

    Raises:
        ValueError: an unknown name, or neither a name nor a function.
    """
    if callable(reward):
        return reward
    if reward not in TEACHER_REWARDS:
        raise ValueError(unknown("teacher_reward", reward, (*TEACHER_REWARDS, "a function of moment and oracle")))
    return TEACHER_REWARDS[reward]
