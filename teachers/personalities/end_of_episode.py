"""end_of_episode(top_k): keeps everything for a summary at the end."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.common import Late
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class EndOfEpisode(Personality):
    """Says nothing until the episode is over, and then the claims about the turns in which most was at stake.

    Of turns with as much at stake the later ones are preferred. A student who leaves before the end hears nothing.
    """

    top_k: int = 5
    """Greatest number of claims, at least 0."""

    source = "Shute 2008"

    def __post_init__(self) -> None:
        check_range("top_k", self.top_k, 0, 1_000_000, int)

    class Stage(Stage):
        """Keeps what is to be said."""

        def begin(self) -> None:
            """Nothing yet."""
            self._kept: list[tuple[float, int, Claim]] = []

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Nothing, or the summary in the order of turns."""
            turn, over = view.turn, view.moment.over
            stake = view.past_importance() if claims else 0.0
            for claim in claims:
                late = claim if over or isinstance(claim, Late) else Late(claim=claim, turn=turn)
                self._kept.append((stake, len(self._kept), late))
            if not over:
                return ()
            best = sorted(self._kept, key=lambda each: (-each[0], -each[1]))[: self.spec.top_k]
            return [claim for _, _, claim in sorted(best, key=lambda each: each[1])]
