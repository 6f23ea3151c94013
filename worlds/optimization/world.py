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
        """The only pair of numbers in a text, with words that propose it; for `stay` or `stop`, the last proposal."""
        found = list(_PAIR.finditer(text))
        if found:
            pairs = {(float(pair[1] or pair[3]), float(pair[2] or pair[4])) for pair in found}
            return pairs.pop() if len(pairs) == 1 and all(_is_proposed(text, *pair.span()) for pair in found) else None
        stays = hasattr(self, "_truth") and _STAY.search(text) and _STAYING.fullmatch(_REASON.sub("", text))
        return self._truth.x if stays else None

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


_NUMBER = r"([-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
_TWO = rf"\s*{_NUMBER}\s*,\s*{_NUMBER}\s*"
_PAIR = re.compile(  # with no factor or summand beside it
    rf"(?<![\w\[(+/^-])(?<!\w\*)(?<![~|\u2260])(?<!!= )(?<!\u2260 )(?<!\w [*/] )(?<![0-9] [+-] )"
    rf"(?:\[{_TWO}\]|\({_TWO}\))(?![\w\])'^]|\s*[*/+-]\s*[0-9.(\[])"
)
_WORDS = (  # that may stand before a proposed pair
    "x|a|advice|advised|an|and|am sure|answer|as|at|be|best|better|believe|but|choice|choose|expect|final"
    "|follow|following|for|go|going|guess|hence|here|i|i'd|i'll|i'm sure|is|it|let|let's|lies|me|minimi[sz]er"
    "|minimum|move|moving|my|new|next|now|of|optimum|our|pick|please|point|probably|proposal|propose|reach"
    "|response|select|should|so|stay|stop|suggest|suggested|take|teacher's|that|the|then|therefore|think|this"
    "|thus|to|try|trying|us|use|we|will|with|would (?:go|like|propose|suggest|try)|you|your|action|thought"
)
_MARKS = r"[\s*_`\"'$)}]*+"
_BEFORE = re.compile(
    rf"(?>(?:(?:{_WORDS})\b|(?<!x)(?<!x )[-\u2013\u2014>\u2192]\s|[\s=:*_`\"'$>#{{(]|->)*)",  # by *+ Python 3.11.2 errs
    re.IGNORECASE,
)
_AFTER = re.compile(  # a remark, or the sentence's end
    rf"{_MARKS}(?:(?:is|now|next|then|please|here|my|the|final|answer|proposal|choice|this|time|turn|instead)\b{_MARKS})*+"
    r"(?:$|[.;!(]|,(?!\s*but\b)|\n|(?:as|because|for|since|so|to|where)\b"
    r"|[\u2013\u2014-]\s(?!.*(?:grad|step|delta|\bx\b|[0-9])))",
    re.IGNORECASE,
)
_HEADER = re.compile(r"[(\[]\s*x_?1\s*,\s*x_?2\s*[)\]]", re.IGNORECASE)
_STAY = re.compile(r"\b(?:stop(?:ped|ping)?|stay(?:ed|ing)?|reached)\b", re.IGNORECASE)
_STAYING = re.compile(
    r"(?:(?:a|again|am|an|and|are|at|be|done|for|going|good|have|has|here|i|i'll|i'm|i've|is|it|let|let's|me|minimum|my"
    r"|now|optimum|please|point|put|same|so|stay|stayed|staying|stop|stopped|stopping|reached|the|there|therefore|think|this"
    r"|time|to|us|we|we've|where|will|x|action|answer|response|should be|enough|has been|been)\b|[\s.,!:*_`\"'])*+",
    re.IGNORECASE,
)
_REASON = re.compile(r",?\s(?:as|because|for|since)\b.*|\s\(.*\)[.!]?$", re.IGNORECASE | re.DOTALL)


def _is_proposed(text: str, begin: int, end: int) -> bool:
    """Whether the surrounding words propose this pair, rather than reject it or call it a gradient."""
    before = re.split(r"[.;!?,](?=\s)|\n", _HEADER.sub("x", text[:begin]))[-1]
    return bool(_BEFORE.fullmatch(before) and _AFTER.match(text, end))


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
