"""Acrobot: two links, of which the lower one is driven at the joint between them, to swing its tip above the line."""

from collections.abc import Mapping
from typing import Any

from teachers.planning.known import Known

_NAMES = (
    *("cosine of theta 1", "sine of theta 1", "cosine of theta 2", "sine of theta 2"),
    *("angular velocity of theta 1", "angular velocity of theta 2"),
)
_AGAINST, _ALONG = 0, 2


def _pump(observation: Any, info: Mapping[str, Any]) -> int:
    """Push as the joint turns, so that the power of the torque is positive.

    Energy is pumped in until the links swing up, as in Spong (1995), The swing up control problem for the Acrobot, IEEE
    Control Systems Magazine 15(1), 49-55.
    """
    return _ALONG if observation[5] > 0 else _AGAINST


def _expert(env: Any) -> Any:
    return _pump


def _describe(observation: Any) -> str:
    listed = ", ".join(f"{name} {value:.3f}" for name, value in zip(_NAMES, observation.tolist(), strict=True))
    return f"{listed}. Theta 1 is the angle of the first link, 0 downwards; theta 2 is that of the second to the first."


def _success(observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    """Whether the free end has swung above the line, which ends an episode before its time."""
    return terminated


KNOWN = Known(
    success=_success,
    action_words={"torque -1": 0, "no torque": 1, "torque +1": 2},
    describe=_describe,
    expert=_expert,
    horizon=200,
)
