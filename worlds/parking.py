"""Parking: drive a car nose first into a marked spot of a car park, with the physics of highway-env."""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from highway_env.envs.common.action import action_factory
from highway_env.envs.common.observation import KinematicsGoalObservation
from highway_env.envs.parking_env import ParkingEnv
from highway_env.vehicle.graphics import VehicleGraphics
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import Landmark, Obstacle, RoadObject

from worlds.world import World, illegal, is_number

__all__ = ["DT", "LENGTH", "WALL_X", "WALL_Y", "WIDTH", "Action", "Car", "Parking", "Spot", "Truth", "step_car"]

Action = tuple[float, float]

LENGTH, WIDTH = Vehicle.LENGTH, Vehicle.WIDTH
"""Size of every car, in metres."""
DT = 1 / 15
"""Duration of a simulation step, in seconds; an action lasts for three."""
WALL_X, WALL_Y = 34.5, 20.5
"""The walls' inner faces lie at x = -34.5 and 34.5, y = -20.5 and 20.5, in metres."""
_HALF = LENGTH / 2
_SPOTS = 28  # in two rows
_MARGIN = 0.1  # m; objects farther apart than this do not touch
_CORNER = math.hypot(LENGTH, WIDTH) / 2
_OPEN_X, _OPEN_Y = WALL_X - _CORNER, WALL_Y - _CORNER  # no wall is near inside
_FAILURE = -1.0
_START = (0.0, 0.0)


class Car(NamedTuple):
    """The state of one car."""

    x: float
    """Coordinate of its middle, in metres."""
    y: float
    """Coordinate of its middle, in metres; positive downwards, as on a screen."""
    heading: float
    """In radians, from the x axis towards the y axis; not wrapped."""
    speed: float
    """In metres per second; negative backwards."""
    impact: tuple[float, float] | None = None
    """Displacement in metres that an unavoidable collision causes in the next simulation step."""
    crashed: bool = False


class Spot(NamedTuple):
    """The parking spot: the target position of the car's middle, in metres, and its heading, in radians."""

    x: float
    y: float
    heading: float


class Truth(NamedTuple):
    """The complete state."""

    car: Car
    spot: Spot
    parked: tuple[Car, ...]
    """The other cars."""
    time: float
    """Seconds since reset."""
    touched: tuple[bool, ...]
    """Whether the spot and each wall were touched in this episode, for rendering."""


def step_car(
    x: float, y: float, heading: float, speed: float, cosine: float, sine: float, slip: float, gain: float
) -> tuple[float, float, float, float]:
    """The position and speed of a car after a simulation step; the oracle's model uses this function, too.

    Args:
        x, y, heading, speed: of the car before the step, as in `Car`.
        cosine, sine: of the direction of travel, which is the heading plus the slip angle.
        slip: sine of the slip angle.
        gain: change of speed in the step, in metres per second.
    """
    return (
        x + speed * cosine * DT,
        y + speed * sine * DT,
        heading + speed * slip / _HALF * DT,
        speed + gain,
    )


