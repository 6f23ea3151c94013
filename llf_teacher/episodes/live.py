"""A lesson with people in some of its seats, who can take back turns.

A session cannot go back. So the lesson keeps the moves of its seats, in order, and plays the episode again from its
seed without the last move. It repeats all queries to teachers, since these may draw from their random streams.
"""

import copy
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from llf_teacher.episodes.record import TurnRow
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.models.asked import Asked
from llf_teacher.registry import Entry
from llf_teacher.speakers.parsing import PHRASES
from llf_teacher.students.student import Student
from pz_envs.assembly import assemble
from pz_envs.frames import EpisodeRenderer
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings
from teachers.atoms import Claim, Utterance
from teachers.seeds import Seeds
from teachers.teacher_turn import TeacherTurn

if TYPE_CHECKING:
    from teachers.information import Bits

__all__ = ["WATCHER", "Input", "LiveLesson", "OutOfTurnError", "Saying"]

WATCHER = "watcher"
"""Moves if no person has a seat: each move is a turn of both seats."""
Saying = Sequence[int] | int | str | None
"""The move of a person in the teacher's seat: claims by their numbers, kinds by a subset's number, words, or None for
the suggestion of the personality.
"""


class OutOfTurnError(ValueError):
    """A move comes too late, too early, or from the wrong seat."""


class Input(NamedTuple):
    """An input of a seat to a session."""

    method: str
    """`act` of the student's seat, or a method of the session."""
    arguments: tuple[Any, ...]
    """The arguments of the method."""
    asked: tuple[str, ...]
    """The queries to the teacher before it, as methods of `TeacherTurn`."""


