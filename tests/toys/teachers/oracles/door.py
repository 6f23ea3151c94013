"""What can be said of a door with two dials: its oracle has no praise and no warnings."""

from collections.abc import Sequence
from collections.abc import Set as Kinds
from dataclasses import replace

from teachers.atoms import FP, HN, ActionClaim, Claim, FeedbackType, Moment, R, claim
from teachers.common import Syntax
from teachers.oracle import Oracle
from worlds.door import SETTINGS, Door, Truth


def opens(lab: Door, truth: Truth, setting: tuple[int, int]) -> bool:
    """Whether the door opens, tried out."""
    lab.restore(truth)
    return bool(lab.step(setting)[4]["success"])


@claim
class Goal(Claim[Truth, Door]):
    """True if one setting of the dials opens the door."""

    def holds(self, moment: Moment[Truth], lab: Door) -> bool:
        """Try them all."""
        return sum(opens(lab, moment.after, setting) for setting in SETTINGS) == 1


@claim
class _Setting(ActionClaim[Truth, Door]):
    """Base of what is said of one setting."""

    action: tuple[int, int]
    action_slot = "dials"

    @property
    def dials(self) -> str:
        """The setting as a student writes it."""
        return str(list(self.action))

    def counterparts(self, moment: Moment[Truth], lab: Door) -> Sequence[Claim]:
        """The same of another setting."""
        return tuple(replace(self, action=setting) for setting in SETTINGS if setting != self.action)


@claim
class Code(_Setting):
    """True if this setting opens the door."""

    def holds(self, moment: Moment[Truth], lab: Door) -> bool:
        """Try it."""
        return opens(lab, moment.after, self.action)


@claim
class Shut(_Setting):
    """True if this is the setting that was tried, and the door does not open for it."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Door) -> bool:
        """Try it again."""
        return moment.action == self.action and not opens(lab, moment.past, self.action)


@claim
class Try(Code):
    """True if this setting opens the door."""

    kind = FP


class DoorOracle(Oracle[Truth, Door]):
    """Knows the code."""

    instruction_types = ("b", "c")
    feedback_types = (R, HN, FP)

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        return Goal(), Syntax(expected=self.lab.action_syntax)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        return (Code(action=truth.code),)

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Kinds[FeedbackType]) -> None:
        if HN in kinds and self.regret(moment):
            claims.append(Shut(action=moment.action))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Kinds[FeedbackType]) -> None:
        if FP in kinds:
            claims.append(Try(action=moment.after.code))

    def plan(self, truth: Truth, n: int) -> tuple[tuple[int, int], ...]:
        """The code."""
        return (truth.code,)[:n]

    def regret(self, moment: Moment[Truth]) -> float:
        """1 for each turn that leaves the door shut."""
        return float(moment.action != moment.after.code)
