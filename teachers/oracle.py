"""The interface of oracles, which read a world's truth and state true claims about a turn."""

import copy
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence, Set
from functools import cached_property
from typing import Any, ClassVar, Generic, Self

import numpy as np

from teachers.atoms import FP, HN, HP, KINDS, Claim, FeedbackType, Moment, R, TruthT, WorldT, fast_constructor
from teachers.common import Reward

ALL_KINDS = frozenset(KINDS)
POSTERIOR, EXACT = "posterior", "exact posterior"
"""Abilities that a family adds: it has a posterior over what the student cannot know; exact: without rejections."""
ABILITIES = ("values", "importance", "plan", "regret", "hindsight", "advice", "hints", "clues", POSTERIOR, EXACT)
"""Abilities that an oracle may have and a personality may need; see `Oracle.abilities`."""

_reward = fast_constructor(Reward)
_KEPT = 32  # claims about rewards


class RefusalError(TypeError):
    """An oracle cannot compute what was requested."""


class Oracle(ABC, Generic[TruthT, WorldT]):
    """States what is true of one world.

    A subclass implements `_basics`, `_hindsight` and `_advice`; `_practice` and `_solution` if it gives such
    instructions; and as many of `values`, `importance`, `plan` and `regret` as it can compute. Its claims are true and
    worth saying.

    Args:
        scratch: makes a scratch world of the taught world's class and options.
    """

    instruction_types: ClassVar[tuple[str, ...]] = ("b", "p", "c")
    """The supported types of instructions."""
    feedback_types: ClassVar[tuple[FeedbackType, ...]] = KINDS
    """The supported kinds of feedback."""
    needs_truth: ClassVar[bool] = True
    """Whether the oracle or one of its claims reads truths."""
    max_importance: ClassVar[float] = 1.0
    """The upper bound of `importance`."""
    least_gain: ClassVar[int] = 1
    """The number of actions by which a way must be shorter than another to be called better; greater than 1 if plans
    are not the shortest and depend on what was planned before."""
    tier: ClassVar[str] = ""
    """The tier of the planner, such as `exact` (see `teachers.planning`); empty without a planner."""

    def __init__(self, scratch: Callable[[], WorldT]) -> None:
        self._scratch = scratch
        self._rewards: dict[float, Reward] = {}

    @cached_property
    def lab(self) -> WorldT:
        """A scratch world, made when it is first needed."""
        return self._scratch()

    def twin(self) -> Self:
        """Another oracle with the same settings and a lab of its own, for other episodes."""
        memo: dict[int, Any] = {id(self._scratch): self._scratch}
        if "lab" in vars(self):
            memo[id(self.lab)] = self._scratch()
        return copy.deepcopy(self, memo)

    @classmethod
    def abilities(cls) -> frozenset[str]:
        """The members of `ABILITIES` that it has.

        A class has the ability of each method that it overrides; `values` also gives importance, plan and regret. It
        has `hindsight` if hp and hn are among its feedback types, `advice` if fp is, and `hints` if some fp claims
        have coarser ones.
        """
        own = {
            name
            for name in ("values", "importance", "plan", "regret", "clues")
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
        """Begin an episode at the truth after the world's reset."""

    def brief(self, truth: TruthT, instruction_type: str, rng: np.random.Generator | None = None) -> tuple[Claim, ...]:
        """The parts of the instruction.

        Args:
            truth: the world's truth at the start.
            instruction_type: `b` has goal, actions and syntax; `p` adds hindsight on some actions that the oracle
                tries; `c` adds enough to infer an optimal policy.
            rng: draws the actions of `p`; nothing else is random.

        Raises:
            ValueError: `p` without a generator.
            TypeError: a hook did not return a tuple of claims.
        """
        parts = self._parts("_basics", self._basics(truth))
        if instruction_type == "p":
            if rng is None:
                raise ValueError("the instruction type 'p' draws actions to try; pass a generator as rng=...")
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
                reward = moment.reward + 0.0  # never -0.0
                claims.append(self._rewards.get(reward) or self._rewarded(reward))
            self._hindsight(claims, moment, kinds)
        if not moment.over:
            self._advice(claims, moment, kinds)
        return tuple(claims)

    def _rewarded(self, reward: float) -> Reward:
        """The claim about a reward, which is kept, since many worlds pay few different ones."""
        if len(self._rewards) >= _KEPT:
            self._rewards.clear()
        claim = self._rewards[reward] = _reward(reward)
        return claim

    @abstractmethod
    def _basics(self, truth: TruthT) -> tuple[Claim, ...]:
        """Goal, meaning of the actions, syntax of the answer."""

    def _practice(self, truth: TruthT, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Hindsight on some actions that the oracle tries."""
        raise RefusalError(f"{type(self).__name__} has 'p' in its instruction_types, but does not implement _practice")

    def _solution(self, truth: TruthT) -> tuple[Claim, ...]:
        """Enough to infer an optimal policy."""
        raise RefusalError(f"{type(self).__name__} has 'c' in its instruction_types, but does not implement _solution")

    @abstractmethod
    def _hindsight(self, claims: list[Claim], moment: Moment[TruthT], kinds: Set[FeedbackType]) -> None:
        """Append the wanted hp and hn claims about an executed action."""

    @abstractmethod
    def _advice(self, claims: list[Claim], moment: Moment[TruthT], kinds: Set[FeedbackType]) -> None:
        """Append the wanted fp and fn claims about the next action."""

    def clues(self, truth: TruthT) -> tuple[Claim, ...]:
        """True claims of kind fp or fn that help with the task and name no action, from little to much.

        Empty once the task is done. `judge` does not return them.
        """
        return ()

    def values(self, truth: TruthT) -> tuple[float, ...] | None:
        """Value per discrete action, greater is better; None where actions cannot be enumerated."""
        return None

    def stated_values(self, truth: TruthT) -> tuple[float, ...] | None:
        """The values as phrases state them: those of `values` without tie-breaking terms."""
        return self.values(truth)

    def importance(self, truth: TruthT) -> float:
        """What is at stake in the next action: the best value minus the worst, at most `max_importance`.

        0 if there are no values.
        """
        values = self.values(truth)
        return 0.0 if values is None else max(values) - min(values)

    def plan(self, truth: TruthT, n: int) -> tuple[Any, ...]:
        """At most `n` actions of an optimal policy from here on; empty if none is known.

        By default the action of the greatest value, if there are values and they differ.
        """
        values = self.values(truth)
        if n < 1 or values is None or max(values) == min(values):
            return ()
        return (values.index(max(values)),)

    def way(self, truth: TruthT, action: Any, horizon: int) -> tuple[Any, ...]:
        """The action, then `plan`'s, until the task is solved; empty if that takes more than `horizon` actions."""
        moment, way = Moment.opening(truth), [action]
        for _ in range(horizon):
            moment = self.try_out(moment, way[-1])
            if moment.success:
                return tuple(way)
            if not (plan := self.plan(moment.after, 1)):
                break
            way.append(plan[0])
        return ()

    def regret(self, moment: Moment[TruthT]) -> float:
        """Value lost by the executed action compared with the best one; if none was executed, see `idle`.

        Raises:
            RefusalError: the oracle has no values.
        """
        if moment.before is None:
            return self.idle(moment.after)
        values = self._known(moment.before)
        lost: float = max(values) - values[moment.action]
        return lost

    def idle(self, truth: TruthT) -> float:
        """Value lost by a turn without an action, because the student's text did not parse.

        By default the regret of the worst action; override it if such a turn has another value.

        Raises:
            RefusalError: the oracle has no values.
        """
        return max(values := self._known(truth)) - min(values)

    def _known(self, truth: TruthT) -> tuple[float, ...]:
        values = self.values(truth)
        if values is None:
            raise RefusalError(f"{type(self).__name__} gives no values; it must implement regret(moment)")
        return values

    def try_out(self, moment: Moment[TruthT], action: Any) -> Moment[TruthT]:
        """The moment after one more action, in the lab.

        Raises:
            ValueError: the action is outside the action space.
        """
        lab = self.lab
        lab.restore(moment.after)
        action = lab.legal(action)
        _, reward, _, _, info = lab.advance(action)
        return Moment(moment.after, action, reward, lab.truth, info["success"], moment.turn + 1, False)

    def texts_at_hand(self, claim: type[Claim], field: str, moment: Moment[TruthT]) -> Sequence[str]:
        """Texts that a claim of a class can have in a field, as far as the student can know them; empty: any text.

        They bound what a language model in the teacher's seat can say.
        """
        return ()

    def falsehoods(self, claim: Claim, moment: Moment[TruthT]) -> list[Claim]:
        """Every counterpart of a claim that is false, by its check."""
        return [c for c in claim.counterparts(moment, self.lab) if not c.holds(moment, self.lab)]

    def distort(self, claim: Claim, moment: Moment[TruthT], rng: np.random.Generator) -> Claim | None:
        """A random one of the `falsehoods` of a claim; None if there is none."""
        false = self.falsehoods(claim, moment)
        return false[rng.integers(len(false))] if false else None


def claims_of(module: str) -> tuple[type[Claim], ...]:
    """The claim classes that a module defines, in its order; bases of claims have names that begin with `_`.

    A package may define them in its module `claims`, after those of its `__init__`; or list them in `CLAIMS`.
    """
    if (listed := getattr(sys.modules[module], "CLAIMS", None)) is not None:
        return tuple(listed)
    inner = f"{module}.claims"
    return tuple(
        value
        for name in ((module, inner) if inner in sys.modules else (module,))
        for key, value in vars(sys.modules[name]).items()
        if isinstance(value, type) and issubclass(value, Claim) and value.__module__ == name and key[0] != "_"
    )
