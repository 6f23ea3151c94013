"""How much a claim says: how improbable it was to a student that knows what it has seen and heard.

The family's posterior draws worlds that the student cannot distinguish from its own, given its actions, all
observations and the stated rewards. Worlds that contradict a claim that the student has heard are dropped. The bits of
a new claim are minus the binary logarithm of the share of the remaining worlds where it is true. `Claim.means` decides
that: the ground of a claim is neither measured nor known.

A hedged claim of probability p drops no world: a world where it does not hold weighs (1 - p) / p times as much as the
others. It changes the student's probability of the claim from s, the share of worlds where it is true, to
q = p s / (p s + (1 - p) (1 - s)). Its bits are q log2(q / s) + (1 - q) log2((1 - q) / (1 - s)), the Kullback-Leibler
divergence of the weighted worlds from the unweighted ones. For p = 1 these are the bits of a flat claim.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from teachers.atoms import Atom, Claim, Grounded, HedgedClaim, Moment, unhedged
from teachers.common import Reward
from teachers.oracle import Oracle
from teachers.spec import is_count
from worlds.posteriors import Draw, NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["LEAST", "TRIES", "WORLDS", "Bits", "Gain", "Information", "PosteriorContext"]

WORLDS = 256
"""Number of worlds that measure a claim."""
TRIES = 40
"""Most draws per world: claims that were heard drop some of the drawn worlds."""
LEAST = 30
"""Fewest worlds that measure a claim, unless fewer are requested."""
_LEVEL = 0.95
_GRID = 101  # shares of an interval, at which bits are computed


class Bits(NamedTuple):
    """How much a claim said to a student when it heard it."""

    worlds: int
    """Number of worlds that measured it; if 0, `why` says why."""
    held: int
    """Number of these worlds where it is true."""
    saved: float | None = None
    """Regret that it saves in the next action, averaged over the worlds where it is true: the regret of the action that
    seemed best before (the mean of tied actions) minus the regret of the action that seems best now. None without
    worlds, and if the family's actions have no values.
    """
    why: str = ""
    p: float = 1.0
    """Its probability; 1 for a flat claim."""

    @property
    def bits(self) -> float | None:
        """Minus the binary logarithm of the share of worlds where it is true; for a hedged claim, see this module.

        If a flat claim is true in no world, the lower end of `interval`. None without worlds.
        """
        if not self.worlds:
            return None
        if self.p < 1:
            return float(_divergence(self.held / self.worlds, self.p))
        return math.log2(self.worlds / self.held) if self.held else self.interval[0]

    @property
    def at_least(self) -> bool:
        """Whether `bits` is only a lower bound, since the claim is true in no world."""
        return self.worlds > 0 and not self.held and self.p == 1

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the bits, from the Clopper-Pearson interval of the share; the end may be infinite."""
        from scipy.stats import binomtest

        if not self.worlds:
            return 0.0, math.inf
        share = binomtest(self.held, self.worlds).proportion_ci(_LEVEL, "exact")
        if self.p < 1:  # neither rises nor falls with the share throughout
            found = _divergence(np.linspace(share.low, share.high, _GRID), self.p)
            return float(found.min()), float(found.max())
        return -math.log2(share.high) + 0.0, -math.log2(share.low) if share.low > 0 else math.inf

    @property
    def short(self) -> str:
        """The text without the interval."""
        return f"{self}".partition(" (")[0]

    @property
    def described(self) -> str:
        """The text with the saved regret, or the reason why nothing is known."""
        saved = "" if self.saved is None else f", saves {self.saved:.2g} of regret"
        return f"{self}{saved}{f': {self.why}' if self.why else ''}"

    def __str__(self) -> str:
        if self.bits is None:
            return "bits unknown"
        low, high = self.interval
        return f"at least {low:.1f} bits" if self.at_least else f"{self.bits:.2f} bits ({low:.2f} to {high:.2f})"


def _divergence(share: npt.ArrayLike, p: float) -> npt.NDArray[np.float64]:
    """The bits of claims hedged with probability p, given the shares of worlds where they are true."""
    from scipy.special import rel_entr

    s = np.asarray(share, float)
    q = p * s / (p * s + (1 - p) * (1 - s))
    bits: npt.NDArray[np.float64] = (rel_entr(q, s) + rel_entr(1 - q, 1 - s)) / math.log(2)
    return bits


