"""highway-env's highway: traffic in lanes, through which to drive fast. The expert drives as the other cars do."""

import copy
from collections.abc import Mapping
from typing import Any

import gymnasium

from teachers.planning.known import Known
from teachers.planning.planner import PlanningError
from worlds.actions import format_value

_MOVES = ("LANE_LEFT", "IDLE", "LANE_RIGHT", "FASTER", "SLOWER")  # highway-env's numbers 0 to 4
_COLUMNS = ("presence", "x", "y", "vx", "vy")
_GENTLE = 0.5  # m/s2: an acceleration below this is none


class _Driver:
    """The Intelligent Driver Model for speed and MOBIL for lanes, by highway-env's own `IDMVehicle`."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        bare: Any = env.unwrapped
        self._env = bare
        if tuple(getattr(bare.action_type, "actions_indexes", ())) != _MOVES:
            raise PlanningError(
                f"the expert of highway-env chooses among {', '.join(_MOVES)}; configure the action type "
                "DiscreteMetaAction, or pass oracle=Expert(policy=...)"
            )

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> int:
        from highway_env.vehicle.behavior import IDMVehicle

        env = self._env
        car, numbers = env.vehicle, env.action_type.actions_indexes
        driver = IDMVehicle.create_from(car)
        driver.target_speed = float(max(car.target_speeds))
        driver.road = copy.copy(env.road)
        driver.road.vehicles = [driver if each is car else each for each in env.road.vehicles]  # in its place
        legal = set(env.action_type.get_available_actions())
        _, _, lane = car.target_lane_index
        for beside in env.road.network.side_lanes(car.target_lane_index):
            way = numbers["LANE_LEFT" if beside[2] < lane else "LANE_RIGHT"]
            if way in legal and car.lane_index == car.target_lane_index and driver.mobil(beside):
                return int(way)
        ahead, behind = driver.road.neighbour_vehicles(driver, car.target_lane_index)
        push = driver.acceleration(driver, ahead, behind)
        wanted = numbers["FASTER" if push > _GENTLE else "SLOWER" if push < -_GENTLE else "IDLE"]
        return int(wanted if wanted in legal else numbers["IDLE"])


def _describe(observation: Any) -> str:
    """The default observation, a row for each car; with other features, give `describe` of your own."""
    rows = format_value(observation)
    return f"Cars, yours first, by {', '.join(_COLUMNS)}: {rows}" if observation.shape[1:] == (5,) else rows


def _success(observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    """Whether the drive went on until its end: a crash, which ends it before, may be paid for, too."""
    return truncated and not terminated


KNOWN = Known(
    success=_success,
    action_words={move.lower().replace("_", " "): action for action, move in enumerate(_MOVES)},
    describe=_describe,
    expert=_Driver,
    horizon=8,  # a step takes 30 ms with 20 cars
    hides=True,
)
