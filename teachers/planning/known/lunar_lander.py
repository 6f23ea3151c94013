"""LunarLander: a craft with three engines, to be landed on a pad. Its expert is Gymnasium's own heuristic."""

from collections.abc import Mapping
from typing import Any

import gymnasium

from teachers.planning.known import Known

_NAMES = (
    *("horizontal position", "vertical position", "horizontal velocity", "vertical velocity"),
    *("angle", "angular velocity"),
)


class _Heuristic:
    """`gymnasium.envs.box2d.lunar_lander.heuristic`, which reads the observation."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        self._env = env

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> Any:
        from gymnasium.envs.box2d.lunar_lander import heuristic

        return heuristic(self._env, observation)  # type: ignore[no-untyped-call]  # of Gymnasium


def _describe(observation: Any) -> str:
    *numbers, left, right = observation.tolist()
    listed = ", ".join(f"{name} {value:.3f}" for name, value in zip(_NAMES, numbers, strict=True))
    legs = " and ".join(
        f"the {side} leg {'touches' if on else 'does not touch'} the ground"
        for side, on in (("left", left), ("right", right))
    )
    return f"From the pad: {listed}; {legs}."


KNOWN = Known(
    action_words={"do nothing": 0, "fire left engine": 1, "fire main engine": 2, "fire right engine": 3},
    describe=_describe,
    expert=_Heuristic,
    horizon=10,  # later the dispersion of the engines decides, whatever the action was
    hides=True,  # the surface beside the pad
)