class LiveLesson:
    """An episode that people and policies play together, each in a seat.

    It ends like episodes of studies: by the world, by its length, or by success unless the task is asked repeatedly. A
    seat without a person plays by itself until it is a person's turn.

    Args:
        entry: the environment.
        settings: the settings of the lesson, with a render mode.
        seed: the seed of the episode.
        people: the seats of people.
        student: plays the student's seat if no person has it.
        worlds: number of worlds for measuring the information of each claim; 0: no measurement.

    Raises:
        ValueError: the student cannot play here.
    """

    def __init__(
        self,
        entry: Entry,
        settings: Settings,
        seed: int,
        people: frozenset[str],
        student: Student | None = None,
        worlds: int = 0,
    ) -> None:
        self.family, self.settings, self.seed, self.people = entry.family.for_lesson(settings), settings, seed, people
        self.reads = "words" if student is None else student.reads
        self.session, self.view, (self.teacher_view,) = assemble(self.family, settings)
        self._policy = None if student is None else student.seat(self.family, self.session.world)
        self._recorder, self._worlds = Recorder(self.family.name, self.view), worlds
        if TEACHER in people and settings.speech == "message":
            self._recorder.read(self.family, PHRASES)
        self.moves: list[tuple[str, Any]] = []
        """The seat of each move, and the move."""
        self.undone = 0
        """Number of turns that were taken back."""
        self.inputs: list[Input] = []
        """The inputs of all seats, in order."""
        self._before: list[int] = []  # for each move the number of inputs before it
        self._asked: dict[str, None] = {}  # the queries to the teacher since the last input, in order
        self._open()
        self._play_up_to_people()

    @property
    def rows(self) -> list[TurnRow]:
        """The turns that are complete: the teacher has spoken."""
        return self._recorder.rows

    @property
    def unmeasured(self) -> str:
        """Why the information of claims cannot be measured; empty if it is measured, or not requested."""
        return self._recorder.why

    def claims(self) -> tuple[Claim[Any], ...]:
        """The claims of this moment, also those that are not feedback."""
        return self._teacher_turn("claims").claims()

    def listed(self) -> list[Claim[Any]]:
        """The claims to choose from."""
        return self._teacher_turn("listed").listed()

    def sentences(self) -> tuple[str, ...]:
        """The words of each claim to choose from."""
        return self._teacher_turn("sentences").sentences()

    def suggestion(self) -> Utterance:
        """The personality's suggestion for this moment."""
        return self._teacher_turn("suggestion").suggestion()

    def weigh(self, claims: Iterable[Claim[Any]]) -> "list[Bits]":
        """The information of each available claim; empty if it is not measured."""
        return self._recorder.weigh(claims)

    @property
    def over(self) -> bool:
        """Whether the last word has been said."""
        return self.session.done

    @property
    def to_move(self) -> str:
        """The seat whose turn it is: `STUDENT`, `TEACHER` or `WATCHER`; empty when it is over."""
        if self.over:
            return ""
        if not self.people:
            return WATCHER
        return STUDENT if self.session.heard else TEACHER

    def move(self, seat: str, what: Any) -> None:
        """Play one turn: a student's text, a teacher's `Saying`, or any value from a watcher.

        Raises:
            OutOfTurnError: it is another seat's turn, or the episode is over.
            ValueError: the move is not possible; nothing has changed.
        """
        if self.over:
            raise OutOfTurnError("the episode is over; begin a new one to go on")
        if seat != self.to_move:
            raise OutOfTurnError("it is the turn of the other seat; wait until it has moved")
        before = len(self.inputs)
        if seat == TEACHER:
            self._say(what)
        else:
            self._act(what if seat == STUDENT else None)
        self.moves.append((seat, what))
        self._before.append(before)
        self._play_up_to_people()

    def undo(self, seat: str) -> None:
        """Take the last turn back.

        Raises:
            ValueError: there is no turn, or another seat has made it.
        """
        if not self.moves:
            raise ValueError("there is no turn to take back")
        if self.moves[-1][0] != seat:
            raise ValueError("the other seat has moved since; a seat can take back the last turn only if it is its own")
        self.moves.pop()
        inputs, self.inputs = self.inputs[: self._before.pop()], []
        self._open()
        self.play_again(inputs)
        self._recorder.forget(self.session.moment.turn + (self.session.heard or self.session.asked))
        self.undone += 1

    def play_again(self, inputs: Iterable[Input]) -> None:
        """Play inputs after the opening: those of this lesson, or of a lesson with the same settings and seed."""
        for method, arguments, asked in inputs:
            for name in asked:
                getattr(self._teacher_turn(name), name)()
            if method == "act" and self._policy is not None:
                self._policy_action()  # the policy acts too, for its memory, but the input's action counts
            self._do(method, *arguments)

    def prompt(self) -> Asked | None:
        """What the student's model was asked for its last action; None without a model."""
        return None if self._policy is None else self._policy.record().get("asked")

    def renderer(self, seat: str) -> EpisodeRenderer:
        """Renders the lesson for a seat: with the truth, which the student sees only at the end."""
        renderer = self.view.require_renderer()
        return renderer if seat != STUDENT or self.over else renderer.without_truth()

    def close(self) -> None:
        """Close the world."""
        self.session.world.close()

    def _open(self) -> None:
        self._asked.clear()
        if self._policy is not None:
            self._policy.reset(Seeds(self.seed).stream("student"))
        self._recorder.measure(self.family, self.seed, self._worlds)
        self.session.open(self.seed)

    def _teacher_turn(self, method: str) -> TeacherTurn:
        """The teacher's turn, for a call of one of its methods; the call is noted, since it may draw random numbers."""
        self._asked[method] = None
        return self.teacher_view.teacher_turn

    def _do(self, method: str, *arguments: Any) -> None:
        """Apply an input of a seat; it is noted when the teacher has spoken."""
        kept = Input(method, copy.deepcopy(arguments), tuple(self._asked))
        getattr(self.view if method == "act" else self.session, method)(*arguments)
        self._asked.clear()
        self.inputs.append(kept)
        if self.session.heard:
            self._note()

    def _play_up_to_people(self) -> None:
        if not self.session.heard and TEACHER not in self.people:
            self._do("speak")
        if self.people == {TEACHER} and self.to_move == STUDENT:
            self._act(None)

    def _act(self, text: str | None) -> None:
        """The student's turn; None: the policy acts."""
        self._do("act", text if self._policy is None else self._policy_action())

    def _policy_action(self) -> Any:
        """The policy's next action."""
        policy, view = self._policy, self.view
        assert policy is not None  # noqa: S101  # otherwise a person acts
        return policy.act(view.observe(), view.info_for(policy))

    def _say(self, saying: Saying) -> None:
        """The turn of a person who teaches."""
        session, speech = self.session, self.settings.speech
        if saying is None and speech != "claims":
            self._do("speak")
        elif speech == "kinds":
            self._do("say_kinds", saying)
        elif speech == "message":
            if not isinstance(saying, str):
                raise ValueError("in this lesson the teacher speaks in its own words; give a text")
            self._do("say", saying)
        else:
            listed = len(self.listed())
            chosen: Any = range(listed) if saying is None else saying
            if not isinstance(chosen, Sequence) or any(type(i) is not int for i in chosen):
                raise ValueError("in this lesson the teacher chooses among claims; give their numbers")
            if unknown_numbers := [i for i in chosen if not 0 <= i < listed]:
                raise ValueError(
                    f"there is no claim {unknown_numbers[0]}; there are {listed} to choose from, counted from 0"
                )
            for i in dict.fromkeys(chosen):
                if not session.heard:
                    self._do("choose", 1 + i)
            if not session.heard:
                self._do("choose", 0)

    def _note(self) -> None:
        """Note the turn, now that the teacher has spoken."""
        if len(self.rows) > self.session.moment.turn:  # noted before: an input played again, or an answer to a question
            self._recorder.measured(self.session.turn)  # what the student knows grows all the same
            return
        policy = self._policy
        answer = policy.record() if policy is not None and self.session.moment.turn else {}
        self._recorder.note(**answer)