class Parking(World[Truth, dict[str, npt.NDArray[np.float64]], Action]):
    """highway-env's `parking-v0`, with the same numbers, tens of times faster.

    Observation: highway-env's Dict of `observation`, `achieved_goal` and `desired_goal`, each Box(6): x and y
    in 100 m, their speeds in 5 m/s, cosine and sine of the heading. It does not contain other cars; `describe` does.
    Action: Box(2) for 0.2 s, each from -1 to 1: acceleration in 5 m/s2, then steering in 45 degrees, positive to the
    driver's right, both rounded to float32. Reward: highway-env's, the negated root of a weighted distance to the
    spot, and -5 for each step as a crashed car; -1 for a text that is not an action.
    A crash and parking terminate, 500 steps truncate. Success: parked without a crash at any speed.
    The info has highway-env's `speed`, `crashed`, `action` (not at reset) and `is_success`.

    Args:
        vehicles_count: number of other cars, each parked in a spot, 0 to 26; touching them is a crash.
    """

    reward_range = (-6.0, 0.0)
    action_parts = ("acceleration", "steering")
    action_syntax = "[acceleration, steering], two numbers from -1 to 1"
    failure_reward = _FAILURE

    def __init__(self, vehicles_count: int = 0, *, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode, vehicles_count=vehicles_count)
        count, most = vehicles_count, _SPOTS - 2
        if not isinstance(count, int) or isinstance(count, bool) or not 0 <= count <= most:
            raise ValueError(f"vehicles_count must be an integer from 0 to {most}, got {count!r}")
        self._lot = _Lot({"vehicles_count": count})
        box = spaces.Box(-np.inf, np.inf, (6,), np.float64)
        self.observation_space = spaces.Dict(dict.fromkeys(_PARTS, box))
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, npt.NDArray[np.float64]], dict[str, Any]]:
        """Draw the heading of the car, the spot and the places of other cars."""
        super().reset(seed=seed, options=options)
        lot = self._lot
        lot.np_random = self.np_random
        observation, info = lot.reset()
        return observation, info | {"success": False}

    @property
    def truth(self) -> Truth:
        """The cars, the spot and the time."""
        lot = self._lot
        car, *parked = lot.road.vehicles
        goal = car.goal
        x, y = goal.position.tolist()
        return Truth(
            _state(car),
            Spot(x, y, float(goal.heading)),
            tuple([_state(other) for other in parked]),
            lot.time,
            tuple([each.crashed or each.hit for each in lot.road.objects]),
        )

    def legal(self, action: Any) -> Action:
        """The action as two Python floats."""
        numbers = action.tolist() if isinstance(action, np.ndarray) else action
        if isinstance(numbers, list | tuple) and len(numbers) == 2:
            acceleration, steering = numbers
            if _is_share(acceleration) and _is_share(steering):
                return float(acceleration) + 0.0, float(steering) + 0.0  # so that there is no negative zero
        raise illegal(action, self.action_syntax)

    def advance(self, action: Action) -> tuple[dict[str, npt.NDArray[np.float64]], float, bool, bool, dict[str, Any]]:
        """Drive for 0.2 s."""
        result = self._lot.step(np.array(action, np.float32))
        info = result[4]
        info["success"] = info["is_success"] and not info["crashed"]
        return result

    def observe(self) -> dict[str, npt.NDArray[np.float64]]:
        """The car and the spot."""
        return self._lot.observation_type.observe()

    def describe(self, observation: dict[str, npt.NDArray[np.float64]]) -> str:
        """Position, heading and speed of the car, the spot, and the positions of other cars."""
        x, y, vx, vy, cos, sin = (observation["observation"] * _SCALES).tolist()
        goal_x, goal_y, _, _, goal_cos, goal_sin = (observation["desired_goal"] * _SCALES).tolist()
        lines = [
            f"Car: x = {x:.2f} m, y = {y:.2f} m, heading {_degrees(cos, sin):.1f} degrees, "
            f"speed {vx * cos + vy * sin:.2f} m/s",
            f"Spot: x = {goal_x:.2f} m, y = {goal_y:.2f} m, heading {_degrees(goal_cos, goal_sin):.1f} degrees",
        ]
        if parked := self._lot.road.vehicles[1:]:
            places = ", ".join(f"({other.position[0]:.1f}, {other.position[1]:.1f})" for other in parked)
            lines.append(f"Other cars at (x, y): {places}")
        return "\n".join(lines)

    def sample_action(self, rng: np.random.Generator) -> np.ndarray:
        """A uniform action."""
        return rng.uniform(-1.0, 1.0, 2).astype(np.float32)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """Any number of other cars."""
        return self.options | {"vehicles_count": int(rng.integers(_SPOTS - 1))}

    def original(self, actions: Sequence[Any], seed: int) -> ParkingEnv:
        """highway-env's own environment."""
        return ParkingEnv({"vehicles_count": self.options["vehicles_count"]})

    def _load(self, truth: Truth) -> None:
        lot = self._lot
        lot.time = truth.time
        car, *parked = lot.road.vehicles
        _place(car, truth.car)
        for other, state in zip(parked, truth.parked, strict=True):
            _place(other, state)
        x, y, heading = truth.spot
        goal = car.goal
        goal.position, goal.heading = np.array([x, y]), heading
        for each, touched in zip(lot.road.objects, truth.touched, strict=True):
            each.crashed, each.hit = touched and each.solid, touched and not each.solid


_PARTS = ("observation", "achieved_goal", "desired_goal")
_FEATURES = ["x", "y", "vx", "vy", "cos_h", "sin_h"]
_SCALES = np.array(ParkingEnv.PARKING_OBS["observation"]["scales"], float)


def _is_share(value: Any) -> bool:
    return is_number(value) and -1 <= value <= 1