class Gain(NamedTuple):
    """How much several claims have said together."""

    claims: int = 0
    """Number of measured claims."""
    unknown: int = 0
    """Number of claims that could not be measured: no worlds were found."""
    bits: float = 0.0
    """Sum of the bits of the measured claims."""
    at_least: int = 0
    """Number of claims whose bits are only a lower bound."""
    words: int = 0
    """Number of words of the measured claims."""
    valued: int = 0
    """Number of measured claims with a known saving."""
    valued_bits: float = 0.0
    """Sum of the bits of the claims with a known saving."""
    saved: float = 0.0
    """Sum of the regret that they save."""

    @classmethod
    def of(cls, text: str, bits: Bits) -> "Gain":
        """The gain from one claim, given its text."""
        if bits.bits is None:
            return cls(unknown=1)
        valued = (0, 0.0, 0.0) if bits.saved is None else (1, bits.bits, bits.saved)
        return cls(1, 0, bits.bits, int(bits.at_least), len(text.split()), *valued)

    def __add__(self, other: "Gain") -> "Gain":  # type: ignore[override]  # no concatenation
        """Both together."""
        added: Any = (one + two for one, two in zip(self, other, strict=True))
        return Gain(*added)

    @property
    def bits_per_word(self) -> float | None:
        """Bits per word; None without words."""
        return self.bits / self.words if self.words else None

    @property
    def saved_per_bit(self) -> float | None:
        """Saved regret per bit, of the claims with a known saving; None without bits."""
        return self.saved / self.valued_bits if self.valued_bits else None


class PosteriorContext(NamedTuple):
    """What is needed to infer what a student can know."""

    posterior: Posterior[Any]
    """Draws worlds."""
    oracle: Oracle[Any, Any]
    """Judges the drawn worlds; not the teacher's oracle, and with a lab of its own."""


class DrawnWorld:
    """A world that the posterior has drawn."""

    def __init__(self, draw: Draw[Any], moments: Sequence[Moment[Any]]) -> None:
        self.draw, self._moments = draw, moments
        self.regrets: npt.NDArray[np.float64] | None = None
        """Regret of each action now, shape (actions,); None until it is computed."""
        self.false: int | None = None
        """Number of flat claims that do not hold in it; None until they are counted."""
        self.likelihood: float | None = None
        """Its factor by the hedged claims, 0 to 1; None until it is computed."""

    def moment(self, turn: int) -> Moment[Any]:
        """The moment of a turn in this world."""
        action, reward, after, success, _ = self.draw[turn]
        before = None if action is None else self.draw[turn - 1].truth
        own = self._moments[turn]  # `_replace` takes half as long again
        return Moment(before, own.action, reward, after, success, own.turn, own.over, own.ask_cost)


