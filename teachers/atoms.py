"""What a teacher says (claims, atoms, utterances), and the moments that it speaks about."""

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, make_dataclass, replace
from enum import Enum, StrEnum
from functools import cache, wraps
from inspect import get_annotations
from itertools import combinations
from typing import Any, ClassVar, Generic, NamedTuple, Self, dataclass_transform, get_origin

from typing_extensions import TypeVar

from worlds.world import World

TruthT = TypeVar("TruthT", default=Any)
"""The type of a world's truth; `Any` by default."""
WorldT = TypeVar("WorldT", bound=World[Any], default=Any)
"""The class of a world; `World[Any]` by default."""


_WORDS = {"r": "reward", "hp": "praise", "hn": "blame", "fp": "advice", "fn": "warning"}


class FeedbackType(StrEnum):
    """The five kinds of feedback of the LLF paper, in speaking order.

    A kind is its code as a string; it equals its word, too, and both name it: `FeedbackType("praise")` is `HP`. Its
    hash is that of the code, so that a set or a dictionary of strings finds it by the code alone.
    """

    R = "r"
    """How well it went: the reward."""
    HP = "hp"
    """Hindsight positive: what was good about the last action."""
    HN = "hn"
    """Hindsight negative: what was bad about it."""
    FP = "fp"
    """Future positive: what to do next."""
    FN = "fn"
    """Future negative: what to avoid next."""

    @property
    def word(self) -> str:
        """The kind in a word, as reports and pages say it."""
        return _WORDS[self]

    @classmethod
    def _missing_(cls, value: object) -> "FeedbackType | None":
        return next((kind for kind in cls if kind.word == value), None)

    def __eq__(self, other: object) -> bool:
        return self is other or str.__eq__(self, other) is True or (type(other) is str and other == self.word)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = str.__hash__


KINDS = tuple(FeedbackType)
R, HP, HN, FP, FN = KINDS


class Scope(StrEnum):
    """How far a claim reaches."""

    ACTION = "action"
    """It is about one action."""
    STATE = "state"
    """It holds of a moment."""
    WORLD = "world"
    """It stays true for the whole episode."""
    FAMILY = "family"
    """It is true in every world of a town: of all worlds that share a law."""

    @property
    def lasts(self) -> bool:
        """Whether what is true once stays true for the whole episode."""
        return self in (Scope.WORLD, Scope.FAMILY)


class Label(StrEnum):
    """The result of checking a claim in the simulator. Students never see it."""

    TRUTHFUL = "truthful"
    """The claim holds."""
    DISTORTED = "distorted"
    """The claim does not hold."""
    PLACEBO = "placebo"
    """The claim holds, and has nothing to do with the task."""
    LATE = "late"
    """The claim holds of an earlier turn."""
    HEDGED = "hedged"
    """The claim has a probability: a single hedge is neither true nor false; see `HedgedClaim`."""
    UNCHECKED = "unchecked"
    """Text without a claim."""


class ParseFailure(NamedTuple):
    """A student's text that did not parse as an action. The world did not step; the turn counts."""

    got: str
    """The start of the text, at most 80 printable characters."""
    expected: str
    """The form of an answer."""
    why: str = "it names no action that there is"
    """What was wrong, as a clause."""


class Moment(NamedTuple, Generic[TruthT]):
    """One turn of a student, privileged truths included."""

    before: TruthT | None
    """The world's truth before the action; None if no action was executed (the opening, or a `ParseFailure`)."""
    action: Any
    """The action in canonical form; None at the opening; a `ParseFailure` for text that is no action."""
    reward: float
    """The world's reward for the action; 0 if none was executed."""
    after: TruthT
    """The world's truth now."""
    success: bool
    """Whether the world says that the task is solved."""
    turn: int
    """Number of turns so far; 0 at the opening."""
    over: bool
    """Whether the episode has ended, so that advice can no longer be followed."""
    ask_cost: float | None = None
    """At the opening, the price of a question to the teacher; None if the student cannot ask."""

    @classmethod
    def opening(cls, truth: TruthT, turn: int = 0) -> Self:
        """The moment before the first action; with `turn`, a later one as if the episode began there."""
        return cls(None, None, 0.0, truth, False, turn, False)

    @classmethod
    def unread(cls, now: TruthT, failure: ParseFailure, reward: float, success: bool, turn: int, over: bool) -> Self:
        """The moment after a text that is no action: only the number of turns has changed."""
        return cls(None, failure, reward, now, success, turn, over)

    @property
    def past(self) -> TruthT:
        """The world's truth before the action.

        Raises:
            ValueError: no action was executed.
        """
        if self.before is None:
            raise ValueError(f"no action was executed in turn {self.turn}; use `past` only where `before` is not None")
        return self.before


