"""Oracles that do not see the truth: they ask the family's oracle in every world that may be the true one."""

from collections.abc import Set
from typing import Any

import numpy as np
from typing_extensions import override

from teachers.atoms import KINDS, Claim, FeedbackType, Moment
from teachers.common import hedge
from teachers.information import DrawnWorld, Information, PosteriorContext
from teachers.spec import unknown
from worlds.posteriors import Draw, NoWorldError, random_walk
from worlds.world import WorldTurn

__all__ = ["EVIDENCE", "PartialOracle"]

EVIDENCE = ("student", "rewards", "walk")
"""What a partial oracle may see; see `PartialOracle`."""
_NEAR = 1e-9  # differences of shares below this are rounding


class PartialOracle(Information):
    """States what is true in the worlds that agree with its evidence, each claim with its probability.

    The evidence is what the student sees, `student`; that and all rewards, `rewards`; or that and a random walk of its
    own, with rewards, from the same opening, `walk`. Neither claims nor the instruction are evidence.

    If the posterior can list all worlds that agree with the evidence, the family's oracle judges each of them; else it
    judges `worlds` draws. A claim that the oracle makes in more than half of them is said: flatly if it holds in all,
    else with the share of worlds where it holds. So flat claims are true if worlds are listed. If they are drawn, a
    claim that holds in all of n draws is false with a mean probability of 1 / (n + 2), given a uniform prior of its
    share (Laplace's rule of succession).

    Args:
        context, worlds: as in `Information`.
        rng: draws the worlds and the walk.
        sees: one of `EVIDENCE`.
        steps: most actions of the walk.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(
        self,
        context: PosteriorContext,
        rng: np.random.Generator,
        worlds: int | None = None,
        *,
        sees: str = "student",
        steps: int = 10,
    ) -> None:
        super().__init__(context, rng, worlds)
        if sees not in EVIDENCE:
            raise ValueError(unknown("evidence", sees, EVIDENCE))
        self._sees, self._steps = sees, steps
        self._walk: list[WorldTurn[Any]] = []

    @override
    def see(self, moment: Moment[Any]) -> None:
        super().see(moment)
        if not moment.turn and self._sees == "walk":
            self._walk = self._walked(moment.after)
        if moment.before is not None and self._sees == "rewards":
            self._rewards[moment.turn] = moment.turn

    def hear(self, atoms: Any) -> tuple[()]:
        """Ignore claims, which are no evidence."""
        return ()

    def possible(self) -> list[tuple[Draw[Any], float]]:
        """The worlds that may be the true one, each with its probability; empty if no world could be drawn."""
        turns = tuple(turn._replace(reward_known=i in self._rewards) for i, turn in enumerate(self._turns))
        try:
            listed = self._posterior.every(turns, self._walk)
            drawn = [] if listed else self._posterior.take(turns, self._rng, self._worlds, self._walk)
        except NoWorldError:
            return []
        return listed or [(draw, 1 / len(drawn)) for draw in drawn]

    def judge(self, kinds: Set[FeedbackType]) -> list[Claim[Any]]:
        """The claims of the wanted kinds about the last moment, in speaking order."""
        worlds = [(self._moment_in(draw), draw[0].truth, share) for draw, share in self.possible()]
        shares: dict[Claim[Any], float] = {}
        said: list[frozenset[Claim[Any]]] = []
        for moment, opening, share in worlds:
            self._oracle.start(opening)
            claims = dict.fromkeys(self._oracle.judge(moment, kinds))
            said.append(frozenset(claims))
            for claim in claims:
                shares[claim] = shares.get(claim, 0.0) + share
        found = []
        for claim, share in shares.items():
            if share > 0.5 + _NEAR:
                # It may hold where the oracle has something else to say.
                rest = (w for w, claims in zip(worlds, said, strict=True) if claim not in claims)
                share += sum(p for moment, _, p in rest if claim.holds(moment, self._oracle.lab))
                found.append(claim if share > 1 - _NEAR else hedge(claim, share))
        return [claim for kind in KINDS for claim in found if claim.kind is kind]

    def _moment_in(self, draw: Draw[Any]) -> Moment[Any]:
        return DrawnWorld(draw, self._moments).moment(len(self._moments) - 1)

    def _walked(self, opening: Any) -> list[WorldTurn[Any]]:
        """A walk of random actions."""
        lab = self._oracle.lab
        lab.restore(opening)
        lab.np_random = self._rng
        walk = (turn._replace(reward_known=True) for turn in random_walk(lab, self._steps, self._rng))
        return [WorldTurn(None, 0.0, opening), *walk]