class Information:
    """What a student can know in an episode, and how much claims tell it.

    In each turn, call `see` with what happened, then `hear` with what was said.

    Args:
        context: the posterior that draws worlds, and the oracle that judges them.
        rng: draws the worlds, apart from all streams of the lesson.
        worlds: number of worlds that measure a claim; None: `WORLDS`.

    Raises:
        ValueError: `worlds` is not an integer of at least 1.
    """

    _trust = 1.0  # in what is heard

    def __init__(self, context: PosteriorContext, rng: np.random.Generator, worlds: int | None = None) -> None:
        worlds = WORLDS if worlds is None else worlds
        if not is_count(worlds):
            raise ValueError(f"worlds must be an integer of at least 1, got {worlds!r}")
        self._posterior, self._oracle = context
        self._rng, self._worlds = rng, worlds
        # Few worlds, which are drawn again and again.
        self._keeps = self._posterior.exact and not self._posterior.chancy
        self._values = "values" in self._oracle.abilities()
        self._moments: list[Moment[Any]] = []
        self._turns: list[WorldTurn[Any]] = []
        self._heard: list[tuple[Claim, int, int]] = []  # each with the turn that it is about, and that of its hearing
        self._rewards: dict[int, int] = {}  # per turn whose reward was said, when it was
        self._known: dict[tuple[Claim, Moment[Any]], bool] = {}
        self._regrets: dict[Moment[Any], npt.NDArray[np.float64]] = {}
        self._draws: Iterator[Draw[Any]] | None = None
        self._left = 0  # draws of this turn
        self._pool: list[DrawnWorld] = []
        self._why = ""  # there are no more worlds

    def see(self, moment: Moment[Any]) -> None:
        """Note a turn, the opening first. An earlier turn replaces itself and all turns after it."""
        turn = moment.turn
        if self._moments[turn:] and self._moments[turn] is moment:
            return  # the student has asked, and hears more of it
        del self._moments[turn:], self._turns[turn:]
        if not turn:
            self._known.clear()
            self._regrets.clear()
        self._heard = [each for each in self._heard if each[2] < turn]
        self._rewards = {about: when for about, when in self._rewards.items() if when < turn}
        action = None if moment.before is None else moment.action
        self._moments.append(moment)
        self._turns.append(WorldTurn(action, moment.reward, moment.after, moment.success))
        self._begin()

    def hear(self, atoms: Sequence[Atom]) -> tuple[Bits, ...]:
        """How much each claim says, given all that was seen and heard, earlier claims of this call included.

        A claim that is true in no world is not believed: it does not affect the claims after it.
        """
        return tuple(map(self._hear, atoms))

    def weigh(self, atom: Atom) -> Bits:
        """How much a claim would say now. The student does not hear it."""
        return self._measure(atom.claim, atom.about_turn)[0]

    def worlds(self) -> tuple[Draw[Any], ...]:
        """Worlds that agree with all that was seen and heard; at most as many as measure a claim."""
        self._fill()
        return tuple(world.draw for world in self._pool)

    def rest(self) -> None:
        """Drop the running generator of draws, which cannot be copied; a new one starts when needed."""
        self._draws = None

    def _hear(self, atom: Atom) -> Bits:
        claim, about, now = atom.claim, atom.about_turn, self._moments[-1].turn
        bits, after = self._measure(claim, about)
        said = isinstance(claim, Reward) and claim.reward == self._moments[about].reward
        if said and bits.worlds and self._posterior.chancy:
            best = self._best(self._pool)
            self._rewards[about] = now
            self._begin()  # of numbers that vary by chance, hardly two are equal
            self._fill()
            return bits._replace(saved=self._saved_by_others(best))
        if after or isinstance(claim, HedgedClaim):
            self._heard.append((claim, about, now))
            self._pool = after
        return bits

    def _measure(self, claim: Claim, about: int) -> tuple[Bits, list[DrawnWorld]]:
        """How much a claim says, and the worlds where it is true."""
        self._fill()
        after = [world for world in self._pool if self._is_true(claim, about, world)]
        if len(self._pool) < min(LEAST, self._worlds):
            few = f"what was heard is true in {len(self._pool) or 'none'} of {TRIES * self._worlds:,} drawn worlds"
            return Bits(0, 0, why=self._why or few), after
        if isinstance(claim, HedgedClaim):
            return self._measure_hedge(claim, after)
        return Bits(len(self._pool), len(after), self._saved(self._pool, after)), after

    def _measure_hedge(self, claim: HedgedClaim, held: list[DrawnWorld]) -> tuple[Bits, list[DrawnWorld]]:
        """How much a hedged claim says, and a sample of the weighted worlds; `held` are the worlds where it is true."""
        true, doubt = set(map(id, held)), self._doubt(claim)
        after = [world for world in self._pool if id(world) in true or self._rng.random() < doubt]
        weights = [1.0 if id(world) in true else doubt for world in self._pool]
        saved = self._saved(self._pool, self._pool, weights)
        return Bits(len(self._pool), len(held), saved, p=claim.p), after

    def _begin(self) -> None:
        """Draw new worlds from now on."""
        self._pool, self._left, self._why = [], TRIES * self._worlds, ""
        self.rest()

    def _next(self) -> Draw[Any]:
        """One more draw."""
        if self._draws is None:
            turns = tuple(turn._replace(reward_known=i in self._rewards) for i, turn in enumerate(self._turns))
            self._draws = self._posterior.draws(turns, self._rng)
        return next(self._draws)

    def _fill(self) -> None:
        """Draw until enough worlds agree with what was heard, or no tries are left."""
        try:
            while len(self._pool) < self._worlds and self._left:
                self._left -= 1
                world = DrawnWorld(self._next(), self._moments)
                if self._agrees(world):
                    self._pool.append(world)
        except NoWorldError as error:
            self._why, self._left = f"{error}", 0

    def _agrees(self, world: DrawnWorld) -> bool:
        """Whether all that was heard is true in a world. A claim that fails here is the first to be checked next time.

        A world where a hedged claim is false passes with the probability of its factor, `_doubt`.
        """
        for i, (claim, about, _) in enumerate(self._heard):
            if not self._is_true(claim, about, world):
                if isinstance(claim, HedgedClaim) and self._rng.random() < self._doubt(claim):
                    continue
                self._heard.insert(0, self._heard.pop(i))
                return False
        return True

    def _doubt(self, claim: HedgedClaim) -> float:
        """Weight of a world that violates a hedge, relative to a world that does not."""
        return 1 - self._trust + self._trust * (1 - claim.p) / claim.p

    def _is_true(self, claim: Claim, about: int, world: DrawnWorld) -> bool:
        """Whether a claim is true in a world, by what it `means`."""
        moment, bare = world.moment(about), unhedged(claim)
        said = bare.within(world.moment, about)
        keeps = self._keeps and said is bare  # or it is about more than the moment
        found = self._known.get((claim, moment)) if keeps else None
        if found is None:
            if isinstance(bare, Grounded):
                self._oracle.start(world.draw[0].truth)
            found = said.means(moment, self._oracle)
            if keeps:
                self._known[claim, moment] = found
        return found

    def _saved(
        self, before: Sequence[DrawnWorld], after: Sequence[DrawnWorld], weights: Sequence[float] | None = None
    ) -> float | None:
        """See `Bits.saved`; `weights` are those of the worlds `after`, equal by default."""
        best = self._best(before)
        if best is None or not after:
            return None
        now = self._mean_regrets(after, weights)
        return float(now[best].mean() - now.min())

    def _saved_by_others(self, best: npt.NDArray[np.int64] | None) -> float | None:
        """See `Bits.saved`; `best` are the best actions in worlds that were replaced by new draws.

        One half of the new worlds chooses actions and the other half judges them, to avoid optimistic bias.
        """
        halves = self._pool[::2], self._pool[1::2]
        if best is None or not all(halves):
            return None
        saved = 0.0
        for chose, judges in (halves, halves[::-1]):
            lost = self._mean_regrets(judges)
            saved += float(lost[best].mean() - lost[self._best(chose)].mean()) / 2
        return saved

    def _best(self, worlds: Sequence[DrawnWorld]) -> npt.NDArray[np.int64] | None:
        """The actions of least mean regret, to within twice its standard error; None without values.

        They count as tied: the drawn worlds would choose one of them by chance, and the student has drawn others.
        """
        if not (self._values and worlds) or self._moments[-1].over:
            return None
        lost = np.array([self._regrets_in(world) for world in worlds])
        more = lost - lost[:, [lost.mean(axis=0).argmin()]]
        return np.flatnonzero(more.mean(axis=0) <= 2 * more.std(axis=0) / math.sqrt(len(worlds)))

    def _mean_regrets(
        self, worlds: Sequence[DrawnWorld], weights: Sequence[float] | None = None
    ) -> npt.NDArray[np.float64]:
        """Mean regret of each action, shape (actions,)."""
        lost = [self._regrets_in(world) for world in worlds]
        means: npt.NDArray[np.float64] = np.average(lost, axis=0, weights=weights)
        return means

    def _regrets_in(self, world: DrawnWorld) -> npt.NDArray[np.float64]:
        if world.regrets is None:
            moment = world.moment(len(self._moments) - 1)
            world.regrets = self._regrets.get(moment) if self._keeps else None
            if world.regrets is None:
                self._oracle.start(world.draw[0].truth)
                values = np.array(self._oracle.values(moment.after))
                world.regrets = values.max() - values
                if self._keeps:
                    self._regrets[moment] = world.regrets
        return world.regrets
