"""end_of_episode(top_k): keeps everything for a summary at the end."""

from dataclasses import dataclass
from typing import Any

from teachers.atoms import Claim
from teachers.common import Late
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Count


class _Summary(Stage["EndOfEpisode"]):
    """Keeps the claims, and what was at stake."""

    def begin(self) -> None:
        self._kept: list[tuple[float, int, Claim[Any]]] = []

    def speak(self, claims: Claims, view: View) -> Claims:
        turn, over = view.turn, view.moment.over
        stake = view.past_importance() if claims else 0.0
        for claim in claims:
            late = claim if over or isinstance(claim, Late) else Late(claim=claim, turn=turn)
            self._kept.append((stake, len(self._kept), late))
        if not over:
            return ()
        best = sorted(self._kept, key=lambda each: (-each[0], -each[1]))[: self.spec.top_k]
        return [claim for _, _, claim in sorted(best, key=lambda each: each[1])]


@dataclass(frozen=True)
class EndOfEpisode(Personality):
    """Says nothing until the episode is over, then the claims about the turns with most at stake.

    Among turns with equal stakes it prefers the later ones. A student that leaves before the end gets no feedback.
    """

    top_k: Count = 5
    """Greatest number of claims, at least 0."""

    source = "Shute 2008"
    stage = _Summary
