"""Optimization: find the least value of a loss of two numbers, one proposal a turn.

Eight test functions of the optimization literature with exact derivatives, and losses of the user's own.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import product
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from worlds.world import World, illegal

Point = tuple[float, float]
Value = Callable[[float, float], float]
Gradient = Callable[[float, float], Sequence[float]]

TOLERANCE = 1e-2
"""A loss that exceeds the minimum by no more than this is a success."""
_SCALE = 100.0  # LLF-Bench's: rewards are losses divided by it
_FAILURE = -0.01
_REACH = 0.2  # greatest shift, as a share of the domain's width
_GRID = 41  # points a side, for a first look at a user's loss
_POLISHED = 8  # of these, how many the search for a minimum starts from


@dataclass(frozen=True)
class Loss:
    """A loss on a rectangle, with its derivatives and the points where it is least."""

    value: Value
    gradient: Gradient
    """The two first derivatives."""
    hessian: Gradient
    """The second derivatives: by x1 twice, by both, by x2 twice."""
    lows: Point
    highs: Point
    minimisers: tuple[Point, ...]
    """The points of the rectangle at which the loss is least."""

    @property
    def minimum(self) -> float:
        """The least loss on the rectangle."""
        return min(self.value(*point) for point in self.minimisers)

    @property
    def corner(self) -> float:
        """The largest loss at a corner of the rectangle; rewards do not fall below its negative."""
        return max(self.value(*corner) for corner in product(*zip(self.lows, self.highs, strict=True)))


class Landscape:
    """A loss that is moved by a shift within its rectangle.

    At `x` it is the loss at `x - shift`; where that lies outside the rectangle it is reflected at the edge, so that
    range and minimum stay the same, and a loss is never asked outside its domain.
    """

    def __init__(self, loss: Loss, shift: Point) -> None:
        self.loss, self.shift = loss, shift
        if shift == (0.0, 0.0):  # the common case goes the short way
            self.value, self.gradient, self.hessian = loss.value, loss.gradient, loss.hessian  # type: ignore[method-assign]

    def value(self, x1: float, x2: float) -> float:
        """The loss."""
        (z1, _), (z2, _) = self._place(0, x1), self._place(1, x2)
        return self.loss.value(z1, z2)

    def gradient(self, x1: float, x2: float) -> tuple[float, float]:
        """The first derivatives; at a reflecting edge, those of one of its sides."""
        (z1, sign1), (z2, sign2) = self._place(0, x1), self._place(1, x2)
        g1, g2 = self.loss.gradient(z1, z2)
        return sign1 * g1, sign2 * g2

    def hessian(self, x1: float, x2: float) -> tuple[float, float, float]:
        """The second derivatives: by x1 twice, by both, by x2 twice."""
        (z1, sign1), (z2, sign2) = self._place(0, x1), self._place(1, x2)
        h11, h12, h22 = self.loss.hessian(z1, z2)
        return h11, sign1 * sign2 * h12, h22

    def minimisers(self) -> tuple[Point, ...]:
        """The points at which the loss is least, mirror images included."""
        return tuple(
            dict.fromkeys(p for m in self.loss.minimisers for p in product(self._images(0, m), self._images(1, m)))
        )

    def _place(self, i: int, x: float) -> tuple[float, float]:
        """The unshifted coordinate, and -1 if it was reflected, else 1."""
        z, low, high = x - self.shift[i], self.loss.lows[i], self.loss.highs[i]
        if z < low:
            return 2 * low - z, -1.0
        return (2 * high - z, -1.0) if z > high else (z, 1.0)

    def _images(self, i: int, minimiser: Point) -> list[float]:
        """Where the shifted coordinate of a minimiser lies in the domain, mirror images included."""
        m, shift, low, high = minimiser[i], self.shift[i], self.loss.lows[i], self.loss.highs[i]
        return [x for x in (m + shift, 2 * low - m + shift, 2 * high - m + shift) if low <= x <= high]


class Truth(NamedTuple):
    """Where the last proposal is, its loss, and how the loss is shifted."""

    x: Point
    y: float
    shift: Point


class Optimization(World):
    """A loss of two numbers that is to be made as small as possible.

    Observation: Dict of `x` (Box(2)), the last proposal, at first a random point, and `y` (Box(1)), its loss.
    Action: Box(2), the next proposal; a text such as `x = [1, 2]`, or one with `stop`, `stay` or `reach`
    (propose the same point again), is understood, too. Reward: the negated loss, clipped to lie between the
    negated largest corner loss and the negated minimum, divided by 100. A text that is no action gets -0.01.
    Success: the loss of this proposal is within 0.01 of the minimum. Nothing terminates.

    LLF-Bench's `reward_range` is not divided by 100; this one is, so that rewards lie in it.

    Args:
        loss: a key of `LOSSES`, or a function of two numbers that returns one, defined on the whole domain.
            To be pickled the world needs a function that is defined at the top of a module.
        shift: move the loss at reset by a hidden, random vector, at most a fifth of the domain's width
            along each axis; the minimiser stays in the domain. See `Landscape`.
        func_choice: which of Bohachevsky's three functions, 1 to 3.
        gradient: for a function of your own, one that returns both derivatives; otherwise they are estimated.
        domain: for a function of your own, `(low, high)` of both numbers, or of each: `((low, high), (low, high))`.
        minimiser: for a function of your own, the point where it is least; otherwise scipy looks for it.
    """

    def __init__(
        self,
        loss: str | Value = "Booth",
        shift: bool = False,
        func_choice: int = 1,
        *,
        gradient: Gradient | None = None,
        domain: Sequence[Any] | None = None,
        minimiser: Sequence[float] | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(
            render_mode=render_mode,
            loss=loss,
            shift=shift,
            func_choice=func_choice,
            gradient=gradient,
            domain=domain,
            minimiser=minimiser,
        )
        if not isinstance(shift, bool):
            raise ValueError(f"shift must be True or False, got {shift!r}")
        own = {"gradient": gradient, "domain": domain, "minimiser": minimiser}
        self.loss = _own_loss(loss, func_choice, **own) if callable(loss) else _named_loss(loss, func_choice, **own)
        self.lows, self.highs = self.loss.lows, self.loss.highs
        self.minimum, self._corner = self.loss.minimum, self.loss.corner
        self.reward_range = (-self._corner / _SCALE, -self.minimum / _SCALE)
        self.failure_reward = min(max(_FAILURE, self.reward_range[0]), self.reward_range[1])
        box = spaces.Box(np.array(self.lows), np.array(self.highs), dtype=np.float64)
        self.observation_space = spaces.Dict({"x": box, "y": spaces.Box(-np.inf, np.inf, (1,), np.float64)})
        self.action_space = spaces.Box(np.array(self.lows), np.array(self.highs), dtype=np.float64)
        (low1, low2), (high1, high2) = self.lows, self.highs
        self.action_syntax = (
            f"x = [x1, x2] with numbers x1 from {low1:.6g} to {high1:.6g} and x2 from {low2:.6g} to {high2:.6g}, "
            f"or the word stay"
        )
        self._landscape = Landscape(self.loss, (0.0, 0.0))
        self._truth: Truth | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a start, and a shift if there is to be one."""
        super().reset(seed=seed)
        x1, x2 = self.np_random.uniform(self.lows, self.highs).tolist()
        shift = self._draw_shift(self.np_random) if self.options["shift"] else (0.0, 0.0)
        self._load(Truth((x1, x2), Landscape(self.loss, shift).value(x1, x2), shift))
        return self._observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The last proposal, its loss and the shift."""
        return self._truth

    def legal(self, action: Any) -> Point:
        """The proposal as two Python floats."""
        numbers = self.read(action) if isinstance(action, str) else action
        if isinstance(numbers, np.ndarray):
            numbers = numbers.tolist()
        if isinstance(numbers, list | tuple) and len(numbers) == 2:
            x1, x2 = numbers
            (low1, low2), (high1, high2) = self.lows, self.highs
            if _is_number(x1) and _is_number(x2) and low1 <= x1 <= high1 and low2 <= x2 <= high2:
                return float(x1) + 0.0, float(x2) + 0.0  # so that there is no negative zero
        raise illegal(action, self.action_syntax)

    def advance(self, action: Point) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Evaluate the loss."""
        y = self._landscape.value(*action)
        self._truth = Truth(action, y, self._landscape.shift)
        reward = -min(max(y, self.minimum), self._corner) / _SCALE
        return self._observe(), reward, False, False, {"success": bool(y - self.minimum <= TOLERANCE)}

    def describe(self, observation: dict[str, Any]) -> str:
        """The proposal and its loss, to six digits."""
        (x1, x2), (y,) = observation["x"].tolist(), observation["y"].tolist()
        return f"x = [{x1:.6g}, {x2:.6g}]\ny = {y:.6g}"

    def sample_action(self, rng: np.random.Generator) -> np.ndarray:
        """A uniform point of the domain."""
        return rng.uniform(self.lows, self.highs)

    def read(self, text: str) -> Point | None:
        """The one pair of numbers in a text; for `stop`, `stay` or `reach` without a pair, the last proposal."""
        pairs = {(float(pair[1] or pair[3]), float(pair[2] or pair[4])) for pair in _PAIR.finditer(text)}
        if len(pairs) == 1:
            return pairs.pop()
        stays = self._truth is not None and "[" not in text and not pairs and _STAY.search(text)
        return self._truth.x if stays else None

    def _load(self, truth: Truth) -> None:
        self._truth = truth
        if truth.shift != self._landscape.shift:
            self._landscape = Landscape(self.loss, truth.shift)

    def _observe(self) -> dict[str, Any]:
        x, y, _ = self._truth
        return {"x": np.array(x), "y": np.array((y,))}

    def _draw_shift(self, rng: np.random.Generator) -> Point:
        """A shift that leaves the first minimiser in the domain."""
        bounds = zip(self.loss.minimisers[0], self.lows, self.highs, strict=True)
        draws = [
            rng.uniform(max(low - m, -_REACH * (high - low)), min(high - m, _REACH * (high - low)))
            for m, low, high in bounds
        ]
        return draws[0], draws[1]


