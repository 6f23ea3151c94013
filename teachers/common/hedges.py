"""Claims that wrap another claim: it comes late, or it is probable."""

from collections.abc import Sequence
from typing import Any

from teachers.atoms import Claim, FeedbackType, HedgedClaim, Moment, claim, unhedged
from worlds.world import World


@claim
class Late(Claim[Any]):
    """A claim about an earlier turn: true if `claim` was true at that turn.

    A personality passes it to the voice; the atom then holds the claim itself and its turn.
    """

    claim: Claim[Any]
    turn: int

    @property
    def kind(self) -> FeedbackType | None:  # type: ignore[override]  # that of the claim
        """The kind of the late claim."""
        return self.claim.kind


@claim
class Probably(HedgedClaim[Any]):
    """Neither true nor false: it says that `claim` is true with the probability `p`.

    The probability is rounded as it is said, to whole per cent from 51 to 99, since a hedge is never flat.

    Raises:
        ValueError: the probability is not above 0.5 and below 1, or the claim is late or hedged itself.
    """

    claim: Claim[Any]
    p: float

    def __post_init__(self) -> None:
        if not 0.5 < self.p < 1:
            raise ValueError(f"p must be above 0.5 and below 1, got {self.p!r}; hedge what is more probable than not")
        if isinstance(self.claim, HedgedClaim | Late):
            raise ValueError(
                f"a hedge needs a flat claim that is not late, got {self.claim!r}; "
                "hedge the claim itself, by `hedge(claim, p)`, which keeps its turn"
            )
        object.__setattr__(self, "p", min(max(round(float(self.p), 2), 0.51), 0.99))

    @property
    def kind(self) -> FeedbackType | None:  # type: ignore[override]  # that of the claim
        """The kind of the hedged claim."""
        return self.claim.kind

    @property
    def percent(self) -> int:
        """The probability in per cent."""
        return round(100 * self.p)

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Whether the hedged claim holds; calibration judges many hedges by this."""
        return self.claim.holds(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Whether the hedged claim is true by its fields."""
        return self.claim.means(moment, oracle)

    def excludes(self, other: Claim[Any]) -> bool:
        """Every claim that the hedged claim excludes: only one of two such claims can be probable."""
        other = unhedged(other)
        return self.claim.excludes(other) or other.excludes(self.claim)

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The counterparts of the hedged claim, with the same probability."""
        return tuple(Probably(claim=each, p=self.p) for each in self.claim.counterparts(moment, lab))


def hedge(claim: Claim[Any], p: float) -> Claim[Any]:
    """Give a claim a probability, or another one if it is hedged; a late claim stays late.

    Raises:
        ValueError: the probability is not above 0.5 and below 1.
    """
    if isinstance(claim, Late):
        return Late(claim=hedge(claim.claim, p), turn=claim.turn)
    return Probably(claim=unhedged(claim), p=p)


def bend(claim: Claim[Any], factor: float) -> Claim[Any]:
    """Multiply the log-odds of a hedged claim by a factor above 0; return any other claim as it is.

    The new probability is rounded to whole per cent, from 51 to 99.
    """
    bare = claim.claim if isinstance(claim, Late) else claim
    if not isinstance(bare, HedgedClaim):
        return claim
    yes, no = bare.p**factor, (1 - bare.p) ** factor
    return hedge(claim, min(max(yes / (yes + no), 0.51), 0.99))
