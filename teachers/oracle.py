"""The interface of every oracle: it sees a world's truth and states what is true of a turn."""

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Set
from functools import cached_property
from typing import Any, ClassVar, Generic

import numpy as np

from teachers.atoms import FP, HN, HP, KINDS, Claim, FeedbackType, Moment, R, TruthT, WorldT, fast_constructor
from teachers.common import Reward

ALL_KINDS = frozenset(KINDS)
ABILITIES = ("values", "importance", "plan", "regret", "hindsight", "advice", "hints")
"""What an oracle may be able to do, and a personality may need; see `Oracle.abilities`."""

_reward = fast_constructor(Reward)


class RefusalError(TypeError):
    """What an oracle raises that is asked for something that it does not know."""


class Oracle(ABC, Generic[TruthT, WorldT]):
    """Knows everything about one world and lies about nothing.

    An oracle implements `_basics`, `_hindsight` and `_advice`, `_practice` and `_solution` if it gives such
    instructions, and what it can of `values`, `importance`, `plan` and `regret`. Each states the claims that are true
    and worth saying, none if there are none.

    Args:
        scratch: makes a scratch world of the taught world's class and options.
    """

    instruction_types: ClassVar[tuple[str, ...]] = ("b", "p", "c")
    """The instructions that it can give."""
    feedback_types: ClassVar[tuple[FeedbackType, ...]] = KINDS
    """The kinds of feedback that it can give."""
    looks: ClassVar[bool] = True
    """Whether it, or one of its claims, ever looks at a truth."""
    max_importance: ClassVar[float] = 1.0
    """Greatest value that `importance` can have."""

    def __init__(self, scratch: Callable[[], WorldT]) -> None:
        self._scratch = scratch

    @cached_property
    def lab(self) -> WorldT:
        """A scratch world, made when it is first needed."""
        return self._scratch()

    @classmethod
    def abilities(cls) -> frozenset[str]:
        """What it can do, of `ABILITIES`.

        A method counts if the class brings its own, and those that follow from `values` count with these. `hindsight`
        is to state hp and hn, `advice` to state fp, and `hints` to have fp claims with coarser ones.
        """
        own = {
            name
            for name in ("values", "importance", "plan", "regret")
            if getattr(cls, name) is not getattr(Oracle, name)
        }
        if "values" in own:
            own |= {"importance", "plan", "regret"}
        kinds = set(cls.feedback_types)
        own |= {name for name, wanted in (("hindsight", {HP, HN}), ("advice", {FP})) if wanted <= kinds}
        if any(claim.kind is FP and claim.coarser is not Claim.coarser for claim in cls.claims()):
            own.add("hints")
        return frozenset(own)

    @classmethod
    def claims(cls) -> tuple[type[Claim], ...]:
        """The classes of claims that this oracle's module defines; see `claims_of`."""
        return claims_of(cls.__module__)

    def start(self, truth: TruthT) -> None:
        """Begin an episode: look at the world as reset left it."""

    def brief(self, truth: TruthT, instruction_type: str, rng: np.random.Generator | None = None) -> tuple[Claim, ...]:
        """The parts of the instruction.

        Args:
            truth: the world's truth at the start.
            instruction_type: `b` goal, actions, syntax; `p` adds how some actions went that the oracle
                tried out; `c` adds enough to infer an optimal policy.
            rng: from which `p` draws what is tried out. All else that an oracle says is determined by the truth.

        Raises:
            ValueError: `p` without a generator.
            TypeError: a hook has returned something else than a tuple of claims.
        """
        parts = self._parts("_basics", self._basics(truth))
        if instruction_type == "p":
            if rng is None:
                raise ValueError("the instruction `p` draws what is tried out; it needs a generator, rng=...")
            return parts + self._parts("_practice", self._practice(truth, rng))
        return parts + self._parts("_solution", self._solution(truth)) if instruction_type == "c" else parts

    def _parts(self, hook: str, parts: Any) -> tuple[Claim, ...]:
        if not isinstance(parts, tuple) or not all(isinstance(part, Claim) for part in parts):
            raise TypeError(f"{type(self).__name__}.{hook} must return a tuple of claims, got {parts!r}")
        return parts

    def judge(self, moment: Moment[TruthT], kinds: Set[FeedbackType] = ALL_KINDS) -> tuple[Claim, ...]:
        """The true claims of the wanted kinds about a moment, in speaking order."""
        claims: list[Claim] = []
        if moment.before is not None:
            if R in kinds:
                claims.append(_reward(moment.reward + 0.0))  # never -0.0
            self._hindsight(claims, moment, kinds)
        if not moment.over:
            self._advice(claims, moment, kinds)
        return tuple(claims)

    @abstractmethod
    def _basics(self, truth: TruthT) -> tuple[Claim, ...]:
        """Goal, meaning of the actions, syntax of the answer."""

    def _practice(self, truth: TruthT, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Hindsight on some actions that were tried out."""
        raise RefusalError(f"{type(self).__name__} has `p` among its instruction_types, but no _practice")

    def _solution(self, truth: TruthT) -> tuple[Claim, ...]:
        """Enough to infer an optimal policy."""
        raise RefusalError(f"{type(self).__name__} has `c` among its instruction_types, but no _solution")

    @abstractmethod
    def _hindsight(self, claims: list[Claim], moment: Moment[TruthT], kinds: Set[FeedbackType]) -> None:
        """Append the wanted hp and hn claims about an executed action."""

    @abstractmethod
    def _advice(self, claims: list[Claim], moment: Moment[TruthT], kinds: Set[FeedbackType]) -> None:
        """Append the wanted fp and fn claims about the next action."""

    def values(self, truth: TruthT) -> tuple[float, ...] | None:
        """Value per discrete action, greater is better; None where actions cannot be enumerated."""
        return None

    def importance(self, truth: TruthT) -> float:
        """How much is at stake in the next action: the best value less the worst, at most `max_importance`.

        Without values it is not known, and 0.
        """
        values = self.values(truth)
        return 0.0 if values is None else max(values) - min(values)

    def plan(self, truth: TruthT, n: int) -> tuple[Any, ...]:
        """At most `n` actions of an optimal policy from here on; none where nothing is known.

        As it stands the action of the greatest value, if there are values and they differ.
        """
        values = self.values(truth)
        if n < 1 or values is None or max(values) == min(values):
            return ()
        return (values.index(max(values)),)

    def regret(self, moment: Moment[TruthT]) -> float:
        """Value lost by the executed action against the best one, or, if none was executed, by the turn; see `idle`.

        Raises:
            RefusalError: the oracle does not know.
        """
        if moment.before is None:
            return self.idle(moment.after)
        values = self._known(moment.before)
        lost: float = max(values) - values[moment.action]
        return lost

    def idle(self, truth: TruthT) -> float:
        """Value lost by a turn in which nothing moved, for the text that was given was no action.

        As it stands what the worst action loses; who knows better what a turn is worth says it here.

        Raises:
            RefusalError: the oracle does not know.
        """
        return max(values := self._known(truth)) - min(values)

    def _known(self, truth: TruthT) -> tuple[float, ...]:
        values = self.values(truth)
        if values is None:
            raise RefusalError(f"{type(self).__name__} gives no values; it must implement regret(moment)")
        return values

    def falsehoods(self, claim: Claim, moment: Moment[TruthT]) -> list[Claim]:
        """Every plausible claim in place of `claim` that is false, checked to be so."""
        return [c for c in claim.counterparts(moment, self.lab) if not c.holds(moment, self.lab)]

    def distort(self, claim: Claim, moment: Moment[TruthT], rng: np.random.Generator) -> Claim | None:
        """A false claim in place of `claim`, checked to be false; None if there is no plausible one."""
        false = self.falsehoods(claim, moment)
        return false[rng.integers(len(false))] if false else None


def claims_of(module: str) -> tuple[type[Claim], ...]:
    """The claim classes that a module defines, in its order; bases of claims have names that begin with `_`.

    A package may have them in a module `claims` of its own: these come after those that it defines itself.
    """
    inner = f"{module}.claims"
    return tuple(
        value
        for name in ((module, inner) if inner in sys.modules else (module,))
        for key, value in vars(sys.modules[name]).items()
        if isinstance(value, type) and issubclass(value, Claim) and value.__module__ == name and key[0] != "_"
    )