ClaimT = TypeVar("ClaimT", bound="Claim")


@dataclass_transform(frozen_default=True, kw_only_default=True)
def claim(cls: type[ClaimT]) -> type[ClaimT]:
    """Class decorator of every claim: a frozen, slotted dataclass with keyword-only fields.

    Raises:
        TypeError: a base with fields lacks the decorator, or `kind` is no kind.
    """
    if isinstance(cls.kind, str) and not isinstance(cls.kind, FeedbackType):
        allowed = ", ".join(kind.name for kind in KINDS)
        raise TypeError(f"{path_of(cls)}.kind is {cls.kind!r}; allowed: {allowed} of teachers.atoms, and None")
    made = dataclass(frozen=True, slots=True, kw_only=True)(cls)
    if "scope" not in vars(cls) and made.scope is Scope.STATE and cls.__name__[0] != "_":
        made.scope = _SCOPES.get(made.kind, Scope.STATE)
    known = {each.name for each in fields(made)}  # type: ignore[arg-type]  # a dataclass
    for base in (each for each in cls.__mro__[1:] if issubclass(each, Claim) and each.__module__ != __name__):
        own = {name for name, kind in get_annotations(base).items() if "ClassVar" not in str(kind)}
        if not is_decorated(base) and own - known:
            raise TypeError(f"the base {path_of(base)} of {cls.__name__} {UNDECORATED}")
    return made


_SCOPES: dict[Any, Scope] = {None: Scope.WORLD, **dict.fromkeys((R, HP, HN), Scope.ACTION)}
UNDECORATED = "lacks the decorator @claim; write @claim before the class, and import it from teachers.atoms"


def is_decorated(cls: type["Claim"]) -> bool:
    """Whether the class itself has the decorator `claim`."""
    return "__dataclass_fields__" in vars(cls)


def path_of(cls: type) -> str:
    """The module and the name of a class."""
    return f"{cls.__module__}.{cls.__qualname__}"


def fast_constructor(cls: type[ClaimT]) -> Callable[..., ClaimT]:
    """Return a function that makes the claims of a class from the values of all fields, in the order of the fields.

    It takes a third of the time of the class itself, which sets each field by a call and collects its keywords in a
    dictionary: this function sets the fields of an instance of a writable subclass, then turns it into one of `cls`.
    It does not refuse NumPy's numbers; the conformance kit does. It serves oracles that make several claims in each
    turn: without it a turn of optimization or movies takes up to 15 % longer, of other families 2 to 4 %.

    Raises:
        TypeError: the class lacks the decorator `claim`.
    """
    if not is_decorated(cls):
        raise TypeError(f"{path_of(cls)} {UNDECORATED}")
    names = [field.name for field in fields(cls)]  # type: ignore[arg-type]  # a dataclass
    members = {"__slots__": (), "__setattr__": object.__setattr__, "__delattr__": object.__delattr__}
    writable: Any = type(cls.__name__, (cls,), members)
    writable.__init__ = make_dataclass(cls.__name__, names).__init__  # type: ignore[misc]  # of a class

    def make(*values: Any) -> ClaimT:
        claim: ClaimT = writable(*values)
        claim.__class__ = cls
        return claim

    return make