def _degrees(cos: float, sin: float) -> float:
    return math.degrees(math.atan2(sin, cos))


def _state(car: Vehicle) -> Car:
    impact = car.impact
    x, y = car.position.tolist()
    return Car(
        x, y, float(car.heading), float(car.speed), None if impact is None else tuple(impact.tolist()), car.crashed
    )


def _place(car: Vehicle, state: Car) -> None:
    x, y, car.heading, car.speed, impact, car.crashed = state
    car.position = np.array([x, y])
    car.impact = None if impact is None else np.array(impact)


@lru_cache(maxsize=64)
def _slip(wheel: float) -> tuple[float, float]:
    """The slip angle of a car with its wheel at this angle, and its sine."""
    slip = np.arctan(1 / 2 * np.tan(wheel))
    return float(slip), float(np.sin(slip))


@lru_cache(maxsize=64)
def _spot_seen(x: float, y: float, heading: float) -> npt.NDArray[np.float64]:
    """What is observed of a spot."""
    seen: npt.NDArray[np.float64] = np.array([x, y, 0.0, 0.0, np.cos(heading), np.sin(heading)]) / _SCALES
    return seen


class _Car(Vehicle):
    """highway-env's car without a lane."""

    position: npt.NDArray[np.float64]
    heading: float
    speed: float
    impact: npt.NDArray[np.float64] | None

    def step(self, dt: float) -> None:
        """As in highway-env, without the update of the lane."""
        self.clip_actions()
        slip, sine = _slip(self.action["steering"])
        (x, y), course, gain = self.position.tolist(), self.heading + slip, self.action["acceleration"] * dt
        x, y, self.heading, self.speed = step_car(
            x, y, self.heading, self.speed, float(np.cos(course)), float(np.sin(course)), sine, gain
        )
        self.position = np.array([x, y])
        if self.impact is not None:
            self.position += self.impact
            self.crashed = True
            self.impact = None


class _Observation(KinematicsGoalObservation):
    """highway-env's observation without data frames."""

    def observe(self) -> dict[str, npt.NDArray[np.float64]]:
        car = self.env.vehicle
        if car is None:  # during construction
            return {name: np.zeros(len(_FEATURES)) for name in _PARTS}
        goal, speed, cos, sin = car.goal, car.speed, np.cos(car.heading), np.sin(car.heading)
        seen = np.array([*car.position.tolist(), speed * cos, speed * sin, cos, sin]) / _SCALES
        wanted = _spot_seen(*goal.position.tolist(), goal.heading).copy()
        return dict(zip(_PARTS, (seen, seen.copy(), wanted), strict=True))


def _walls() -> Iterator[Obstacle]:
    """highway-env's walls, 1 m thick."""
    width, height = 70, 42
    for x, y, length in (
        (0, -height / 2, width),
        (0, height / 2, width),
        (-width / 2, 0, height),
        (width / 2, 0, height),
    ):
        wall = Obstacle(None, [x, y], heading=np.pi / 2 if x else 0)
        wall.LENGTH, wall.WIDTH = length, 1
        wall.diagonal = np.sqrt(length**2 + 1)
        yield wall


