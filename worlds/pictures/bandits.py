"""Picture of bandits: for each arm, the number of pulls and the mean payout."""

import math
from collections.abc import Sequence

import numpy as np

from worlds.bandits import Bandit, Truth
from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas
from worlds.pictures.themes import LARGE, SMALL
from worlds.world import WorldTurn

__all__ = ["BanditPicture"]


class BanditPicture(Picture[Truth, Bandit]):
    """A row of arms with their payouts; if privileged, with their true means."""

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw a bar per arm, from 0 to its mean payout."""
        theme, truth = canvas.theme, sight.now
        paid = _paid(self.lab.arms, sight.turns)
        means = [sum(each) / len(each) for each in paid if each] + list(truth.means if sight.privileged else ())
        low, high = min([0.0, *means]), max([0.0, *means])
        if high - low < 1:
            high = low + 1
        left, right, top, floor = 44, canvas.width - 14, 56, canvas.height - 76

        def level(value: float) -> float:
            return floor - (value - low) / (high - low) * (floor - top)

        canvas.text((left, 22), "mean payout", SMALL, theme.muted)
        if sight.privileged:
            canvas.line([(left + 128, 22), (left + 152, 22)], theme.orange, 3)
            canvas.text((left + 158, 22), "expected", SMALL, theme.muted)
        step = _step(high - low)
        for i in range(math.ceil(low / step), math.floor(high / step) + 1):
            y = level(i * step)
            canvas.line([(left, y), (right, y)], theme.muted if i == 0 else theme.faint)
            canvas.text((left - 6, y), f"{i * step:.3g}", SMALL, theme.muted, anchor="rm")
        width = (right - left) / self.lab.arms
        last = sight.turns[-1].action
        for arm, each in enumerate(paid):
            x, bar = left + (arm + 0.5) * width, min(width * 0.66, 56)
            chosen = arm == last
            if each:
                y = level(sum(each) / len(each))
                colour = theme.blue if chosen else theme.sky
                corner, size = (x - bar / 2, min(y, level(0))), (bar, max(abs(y - level(0)), 1.5))
                canvas.box(corner, size, colour)
            if sight.privileged:
                y = level(truth.means[arm])
                canvas.line([(x - bar / 2 - 2, y), (x + bar / 2 + 2, y)], theme.orange, 3)
                if arm in truth.best:
                    canvas.star((x, y - 14), 8, theme.yellow, "#000000")
            if chosen:
                canvas.box((x - width / 2 + 1, floor + 8), (width - 2, 56), None, theme.blue, 2, 6)
            canvas.text((x, floor + 22), f"{arm}", LARGE, anchor="mm", bold=True)
            canvas.text((x, floor + 42), f"{len(each)} x" if each else "-", SMALL, theme.muted, anchor="mm")

    def text(self, sight: Sight[Truth]) -> Text:
        """A line for each arm that was pulled."""
        last = sight.turns[-1].action
        return tuple(
            (f"arm {arm}: pulls {len(each)}, mean payout {sum(each) / len(each):.3g}\n", "here" * (arm == last))
            for arm, each in enumerate(_paid(self.lab.arms, sight.turns))
            if each
        )

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """Lower payouts of the arms that are not best, which could have paid the same by chance."""
        truth = turns[0].truth
        less = [0.0 if arm in truth.best else float(rng.uniform(0.1, 1)) for arm in range(self.lab.arms)]
        payouts = tuple(payout - each for payout, each in zip(truth.payouts, less, strict=True))
        means = tuple(chance * payout for chance, payout in zip(truth.chances, payouts, strict=True))
        other = truth._replace(payouts=payouts, means=means)
        return [turn._replace(truth=other) for turn in turns]


def _paid(arms: int, turns: Sequence[WorldTurn[Truth]]) -> list[list[float]]:
    """The payouts of each arm."""
    paid: list[list[float]] = [[] for _ in range(arms)]
    for turn in turns:
        if turn.action is not None:
            paid[turn.action].append(turn.reward)
    return paid


def _step(width: float) -> float:
    """A round number that divides a width into three to eight parts."""
    unit = 10.0 ** math.floor(math.log10(width))
    return next(unit * share for share in (0.2, 0.25, 0.5, 1.0) if width / (unit * share) <= 8)
