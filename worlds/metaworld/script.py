"""metaworld's scripted policies, asked for what they aim at."""

import types
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.metaworld.state import FloatArray


class Aim(NamedTuple):
    """What metaworld's scripted policy does in a state."""

    target: tuple[float, float, float]
    """Where it wants the hand to be."""
    gain: float
    """The factor from the hand's distance to its command."""
    grip: float
    """-1 opens the gripper, 1 closes it; anything between does so with less force."""


_Asked = tuple[tuple[float, ...], Aim]
_NONE: _Asked = (), Aim((0.0, 0.0, 0.0), 0.0, 0.0)
_LAST: dict[str, _Asked] = {}
"""By task an observation and its aim: a world and the worlds in which it is thought about ask the same."""


class Script:
    """metaworld's scripted policy of a task, asked for what it aims at instead of for a command."""

    def __init__(self, task: str) -> None:
        from metaworld.policies import ENV_POLICY_MAP

        policy: Any = ENV_POLICY_MAP[task]
        self._task = task
        self.policy = policy()
        """metaworld's own."""
        act = policy.get_action
        # A copy of the method that finds our `move` in place of metaworld's: nothing of metaworld is changed.
        self._act = types.FunctionType(act.__code__, act.__globals__ | {"move": self._move}, closure=act.__closure__)
        self._aimed: tuple[Any, float] = (None, 0.0)

    def __reduce__(self) -> tuple[Any, ...]:
        return Script, (self._task,)

    def _move(self, from_xyz: FloatArray, to_xyz: FloatArray, p: float) -> FloatArray:
        self._aimed = to_xyz, p
        return p * (to_xyz - from_xyz)

    def command(self, observation: tuple[float, ...]) -> npt.NDArray[np.float32]:
        """The policy's own command, float32 (4,): velocity and grip."""
        # Some policies write into what they are given.
        command: npt.NDArray[np.float32] = self._act(self.policy, np.array(observation))
        return command

    def aim(self, observation: tuple[float, ...]) -> Aim:
        """What it aims at; of the observation that some script of the task was asked of last, it is remembered."""
        known, aim = _LAST.get(self._task, _NONE)
        if known is not observation:
            grip = float(self.command(observation)[3])
            target, gain = self._aimed
            x, y, z = np.broadcast_to(target, (3,)).tolist()
            aim = Aim((x, y, z), float(gain), grip)
            _LAST[self._task] = observation, aim
        return aim
