"""A teacher's side of a lesson: which claims there are to say now, saying some of them, and what that costs."""

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeGuard

import numpy as np
from gymnasium import spaces

from teachers.atoms import (
    KINDS,
    SILENCE,
    ActionClaim,
    Atom,
    Claim,
    EditClaim,
    FeedbackType,
    Moment,
    PlanClaim,
    Utterance,
)
from teachers.common import Late
from teachers.teacher import Teacher
from worlds.spaces import Prose
from worlds.world import is_number

SUBSETS = 2 ** len(KINDS)
"""Number of subsets of the kinds: bit i of a subset's number is kind i in the order r, hp, hn, fp, fn."""
PROSE = 65_536
"""Greatest length of a teacher's words, and of a world's description."""
CLAIMS = 32
"""Greatest number of claims of a moment to choose from."""
CHOICES = {"kinds": SUBSETS, "claims": 1 + CLAIMS}
"""Number of actions of a teacher who chooses, by its speech."""
TRAITS = (*KINDS, "action", "plan", "edit")
"""What `TeacherSeat.table` tells of a claim: its kind, and its role."""
FEATURES = ("turn", "reward", "importance", "budget", "over")
"""What the numbers of `TeacherSeat.features` are."""
BIT = {kind: 1 << i for i, kind in enumerate(KINDS)}
"""Per kind the subset of it alone."""
SUBSET_BITS = np.array([[subset >> i & 1 for i in range(len(KINDS))] for subset in range(SUBSETS)], np.int8)
"""Per subset its members, 0 or 1 a kind, shape (32, 5)."""
LEGAL = np.array([[int(not said & ~true) for said in range(SUBSETS)] for true in range(SUBSETS)], np.int8)
"""Per subset of what is true the subsets that can be said, shape (32, 32); silence always can."""
ACTIONS = ("all", "compact")
"""Which subsets a teacher chooses from: all, or those that its feedback type and its oracle leave; see `choices_of`."""
_FLOAT = np.dtype(np.float32)
_BITS, _MASKS = list(SUBSET_BITS), list(LEGAL)  # rows, which a list finds faster


def is_count(value: Any, most: float = math.inf) -> TypeGuard[int]:
    """Whether a value is an integer, numpy's included, from 1 to `most`."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and 1 <= int(value) <= most


def choices_of(actions: str, teacher: Teacher, speech: str = "kinds") -> tuple[int, ...]:
    """The subsets that a teacher chooses from, by the number of its action.

    Raises:
        ValueError: there is no such choice, or the teacher does not say kinds.
    """
    if actions not in ACTIONS:
        raise ValueError(f"actions {actions!r} is unknown; allowed: {', '.join(ACTIONS)}")
    if actions == "all":
        return tuple(range(SUBSETS))
    if speech != "kinds":
        raise ValueError(f"actions='compact' needs speech='kinds', got {speech!r}; with it give actions='all'")
    able = sum(BIT[kind] for kind in teacher.kinds.intersection(teacher.oracle.feedback_types))
    return tuple(subset for subset in range(SUBSETS) if not subset & ~able)


def check_cost(name: str, value: Any) -> None:
    """Check what is charged for something.

    Raises:
        ValueError: it is not a finite number of at least 0.
    """
    if not is_number(value) or not 0 <= value < math.inf:
        raise ValueError(f"{name} must be a finite number of at least 0, got {value!r}")


class Purse:
    """What a teacher may still say in an episode, and what saying it costs.

    Args:
        cost: paid per atom of feedback, or per text without atoms, at least 0.
        budget: atoms of feedback that may be said; what exceeds it is not said. None: any number.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(self, cost: float = 0.01, budget: int | None = None) -> None:
        check_cost("cost", cost)
        if budget is not None and not is_count(budget):
            raise ValueError(f"budget must be None or an integer of at least 1, got {budget!r}")
        self.cost, self.budget, self.spent = cost, budget, 0

    @property
    def left(self) -> int:
        """Atoms that can still be said; with no budget, more than there can be in a turn."""
        return 1 + CLAIMS if self.budget is None else max(self.budget - self.spent, 0)

    @property
    def share(self) -> float:
        """Share of the budget that is left, 0 to 1; 1 without a budget."""
        return self.left / self.budget if self.budget else 1.0

    def pay(self, atoms: int) -> float:
        """Spend; the teacher's reward for that."""
        self.spent += atoms
        return -self.cost * atoms


