"""CliffWalking: four rows of twelve squares, with a cliff between start and goal."""

from typing import Any

from teachers.planning.known import Known

_COLUMNS = 12


def _describe(observation: int) -> str:
    row, column = divmod(int(observation), _COLUMNS)
    return f"You are in row {row}, column {column}, counted from 0 at the top left. The goal is in row 3, column 11."


def _success(observation: int, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    return terminated  # the goal alone ends an episode, and pays less than nothing


KNOWN = Known(
    action_words={"up": 0, "right": 1, "down": 2, "left": 3},
    describe=_describe,
    success=_success,
)
