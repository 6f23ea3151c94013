"""What a teacher says: claims, atoms and utterances; and the moment of which it is said."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, ClassVar, NamedTuple, Self, dataclass_transform

from worlds.world import World


class FeedbackType(StrEnum):
    """The five kinds of feedback of the LLF paper, in speaking order."""

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


KINDS = tuple(FeedbackType)
R, HP, HN, FP, FN = KINDS


class Label(StrEnum):
    """What a check in the simulator makes of something that was said. Students never see it."""

    TRUTHFUL = "truthful"
    """The claim holds."""
    DISTORTED = "distorted"
    """The claim does not hold."""
    PLACEBO = "placebo"
    """The claim holds, and has nothing to do with the task."""
    LATE = "late"
    """The claim holds of an earlier turn."""
    UNCHECKED = "unchecked"
    """Text without a claim."""


class ParseFailure(NamedTuple):
    """A student's text that is no action. The world did not step; the turn counts."""

    got: str
    """What was received: an excerpt of at most 80 printable characters."""
    expected: str
    """What an answer has to look like."""


class Moment(NamedTuple):
    """One turn of a student, as a teacher sees it."""

    before: Any
    """The world's truth before the action; None if no action was executed (the opening, or a `ParseFailure`)."""
    action: Any
    """The action in canonical form; None at the opening; a `ParseFailure` for text that is no action."""
    reward: float
    """The world's reward for the action; 0 if none was executed."""
    after: Any
    """The world's truth now."""
    success: bool
    """Whether the world says that the task is solved."""
    turn: int
    """Number of turns the student has had; 0 at the opening."""
    over: bool
    """Whether the episode has ended, so that advice could not be followed any more."""


@dataclass_transform(frozen_default=True, kw_only_default=True)
def claim(cls: type) -> type:
    """Class decorator of every claim: a frozen, slotted dataclass with keyword-only fields."""
    return dataclass(frozen=True, slots=True, kw_only=True)(cls)


class Claim:
    """One thing that can be said, as data.

    Its docstring spells out when it is true. Fields are JSON scalars, enums and tuples of them. A claim
    that advises or judges an action has it in a field `action`, in the form that `World.step` takes.
    """

    __slots__ = ()
    kind: ClassVar[FeedbackType | None] = None
    """The kind of feedback; None for the parts of an instruction and for notices of the environment."""
    placebo: ClassVar[bool] = False
    """Whether it has nothing to do with the task, however true."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Whether the claim is true of `moment`; `lab` is a scratch world to restore and step.

        The check reaches the truth by another way than the oracle does.
        """
        raise TypeError(f"{type(self).__name__} does not say when it holds; implement holds(moment, lab)")

    def counterparts(self, moment: Moment, lab: World) -> Sequence["Claim"]:
        """Well-formed, plausible claims that might be false where this one is true, for teachers that err."""
        return ()

    def coarser(self, moment: Moment, lab: World) -> Sequence["Claim"]:
        """Claims of the same kind that this one implies, saying less, the vaguest first, for teachers that hint."""
        return ()


class Grounded(Claim):
    """Base of claims that say less than another one and are true because that one is: their ground.

    The ground is no field: it is in no record, and a student who reads fields does not see it.
    """

    __slots__ = ("_ground",)

    @classmethod
    def on(cls, ground: Any, **fields: Any) -> Self:
        """A claim of these fields that rests on another claim, or on several."""
        claim = cls(**fields)
        object.__setattr__(claim, "_ground", ground)
        return claim

    def stands(self, moment: Moment, lab: World) -> bool:
        """Whether the ground holds."""
        return self._ground.holds(moment, lab)

    def __reduce__(self) -> tuple[Any, ...]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return _regrounded, (type(self), getattr(self, "_ground", None), {name: getattr(self, name) for name in names})


def _regrounded(cls: type[Grounded], ground: Any, fields: dict[str, Any]) -> Grounded:
    return cls.on(ground, **fields)


class Atom(NamedTuple):
    """A claim as it was said."""

    claim: Claim
    text: str
    """The sentence, without the other atoms of the utterance."""
    about_turn: int
    """The turn of which the claim speaks; smaller than the current turn if it comes late."""
    speaker: str = ""
    """The seat of who said it, where several teachers speak; else empty."""

    @property
    def kind(self) -> FeedbackType | None:
        """The claim's kind."""
        return self.claim.kind

    def label(self, moments: Sequence[Moment], lab: World) -> Label:
        """What the simulator says of it, given the moments of the episode up to the one in which it was said."""
        if not self.claim.holds(moments[self.about_turn], lab):
            return Label.DISTORTED
        if self.claim.placebo:
            return Label.PLACEBO
        return Label.TRUTHFUL if self.about_turn == moments[-1].turn else Label.LATE


class Utterance(str):
    """What a teacher says in one turn: a string that carries its atoms.

    Text of a person or a language model has no atoms: nothing vouches for it.
    """

    __slots__ = ("atoms",)
    atoms: tuple[Atom, ...]

    def __new__(cls, text: str = "", atoms: tuple[Atom, ...] = ()) -> "Utterance":
        """Make an utterance of a text and the atoms whose texts it is made of."""
        self = str.__new__(cls, text)
        self.atoms = atoms
        return self

    @classmethod
    def of(cls, atoms: Sequence[Atom]) -> "Utterance":
        """Join the texts of atoms."""
        return cls(" ".join(atom.text for atom in atoms), tuple(atoms))

    def __reduce__(self) -> tuple[Any, ...]:
        return Utterance, (str(self), self.atoms)

    def __copy__(self) -> "Utterance":
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> "Utterance":
        return self  # immutable, and copied by vector environments at every step


SILENCE = Utterance()