class TeacherSeat:
    """One teacher in front of one student.

    Args:
        teacher: whose oracle sees the truth, and whose claims can be said.
        purse: what it may say; several seats can share one.
        max_turns: turns of the student in an episode.
        reward_range: least and greatest reward of one turn.
        asks: whether the student may ask for advice.
    """

    def __init__(
        self, teacher: Teacher, purse: Purse, max_turns: int, reward_range: tuple[float, float], asks: bool = False
    ) -> None:
        self.teacher, self.purse, self.max_turns, self.asks = teacher, purse, max_turns, asks
        self.low, self.high = reward_range
        self.moment: Moment[Any]
        self.asked = False
        self._claims: tuple[Claim[Any], ...] | None = None
        self._kinds = -1  # as a subset's number, once it has been asked for
        self.choosing: list[int] = []
        """Indices into `listed` that have been chosen in this turn."""
        self.trimmed = 0
        """The kinds that it was last to say and of which nothing could be said, as a subset's number."""

    def see(self, moment: Moment[Any], asked: bool = False) -> None:
        """Take note of what there is to speak of now; `asked`: that the student asks for advice on it."""
        self.moment, self.asked, self.choosing = moment, asked, []
        self._claims, self._kinds = None, -1

    def claims(self) -> tuple[Claim[Any], ...]:
        """The claims of this moment, notices included; asked for once a moment, and only if somebody wants to know."""
        if self._claims is None:
            moment, teacher = self.moment, self.teacher
            if self.asked:
                self._claims = teacher.answer(moment)
            else:
                said = teacher.judge(moment)
                told = moment.before is not None or not moment.turn
                self._claims = said if told else teacher.notice(moment) + said
        return self._claims

    def suggestion(self, brief: bool = False) -> Utterance:
        """What the teacher would say now: all that it has to say, in its words; `brief`: after the instruction."""
        teacher, moment = self.teacher, self.moment
        if brief:  # which comes first: with it the oracle starts
            return teacher.say(teacher.notice(moment) + self.claims(), moment.turn)
        return teacher.say(self.claims(), moment.turn)

    def speak(self, moment: Moment[Any]) -> Utterance:
        """Take note of a turn, and what the teacher would say of it: `see` and `suggestion` in one go."""
        self.moment, self.asked, self.choosing, self._kinds = moment, False, [], -1
        teacher = self.teacher
        said = teacher.judge(moment)
        self._claims = said = said if moment.before is not None else teacher.notice(moment) + said
        return teacher.say(said, moment.turn)

    def info(self, speech: str, brief: bool = False) -> dict[str, Any]:
        """Told beside the observation: the moment, and what could be said, `brief` as in `suggestion`."""
        told: dict[str, Any]
        if speech == "kinds":
            told = {"moment": self.moment, "trimmed": self.trimmed}
        elif speech == "message":
            told = {"moment": self.moment, "suggestion": self.suggestion(brief)}
        else:
            told = {"moment": self.moment, "claims": tuple(self.listed()), "sentences": self.sentences()}
        if self.asked:
            told["asked"] = True
        return told

    def available(self) -> int:
        """The kinds that can be said now, as a subset's number."""
        if self._kinds < 0:
            self._kinds = kinds_of(self.claims())
        return self._kinds if self.purse.budget is None or self.purse.left else 0

    def features(self) -> tuple[float, float, float, float, float]:
        """Turn / max_turns, the last reward, importance of the next action, share of the budget left, 1 if over."""
        _, _, reward, after, _, turn, over, _ = self.moment
        oracle, purse = self.teacher.oracle, self.purse
        importance, most = oracle.importance(after), oracle.max_importance
        if not self.low <= reward <= self.high:
            reward = self.low if reward < self.low else self.high
        return (
            turn / self.max_turns,
            reward,
            importance if importance <= most else most,
            1.0 if purse.budget is None else purse.share,
            over,
        )

    def feature_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest values of the features, float32 arrays of shape (5,)."""
        low, high = (0, self.low, 0, 0, 0), (1, self.high, self.teacher.oracle.max_importance, 1, 1)
        return np.array(low, np.float32), np.array(high, np.float32)

    def view_space(self, speech: str, **more: spaces.Space[Any]) -> spaces.Dict:
        """The space of `observe`, with more entries."""
        asked = {"asked": spaces.MultiBinary(1)} if self.asks else {}
        listed = {"claims": spaces.Box(0, 1, (CLAIMS, len(TRAITS)), np.int8)} if speech == "claims" else {}
        return spaces.Dict(
            {
                "available": spaces.MultiBinary(len(KINDS)),
                "features": spaces.Box(*self.feature_bounds()),
                **asked,
                **listed,
                **more,
                "action_mask": mask_space(CHOICES[speech]),
            }
        )

    def observe(self, speech: str, acts: bool) -> dict[str, Any]:
        """What a teacher who chooses sees.

        Args:
            speech: `kinds` or `claims`.
            acts: whether it is its turn, else only silence is legal.
        """
        available = self.available()
        observation: dict[str, Any] = {
            "available": _BITS[available].copy(),
            "features": np.fromiter(self.features(), _FLOAT, 5),
        }
        if self.asks:
            observation["asked"] = np.array([self.asked], np.int8)
        if speech == "kinds":
            observation["action_mask"] = _MASKS[available if acts else 0].copy()
        else:
            observation["claims"] = self.table()
            observation["action_mask"] = self.choices() if acts else _silence()
        return observation

    # To say kinds.

    def say(self, subset: Any) -> Utterance:
        """The claims of some kinds in words, as many as the budget allows; notices are always said.

        Raises:
            ValueError: it is no subset's number.
        """
        # Gymnasium's own check takes twenty times as long: it is asked about unusual types only.
        if type(subset) is not int or not 0 <= subset < SUBSETS:
            if not _DISCRETE.contains(subset):
                raise ValueError(f"the teacher's action must be an integer from 0 to {SUBSETS - 1}, got {subset!r}")
            subset = int(subset)
        said, available = self.claims(), self._kinds
        if available < 0 or self.purse.budget is not None:
            available = self.available()
        self.trimmed = subset & ~available
        if available & ~subset:  # or it says all that there is, as it mostly does
            said = tuple([claim for claim in said if claim.kind is None or subset & BIT[claim.kind]])
        if self.purse.budget is not None:
            said = tuple(within(self.purse.left, said, _kind))
            self.trimmed = subset & ~kinds_of(said)
        return self.teacher.say(said, self.moment.turn)

    # To say one claim after the other.

    def listed(self) -> list[Claim[Any]]:
        """The claims to choose from, at most `CLAIMS`: those of the moment that are feedback, in speaking order."""
        return [claim for claim in self.claims() if claim.kind is not None][:CLAIMS]

    def sentences(self) -> tuple[str, ...]:
        """How each of those would sound, in one of its wordings; another may be drawn when it is said.

        Nothing is drawn for it, and no voice that rewrites is asked.
        """
        return self.teacher.voice.first(self.listed(), self.teacher.paraphrase)

    def table(self) -> np.ndarray:
        """What is to be known of each claim that can be chosen, 0 or 1, int8 (32, 8); see `TRAITS`."""
        table = np.zeros((CLAIMS, len(TRAITS)), np.int8)
        for i, claim in enumerate(self.listed()):
            bare = claim.claim if isinstance(claim, Late) else claim
            table[i] = (
                *(claim.kind is kind for kind in KINDS),
                isinstance(bare, ActionClaim),
                isinstance(bare, PlanClaim),
                isinstance(bare, EditClaim),
            )
        return table

    def choices(self) -> np.ndarray:
        """Which choices are legal, int8 (33,): 0 ends the turn, i says claim i - 1 of `listed`."""
        mask = _silence()
        if self.purse.left:
            mask[1 : 1 + len(self.listed())] = 1
            mask[[1 + i for i in self.choosing]] = 0
        return mask

    def choose(self, choice: Any) -> bool:
        """Choose one more claim, or none; whether the turn is over, since nothing else can be said.

        A choice that is not legal says nothing and ends the turn.

        Raises:
            ValueError: it is no choice.
        """
        if not (type(choice) is int and 0 <= choice <= CLAIMS) and not _CHOICE.contains(choice):
            raise ValueError(f"the teacher's action must be an integer from 0 to {CLAIMS}, got {choice!r}")
        if not choice or not self.choices()[choice]:
            return True
        self.choosing.append(int(choice) - 1)
        return self.purse.left <= 1 or len(self.choosing) == len(self.listed())

    def chosen(self) -> Utterance:
        """What has been chosen in words, in speaking order; notices are always said."""
        listed = self.listed()
        kept = {id(listed[i]) for i in self.choosing}
        said = [claim for claim in self.claims() if claim.kind is None or id(claim) in kept]
        return self.teacher.say(tuple(said), self.moment.turn)

    # To say one's own words.

    def allow(self, said: Any) -> str:
        """A message, as much of it as the feedback type and the budget allow.

        Text without atoms is of no kind: it passes unless no feedback is wanted at all.

        Raises:
            ValueError: it is no text, or too long.
        """
        if not isinstance(said, str) or len(said) > PROSE:
            raise ValueError(f"the teacher must say a string of at most {PROSE} characters, got {said!r:.80}")
        wanted, purse = self.teacher.kinds, self.purse
        if type(said) is not Utterance or not said.atoms:
            return said if (wanted or not self.moment.turn) and purse.left else SILENCE
        if len(wanted) < len(KINDS) and any(atom.kind not in wanted for atom in said.atoms if atom.kind is not None):
            said = Utterance.of([atom for atom in said.atoms if atom.kind is None or atom.kind in wanted])
        return said if purse.budget is None else Utterance.of(within(purse.left, said.atoms, _kind))

    def feedback(self, said: Any) -> str:
        """A message to a student who has the instruction already: what is no feedback at the opening is left out."""
        if type(said) is Utterance and not self.moment.turn:
            said = Utterance.of([atom for atom in said.atoms if atom.kind is not None])
        return self.allow(said)


_DISCRETE, _CHOICE = spaces.Discrete(SUBSETS), spaces.Discrete(1 + CLAIMS)


def _silence() -> np.ndarray:
    mask = np.zeros(1 + CLAIMS, np.int8)
    mask[0] = 1
    return mask


def kinds_of(claims: Sequence[Claim[Any]]) -> int:
    """The kinds of claims, as a subset's number."""
    kinds = 0
    for claim in claims:
        kind = claim.kind
        if kind is not None:
            kinds |= BIT[kind]
    return kinds


def mask_space(actions: int) -> spaces.Box:
    """The space of a mask of so many actions."""
    return spaces.Box(0, 1, (actions,), np.int8)


def message_space() -> Prose:
    """The space of what a teacher says in its own words."""
    return Prose(PROSE)


def price(said: str) -> int:
    """Atoms of feedback in what is said; 1 for a text without atoms, 0 for silence."""
    atoms = said.atoms if type(said) is Utterance else ()
    return sum(atom.kind is not None for atom in atoms) if atoms else int(said != "")


def within(left: int, items: Sequence[Any], kind: Callable[[Any], FeedbackType | None]) -> list[Any]:
    """The first `left` items that are feedback, and all that are not."""
    kept = []
    for item in items:
        if kind(item) is None or left > 0:
            kept.append(item)
            left -= kind(item) is not None
    return kept


def _kind(item: Claim[Any] | Atom) -> FeedbackType | None:
    return item.kind