_NUMBER = r"([-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
_TWO = rf"\s*{_NUMBER}\s*,\s*{_NUMBER}\s*"
_PAIR = re.compile(rf"(?<![\w\[(])(?:\[{_TWO}\]|\({_TWO}\))(?![\w\])])")
_STAY = re.compile(r"\b(?:stop|stay|reach)(?:ped|ping|ed|ing|es|s)?\b", re.IGNORECASE)


def _is_number(value: Any) -> bool:
    return type(value) is float or (isinstance(value, Real) and not isinstance(value, bool))


def _booth(x1: float, x2: float) -> float:
    return (x1 + 2 * x2 - 7) ** 2 + (2 * x1 + x2 - 5) ** 2


def _booth_gradient(x1: float, x2: float) -> Point:
    return 10 * x1 + 8 * x2 - 34, 8 * x1 + 10 * x2 - 38


def _mccormick(x1: float, x2: float) -> float:
    return math.sin(x1 + x2) + (x1 - x2) ** 2 - 1.5 * x1 + 2.5 * x2 + 1


def _mccormick_gradient(x1: float, x2: float) -> Point:
    cos, difference = math.cos(x1 + x2), 2 * (x1 - x2)
    return cos + difference - 1.5, cos - difference + 2.5


def _mccormick_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    sin = math.sin(x1 + x2)
    return 2 - sin, -2 - sin, 2 - sin


