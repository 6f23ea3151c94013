"""Traits, which change what a student hears, remembers or does: `obedient | stubborn(p=0.3)`.

A trait is a frozen dataclass in a module of its name under `llf_teacher/students/traits/`. It overrides one or two of
`hear`, `forgets` and `act`; a `Scene` is its knowledge of an episode. Traits know no family and no student. A policy
between the seat and the student applies them.
"""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from llf_teacher.students import traits
from llf_teacher.students.scene import BareSentence, HeardBatch, Scene, SceneBatch
from llf_teacher.students.student import TAUGHT, ModelReply, Policy, Student
from pz_envs.subject import Subject
from teachers.atoms import SILENCE, ActionClaim, Atom, Claim, PlanClaim, Utterance
from teachers.common import Late
from teachers.phrasebook import Drawn
from teachers.seeds import streams_beside
from teachers.spec import Spec, fits
from worlds.batches import Bools, Ints
from worlds.batches.streams import Stream
from worlds.world import World

_SENTENCES = re.compile(r"(?<=[.!?])\s+|\n+")


class Trait(Spec):
    """Base of all traits: a frozen value with what it changes.

    `hear` needs a student that reads feedback, `forgets` one that learns, `act` one that is not a method of search.
    """

    package: ClassVar[str] = traits.__name__
    strength: ClassVar[str]
    """The name of the parameter for its strength."""
    absent: ClassVar[float | None] = 0.0
    """The value of this parameter that changes nothing."""

    def __ror__(self, student: Student) -> "Traited":
        """The student with this trait added last: `student | trait`."""
        bare, others = traits_of(student)
        return Traited(bare, (*others, self))

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim that the student hears instead of this atom; None: nothing. By default the atom's own claim.

        A changed claim is worded anew, so that students hear the same in text and in atoms.
        """
        return atom.claim

    def forgets(self, scene: Scene) -> bool:
        """Whether the student now forgets everything; asked in each turn before it hears, but not at the opening."""
        return False

    def act(self, action: Any, scene: Scene) -> Any:
        """The action to take when the student chooses this one; by default the same object."""
        return action

    # The same in arrays; a class overrides both forms; see `llf_teacher.students.batches.traited`.

    def hear_rows(self, heard: HeardBatch, scene: SceneBatch) -> HeardBatch:
        """The heard claims in the rows of a scene."""
        return heard

    def forgets_rows(self, scene: SceneBatch) -> Bools:
        """Whether the students in the rows of a scene forget now, shape (n,)."""
        return np.zeros(len(scene.rows), bool)

    def act_rows(self, actions: Ints, scene: SceneBatch) -> Ints:
        """The taken actions in the rows of a scene, shape (n,)."""
        return actions

    @classmethod
    def in_arrays(cls) -> bool:
        """Whether each of its methods has its form in arrays."""
        return cls is not Trait and all(fits(cls, name, f"{name}_rows") for name in ("hear", "forgets", "act"))


class _Policy(Policy["Traited"]):
    """Claims pass the traits from left to right, then the student acts, and its action passes the traits, too."""

    def __init__(self, spec: "Traited", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        self.inner = spec.student.seat(family, world)
        for trait in spec.traits:
            _check_serves(trait, self.inner.spec)  # may differ by family
        if hasattr(self.inner, "intend"):
            self.intend = self._intend

    def begin(self) -> None:
        """Begin an episode: the student with the stream, each trait with a stream beside it."""
        self.inner.reset(self.rng)
        self._words, *streams = streams_beside(self.rng, 1 + len(self.spec.traits))
        self._scenes = [Scene(stream, self.world, self.spec.text) for stream in streams]
        self._turn = 0
        self._asked, self._anew = 0, False  # the last turn in which traits were asked, and whether they forgot
        self._since = 0  # the turn before which it last forgot
        self._instruction = SILENCE

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The action after all traits."""
        forgets = self._forgets(info)  # changes `inner`
        action = given = self.inner.act(*self._heard(observation, info, forgets))
        for trait, scene in self._parts():
            action = trait.act(action, scene)
        if action is not given:
            self.inner.did(action)
        for scene in self._scenes:
            scene.last = action
        self._turn += 1
        return action

    def _intend(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The action that the student intends, before its traits change what it hears and does."""
        self._forgets(info)
        return self.inner.intend(observation, info)  # type: ignore[attr-defined]  # where it has it

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Pass the last words through the traits to the student."""
        for scene in self._scenes:
            scene.turn = self._turn
        self.inner.finish(*self._heard(observation, info), terminated)

    def resume_at(self, turn: int, since: int, asked: int, last: Any, streams: Sequence[Stream]) -> None:
        """Continue in the middle of an episode.

        Args:
            turn: number of turns so far.
            since: the turn before which it last forgot, else 0.
            asked: the last turn in which traits were asked whether they forget, else 0.
            last: the action of the last turn.
            streams: one for each trait.
        """
        self._turn, self._since, self.rng = turn, since, self.inner.rng
        self._asked, self._anew = asked, 0 < since == asked
        for scene, stream in zip(self._scenes, streams, strict=True):
            scene.last, scene.rng = last, stream

    def record(self) -> ModelReply:
        """The student's."""
        return self.inner.record()

    def _parts(self) -> Any:
        return zip(self.spec.traits, self._scenes, strict=True)

    def _forgets(self, info: dict[str, Any]) -> bool:
        """Begin with a new student if a trait forgets in this turn, but not in the first; returns whether it did."""
        for scene in self._scenes:
            scene.turn, scene.listed = self._turn, info.get(self.world.actions_key) or ()
        if self._asked == self._turn:
            return self._anew
        self._asked = self._turn
        asked = [trait.forgets(scene) for trait, scene in self._parts()]  # ask all, since each may draw
        self._anew = any(asked)
        if self._anew:
            # A new value, since a user's own agent belongs to its value.
            past, self.inner = self.inner, dataclasses.replace(self.spec.student).seat(self.family, self.world)
            self.inner.reset(self.rng)
            self.inner.succeed(past)
            self._since = self._turn
        return self._anew

    def _heard(
        self, observation: dict[str, Any], info: dict[str, Any], anew: bool = False
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Observation and info after the traits; the same objects if they change nothing."""
        said = {name: _utterance(observation[name], info) for name in ("instruction", "feedback")}
        if said["instruction"]:
            self._instruction = _without_actions(said["instruction"])
        if anew:
            said["instruction"] = self._now(self._instruction)
        heard = {name: self._through(words) for name, words in said.items()}
        if not self._since and all(heard[name] is said[name] for name in said):
            return observation, info
        if "atoms" in info:
            info = {**info, "atoms": heard["instruction"].atoms + heard["feedback"].atoms}
        return {**observation, **heard}, info

    def _now(self, instruction: Utterance) -> Utterance:
        """The atoms of an instruction, dated to this turn."""
        return Utterance(str(instruction), tuple(atom._replace(about_turn=self._turn) for atom in instruction.atoms))

    def _through(self, said: Utterance) -> Utterance:
        """The heard part of an utterance; the same object if nothing changes."""
        atoms = said.atoms or tuple(
            Atom(BareSentence(text=text), text, self._turn) for text in _SENTENCES.split(said) if text
        )
        heard = [self._one(atom) for atom in atoms]
        if all(new is old for old, new in zip(atoms, heard, strict=True)):
            return said
        left = tuple(new for new in heard if new is not None)
        if " ".join(atom.text for atom in atoms) == said:
            text = " ".join(atom.text for atom in left)
        else:  # words between the sentences
            text = str(said)
            for old, new in zip(atoms, heard, strict=True):
                text = text.replace(old.text, new.text if new else "", 1)
        return Utterance(text.strip(), tuple(atom for atom in left if not isinstance(atom.claim, BareSentence)))

    def _one(self, atom: Atom) -> Atom | None:
        """The heard part of an atom, its turn counted from the student's last forgetting; the same without a change."""
        said = atom
        for trait, scene in self._parts():
            claim = trait.hear(atom, scene)
            if claim is None:
                return None
            atom = atom if claim is atom.claim else atom._replace(claim=claim)
        if isinstance(atom.claim, BareSentence):
            return atom
        about, now = atom.about_turn - self._since, self._turn - self._since
        if about < 0:
            return None  # it has forgotten this turn
        if atom is said and (not self._since or about == now):  # only late words name a turn
            return atom._replace(about_turn=about) if self._since else atom
        words = self.family.phrasebook().say(
            (atom.claim if about == now else Late(claim=atom.claim, turn=about),),
            now,
            Drawn([self._words.random()]),
            "random",
        )
        return words.atoms[0]._replace(speaker=atom.speaker)


@dataclasses.dataclass(frozen=True)
class Traited(Student):
    """A student with traits."""

    student: Student
    """The student without them."""
    traits: tuple[Trait, ...]
    """From left to right; at least one."""
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        for trait in self.traits:
            if not isinstance(trait, Trait):
                raise TypeError(f"the value behind | must be a trait, such as Stubborn(p=0.3), got {trait!r}")
            _check_serves(trait, self.student)

    def __str__(self) -> str:
        return " | ".join(map(str, (self.student, *self.traits)))

    # As the student.
    reads = property(attrgetter("student.reads"))
    draws_worlds = property(attrgetter("student.draws_worlds"))
    needs_discrete = property(attrgetter("student.needs_discrete"))
    text = property(attrgetter("student.text"))
    remembers = property(attrgetter("student.remembers"))

    @property
    def forget(self) -> bool:
        """Whether the student forgets between episodes."""
        return getattr(self.student, "forget", True)

    def check(self, environment: Mapping[str, str]) -> None:
        """The student's check."""
        self.student.check(environment)

    def facts(self) -> dict[str, Any]:
        """The student's facts."""
        return self.student.facts()


def traits_of(student: Student) -> tuple[Student, tuple[Trait, ...]]:
    """The student without traits, and its traits."""
    return (student.student, student.traits) if isinstance(student, Traited) else (student, ())


def _check_serves(trait: Trait, student: Student) -> None:
    """Check that a trait has something to change.

    Raises:
        ValueError: it has nothing.
    """
    cls = type(trait)
    why = ""
    if cls.hear is not Trait.hear and student.reads not in TAUGHT:
        why = f"changes what is heard, and the student {student} reads {student.reads}; allowed: students that read "
        why += ", ".join(TAUGHT)
    elif cls.forgets is not Trait.forgets and student.reads in ("nothing", "truth"):
        why = f"forgets what was learned, and the student {student} reads {student.reads} and learns nothing; allowed: "
        why += "students that read words, atoms or rewards"
    elif cls.act is not Trait.act and student.searches:
        why = f"changes actions, and the student {student} needs the reward of each action that it proposes; allowed: "
        why += "students that learn from whatever is done, such as obedient, bayesian, q_learning"
    if why:
        raise ValueError(f"the trait {trait} {why}")


def _utterance(words: str, info: dict[str, Any]) -> Utterance:
    """Words with their atoms; the atoms may come from the info instead."""
    if isinstance(words, Utterance):
        return words
    return Utterance(words, tuple(atom for atom in info.get("atoms", ()) if atom.text in words))


def _without_actions(said: Utterance) -> Utterance:
    """An instruction without feedback and without claims about actions."""
    kept = [each for each in said.atoms if each.kind is None and not isinstance(each.claim, ActionClaim | PlanClaim)]
    return said if len(kept) == len(said.atoms) else Utterance.of(kept)