class _Lot(ParkingEnv):
    """highway-env's car park without computations that do not affect the results.

    Cars do not look up lanes, parked cars are not moved, distant objects are not checked for collisions, a step makes
    one observation instead of four, and a reset keeps the road.
    """

    time: float
    road: Any

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """As in highway-env, without the random action in the info; the random stream is `np_random`."""
        self.time = self.steps = 0
        self._reset()
        seen = self.observation_type.observe()
        success = bool(self._is_success(seen["achieved_goal"], seen["desired_goal"]))
        return seen, {"speed": self.vehicle.speed, "crashed": self.vehicle.crashed, "is_success": success}

    def _create_road(self, spots: int = _SPOTS // 2) -> None:
        """As in highway-env, once."""
        if not self.road:
            super()._create_road(spots)
            self._lanes = self.road.network.lanes_dict()
            # The lanes that may be nearest for some heading, which adds at most pi to the distance.
            off = {index: lane.distance(_START) for index, lane in self._lanes.items()}
            self._nearest = [index for index in off if off[index] <= min(off.values()) + math.pi]
            self._dt = 1 / self.config["simulation_frequency"]
            self._frames = self.config["simulation_frequency"] // self.config["policy_frequency"]

    def _create_vehicles(self) -> None:
        """As in highway-env, with the same draws; vehicles get no road, so that they do not look up lanes."""
        lanes, rng = self._lanes, self.np_random
        heading = 2.0 * np.pi * rng.uniform()
        car = _Car(None, _START, heading, 0.0)
        car.color = VehicleGraphics.EGO_COLOR
        left = list(lanes)
        left.remove(min(self._nearest, key=lambda index: lanes[index].distance_with_heading(car.position, heading)))
        taken = []
        for _ in range(1 + self.config["vehicles_count"]):
            taken.append(lanes[left.pop(rng.choice(np.arange(len(left))))])
        spot, *places = taken
        car.goal = Landmark(None, spot.position(spot.length / 2, 0), heading=spot.heading)
        parked = [_Car(None, lane.position(4.0, 0), lane.heading_at(4.0), 0.0) for lane in places]
        self.controlled_vehicles = [car]
        self.road.vehicles = [car, *parked]
        self.road.objects = [car.goal, *_walls()]

    def define_spaces(self) -> None:
        """As in highway-env, with the faster observation."""
        self.action_type = action_factory(self, self.config["action"] | {"clip": False})  # `legal` has checked it
        self.action_space = self.action_type.space()
        settings = {name: value for name, value in self.config["observation"].items() if name != "type"}
        self.observation_type = self.observation_type_parking = _Observation(self, **settings)
        self.observation_space = self.observation_type.space()

    def step(self, action: np.ndarray) -> tuple[dict[str, npt.NDArray[np.float64]], float, bool, bool, dict[str, Any]]:
        """As in highway-env, with one observation."""
        config, car = self.config, self.vehicle
        self.time += 1 / config["policy_frequency"]
        self._simulate(action)
        seen = self.observation_type.observe()
        closeness = self.compute_reward(seen["achieved_goal"], seen["desired_goal"], {})
        success = bool(closeness > -config["success_goal_reward"])
        info = {"speed": car.speed, "crashed": car.crashed, "action": action, "is_success": success}
        reward = float(closeness + config["collision_reward"] * car.crashed)
        return seen, reward, car.crashed or success, self.time >= config["duration"], info

    def _simulate(self, action: np.ndarray | None = None) -> None:
        dt, vehicles = self._dt, self.road.vehicles
        self.action_type.act(action)
        for _ in range(self._frames):
            for car in vehicles:
                if not _at_rest(car) or car is vehicles[0]:
                    car.step(dt)
            for car, other in self._pairs():
                car.handle_collisions(other, dt)

    def _pairs(self) -> Iterator[tuple[Vehicle, RoadObject]]:
        """The pairs that may collide, in highway-env's order; to check all pairs doubles the time of a turn."""
        (car, *parked), (goal, *walls) = self.road.vehicles, self.road.objects
        (x, y), (goal_x, goal_y) = car.position.tolist(), goal.position.tolist()
        drift = abs(car.speed) * self._dt + _MARGIN
        near = drift + (car.diagonal + goal.diagonal) / 2
        by_goal = not goal.hit and abs(goal_x - x) < near and abs(goal_y - y) < near  # to be hit is all that happens
        if not parked and not by_goal and abs(x) + drift < _OPEN_X and abs(y) + drift < _OPEN_Y:
            return
        cos, sin = abs(math.cos(car.heading)), abs(math.sin(car.heading))
        # Half of the car's extent along each axis, now and in the next step.
        width = drift + (cos * LENGTH + sin * WIDTH) / 2
        height = drift + (sin * LENGTH + cos * WIDTH) / 2
        for other in parked:
            dx, dy = abs(other.position - car.position).tolist()
            if (dx < width + WIDTH / 2 and dy < height + LENGTH / 2) or not _at_rest(other):
                yield car, other
        if by_goal:
            yield car, goal
        beyond = (height - y - WALL_Y, height + y - WALL_Y, width - x - WALL_X, width + x - WALL_X)
        for wall, far in zip(walls, beyond, strict=True):
            if far > 0:
                yield car, wall
        for i, first in enumerate(parked):
            still = _at_rest(first)
            for other in parked[i + 1 :]:
                if not still or not _at_rest(other):
                    yield first, other
            if not still:
                for each in (goal, *walls):
                    yield first, each


def _at_rest(car: Vehicle) -> bool:
    """Whether a parked car was not moved."""
    return car.impact is None and not car.crashed
