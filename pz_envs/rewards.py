"""What the teacher's seat is paid for: functions of a student's turn and the oracle, by name or one's own."""

from collections.abc import Callable

from teachers.atoms import Moment
from teachers.oracle import Oracle
from teachers.session import check_cost
from teachers.spec import unknown
from worlds.world import is_number

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


def check_prices(ask_cost: float | None, failure_reward: float | None, reward_range: tuple[float, float]) -> None:
    """Check what the student pays for asking, and what it gets for a text that is no action; None is in order.

    Raises:
        ValueError: one of them is not allowed.
    """
    if ask_cost is not None:
        check_cost("ask_cost", ask_cost)
    low, high = reward_range
    if failure_reward is not None and not (is_number(failure_reward) and low <= failure_reward <= high):
        raise ValueError(
            f"failure_reward must be None (the world's own) or a number of its reward range, {low:g} to {high:g}, got "
            f"{failure_reward!r}"
        )
