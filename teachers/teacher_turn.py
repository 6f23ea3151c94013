"""A teacher's turn: what one teacher may say of a moment, and the ways in which it can say it.

A teacher can say all that its personality suggests, the claims of some kinds, claims that it chooses one by one, or
words of its own. A `teachers.session.Session` has a `TeacherTurn` for each of its teachers, and uses it again for each
moment.
"""

import operator
from collections.abc import Sequence, Set
from enum import Enum
from functools import cached_property
from typing import Any

from teachers.atoms import FN, FP, KINDS, SILENCE, Claim, FeedbackType, Moment, Utterance, atoms_of
from teachers.budget import Budget, within
from teachers.feedback import SUBSETS, number_of, of_subset, subset_of
from teachers.schema import Message, Vocabulary, holds, in_own_words, storable
from teachers.teacher import Teacher

__all__ = ["CLAIMS", "LONGEST", "Phase", "TeacherTurn", "split_advice"]

CLAIMS = 32
"""Greatest number of claims of a moment to choose from."""
LONGEST = 65_536
"""Greatest length of a teacher's words, in characters."""


class Phase(Enum):
    """Whose turn it is in a session, and what teachers speak of when it is theirs."""

    INSTRUCTION = "instruction"
    """The teacher speaks of the opening: its words contain the instruction."""
    OPENING = "opening"
    """The teachers speak of the opening: the student has the instruction."""
    FEEDBACK = "feedback"
    """The teachers speak of the student's action."""
    ANSWER = "answer"
    """The teachers answer the student's question."""
    STUDENT = "student"
    """The student has heard all teachers; it acts or asks."""


# Reading a member from the class takes seven times as long.
INSTRUCTION, OPENING, FEEDBACK, ANSWER, STUDENT = Phase