def _rosenbrock(x1: float, x2: float) -> float:
    return (1 - x1) ** 2 + (x2 - x1**2) ** 2


def _rosenbrock_gradient(x1: float, x2: float) -> Point:
    off = x2 - x1**2
    return 2 * (x1 - 1) - 4 * x1 * off, 2 * off


def _rosenbrock_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    return 2 - 4 * (x2 - x1**2) + 8 * x1**2, -4 * x1, 2.0


def _six_hump_camel(x1: float, x2: float) -> float:
    return (4 - 2.1 * x1**2 + x1**4 / 3) * x1**2 + x1 * x2 + (4 * x2**2 - 4) * x2**2


def _six_hump_camel_gradient(x1: float, x2: float) -> Point:
    return 8 * x1 - 8.4 * x1**3 + 2 * x1**5 + x2, x1 - 8 * x2 + 16 * x2**3


def _six_hump_camel_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    return 8 - 25.2 * x1**2 + 10 * x1**4, 1.0, 48 * x2**2 - 8


def _bohachevsky_1(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * math.cos(_A * x1) - 0.4 * math.cos(_B * x2) + 0.7


def _bohachevsky_1_gradient(x1: float, x2: float) -> Point:
    return 2 * x1 + 0.3 * _A * math.sin(_A * x1), 4 * x2 + 0.4 * _B * math.sin(_B * x2)


def _bohachevsky_1_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    return 2 + 0.3 * _A**2 * math.cos(_A * x1), 0.0, 4 + 0.4 * _B**2 * math.cos(_B * x2)


def _bohachevsky_2(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * math.cos(_A * x1) * math.cos(_B * x2) + 0.3


def _bohachevsky_2_gradient(x1: float, x2: float) -> Point:
    return (
        2 * x1 + 0.3 * _A * math.sin(_A * x1) * math.cos(_B * x2),
        4 * x2 + 0.3 * _B * math.cos(_A * x1) * math.sin(_B * x2),
    )


def _bohachevsky_2_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    cosines = 0.3 * math.cos(_A * x1) * math.cos(_B * x2)
    return 2 + _A**2 * cosines, -0.3 * _A * _B * math.sin(_A * x1) * math.sin(_B * x2), 4 + _B**2 * cosines


def _bohachevsky_3(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * math.cos(_A * x1 + _B * x2) + 0.3


def _bohachevsky_3_gradient(x1: float, x2: float) -> Point:
    sin = 0.3 * math.sin(_A * x1 + _B * x2)
    return 2 * x1 + _A * sin, 4 * x2 + _B * sin


def _bohachevsky_3_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    cos = 0.3 * math.cos(_A * x1 + _B * x2)
    return 2 + _A**2 * cos, _A * _B * cos, 4 + _B**2 * cos


def _rotated_hyper_ellipsoid(x1: float, x2: float) -> float:
    return 2 * x1**2 + x2**2


def _rotated_hyper_ellipsoid_gradient(x1: float, x2: float) -> Point:
    return 4 * x1, 2 * x2


def _matyas(x1: float, x2: float) -> float:
    return 0.26 * (x1**2 + x2**2) - 0.48 * x1 * x2


def _matyas_gradient(x1: float, x2: float) -> Point:
    return 0.52 * x1 - 0.48 * x2, 0.52 * x2 - 0.48 * x1


def _three_hump_camel(x1: float, x2: float) -> float:
    return 2 * x1**2 - 1.05 * x1**4 + x1**6 / 6 + x1 * x2 + x2**2


def _three_hump_camel_gradient(x1: float, x2: float) -> Point:
    return 4 * x1 - 4.2 * x1**3 + x1**5 + x2, x1 + 2 * x2


def _three_hump_camel_hessian(x1: float, x2: float) -> tuple[float, float, float]:
    return 4 - 12.6 * x1**2 + 5 * x1**4, 1.0, 2.0


def _constant(x1: float, x2: float, *, curvature: tuple[float, float, float]) -> tuple[float, float, float]:
    return curvature


def _square(
    value: Value, gradient: Gradient, hessian: Gradient | tuple[float, ...], low: float, high: float, *minimisers: Point
) -> Loss:
    if isinstance(hessian, tuple):
        hessian = partial(_constant, curvature=hessian)
    return Loss(value, gradient, hessian, (low, low), (high, high), minimisers)


_A, _B = 3 * math.pi, 4 * math.pi
_CAMEL = (0.08984201310031807, -0.7126564030207396)
LOSSES: dict[str, tuple[Loss, ...]] = {
    "Booth": (_square(_booth, _booth_gradient, (10.0, 8.0, 10.0), -10.0, 10.0, (1.0, 3.0)),),
    # On LLF-Bench's square the function is least at the edge; its unbounded minimiser (-0.547, -1.547) lies outside.
    "McCormick": (
        _square(_mccormick, _mccormick_gradient, _mccormick_hessian, -1.5, 4.0, (-0.5288833955428878, -1.5)),
    ),
    "Rosenbrock": (_square(_rosenbrock, _rosenbrock_gradient, _rosenbrock_hessian, -5.0, 10.0, (1.0, 1.0)),),
    "SixHumpCamel": (
        _square(
            _six_hump_camel,
            _six_hump_camel_gradient,
            _six_hump_camel_hessian,
            -2.0,
            2.0,
            _CAMEL,
            (-_CAMEL[0], -_CAMEL[1]),
        ),
    ),
    "Bohachevsky": (
        _square(_bohachevsky_1, _bohachevsky_1_gradient, _bohachevsky_1_hessian, -100.0, 100.0, (0.0, 0.0)),
        _square(_bohachevsky_2, _bohachevsky_2_gradient, _bohachevsky_2_hessian, -100.0, 100.0, (0.0, 0.0)),
        _square(_bohachevsky_3, _bohachevsky_3_gradient, _bohachevsky_3_hessian, -100.0, 100.0, (0.0, 0.0)),
    ),
    "RotatedHyperEllipsoid": (
        _square(
            _rotated_hyper_ellipsoid, _rotated_hyper_ellipsoid_gradient, (4.0, 0.0, 2.0), -65.536, 65.536, (0.0, 0.0)
        ),
    ),
    "Matyas": (_square(_matyas, _matyas_gradient, (0.52, -0.48, 0.52), -10.0, 10.0, (0.0, 0.0)),),
    "ThreeHumpCamel": (
        _square(_three_hump_camel, _three_hump_camel_gradient, _three_hump_camel_hessian, -5.0, 5.0, (0.0, 0.0)),
    ),
}
"""The losses by LLF-Bench's names, each with its variants (`func_choice`)."""


def _named_loss(name: str, choice: int, **own: Any) -> Loss:
    if name not in LOSSES:
        raise ValueError(f"loss {name!r} is unknown; allowed: {', '.join(LOSSES)}, or a function of two numbers")
    for option, value in own.items():
        if value is not None:
            raise ValueError(f"{option} is for a function of your own; {name} has one already, allowed: None")
    variants = LOSSES[name]
    if type(choice) is not int or not 1 <= choice <= len(variants):
        raise ValueError(f"func_choice must be an integer from 1 to {len(variants)} for {name}, got {choice!r}")
    return variants[choice - 1]


def _own_loss(function: Value, choice: int, gradient: Gradient | None, domain: Any, minimiser: Any) -> Loss:
    if choice != 1:
        raise ValueError(f"func_choice is for Bohachevsky, got {choice!r} for a function of your own; allowed: 1")
    try:
        first, second = domain
        bounds = (first, second) if isinstance(first, Sequence) else ((first, second), (first, second))
        lows, highs = tuple(zip(*((float(low), float(high)) for low, high in bounds), strict=True))
        if not all(low < high and math.isfinite(high - low) for low, high in zip(lows, highs, strict=True)):
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(
            f"domain must be (low, high) or ((low, high), (low, high)) with low < high for a function of your own, "
            f"got {domain!r}"
        ) from None
    return _look_at(function, gradient, lows, highs, None if minimiser is None else tuple(map(float, minimiser)))


@lru_cache(maxsize=64)
def _look_at(function: Value, gradient: Gradient | None, lows: Point, highs: Point, minimiser: Point | None) -> Loss:
    """The loss that a user's function is; looked at once, since every scratch world needs it."""
    value = partial(_number, function)
    slope = gradient or partial(_differences, value, lows, highs)
    hessian = partial(_curvature, slope, lows, highs)
    grid = product(*(np.linspace(low, high, _GRID).tolist() for low, high in zip(lows, highs, strict=True)))
    seen = sorted((value(*point), point) for point in grid)
    if minimiser is None:
        minimisers = _search(value, slope, lows, highs, [point for _, point in seen[:_POLISHED]])
    elif len(minimiser) != 2 or not all(lows[i] <= minimiser[i] <= highs[i] for i in (0, 1)):
        raise ValueError(f"minimiser must be a point of the domain, got {minimiser!r}")
    elif seen[0][0] < value(*minimiser):
        raise ValueError(f"the function is not least at {minimiser}, it is less at {seen[0][1]}")
    else:
        minimisers = (minimiser,)
    return Loss(value, slope, hessian, lows, highs, minimisers)


def _number(function: Value, x1: float, x2: float) -> float:
    """The value of a user's function as a Python float."""
    value = float(function(x1, x2))
    if not math.isfinite(value):
        raise ValueError(f"the loss must be finite on its domain; at [{x1}, {x2}] it is {value}")
    return value


def _differences(function: Callable[..., Any], lows: Point, highs: Point, x1: float, x2: float) -> tuple[Any, ...]:
    """Derivatives of a function of two numbers, estimated by central differences within the domain."""
    slopes = []
    for i in range(2):
        x = (x1, x2)[i]
        step = 1e-6 * (highs[i] - lows[i])
        below, above = max(x - step, lows[i]), min(x + step, highs[i])
        at = (lambda z: (z, x2), lambda z: (x1, z))[i]
        slopes.append((function(*at(above)) - function(*at(below))) / (above - below))
    return tuple(slopes)


def _curvature(gradient: Gradient, lows: Point, highs: Point, x1: float, x2: float) -> tuple[float, float, float]:
    """Second derivatives, estimated from first ones; a wider step, since these may be estimates themselves."""
    rows = []
    for i in range(2):
        x = (x1, x2)[i]
        step = 1e-3 * (highs[i] - lows[i])
        below, above = max(x - step, lows[i]), min(x + step, highs[i])
        at = (lambda z: (z, x2), lambda z: (x1, z))[i]
        ends = zip(gradient(*at(above)), gradient(*at(below)), strict=True)
        rows.append([(float(up) - float(down)) / (above - below) for up, down in ends])
    return rows[0][0], (rows[0][1] + rows[1][0]) / 2, rows[1][1]


def _search(value: Value, gradient: Gradient, lows: Point, highs: Point, starts: list[Point]) -> tuple[Point, ...]:
    """The points of least loss that scipy finds from these starts."""
    from scipy.optimize import minimize

    found = []
    for start in starts:
        result = minimize(
            lambda x: value(*x.tolist()),
            start,
            jac=lambda x: np.array(gradient(*x.tolist()), float),
            bounds=list(zip(lows, highs, strict=True)),
            method="L-BFGS-B",
            options={"ftol": 1e-15, "gtol": 1e-10},
        )
        found += [(value(*point), point) for point in (start, tuple(result.x.tolist()))]
    least, best = min(found)
    minimisers = [best]
    for y, point in sorted(found):
        apart = min(max(abs(point[i] - m[i]) / (highs[i] - lows[i]) for i in range(2)) for m in minimisers)
        if y - least <= 1e-9 * (1 + abs(least)) and apart > 1e-3:
            minimisers.append(point)
    return tuple(minimisers)
