"""How much a claim says: how improbable it was to a student that knows what it has seen and heard.

Worlds that the student cannot distinguish from its own are drawn by the family's posterior, given its own actions, all
observations and the rewards that were said. Those in which some claim that it has heard is false are left out. The
bits of a claim are minus the binary logarithm of the share of the others in which it is true. A claim is taken as it is
said, by `Claim.means`: what only its ground says is neither measured nor known.

A hedged claim of probability p leaves no world out: those in which it does not hold count (1 - p) / p as much as the
others. Its bits are those by which it changes what the student holds probable of it, from the share s of worlds in
which it is true to q = p s / (p s + (1 - p) (1 - s)): q log2(q / s) + (1 - q) log2((1 - q) / (1 - s)), which is the
Kullback-Leibler divergence of the weighed worlds from the others. For p = 1 these are the bits of a flat claim.
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
"""Number of worlds by which a claim is measured."""
TRIES = 40
"""Draws for each of them, at most: what was heard leaves only some of the worlds that were drawn."""
LEAST = 30
"""Number of worlds below which a claim is not measured, unless fewer are wanted."""
_LEVEL = 0.95
_GRID = 101  # shares of an interval, at which bits are computed


class Bits(NamedTuple):
    """How much a claim said to a student when it heard it."""

    worlds: int
    """Number of worlds by which it was measured; if it is 0, `why` says why."""
    held: int
    """Number of those in which it is true."""
    saved: float | None = None
    """Regret that it saves in the next action: in the worlds in which it is true, the mean regret of what seemed best
    before (of equal actions their mean) less that of what seems best now. None without worlds, and where the family's
    actions have no values.
    """
    why: str = ""
    p: float = 1.0
    """The probability with which it is said; 1 if it is flat."""

    @property
    def bits(self) -> float | None:
        """Minus the binary logarithm of the share of worlds in which it is true; if it is hedged, see this module.

        If a flat claim is true in none of them, what it says at least, by the end of `interval`. None without worlds.
        """
        if not self.worlds:
            return None
        if self.p < 1:
            return float(_divergence(self.held / self.worlds, self.p))
        return math.log2(self.worlds / self.held) if self.held else self.interval[0]

    @property
    def at_least(self) -> bool:
        """Whether it says at least `bits`, since it is true in none of the worlds."""
        return self.worlds > 0 and not self.held and self.p == 1

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the bits, from that of the share by Clopper and Pearson; the end may be infinite."""
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
        """The text with what it saves, or why it is unknown."""
        saved = "" if self.saved is None else f", saves {self.saved:.2g} of regret"
        return f"{self}{saved}{f': {self.why}' if self.why else ''}"

    def __str__(self) -> str:
        if self.bits is None:
            return "bits unknown"
        low, high = self.interval
        return f"at least {low:.1f} bits" if self.at_least else f"{self.bits:.2f} bits ({low:.2f} to {high:.2f})"


def _divergence(share: npt.ArrayLike, p: float) -> npt.NDArray[np.float64]:
    """The bits of claims that are hedged with probability p, given the shares of worlds in which they are true."""
    from scipy.special import rel_entr

    s = np.asarray(share, float)
    q = p * s / (p * s + (1 - p) * (1 - s))
    bits: npt.NDArray[np.float64] = (rel_entr(q, s) + rel_entr(1 - q, 1 - s)) / math.log(2)
    return bits


class Gain(NamedTuple):
    """How much several claims have said together, as far as it was measured."""

    claims: int = 0
    """Number of claims that were measured."""
    unknown: int = 0
    """Number of claims that were not, since no worlds were found."""
    bits: float = 0.0
    """Sum of their bits."""
    at_least: int = 0
    """Number of claims whose bits are only a bound from below."""
    words: int = 0
    """Number of words of the claims that were measured."""
    valued: int = 0
    """Number of those of which it is known what they save."""
    valued_bits: float = 0.0
    """Sum of the bits of these."""
    saved: float = 0.0
    """Sum of the regret that they save."""

    @classmethod
    def of(cls, text: str, bits: Bits) -> "Gain":
        """What one claim has said in a text."""
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
        """Bits in a word; None without words."""
        return self.bits / self.words if self.words else None

    @property
    def saved_per_bit(self) -> float | None:
        """Regret saved by a bit of the claims of which both are known; None without bits."""
        return self.saved / self.valued_bits if self.valued_bits else None


class PosteriorContext(NamedTuple):
    """What is needed to infer what a student can know."""

    posterior: Posterior[Any]
    """Draws worlds."""
    oracle: Oracle[Any, Any]
    """Judges in the drawn worlds; not the oracle of a teacher, and with a lab of its own."""