class TeacherTurn:
    """What one teacher may say of the last moment.

    Args:
        teacher: its oracle sees the truth; its personality chooses the claims.
        budget: several teacher turns can share one.
        seat: the seat of the teacher, where several teachers speak; else empty.
        max_turns: the student's turns in an episode.
        answers: whether the student can ask.
    """

    def __init__(self, teacher: Teacher, budget: Budget, seat: str, max_turns: int, answers: bool) -> None:
        self.teacher, self.budget, self.seat = teacher, budget, seat
        self.max_turns, self.answers = max_turns, answers
        self.moment: Moment[Any]
        """The moment to speak of."""
        self.phase: Phase
        """The phase in which the moment was seen."""
        self.said: str | None = None
        """What the teacher has said of the moment; None if it has yet to speak."""
        self.trimmed = 0
        """The kinds requested last but unavailable, as a subset's number."""
        self.chosen: tuple[int, ...] = ()
        """Indices into `listed` of the claims chosen so far."""
        self.unbuilt: tuple[str, ...] = ()
        """Why claims of the last message could not be made, one reason for each."""
        self._brief: tuple[Claim[Any], ...] = ()  # the instruction, if the suggestion begins with it
        self._claims: tuple[Claim[Any], ...] | None = None
        self._suggestion: Utterance | None = None
        self._numbers: list[float] | None = None  # random numbers that draw the words, one per claim
        self._kinds = -1

    def see(self, moment: Moment[Any], phase: Phase) -> None:
        """Begin the turn: take the moment to speak of."""
        self.moment, self.phase = moment, phase
        self.said = self._claims = self._suggestion = self._numbers = None
        self._brief = self.chosen = ()
        self._kinds = -1

    @property
    def asked(self) -> bool:
        """Whether the student asks for advice on the moment."""
        return self.phase is ANSWER

    def claims(self) -> tuple[Claim[Any], ...]:
        """The claims of this moment, with notices but without the instruction.

        The first call asks the teacher, which may draw random numbers; later calls return the same claims.
        """
        claims = self._claims
        if claims is None:
            moment, teacher = self.moment, self.teacher
            if self.phase is ANSWER:
                claims = teacher.answer(moment)
            elif moment.before is not None:
                claims = teacher.judge(moment)
            elif self.phase is INSTRUCTION:
                self._brief = teacher.notice(moment)  # first, since the oracle starts with the instruction
                claims = teacher.judge(moment)
            else:
                claims = teacher.judge(moment)
                if moment.turn:
                    claims = teacher.notice(moment) + claims
            self._claims = claims
        return claims

    @property
    def judged(self) -> bool:
        """Whether the teacher has been asked for the claims of this moment."""
        return self._claims is not None

    def suggestion(self) -> Utterance:
        """All that the teacher has to say of this moment, in its words; drawn once."""
        said = self._suggestion
        if said is None:
            claims = self.claims()
            said = self._suggestion = self.teacher.say(self._brief + claims, self.moment.turn)
        return said

    # What a seat observes.

    def available(self) -> int:
        """The kinds that can be said now, as a subset's number."""
        if self._kinds < 0:
            self._kinds = subset_of(self.claims())
        return self._kinds if self.budget.limit is None or self.budget.left else 0

    def features(self, moment: Moment[Any]) -> tuple[float, float, float, float, float]:
        """Turn / max_turns, the last reward, importance of the next action, share of the budget left, 1 if over."""
        oracle, reward = self.teacher.oracle, moment.reward
        importance, most, (low, high) = oracle.importance(moment.after), oracle.max_importance, oracle.lab.reward_range
        if not low <= reward <= high:
            reward = low if reward < low else high
        importance = importance if importance <= most else most
        return moment.turn / self.max_turns, reward, importance, self.budget.share, moment.over

    def numbers(self, moment: Moment[Any], kinds: Set[FeedbackType | None], asked: bool) -> tuple[float, ...]:
        """What a seat with `teacher_numbers=True` observes of a moment with claims of these kinds."""
        left = self.budget.left > 0
        return *((asked,) if self.answers else ()), *(left and kind in kinds for kind in KINDS), *self.features(moment)

    # The claims of some kinds.

    def of_kinds(self, subset: Any) -> Utterance:
        """The claims of a subset of the kinds in words, as many as the budget allows; notices are always said.

        Raises:
            ValueError: it is no subset's number.
        """
        if type(subset) is not int or not 0 <= subset < SUBSETS:
            subset = _index(subset, SUBSETS)
        said, available = self.claims(), self._kinds
        if available < 0 or self.budget.limit is not None:
            available = self.available()
        self.trimmed = subset & ~available
        if available & ~subset:
            said = tuple(of_subset(said, subset))
        if self.budget.limit is not None:
            said = tuple(within(self.budget.left, said))
            self.trimmed = subset & ~subset_of(said)
        return self.teacher.say(said, self.moment.turn)

    # Claims chosen one by one.

    def listed(self) -> list[Claim[Any]]:
        """The claims to choose from, at most `CLAIMS`: those of the moment that are feedback, in speaking order."""
        return [claim for claim in self.claims() if claim.kind is not None][:CLAIMS]

    def sentences(self) -> tuple[str, ...]:
        """The sentence for each listed claim; a voice that rewrites rewrites only what is chosen."""
        teacher, listed = self.teacher, self.listed()
        return teacher.voice.sentences_of(listed, self._drawn(listed), teacher.paraphrase)

    def choices(self) -> list[int]:
        """The choices that are legal, in order: 0 ends the turn, i says claim i - 1 of `listed`."""
        listed = range(1, 1 + len(self.listed())) if self.budget.left else ()
        return [0, *(i for i in listed if i - 1 not in self.chosen)]

    def choose(self, choice: Any) -> bool:
        """Choose one more claim, or none with 0; whether the turn is over, since nothing else can be said.

        A choice that is not legal says nothing and ends the turn.

        Raises:
            ValueError: it is no choice.
        """
        if type(choice) is not int or not 0 <= choice <= CLAIMS:
            choice = _index(choice, 1 + CLAIMS)
        if not choice or choice not in self.choices():
            return True
        self.chosen += (choice - 1,)
        return self.budget.left <= 1 or len(self.chosen) == len(self.listed())

    def of_chosen(self) -> Utterance:
        """The chosen claims in words, in speaking order; notices are always said."""
        listed = self.listed()
        kept = {id(listed[i]) for i in self.chosen}
        said = [claim for claim in self.claims() if claim.kind is None or id(claim) in kept]
        return self.teacher.say(tuple(said), self.moment.turn, self._drawn(said))

    def _drawn(self, claims: Sequence[Claim[Any]]) -> list[float]:
        """The random numbers that draw the words of these claims; drawn once for all claims of the moment."""
        known = self.claims()
        if self._numbers is None:
            self._numbers = self.teacher.draw(len(known))
        wanted = {id(claim) for claim in claims}
        return [number for claim, number in zip(known, self._numbers, strict=True) if id(claim) in wanted]

    # The teacher's own words.

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """The claims that a message can have."""
        return Vocabulary.of(self.teacher.oracle, self.teacher.kinds)

    def compose(self, message: Message) -> str:
        """Put a message of claims into words, its own or the voice's, after instruction and notices.

        Leaves out claims that cannot be made, checked or worded, with the reasons in `unbuilt`, and claims that
        feedback type and budget do not allow. If the latter leave out a claim, the voice words the rest.
        """
        moment, teacher = self.moment, self.teacher
        notices = [claim for claim in self.claims() if claim.kind is None]
        notices[:0] = self._brief
        problems, made, left = [*message.problems], [], LONGEST // 2  # the rest is for notices, or for its own words
        for claim in message.claims:
            try:
                holds(claim, moment, teacher.oracle, teacher.voice)
                if (size := 1 + max(map(len, teacher.voice.sentences(claim)))) > left:
                    raise ValueError(f"{claim!r:.100} makes the words longer than {LONGEST // 2} characters")
            except ValueError as error:
                problems.append(f"{error}")
            else:
                made.append(claim)
                left -= size
        self.unbuilt = tuple(problems)
        claims = within(self.budget.left, [claim for claim in made if claim.kind in teacher.kinds])
        said = teacher.say((*notices, *claims), moment.turn)
        if not message.text or len(claims) < len(made):
            return said
        given, own = said.atoms[: len(notices)], said.atoms[len(notices) :]
        words = in_own_words(own, message.text, teacher.voice)
        return Utterance(" ".join([*(atom.text for atom in given), words]), (*given, *words.atoms))

    def allowed(self, words: Any) -> str:
        """The part of some words that feedback type and budget allow.

        Text without atoms is of no kind: it passes unless no feedback is wanted at all.

        Raises:
            ValueError: it is no text, or too long.
        """
        if not isinstance(words, str) or len(words) > LONGEST:
            raise ValueError(f"the teacher must say a string of at most {LONGEST} characters, got {words!r:.80}")
        if (kept := storable(words)) != words:
            words = Utterance(kept, tuple(atom._replace(text=storable(atom.text)) for atom in atoms_of(words)))
        wanted, budget, turn = self.teacher.kinds, self.budget, self.moment.turn
        if type(words) is not Utterance or not words.atoms:
            return words if (wanted or not turn) and budget.left else SILENCE
        if len(wanted) < len(KINDS) and len(fitting := of_subset(words.atoms, number_of(wanted))) < len(words.atoms):
            words = Utterance.of(fitting)
        return words if budget.limit is None else Utterance.of(within(budget.left, words.atoms))

    # Among several teachers.

    def sign(self, words: str, spoken: Sequence[str]) -> Utterance:
        """Words whose atoms name their speaker, without the notices that other teachers have spoken in this turn."""
        atoms = atoms_of(words)
        given = [atom.claim for said in spoken for atom in atoms_of(said) if atom.kind is None]
        if any(atom.claim in given for atom in atoms):
            words = Utterance.of(atoms := tuple(atom for atom in atoms if atom.claim not in given))
        return Utterance(words, tuple(atom._replace(speaker=self.seat) for atom in atoms))


def split_advice(words: str) -> tuple[str, str]:
    """The first words of an episode as instruction and feedback: advice for the first action is feedback."""
    atoms = atoms_of(words)
    advice = [atom for atom in atoms if atom.kind in (FP, FN)]
    if not advice:
        return words, SILENCE
    return Utterance.of([atom for atom in atoms if atom.kind not in (FP, FN)]), Utterance.of(advice)


def _index(value: Any, count: int) -> int:
    """An integer from 0 on, below `count`, NumPy's included.

    Raises:
        ValueError: it is none.
    """
    try:
        index = operator.index(value)
    except TypeError:
        index = -1
    if not 0 <= index < count:
        raise ValueError(f"the teacher's action must be an integer from 0 to {count - 1}, got {value!r}")
    return index
