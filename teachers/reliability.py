"""The reliability of hedges: whether claims hold as often as their probabilities say."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

__all__ = ["FEW", "LEVEL", "Bin", "Reliability", "share_of_clusters"]

LEVEL = 0.05
"""A teacher whose hedges deviate with a smaller p-value is not calibrated."""
FEW = 10
"""Fewest episodes to call a teacher calibrated."""


class Bin(NamedTuple):
    """The hedged claims with probabilities in one interval of 10 per cent."""

    low: float
    """Lower end of the interval, such as 0.5; its upper end, 0.1 above, is excluded."""
    sentences: int
    said: float
    """Mean of their probabilities."""
    held: float
    """Share of the claims that hold."""


def share_of_clusters(clusters: Iterable[tuple[int, int]]) -> tuple[float, float]:
    """The 95 % interval of a proportion from a cluster sample: sentences of one episode may be alike.

    It is the Clopper-Pearson interval with the effective sample size of Korn and Graubard (1998); if all sentences
    are hits or none is, the effective size is the number of clusters.

    Args:
        clusters: the number of sentences and the number of hits of each cluster; at least one sentence in all.
    """
    from scipy.stats import beta, t

    sizes = [each for each in clusters if each[0]]
    n, m, tail = sum(size for size, _ in sizes), len(sizes), 0.025
    share = sum(such for _, such in sizes) / n
    spread = math.fsum((such - share * size) ** 2 for size, such in sizes) * m / max(m - 1, 1) / n**2
    if m > 1 and spread > 1e-12:
        m = min(n, share * (1 - share) / spread * (t.isf(tail, n - 1) / t.isf(tail, m - 1)) ** 2)
    ends = beta.ppf([tail, 1 - tail], [share * m, share * m + 1], [(1 - share) * m + 1, (1 - share) * m])
    return (float(ends[0]) if share else 0.0), (float(ends[1]) if share < 1 else 1.0)


@dataclass
class Reliability:
    """How often hedged claims hold, by the probability with which they were said."""

    episodes: list[Counter[tuple[float, bool]]] = field(default_factory=list)
    """Per episode, the number of sentences for each probability and whether the hedged claim holds."""

    def add(self, hedges: Iterable[tuple[float, bool]]) -> None:
        """Add the hedged claims of an episode, each with its probability and whether it holds."""
        if counts := Counter(hedges):
            self.episodes.append(counts)

    @property
    def counts(self) -> Counter[tuple[float, bool]]:
        """The same number over all episodes."""
        return sum(self.episodes, Counter())

    @property
    def scores(self) -> list[float]:
        """Per episode, the sum of (held - p) (1 - 2 p); its mean is 0 if the probabilities are right."""
        return [sum(n * (held - p) * (1 - 2 * p) for (p, held), n in each.items()) for each in self.episodes]

    @property
    def sentences(self) -> int:
        """Number of hedged claims."""
        return self.counts.total()

    @property
    def bins(self) -> tuple[Bin, ...]:
        """The reliability table, without empty bins."""
        tens: dict[int, Counter[tuple[float, bool]]] = {}
        for (p, held), number in sorted(self.counts.items()):
            tens.setdefault(_ten(p), Counter())[p, held] += number
        return tuple(
            Bin(
                ten / 10,
                n := counts.total(),
                sum(p * each for (p, _), each in counts.items()) / n,
                sum(each for (_, held), each in counts.items() if held) / n,
            )
            for ten, counts in tens.items()
        )

    @property
    def brier(self) -> float | None:
        """Brier score: mean of (held - p)², less is better; None without claims."""
        total = sum(number * (held - p) ** 2 for (p, held), number in self.counts.items())
        return total / self.sentences if self.sentences else None

    @property
    def error(self) -> float | None:
        """Expected calibration error: mean over claims of |said - held| of their bin."""
        total = sum(each.sentences * abs(each.said - each.held) for each in self.bins)
        return total / self.sentences if self.sentences else None

    @property
    def p_value(self) -> float:
        """The p-value of Spiegelhalter's test (1986) that all probabilities are right; 1 with fewer than two episodes.

        Hedges of one episode depend on each other, so Student's t test compares the sums of the episodes.
        """
        sign = math.copysign(1.0, math.fsum(self.scores))
        return min(1.0, 2 * _tail([sign * score for score in self.scores]))

    @property
    def overstated(self) -> float:
        """The p-value that in each interval of 10 per cent as many claims hold as said, against fewer in one of them.

        The sums that `p_value` compares may cancel: lies that are hedged at 99 % by much truth that is hedged at 60 %.
        """
        sums: dict[int, list[float]] = {}
        for each in self.episodes:
            tens: dict[int, float] = {}
            for (p, held), n in each.items():
                tens[_ten(p)] = tens.get(_ten(p), 0.0) + n * (p - held)
            for ten, surplus in tens.items():
                sums.setdefault(ten, []).append(surplus)
        return min((min(1.0, len(sums) * _tail(each)) for each in sums.values()), default=1.0)

    @property
    def verdict(self) -> str:
        """`overconfident`, `timid`, or `calibrated` if neither is found at `LEVEL`; empty without claims.

        With fewer than `FEW` episodes it is `too few to tell` in place of `calibrated`.
        """
        if not self.sentences:
            return ""
        if self.p_value >= LEVEL:
            return "calibrated" if len(self.episodes) >= FEW else "too few to tell"
        return "overconfident" if sum(self.scores) > 0 else "timid"

    def as_dict(self) -> dict[str, Any]:
        """All of it as JSON values."""
        return {
            "sentences": self.sentences,
            "episodes": len(self.episodes),
            "brier": self.brier,
            "error": self.error,
            "p_value": self.p_value,
            "verdict": self.verdict,
            "bins": [each._asdict() for each in self.bins],
        }


def _tail(sums: Sequence[float]) -> float:
    """The one-sided p-value of Student's t test that the mean of independent sums is 0, against more; 1 for one sum."""
    from scipy.stats import t

    spread = math.sqrt(math.fsum(each**2 for each in sums))
    return float(t.sf(math.fsum(sums) / spread, len(sums) - 1)) if len(sums) > 1 and spread else 1.0


def _ten(p: float) -> int:
    """The index of a probability's interval of 10 per cent."""
    return round(100 * p) // 10
