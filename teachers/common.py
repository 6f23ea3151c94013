"""Claims that belong to no family; their phrases are in `phrases/common.toml`."""

from collections.abc import Sequence

from teachers.atoms import HN, HP, Claim, FeedbackType, Moment, R, claim
from worlds.world import World


@claim
class Reward(Claim):
    """True if `reward` is what the world paid for the action of this turn."""

    kind = R
    reward: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compare with the world's payment."""
        return moment.before is not None and self.reward == moment.reward

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another reward that the world might pay."""
        low, high = lab.reward_range
        others = (1.0 - self.reward, 0.5 * self.reward, low, high)
        return tuple(Reward(reward=r) for r in others if low <= r <= high and r != self.reward)[:1]


@claim
class TryAgain(Claim):
    """True if the task is not solved."""

    kind = HN

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask the record."""
        return moment.action is not None and not moment.success

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that it is solved."""
        return (Solved(),)


@claim
class Solved(Claim):
    """True if the task is solved."""

    kind = HP

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask the record."""
        return moment.success

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that it is not."""
        return (TryAgain(),)


@claim
class Truism(Claim):
    """True always: a fact that has nothing to do with the task, from the list of the placebo personality."""

    kind: FeedbackType
    """The kind of the claim that it stands in for: a truism has none of its own."""
    placebo = True
    fact: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the fact up."""
        return self.fact in FACTS

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """A fact turned into its opposite."""
        return (Truism(kind=self.kind, fact=f"it is wrong that {self.fact}"),)


@claim
class NotUnderstood(Claim):
    """True if the student's text was no action, and `expected` is what the world understands.

    A notice of the environment, not feedback of the teacher: no personality and no feedback type withholds it.
    """

    got: str
    expected: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compare with the turn's parse failure."""
        return moment.action == (self.got, self.expected) and self.expected == lab.action_syntax


@claim
class Maximize(Claim):
    """True of every world, if nothing but its rewards counts: how reinforcement learning is put as an instruction."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """By definition."""
        return True


@claim
class Syntax(Claim):
    """True if `expected` is what the world understands as an action."""

    expected: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask the world."""
        return self.expected == lab.action_syntax


@claim
class Late(Claim):
    """A claim about an earlier turn: true if `claim` was true at that turn.

    It exists between a personality and the voice only; the atom holds the claim itself and its turn.
    """

    claim: Claim
    turn: int

    @property
    def kind(self) -> FeedbackType | None:
        """The kind of the claim that comes late."""
        return self.claim.kind


FACTS = (
    "ice is cold",
    "a week has seven days",
    "the sun rises in the east",
    "bread is often made from wheat flour",
    "a triangle has three sides and three corners",
    "most cats sleep for many hours of the day",
    "letters are sorted into the alphabet from a to z",
    "a bicycle has two wheels and a car usually has four",
    "rain falls from clouds and rivers carry the water to the sea",
    "the moon goes around the earth about once in every twenty-seven days",
    "an orchestra has strings, woodwinds, brass and percussion, and a conductor who leads them",
    "paper is made from wood, and wood comes from trees, which need light and water to grow",
)
"""True, useless sentences of 3 to 17 words, by length."""
