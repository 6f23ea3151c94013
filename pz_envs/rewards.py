"""Rewards of the teacher's seat: functions of the moment of a student's turn and the oracle."""

from collections.abc import Callable

from teachers.atoms import Moment
from teachers.oracle import Oracle
from teachers.spec import check_cost, unknown
from worlds.world import is_number

TeacherReward = Callable[[Moment, Oracle], float]
"""The teacher's reward of a student's turn; `cost` for the teacher's words is subtracted separately."""


def student_reward(moment: Moment, oracle: Oracle) -> float:
    """The student's reward, in the world's `reward_range`."""
    return moment.reward


def student_progress(moment: Moment, oracle: Oracle) -> float:
    """The negative regret of the student's action, in the family's unit of regret; at most 0."""
    return -oracle.regret(moment)


def success_minus_cost(moment: Moment, oracle: Oracle) -> float:
    """1 when an episode ends in success, else 0; the costs are subtracted separately."""
    return float(moment.over and moment.success)


TEACHER_REWARDS: dict[str, TeacherReward] = {
    function.__name__: function for function in (student_reward, student_progress, success_minus_cost)
}
"""Every named reward."""


def parse_teacher_reward(reward: str | TeacherReward) -> TeacherReward:
    """The function of a name; a function is returned as it is.

    Raises:
        ValueError: the name is unknown.
    """
    if callable(reward):
        return reward
    if reward not in TEACHER_REWARDS:
        raise ValueError(unknown("teacher_reward", reward, (*TEACHER_REWARDS, "a function of moment and oracle")))
    return TEACHER_REWARDS[reward]


def check_prices(ask_cost: float | None, failure_reward: float | None, reward_range: tuple[float, float]) -> None:
    """Check the cost of asking and the reward of a text that is not an action; None is allowed.

    Raises:
        ValueError: a value is not allowed.
    """
    if ask_cost is not None:
        check_cost("ask_cost", ask_cost)
    low, high = reward_range
    if failure_reward is not None and not (is_number(failure_reward) and low <= failure_reward <= high):
        raise ValueError(
            f"failure_reward must be None (the world's own) or a number of its reward range, {low:g} to {high:g}, got "
            f"{failure_reward!r}"
        )