class DrawnWorld:
    """A world that was drawn."""

    def __init__(self, draw: Draw[Any], moments: Sequence[Moment[Any]]) -> None:
        self.draw, self._moments = draw, moments
        self.regrets: npt.NDArray[np.float64] | None = None
        """What each action loses now, shape (actions,); None as long as it is not computed."""
        self.false: int | None = None
        """Number of flat claims that do not hold in it; None as long as they are not counted."""
        self.likelihood: float | None = None
        """How much it counts by hedged claims, 0 to 1; None as long as it is not computed."""

    def moment(self, turn: int) -> Moment[Any]:
        """The moment of a turn, as it is in this world."""
        action, reward, after, success, _ = self.draw[turn]
        before = None if action is None else self.draw[turn - 1].truth
        own = self._moments[turn]  # `_replace` takes half as long again
        return Moment(before, own.action, reward, after, success, own.turn, own.over, own.ask_cost)


class Information:
    """What a student can know in an episode, and how much it is told.

    For each turn, `see` what happened, then `hear` what was said of it.

    Args:
        context: the posterior, and an oracle for the worlds that it draws.
        rng: draws the worlds, apart from all streams of the lesson.
        worlds: number of worlds by which a claim is measured; None: `WORLDS`.

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
        """What has happened, the opening first; a turn that comes again takes the place of all from there on."""
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
        """How much each of some claims says, given all that was seen and heard before, the claims before it included.

        A claim that is true in none of the worlds is not believed; what comes after it is measured without it.
        """
        return tuple(map(self._hear, atoms))

    def weigh(self, atom: Atom) -> Bits:
        """How much a claim would say now; it is not heard."""
        return self._measure(atom.claim, atom.about_turn)[0]

    def worlds(self) -> tuple[Draw[Any], ...]:
        """Worlds that agree with all that was seen and heard: as many as claims are measured by, or fewer."""
        self._fill()
        return tuple(world.draw for world in self._pool)

    def rest(self) -> None:
        """Give up the draws that have begun, so that it can be copied; others begin when they are needed."""
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
        """How much a claim says, and the worlds in which it is true."""
        self._fill()
        after = [world for world in self._pool if self._is_true(claim, about, world)]
        if len(self._pool) < min(LEAST, self._worlds):
            few = f"what was heard is true in {len(self._pool) or 'none'} of {TRIES * self._worlds:,} drawn worlds"
            return Bits(0, 0, why=self._why or few), after
        if isinstance(claim, HedgedClaim):
            return self._measure_hedge(claim, after)
        return Bits(len(self._pool), len(after), self._saved(self._pool, after)), after

    def _measure_hedge(self, claim: HedgedClaim, held: list[DrawnWorld]) -> tuple[Bits, list[DrawnWorld]]:
        """The same of a hedged claim, given the worlds in which it is true."""
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
        """Draw until there are enough worlds that agree with what was heard, or all tries are used up."""
        try:
            while len(self._pool) < self._worlds and self._left:
                self._left -= 1
                world = DrawnWorld(self._next(), self._moments)
                if self._agrees(world):
                    self._pool.append(world)
        except NoWorldError as error:
            self._why, self._left = f"{error}", 0

    def _agrees(self, world: DrawnWorld) -> bool:
        """Whether all that was heard is true in a world; what is not is asked of the next world first.

        A world in which a hedged claim is false agrees as often as it counts.
        """
        for i, (claim, about, _) in enumerate(self._heard):
            if not self._is_true(claim, about, world):
                if isinstance(claim, HedgedClaim) and self._rng.random() < self._doubt(claim):
                    continue
                self._heard.insert(0, self._heard.pop(i))
                return False
        return True

    def _doubt(self, claim: HedgedClaim) -> float:
        """How much a world counts in which a hedged claim is false, beside one in which it is true."""
        return 1 - self._trust + self._trust * (1 - claim.p) / claim.p

    def _is_true(self, claim: Claim, about: int, world: DrawnWorld) -> bool:
        """Whether a claim is true in a world, as it is said."""
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
        """See `Bits.saved`; the weights are those of the worlds after, which are equal by default."""
        best = self._best(before)
        if best is None or not after:
            return None
        now = self._mean_regrets(after, weights)
        return float(now[best].mean() - now.min())

    def _saved_by_others(self, best: npt.NDArray[np.int64] | None) -> float | None:
        """See `Bits.saved`, where other worlds were drawn than those in which `best` were the best actions.

        One half of them chooses, the other half judges: an action judged by the worlds that chose it seems too good.
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
        """The actions that lose least in the mean, to within twice its standard error; None without values.

        Of equal ones the worlds that happen to be drawn would choose one, but the student has drawn others.
        """
        if not (self._values and worlds) or self._moments[-1].over:
            return None
        lost = np.array([self._regrets_in(world) for world in worlds])
        more = lost - lost[:, [lost.mean(axis=0).argmin()]]
        return np.flatnonzero(more.mean(axis=0) <= 2 * more.std(axis=0) / math.sqrt(len(worlds)))

    def _mean_regrets(
        self, worlds: Sequence[DrawnWorld], weights: Sequence[float] | None = None
    ) -> npt.NDArray[np.float64]:
        """The mean of what each action loses, shape (actions,)."""
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
