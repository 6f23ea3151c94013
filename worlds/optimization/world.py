"""The world of optimization: it answers each proposal with its loss."""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from worlds.actions import inward
from worlds.optimization.custom import custom_loss
from worlds.optimization.functions import LOSSES
from worlds.optimization.loss import Gradient, Landscape, Loss, Point, Value
from worlds.world import World, illegal, is_number

TOLERANCE = 1e-2
"""A proposal is a success if its loss exceeds the minimum by at most this."""
SCALE = 100.0
"""Rewards are losses divided by it, as in LLF-Bench."""
_FEE = 0.01  # subtracted for a text that is not an action
_REACH = 0.2  # greatest shift, as a share of the domain's width


class Truth(NamedTuple):
    """The last proposal `x`, its loss `y`, and the shift of the loss."""

    x: Point
    y: float
    shift: Point


class Optimization(World[Truth, dict[str, Any], Point]):
    """A loss of two numbers to minimise.

    Observation: Dict of `x` (Box(2)), the last proposal, at first a random point, and `y` (Box(1)), its loss.
    Action: Box(2), the next proposal; also a text such as `x = [1, 2]`, or one with `stop`, `stay` or `reach`
    (propose the same point again). Reward: the negated loss, clipped to lie between the
    negated largest corner loss and the negated minimum, divided by 100. A text that is not an action
    gets the reward of the same point, minus 0.01.
    Success: the loss of this proposal is within 0.01 of the minimum. Nothing terminates.

    Unlike LLF-Bench's, `reward_range` is divided by 100, too, so that rewards lie in it.

    Args:
        loss: a key of `LOSSES`, or a function of two numbers that returns a number and is defined on the whole
            domain. To pickle the world, the function must be defined at the top level of a module.
        shift: move the loss at reset by a hidden, random vector, at most a fifth of the domain's width
            along each axis; the minimiser stays in the domain. See `Landscape`.
        func_choice: which of Bohachevsky's three functions, 1 to 3.
        gradient: for a custom function, a function that returns both derivatives; None: they are estimated.
        domain: for a custom function, `(low, high)` of both numbers, or of each: `((low, high), (low, high))`.
        minimiser: for a custom function, its minimiser; None: scipy searches for it.
    """

    action_parts = ("x1", "x2")
    answer_words = ("stay",)
    action_fillers = ("point", "proposal", "guess", "minimum", "at")
    _truth: Truth

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
        own: dict[str, Any] = {"gradient": gradient, "domain": domain, "minimiser": minimiser}
        self.loss = custom_loss(loss, func_choice, **own) if callable(loss) else _named_loss(loss, func_choice, **own)
        self.lows, self.highs = self.loss.lows, self.loss.highs
        self.minimum, self.corner = self.loss.minimum, self.loss.corner
        self.reward_range = (-self.corner / SCALE, -self.minimum / SCALE)
        box = spaces.Box(np.array(self.lows), np.array(self.highs), dtype=np.float64)
        self.observation_space = spaces.Dict({"x": box, "y": spaces.Box(-np.inf, np.inf, (1,), np.float64)})
        self.action_space = spaces.Box(np.array(self.lows), np.array(self.highs), dtype=np.float64)
        (low1, high1), (low2, high2) = map(inward, self.lows, self.highs)
        self.action_syntax = (
            f"x = [x1, x2] with numbers x1 from {low1:.15g} to {high1:.15g} and x2 from {low2:.15g} to {high2:.15g}, "
            f"or the word stay"
        )
        self._landscape = Landscape(self.loss, (0.0, 0.0))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a first point, and a shift if the option `shift` is set."""
        super().reset(seed=seed, options=options)
        x1, x2 = self.np_random.uniform(self.lows, self.highs).tolist()
        shift = self._draw_shift(self.np_random) if self.options["shift"] else (0.0, 0.0)
        self._load(Truth((x1, x2), Landscape(self.loss, shift).value(x1, x2), shift))
        return self.observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The last proposal, its loss and the shift."""
        return self._truth

    @property
    def failure_reward(self) -> float:
        """The reward of proposing the same point again, minus 0.01, so that the word `stay` pays more."""
        low, high = self.reward_range
        return max(min(-self._truth.y / SCALE, high) - _FEE, low) if hasattr(self, "_truth") else low

    def legal(self, action: Any) -> Point:
        """The proposal as two Python floats."""
        numbers = self.read(action) if isinstance(action, str) else action
        if isinstance(numbers, np.ndarray):
            numbers = numbers.tolist()
        if isinstance(numbers, list | tuple) and len(numbers) == 2:
            x1, x2 = numbers
            (low1, low2), (high1, high2) = self.lows, self.highs
            if is_number(x1) and is_number(x2) and low1 <= x1 <= high1 and low2 <= x2 <= high2:
                return float(x1) + 0.0, float(x2) + 0.0  # so that there is no negative zero
        raise illegal(action, self.action_syntax)

    def advance(self, action: Point) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Evaluate the loss."""
        landscape, low, high = self._landscape, self.minimum, self.corner
        y = landscape.value(*action)
        self._truth = Truth(action, y, landscape.shift)
        reward = -(low if y < low else high if y > high else y) / SCALE
        return self.observe(), reward, False, False, {"success": bool(y - low <= TOLERANCE)}

    def observe(self) -> dict[str, Any]:
        """The last proposal and its loss."""
        x, y, _ = self._truth
        return {"x": np.array(x), "y": np.array((y,))}

    def describe(self, observation: dict[str, Any]) -> str:
        """The proposal and its loss, with six digits."""
        (x1, x2), (y,) = observation["x"].tolist(), observation["y"].tolist()
        return f"x = [{x1:.6g}, {x2:.6g}]\ny = {y:.6g}"

    def sample_action(self, rng: np.random.Generator) -> np.ndarray:
        """A uniform point of the domain."""
        return rng.uniform(self.lows, self.highs)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """A shift or none, and any variant of a named loss."""
        options = self.options | {"shift": bool(rng.integers(2))}
        if isinstance(self.options["loss"], str):
            options["func_choice"] = int(rng.integers(len(LOSSES[self.options["loss"]]))) + 1
        return options

    def elsewhere(self, seed: int) -> Truth:
        """Another first point, and the loss shifted, so that its minimiser is another one."""
        self.reset(seed=seed)
        x1, x2 = self._truth.x
        shift = self._draw_shift(self.np_random)
        self._load(Truth((x1, x2), Landscape(self.loss, shift).value(x1, x2), shift))
        return self._truth

    def read(self, text: str) -> Point | None:
        """The pair of numbers that a text is, as in `x = [1, 2]`; for `stay` or `stop`, the last proposal."""
        text = text.lstrip(_QUOTES).rstrip(f"{_QUOTES}!")
        if pair := _PAIR.fullmatch(text):
            x1, x2 = filter(None, pair.groups())
            return float(x1), float(x2)
        return self._truth.x if hasattr(self, "_truth") and _STAY.fullmatch(text) else None

    def _load(self, truth: Truth) -> None:
        self._truth = truth
        if truth.shift != self._landscape.shift:
            self._landscape = Landscape(self.loss, truth.shift)

    def _draw_shift(self, rng: np.random.Generator) -> Point:
        """A shift that leaves the first minimiser in the domain."""
        first, second = (float(rng.uniform(low, high)) for low, high in self.shift_bounds())
        return first, second

    def shift_bounds(self) -> list[Point]:
        """The least and the greatest shift along each axis."""
        bounds = zip(self.loss.minimisers[0], self.lows, self.highs, strict=True)
        return [(max(low - m, -_REACH * (high - low)), min(high - m, _REACH * (high - low))) for m, low, high in bounds]


_QUOTES = " \t\r\n.,;\"'`"  # allowed around it
_NUMBER = r"([-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
_TWO = rf"\s*{_NUMBER}\s*,\s*{_NUMBER}\s*"
_PAIR = re.compile(rf"(?:x\s*[:=]\s*)?(?:\[{_TWO}\]|\({_TWO}\))|\{{\s*\"x\"\s*:\s*\[{_TWO}\]\s*\}}")
_STAY = re.compile(
    r"(?:stop|stay|(?:have |has been |is )?reached)(?: here| there| put| the (?:minimum|point))*", re.IGNORECASE
)


def _named_loss(name: str, choice: int, **own: Any) -> Loss:
    if name not in LOSSES:
        raise ValueError(f"loss {name!r} is unknown; allowed: {', '.join(LOSSES)}, or a function of two numbers")
    for option, value in own.items():
        if value is not None:
            raise ValueError(f"{option} applies to custom functions only, got {value!r} for {name}; allowed: None")
    variants = LOSSES[name]
    if type(choice) is not int or not 1 <= choice <= len(variants):
        raise ValueError(f"func_choice must be an integer from 1 to {len(variants)} for {name}, got {choice!r}")
    return variants[choice - 1]
