"""Advice that belongs to no family: without its content, and a worked example."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from teachers.atoms import FN, FP, ActionClaim, Claim, Grounded, Moment, PlanClaim, action_of, claim
from teachers.common.rewards import as_said
from worlds.world import World

_TRIES = 5  # random actions, in search of another first one


def as_written(action: Any) -> str:
    """An action as a student writes it: several numbers as a list, a text that is no list in quotation marks."""
    if isinstance(action, tuple):
        return f"[{', '.join(map(as_written, action))}]"
    return f'"{action}"' if isinstance(action, str) and action[:1] not in ("[", "{") else f"{action}"


def rounded(action: Any) -> Any:
    """An action whose numbers have the digits that phrases state, four significant ones."""
    if isinstance(action, tuple):
        return tuple(map(rounded, action))
    return float(as_said(action)) if isinstance(action, float) else action


@claim
class Chance(Grounded[Any]):
    """True if there is something good to do next: its ground, an advice, holds."""

    kind = FP

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the advice."""
        return not self._ground.relative and self.stands(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask the oracle for advice."""
        return any(each.kind is FP and not each.relative for each in oracle.judge(moment, {FP}))


@claim
class Trap(Grounded[Any]):
    """True if there is something to avoid next: its ground, a warning, holds."""

    kind = FN

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the warning."""
        return not self._ground.relative and self.stands(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask the oracle for warnings."""
        return any(each.kind is FN and not each.relative for each in oracle.judge(moment, {FN}))


@claim
class Example(Grounded[Any], PlanClaim[Any]):
    """True if these actions are optimal one after the other: its ground has for each the advice to take it, which holds
    at that point, or None if it solves the task.
    """  # noqa: D205

    kind = FP
    plan_slot = "steps"
    separator = ", then "
    actions: tuple[Any, ...]

    @property
    def action(self) -> Any:
        """The first action."""
        return self.actions[0]

    @property
    def steps(self) -> str:
        """The actions as a student writes them."""
        return self.separator.join(map(as_written, self.actions))

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Take the actions, and check each advice where it applies."""
        truth = moment.after
        for action, advice in zip(self.actions, self._ground, strict=True):
            if advice is not None and not advice.holds(moment._replace(after=truth), lab):
                return False
            lab.restore(truth)
            solved = lab.step(action)[4]["success"]
            if advice is None and not solved:
                return False
            truth = lab.truth
        return True

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Take the actions: the oracle advises each, or it solves the task."""
        for action in self.actions:
            now = Moment.opening(moment.after, moment.turn)
            advice = oracle.judge(now, {FP})
            moment = oracle.try_out(moment, action)
            if not (moment.success or any(action_of(each) == action for each in advice)):
                return False
        return True

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The same example with another first action."""
        first, *rest = self._ground
        if first is None:
            rng = np.random.default_rng(0)
            others: list[tuple[Any, Any]] = [(None, lab.legal(lab.sample_action(rng))) for _ in range(_TRIES)]
        else:
            others = [(c, c.action) for c in first.counterparts(moment, lab) if isinstance(c, ActionClaim)]
        return tuple(Example.on((advice, *rest), actions=(action, *self.actions[1:])) for advice, action in others)