class Claim(Generic[TruthT, WorldT]):
    """One thing that a teacher can say, as data, about a world of class `WorldT` with truths of `TruthT`.

    The docstring of a class says when its claims are true. Fields are JSON scalars, enums and tuples of them; what
    phrases need beside these (plurals, lists, names) are properties, computed from the fields. The role of a class,
    `ActionClaim`, `PlanClaim` or `EditClaim`, declares what readers of any family can do with its claims.
    """

    __slots__ = ()
    kind: ClassVar[FeedbackType | None] = None
    """The kind of feedback; None for the parts of an instruction and for notices of the environment."""
    placebo: ClassVar[bool] = False
    """Whether it has nothing to do with the task; it may be true."""
    scope: ClassVar[Scope] = Scope.STATE
    """How far it reaches. By default the scope of the base; if that is `STATE`, parts of an instruction reach the
    world, and rewards and hindsight the action."""
    relative: ClassVar[bool] = False
    """Whether it only compares with a policy, or says what a policy would do. No verdict may rest on it."""
    tried: ClassVar[bool] = False
    """Whether it is about an action that the oracle tried before the episode, not about the student's."""

    def __init_subclass__(cls, **more: Any) -> None:
        """Let the checks of a class give False for claims that name what does not exist."""
        super().__init_subclass__(**more)
        for name in {"holds", "means"} & vars(cls).keys():
            if not hasattr(check := vars(cls)[name], "__wrapped__"):
                setattr(cls, name, _checked(check))

    def __post_init__(self) -> None:
        """Refuse NumPy's numbers and arrays, which JSON writes differently, and subclasses, which may say anything.

        Raises:
            TypeError: a field holds one.
        """
        for name in self.__dataclass_fields__:  # type: ignore[attr-defined]  # a dataclass
            kind = type(value := getattr(self, name))
            if kind in _PLAIN or (kind is tuple and not _has_odd(value)):
                continue
            if kind is tuple or _is_odd(kind):  # type: ignore[arg-type]  # classes are hashable
                raise TypeError(
                    f"the field {name!r} of the claim {type(self).__name__} holds {value!r}; "
                    "allowed: str, int, float, bool, None, enumerations and tuples of Python's own, no subclasses of "
                    "them; convert it, as in x.item() or tuple(x.tolist())"
                )

    def holds(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Whether the claim is true of `moment`; `lab` is a scratch world to restore and step.

        The check does not use the oracle's method. A LookupError, ValueError or ArithmeticError in it counts as False:
        the claim names an action, a place or a number that this world does not have.
        """
        raise TypeError(f"{type(self).__name__} does not implement holds(moment, lab)")

    def means(self, moment: Moment[TruthT], oracle: Any) -> bool:
        """Whether the claim is true of a moment by its fields alone, with numbers as phrases round them.

        Errors count as for `holds`.

        Args:
            moment: any moment, not only the one for which the claim was made.
            oracle: an oracle of the same family. For a `Grounded` claim it must have started on the moment's episode.
        """
        return self.holds(moment, oracle.lab)

    def within(self, moments: Callable[[int], Moment[TruthT]], about: int) -> "Claim":
        """The claim as `means` judges it in an episode that has these moments.

        Only claims that compare the turn `about` with an earlier turn change: they take the earlier turn from there.

        Args:
            moments: the moment of each turn of the episode.
            about: the turn that the claim is about.
        """
        return self

    def counterparts(self, moment: Moment[TruthT], lab: WorldT) -> Sequence["Claim"]:
        """Plausible claims that may be false where this one is true, for teachers that err."""
        return ()

    @staticmethod
    def varied(field: str, values: Iterable[Any] | Callable[..., Iterable[Any]]) -> Callable[..., Sequence["Claim"]]:
        """A method `counterparts` that gives the same claim with each other value of a field.

        Args:
            field: the name of the field.
            values: the allowed values, or a function of claim, moment and lab that returns them.
        """

        def counterparts(self: Any, moment: Moment[Any], lab: Any) -> Sequence[Claim]:
            own, found = getattr(self, field), values(self, moment, lab) if callable(values) else values
            return tuple(replace(self, **{field: value}) for value in found if value != own)

        return counterparts

    def coarser(self, moment: Moment[TruthT], lab: WorldT) -> Sequence["Claim"]:
        """Less specific claims of the same kind that this one implies, the vaguest first, for teachers that hint."""
        return ()

    def excludes(self, other: "Claim") -> bool:
        """Whether this claim and another about the same moment cannot both be meant; see `contradictions`."""
        return False

    def worth(self, moment: Moment[TruthT], lab: WorldT, action: Any) -> float | None:
        """For verdicts: the value of taking `action` in place of the moment's action.

        The method differs from that of `Oracle.values`. None if the verdict cannot tell; then nobody checks claims
        that compare values, such as `common.NoDifference`.
        """
        return None

    def stated_worth(self, moment: Moment[TruthT], lab: WorldT, action: Any) -> float | None:
        """`worth` as phrases state it; the method differs from that of `Oracle.stated_values`."""
        return self.worth(moment, lab, action)


def _checked(method: Callable[..., bool]) -> Callable[..., bool]:
    """A check that gives False where a claim names what does not exist, or lacks its ground."""

    @wraps(method)
    def check(self: Any, moment: Any, lab: Any) -> bool:
        try:
            return method(self, moment, lab)
        except (LookupError, ValueError, ArithmeticError):
            return False
        except AttributeError:
            if getattr(self, "grounded", True):
                raise
            return False  # it was read from text, and is judged by what it means

    return check


_PLAIN = frozenset((bool, int, float, str, type(None), FeedbackType))  # a kind equals its word, which says the same


def _has_odd(values: tuple[Any, ...]) -> bool:
    for each in values:  # three times as fast as `any` for the long plans of parking
        kind = type(each)
        if _has_odd(each) if kind is tuple else kind not in _PLAIN and _is_odd(kind):  # type: ignore[arg-type]
            return True
    return False


@cache
def _is_odd(kind: type) -> bool:
    """Whether values of a class, which is none of `_PLAIN`, may equal what they do not say."""
    if issubclass(kind, Enum):
        bases = [base for base in kind.__mro__[:-1] if base not in _SCALARS and base.__module__ != "enum"]
        return any("__eq__" in vars(base) for base in bases)
    return kind.__module__ == "numpy" or issubclass(kind, _SCALARS)


_SCALARS = (bool, int, float, str, tuple)


class ActionClaim(Claim[TruthT, WorldT]):
    """Role of a claim about one action.

    It is advice (fp), a warning (fn), a verdict (hp, hn), or, in an instruction, an action that is right in every turn.
    """

    __slots__ = ()
    scope = Scope.ACTION
    action: Any
    """The action in the form that `World.step` takes, canonical."""
    action_slot: ClassVar[str] = "action"
    """The slot of the phrases that holds the action as a student would write it; empty if there is none."""

    def excludes(self, other: Claim) -> bool:
        """For advice: a warning of the same action."""
        return self.kind is FP and _warns_of(self.action, other)


class PlanClaim(Claim[TruthT, WorldT]):
    """Role of a claim that states actions to take in order, from now on or, in an instruction, from the start."""

    __slots__ = ()
    scope = Scope.ACTION
    actions: tuple[Any, ...]
    """The actions in the form that `World.step` takes, canonical; at least one."""
    plan_slot: ClassVar[str] = "listing"
    """The slot of the phrases that holds the actions as a student would write them; empty if there is none."""
    separator: ClassVar[str] = ", "
    """The text between two actions in that slot."""

    def excludes(self, other: Claim) -> bool:
        """For advice: a warning of the first action."""
        return self.kind is FP and self.actions != () and _warns_of(self.actions[0], other)


def _warns_of(action: Any, claim: Claim) -> bool:
    return claim.kind is FN and isinstance(claim, ActionClaim) and bool(claim.action == action)


class HintClaim(Claim[TruthT, WorldT]):
    """Role of advice that leaves several actions open, one of which is right."""

    __slots__ = ()

    @abstractmethod
    def leaves(self, action: Any) -> bool:
        """Whether it leaves this action open."""

    def excludes(self, other: Claim) -> bool:
        """A warning of an action that it leaves open: with the warning it could be the answer."""
        return other.kind is FN and isinstance(other, ActionClaim) and self.leaves(other.action)


class HedgedClaim(Claim[TruthT, WorldT]):
    """Role of a claim that says how probable another claim is.

    It `holds` if that claim does, but a single hedge is neither true nor false. Calibration judges many: of claims
    hedged with probability p, a share p should hold.
    """

    __slots__ = ()
    claim: Claim[TruthT, WorldT]
    """The hedged claim; neither late nor hedged itself."""
    p: float
    """Its probability, above 0.5 and below 1."""


def unhedged(claim: Claim) -> Claim:
    """The claim inside a hedge; any other claim as it is."""
    return claim.claim if isinstance(claim, HedgedClaim) else claim


def confidence(claim: Claim) -> float:
    """The probability of a hedged claim; 1 for any other."""
    return claim.p if isinstance(claim, HedgedClaim) else 1.0


def action_of(claim: Claim) -> Any:
    """The action of a claim, hedged or not; the first action of a plan; None for claims about no action."""
    claim = unhedged(claim)
    if isinstance(claim, ActionClaim):
        return claim.action
    return claim.actions[0] if isinstance(claim, PlanClaim) and claim.actions else None


class EditClaim(Claim[TruthT, WorldT]):
    """Role of a claim that advises to replace one line of the student's last text, or to cut the text after a line."""

    __slots__ = ()
    scope = Scope.ACTION
    line: int
    """The number of the line, counted from 1; at most one more than there are lines."""
    words: str
    """The new line. A claim that cuts has none: the lines that stay do not change."""
    cuts: ClassVar[bool] = False
    """Whether the text should end after the line."""
    line_slot: ClassVar[str] = "line"
    """The slot of the phrases that holds the number."""
    words_slot: ClassVar[str] = "words"
    """The slot of the phrases that holds the new line."""


class Verdict(Claim[TruthT, WorldT]):
    """Base of a pair of opposite verdicts, which share their fields and one definition.

    A pair is a common base with the fields, `applies` and `good` (and the role `ActionClaim` if the verdict is on an
    action), and two classes, one hp and one hn, that `opposed` links.
    """

    __slots__ = ()
    scope = Scope.ACTION
    opposite: ClassVar[type["Verdict"]]
    """The class of the opposite verdict."""

    def applies(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Whether the fields describe this turn; if not, neither verdict holds."""
        raise TypeError(f"{type(self).__name__} does not implement applies(moment, lab)")

    def good(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Whether praise is due; called only if `applies` is true."""
        raise TypeError(f"{type(self).__name__} does not implement good(moment, lab)")

    def opposing(self, **changes: Any) -> "Verdict":
        """The opposite verdict, with some fields changed."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]  # a dataclass
        return self.opposite(**own | changes)

    def holds(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Praise holds where it is due, blame where it is not."""
        return self.applies(moment, lab) and self.good(moment, lab) == (self.kind is FeedbackType.HP)

    def counterparts(self, moment: Moment[TruthT], lab: WorldT) -> Sequence[Claim]:
        """The opposite verdict."""
        return (self.opposing(),)

    def excludes(self, other: Claim) -> bool:
        """The opposite verdict with equal fields; floats, which are measures, may differ."""
        if type(other) is not self.opposite:
            return False
        pairs = ((getattr(self, field.name), getattr(other, field.name)) for field in fields(self))  # type: ignore[arg-type]  # a dataclass
        return all(mine == its or isinstance(mine, float) for mine, its in pairs)


def slots_of(cls: type[Claim]) -> tuple[str, ...]:
    """The slots that phrases of a class can have, in order: its fields that are not tuples, and its properties."""
    single = [field.name for field in fields(cls) if get_origin(field.type) is not tuple]  # type: ignore[arg-type]  # a dataclass
    derived = (name for base in cls.__mro__ for name, value in vars(base).items() if isinstance(value, property))
    return tuple(dict.fromkeys((*single, *(name for name in derived if name != "kind"))))


def slot(words: Callable[[Any], Any], field: str) -> property:
    """A slot for phrases that is computed from one field of a claim, such as its text or its length."""
    return property(lambda claim: words(getattr(claim, field)))


def opposed(praise: type[Verdict], blame: type[Verdict]) -> None:
    """Link two verdict classes with the same fields as opposites."""
    praise.opposite, blame.opposite = blame, praise


class Grounded(Claim[TruthT, WorldT]):
    """Base of claims that follow from another claim, their ground, and say less.

    The ground is not a field: neither records nor students see it. They judge the claim by what it `means`.
    """

    __slots__ = ("_ground",)

    @classmethod
    def on(cls, ground: Any, **fields: Any) -> Self:
        """A claim with these fields and this ground: another claim, or several."""
        claim = cls(**fields)
        object.__setattr__(claim, "_ground", ground)
        return claim

    _ground: Any

    @property
    def grounded(self) -> bool:
        """Whether it has a ground. Claims that were read from text have none; `means` checks them."""
        return getattr(self, "_ground", None) is not None

    def stands(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Whether the ground holds."""
        return bool(self._ground.holds(moment, lab))

    @abstractmethod
    def means(self, moment: Moment[TruthT], oracle: Any) -> bool:
        """As in `Claim`, without the ground."""

    def __reduce__(self) -> tuple[Any, ...]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]  # a dataclass
        return _regrounded, (type(self), getattr(self, "_ground", None), {name: getattr(self, name) for name in names})


def _regrounded(cls: type[Grounded], ground: Any, fields: dict[str, Any]) -> Grounded:
    return cls.on(ground, **fields)


class Atom(NamedTuple):
    """A claim as it was said."""

    claim: Claim
    text: str
    """The sentence, without the other atoms of the utterance."""
    about_turn: int
    """The turn that the claim is about; earlier than the current turn if the claim comes late."""
    speaker: str = ""
    """The seat of the teacher that said it; empty if there is one teacher."""

    @property
    def kind(self) -> FeedbackType | None:
        """The claim's kind."""
        return self.claim.kind

    def label(self, moments: Sequence[Moment], lab: World[Any], oracle: Any = None) -> Label:
        """The result of checking the claim.

        Args:
            moments: the moments of the episode, up to the turn that said the claim.
            lab: a scratch world for the check.
            oracle: has started on the episode; checks claims whose ground is unknown. None leaves them unchecked.
        """
        claim, moment = self.claim, moments[self.about_turn]
        if isinstance(claim, HedgedClaim):
            return Label.HEDGED
        if isinstance(claim, Grounded) and not claim.grounded:
            if oracle is None:
                return Label.UNCHECKED
            holds = claim.means(moment, oracle)
        else:
            holds = claim.holds(moment, lab)
        if not holds:
            return Label.DISTORTED
        if claim.placebo:
            return Label.PLACEBO
        return Label.TRUTHFUL if self.about_turn == moments[-1].turn else Label.LATE


def contradictions(atoms: Iterable[Atom]) -> list[tuple[Atom, Atom]]:
    """Pairs of atoms in one utterance whose claims about the same turn exclude each other."""
    return [
        (one, other)
        for one, other in combinations(atoms, 2)
        if one.about_turn == other.about_turn
        and one.speaker == other.speaker
        and (one.claim.excludes(other.claim) or other.claim.excludes(one.claim))
    ]


class Utterance(str):
    """What a teacher says in one turn: a string that carries its atoms.

    Text of a person or a language model has no atoms, so that it cannot be checked.
    """

    __slots__ = ("atoms",)
    atoms: tuple[Atom, ...]

    def __new__(cls, text: str = "", atoms: tuple[Atom, ...] = ()) -> "Utterance":
        """Make an utterance of a text and its atoms."""
        self = str.__new__(cls, text)
        self.atoms = atoms
        return self

    @classmethod
    def of(cls, atoms: Sequence[Atom]) -> "Utterance":
        """Join the texts of atoms; an atom that shares its text with another may have none."""
        return cls(" ".join(atom.text for atom in atoms if atom.text), tuple(atoms))

    def within(self, longest: int) -> "Utterance":
        """The first atoms whose texts, joined, have at most so many characters."""
        kept: list[Atom] = []
        size = -1
        for atom in self.atoms:
            size += 1 + len(atom.text) if atom.text else 0
            if size > longest:
                break
            kept.append(atom)
        return Utterance.of(kept)

    def __reduce__(self) -> tuple[Any, ...]:
        return Utterance, (str(self), self.atoms)

    def __copy__(self) -> "Utterance":
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> "Utterance":
        return self  # immutable, and copied by vector environments at every step


SILENCE = Utterance()


def atoms_of(said: str) -> tuple[Atom, ...]:
    """The atoms of an utterance; plain text has none."""
    return said.atoms if type(said) is Utterance else ()
