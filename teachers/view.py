"""What a personality sees of a turn. It knows no template and no family."""

from collections.abc import Callable, Sequence, Set
from typing import Any

import numpy as np
from gymnasium import spaces

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Atom, Claim, FeedbackType, HedgedClaim, Moment, R, unhedged
from teachers.common import (
    HORIZON,
    Better,
    BetterTurn,
    Chance,
    Example,
    Late,
    Paid,
    PartlyRight,
    Right,
    Trap,
    WorseTurn,
    Wrong,
    hedge,
    rounded,
    sign_of,
)
from teachers.elsewhere import Elsewhere
from teachers.fingerprint import Fingerprints
from teachers.information import Bits, Information, PosteriorContext
from teachers.oracle import Oracle
from teachers.witness import InformationT, Note, Witness

HINDSIGHT = frozenset((HP, HN))
_EQUAL = 1e-9  # values that differ by less differ by rounding


def first_of(kinds: Set[FeedbackType], claims: Sequence[Claim[Any]]) -> int | None:
    """The index of the first claim of some kinds that is no placebo; None if there is none."""
    return next((i for i, claim in enumerate(claims) if claim.kind in kinds and not _bare(claim).placebo), None)


class View:
    """The moment, what the oracle computes from it, and operations on claims.

    All methods treat a late claim as a claim about its own turn.
    """

    def __init__(self, oracle: Oracle, words: Callable[[Claim[Any]], float], numbers: Any = None) -> None:
        self._oracle = oracle
        self.numbers = numbers
        """`teachers.teacher_turn.TeacherTurn.numbers` of the teacher's seat; None outside of a lesson."""
        self._moments: list[Moment[Any]] = []
        self._fingerprints = Fingerprints()
        self._hindsight: dict[int, tuple[Claim[Any], ...]] = {}  # by turn
        self.kinds: frozenset[FeedbackType] = frozenset()
        """The wanted kinds of feedback; claims of other kinds are withheld after the personality."""
        self.asked = False
        """Whether this is the answer to a student's question; it consists of advice only."""
        self._words = words
        self._origins: dict[tuple[Claim[Any], int], Moment[Any]] = {}
        self._context: PosteriorContext | None = None

    def see(self, moment: Moment[Any], kinds: frozenset[FeedbackType]) -> None:
        """Go on to the next moment and its wanted kinds."""
        self._moments.append(moment)
        if self._context is not None:
            self._notes.append(moment)
        self.kinds = kinds
        self.asked = False

    def ask(self) -> None:
        """Note that the student asks for advice, after the feedback of this moment."""
        self.asked = True

    def hear(self, atoms: Sequence[Atom]) -> None:
        """Note what the student has heard in this turn."""
        self._notes.append(tuple(atoms))

    @property
    def moment(self) -> Moment[Any]:
        """The moment to speak about."""
        return self._moments[-1]

    @property
    def turn(self) -> int:
        """The number of turns so far."""
        return self.moment.turn

    @property
    def last(self) -> Moment[Any] | None:
        """The moment of the turn before; None at the opening."""
        return self._moments[-2] if len(self._moments) > 1 else None

    # What the oracle computes.

    def values(self) -> tuple[float, ...] | None:
        """Value per discrete action now; None where actions cannot be enumerated."""
        return self._oracle.values(self.moment.after)

    def past_values(self) -> tuple[float, ...] | None:
        """Value per discrete action before the last action; None also if no action was executed."""
        return None if self.moment.before is None else self._oracle.values(self.moment.before)

    def past_stated_values(self) -> tuple[float, ...] | None:
        """`past_values` as phrases state them."""
        return None if self.moment.before is None else self._oracle.stated_values(self.moment.before)

    def importance(self) -> float:
        """What is at stake in the next action."""
        return self._oracle.importance(self.moment.after)

    def past_importance(self) -> float:
        """What was at stake in the last action; if none was executed, what is at stake in the next."""
        moment = self.moment
        return self._oracle.importance(moment.after if moment.before is None else moment.before)

    def plan(self, n: int) -> tuple[Any, ...]:
        """At most `n` actions of an optimal policy from here on."""
        return self._oracle.plan(self.moment.after, n)

    def clues(self) -> tuple[Claim[Any], ...]:
        """True claims that help and name no action, from little to much; none once the episode is over."""
        return () if self.moment.over else self._oracle.clues(self.moment.after)

    def regret(self) -> float:
        """Value lost by the last action: 0 if it was optimal, ties included."""
        return self._oracle.regret(self.moment)

    def loss(self, action: Any) -> float:
        """Value that this action would lose as the next one."""
        return self._oracle.regret(self._oracle.try_out(self.moment, action))

    def steps_to_success(self, truth: Any, action: Any, horizon: int) -> int | None:
        """Number of actions until this one and then an optimal policy solve the task; None if above `horizon`."""
        return len(self._oracle.way(truth, action, horizon)) or None

    def hindsight(self) -> tuple[Claim[Any], ...]:
        """All true hp and hn claims about the last action, wanted or not."""
        return self._hindsight_on(self.moment)

    def _hindsight_on(self, moment: Moment[Any]) -> tuple[Claim[Any], ...]:
        said = () if moment.before is None else self._hindsight.get(moment.turn)
        if said is None:
            said = self._hindsight[moment.turn] = self._oracle.judge(moment._replace(over=True), HINDSIGHT)
        return said

    def right(self) -> bool | None:
        """Whether all hindsight on the last action is praise; None if there is no hindsight."""
        said = self.hindsight()
        return all(claim.kind is HP for claim in said) if said else None

    def share(self, truth: Any) -> float:
        """A number in [0, 1) that is fixed for each state and uniform over the states."""
        return self._fingerprints.share(self._oracle.lab.state_of(truth))

    def fingerprint(self, truth: Any) -> int:
        """A number that is equal for equal states."""
        return self._fingerprints.of(self._oracle.lab.state_of(truth))

    def action_fingerprint(self, action: Any) -> int:
        """A number that is equal for equal actions."""
        return self._fingerprints.of(action)

    # What a student can know.

    def infer_from(self, context: PosteriorContext | None, rng: np.random.Generator) -> None:
        """Track from now on what the student can know.

        Args:
            context: the posterior and the oracle for this.
            rng: draws the worlds that measure claims.
        """
        self._context, self._notes, self._rng = context, list[Note](), rng
        self._witnesses: dict[int, Witness[Information]] = {}

    def witness(
        self, cls: Callable[..., InformationT], rng: np.random.Generator, **arguments: Any
    ) -> Witness[InformationT]:
        """A witness whose information is of class `cls`, with a random stream and the other arguments of that class."""
        assert self._context is not None  # noqa: S101  # or the personality would not be served
        return Witness(cls(self._context, rng, **arguments), self._notes)

    def weigh(self, claim: Claim[Any], worlds: int) -> Bits:
        """How much a claim would say to the student, given all that it saw and heard, measured by so many worlds."""
        if worlds not in self._witnesses:
            self._witnesses[worlds] = self.witness(Information, self._rng, worlds=worlds)
        return self._witnesses[worlds].weigh(_bare(claim), claim.turn if isinstance(claim, Late) else self.turn)

    def weigh_all(self, claims: Sequence[Claim[Any]], worlds: int) -> list[tuple[Claim[Any], Bits]]:
        """These claims and the oracle's clues of the wanted kinds, each with how much it would say."""
        clues = [clue for clue in self.clues() if clue.kind in self.kinds]
        return [(claim, self.weigh(claim, worlds)) for claim in (*claims, *clues)]

    # What is true elsewhere.

    def elsewhere(self, rng: np.random.Generator, *, clues: bool = False) -> Elsewhere:
        """Lessons in other worlds of the same kind; with `clues`, their claims include the oracle's clues."""
        return Elsewhere(self._oracle, self.kinds, self._words, rng, clues=clues)

    def displace(self, claim: Claim[Any], there: Claim[Any], moment: Moment[Any]) -> Claim[Any]:
        """A claim of a moment elsewhere, as if it were about the turn of this claim: late, or hedged, if this is."""
        self._origins[there, claim.turn if isinstance(claim, Late) else self.turn] = moment
        bare = _bare(claim)
        return _like(claim, hedge(there, bare.p) if isinstance(bare, HedgedClaim) else there)

    def origin(self, claim: Claim[Any], turn: int) -> Moment[Any] | None:
        """The moment elsewhere from which a claim about a turn was taken; None if it was made of that turn itself."""
        return self._origins.get((unhedged(claim), turn))

    # Operations on claims.

    def moment_of(self, claim: Claim[Any]) -> Moment[Any]:
        """The moment that a claim is about; of a displaced claim, the moment elsewhere."""
        own = self._moments[claim.turn] if isinstance(claim, Late) else self.moment
        return self._origin_of(claim) or own

    def _origin_of(self, claim: Claim[Any]) -> Moment[Any] | None:
        if not self._origins:
            return None
        return self.origin(_bare(claim), claim.turn if isinstance(claim, Late) else self.turn)

    def state_of(self, claim: Claim[Any]) -> Any:
        """The truth before the action that a claim is about."""
        moment = self.moment_of(claim)
        return moment.after if claim.kind in (FP, FN) or moment.before is None else moment.before

    def words(self, claim: Claim[Any]) -> float:
        """The mean number of words of a claim's paraphrases; of a late claim, without the words that say so."""
        return self._words(_bare(claim))

    def holds(self, claim: Claim[Any]) -> bool:
        """Whether a claim is true."""
        return _bare(claim).holds(self.moment_of(claim), self._oracle.lab)

    def distort(self, claim: Claim[Any], rng: np.random.Generator) -> Claim[Any] | None:
        """A plausible false claim about the same turn; None if there is none."""
        false = self._oracle.distort(_bare(claim), self.moment_of(claim), rng)
        return false and _like(claim, false)

    def falsehoods(self, claim: Claim[Any]) -> list[Claim[Any]]:
        """Every plausible false claim about the same turn."""
        return [_like(claim, false) for false in self._oracle.falsehoods(_bare(claim), self.moment_of(claim))]

    def flip(self, claim: Claim[Any], rng: np.random.Generator) -> Claim[Any]:
        """A false opposite of a verdict: praise for blame, or blame for praise.

        The claim is returned unchanged if no opposite is false, if it is a comparison, or if it is displaced.
        """
        false = [other for other in self.falsehoods(claim) if other.kind in HINDSIGHT - {claim.kind}]
        if false:
            return false[rng.integers(len(false))]
        if _bare(claim).relative or self._origin_of(claim):
            return claim
        moment = self.moment_of(claim)
        opposite = (Wrong if claim.kind is HP else Right).on(self._hindsight_on(moment), action=moment.action)
        return claim if opposite.holds(moment, self._oracle.lab) else _like(claim, opposite)

    def coarsen(self, claim: Claim[Any], level: int) -> Claim[Any]:
        """A less specific claim that advice or a warning implies. Level 0 is the vaguest, the last the claim itself.

        If the claim has no coarser ones, level 0 says that there is something to do or to avoid. Returned unchanged are
        claims from which nothing follows: false, hedged, placebo and displaced claims, and `relative` claims without
        coarser ones.
        """
        bare, moment = _bare(claim), self.moment_of(claim)
        if bare.placebo or isinstance(bare, HedgedClaim) or self._origin_of(claim):
            return claim
        rungs = bare.coarser(moment, self._oracle.lab) or (() if bare.relative else (self._dim(bare),))
        return _like(claim, rungs[level]) if level < len(rungs) and self.holds(claim) else claim

    def gives_away(self, claim: Claim[Any], hint: Claim[Any]) -> bool:
        """Whether a claim contradicts a hint about the same turn, or makes it the answer."""
        bare, dim = unhedged(_bare(claim)), _bare(hint)
        if self.moment_of(claim) is not self.moment_of(hint):
            return False
        only = isinstance(dim, Chance) and bare.kind is FN and isinstance(bare, ActionClaim) and self._actions() == 2
        return only or dim.excludes(bare) or bare.excludes(dim)

    def _actions(self) -> int | None:
        """The number of discrete actions; None if there are none."""
        space = self._oracle.lab.action_space
        return int(space.n) if isinstance(space, spaces.Discrete) else None

    def vague(self, claim: Claim[Any]) -> Claim[Any]:
        """A claim without its numbers and names.

        False, hedged, placebo, displaced and `relative` claims are returned unchanged.
        """
        bare, moment = _bare(claim), self.moment_of(claim)
        if self._origin_of(claim):
            return claim
        if bare.placebo or bare.relative or isinstance(bare, HedgedClaim) or not self.holds(claim):
            return claim
        if claim.kind is R:
            return _like(claim, Paid(sign=sign_of(moment.reward)))
        if claim.kind in (FP, FN):
            return _like(claim, self._dim(bare))
        return next((_like(claim, each) for each in self._verdicts(moment) if each.kind is claim.kind), claim)

    def verdict(self) -> Claim[Any] | None:
        """Right or wrong, without a reason; None if no hindsight on the last action is a verdict."""
        return next(iter(self._verdicts(self.moment)), None)

    def example(self, n: int) -> Example | None:
        """At most `n` next actions of an optimal policy, up to the first without a check; None if there are none."""
        lab, moment = self._oracle.lab, self.moment
        ground: list[Claim[Any] | None] = []
        actions: list[Any] = []
        solved = False
        for action in () if moment.over else self.plan(n):
            if solved and np.array_equal(action, actions[-1]):
                break
            now = Moment.opening(moment.after, moment.turn)
            advice = self._oracle.judge(now, {FP})
            advised = [c for c in advice if isinstance(c, ActionClaim) and np.array_equal(c.action, action)]
            moment = self._oracle.try_out(moment, action)
            solved = moment.success
            if not solved and not (advised and advised[0].holds(now, lab)):
                break
            actions.append(action)
            ground.append(None if solved else advised[0])
        return Example.on(tuple(ground), actions=tuple(actions)) if actions else None

    def as_said(self, action: Any) -> Any:
        """An action with its numbers as phrases state them; the action itself where that is outside of the space."""
        try:
            return self._oracle.lab.legal(rounded(action))
        except ValueError:
            return action

    def better(self, this: Any, that: Any) -> Better | None:
        """The claim that one action is better now than another.

        None if no hindsight gives their values, or, without values, if no plan from either solves the task.
        """
        this, that = map(self._oracle.lab.legal, (this, that))
        if self.values() is None:
            ways = tuple(self._oracle.way(self.moment.after, action, HORIZON) for action in (this, that))
            return Better.on(ways, this=this, that=that) if any(ways) else None
        tried = self._oracle.try_out(self.moment, this)._replace(over=True)
        found = self._oracle.judge(tried, HINDSIGHT)
        return Better.on(found[0], this=this, that=that) if found and self._tells(found[0], tried) else None

    def clearly(self, claim: Better) -> bool:
        """Whether another plan from the same state would hardly give the opposite comparison."""
        return claim.gain() >= self._oracle.least_gain

    def _tells(self, verdict: Claim[Any], moment: Moment[Any]) -> bool:
        """Whether a verdict gives the value of the moment's action, so that a comparison can be checked."""
        return verdict.worth(moment, self._oracle.lab, moment.action) is not None

    def better_turn(self, ago: int) -> BetterTurn | WorseTurn | None:
        """The claim that this turn was better or worse than the turn `ago` turns earlier.

        None if both lost as much, or if no hindsight gives their values.
        """
        both = self.moment, self._moments[-1 - ago]
        verdicts = [next(iter(self._hindsight_on(each)), None) for each in both]
        if not all(each and self._tells(each, moment) for each, moment in zip(verdicts, both, strict=True)):
            return None
        lost, earlier = map(self._oracle.regret, both)
        cls = BetterTurn if lost < earlier else WorseTurn
        return cls.on((both[1], *verdicts), ago=ago) if abs(lost - earlier) > _EQUAL else None

    def _dim(self, ground: Claim[Any]) -> Claim[Any]:
        return (Chance if ground.kind is FP else Trap).on(ground)

    def _verdicts(self, moment: Moment[Any]) -> list[Claim[Any]]:
        """The verdicts on the action of a moment, without reasons, the most important first."""
        said = tuple(claim for claim in self._hindsight_on(moment) if not claim.relative)
        kinds = {claim.kind for claim in said}
        classes = [Wrong] * (HN in kinds) + [PartlyRight if HN in kinds else Right] * (HP in kinds)
        return [verdict.on(said, action=moment.action) for verdict in classes]


def _bare(claim: Claim[Any]) -> Claim[Any]:
    return claim.claim if isinstance(claim, Late) else claim


def _like(claim: Claim[Any], other: Claim[Any]) -> Claim[Any]:
    """The other claim, about the same turn as the first: late if the first is late."""
    return Late(claim=other, turn=claim.turn) if isinstance(claim, Late) else other
