"""The targets of metaworld's scripted policies."""

import types
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.metaworld.state import FloatArray


class Aim(NamedTuple):
    """The target of metaworld's scripted policy in a state."""

    target: tuple[float, float, float]
    """Target position of the hand, in metres."""
    gain: float
    """The factor from the hand's distance to its command."""
    grip: float
    """From -1, open, to 1, close; between them with less force."""


_Asked = tuple[tuple[float, ...], Aim]
_NONE: _Asked = (), Aim((0.0, 0.0, 0.0), 0.0, 0.0)
_LAST: dict[str, _Asked] = {}
"""The last observation of each task and its aim: in a turn the world and the oracle's lab ask for the same."""


class Script:
    """metaworld's scripted policy of a task, with access to its target."""

    def __init__(self, task: str) -> None:
        from metaworld.policies import ENV_POLICY_MAP

        policy: Any = ENV_POLICY_MAP[task]
        self._task = task
        self.policy = policy()
        """metaworld's own policy."""
        act = policy.get_action
        # A copy of the method with our `move` instead of metaworld's, which stays unchanged.
        self._act = types.FunctionType(act.__code__, act.__globals__ | {"move": self._move}, closure=act.__closure__)
        self._aimed: tuple[Any, float] = (None, 0.0)

    def __reduce__(self) -> tuple[Any, ...]:
        return Script, (self._task,)

    def _move(self, from_xyz: FloatArray, to_xyz: FloatArray, p: float) -> FloatArray:
        self._aimed = to_xyz, p
        return p * (to_xyz - from_xyz)

    def command(self, observation: tuple[float, ...]) -> npt.NDArray[np.float32]:
        """The policy's own command, float32 (4,): velocity and grip."""
        # Some policies write into their argument.
        command: npt.NDArray[np.float32] = self._act(self.policy, np.array(observation))
        return command

    def aim(self, observation: tuple[float, ...]) -> Aim:
        """The policy's target, gain and grip for an observation, 39 numbers; the last one of a task is remembered."""
        known, aim = _LAST.get(self._task, _NONE)
        if known is not observation:
            grip = float(self.command(observation)[3])
            target, gain = self._aimed
            x, y, z = np.broadcast_to(target, (3,)).tolist()
            aim = Aim((x, y, z), float(gain), grip)
            _LAST[self._task] = observation, aim
        return aim
