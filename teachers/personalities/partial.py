"""partial(sees): says what it can know itself, flatly where it is certain, else with its probability."""

from dataclasses import dataclass
from typing import Annotated

from teachers.oracle import EXACT, POSTERIOR
from teachers.partial import EVIDENCE, PartialOracle
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range, Worlds, unknown
from teachers.witness import Witness


class _Knowledge(Stage["Partial"]):
    """Keeps what it has seen."""

    def begin(self) -> None:
        self._witness: Witness[PartialOracle] | None = None

    def speak(self, claims: Claims, view: View) -> Claims:
        if self._witness is None:
            self._witness = view.witness(PartialOracle, self.rng, **vars(self.spec))
        self._witness.follow()
        return self._witness.information.judge(view.kinds)


@dataclass(frozen=True)
class Partial(Personality):
    """Replaces the oracle's claims by those of `teachers.partial.PartialOracle`, which does not see the truth.

    The oracle judges worlds that agree with the evidence. A claim that it makes in more than half of them is said:
    flatly if it holds in all, else with the share of worlds where it holds.
    """

    sees: str = "student"
    """Its evidence: `student`, what the student sees; `rewards`, that and all rewards; `walk`, that and a random walk
    of its own through the same world."""
    steps: Annotated[int, Range(1, 1000)] = 10
    """Actions of that walk, at most."""
    worlds: Worlds = 256
    """Number of worlds that are drawn in a turn if the posterior cannot list all."""

    stage = _Knowledge

    @property
    def evidence(self) -> str:
        """What it sees in place of the truth."""
        return self.sees

    @property
    def needs(self) -> frozenset[str]:
        """A posterior; with a walk an exact one, or hardly any world would agree with both."""
        return frozenset((POSTERIOR, EXACT) if self.sees == "walk" else (POSTERIOR,))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sees not in EVIDENCE:
            raise ValueError(unknown("evidence", self.sees, EVIDENCE))
