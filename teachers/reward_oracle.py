"""The oracle of reinforcement learning: it states rewards and nothing else."""

from collections.abc import Set
from typing import Any

from teachers.atoms import Claim, FeedbackType, Moment, R
from teachers.common import Maximize, Syntax
from teachers.oracle import Oracle


class RewardOracle(Oracle):
    """The reduction of reinforcement learning to learning from language feedback.

    The instruction is to maximize the accumulated rewards; the feedback is the reward of each action. It serves any
    world and needs no truth. Other instructions, other kinds of feedback and regret are not supported.
    """

    instruction_types = ("b",)
    feedback_types = (R,)
    needs_truth = False

    def _basics(self, truth: Any) -> tuple[Claim, ...]:
        return Maximize(), Syntax(expected=self.lab.action_syntax)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """Nothing: the base class states the reward."""

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """Nothing."""
