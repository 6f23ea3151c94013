"""A lesson with people in some of its seats: the episode, whose turns can be taken back, and the record of it."""

from collections.abc import Sequence
from typing import Any, cast

from llf_teacher.episodes.record import EpisodeSpec, Record, TurnRow, summary
from llf_teacher.episodes.scenes import Scene, turn_row
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.web.plan import WATCHER, Plan
from pz_envs.frames import Watch
from pz_envs.seatings.tutoring import SEATING as TUTORING
from pz_envs.seatings.tutoring.shown import ShownTutoring
from pz_envs.seats import STUDENT, TEACHER, entitled
from teachers.atoms import SILENCE
from teachers.seeds import Seeds
from worlds.pictures.canvas import Frame

Saying = Sequence[int] | str | None
"""What a person in the teacher's seat says: claims by their numbers, words, or None, what the personality would."""


class LiveLesson:
    """An episode that people and policies play together, each in a seat, as studies play theirs.

    It ends as those do: by the world, by its length, or by success, unless the task is asked repeatedly. Whoever is no
    person plays by itself up to where a person is to move; where nobody sits, a watcher has them play turn by turn.

    Args:
        plan: what it is to be.

    Raises:
        ValueError: the student cannot play here.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        found = entry(plan.id)
        self.family = found.family
        student = None if STUDENT in plan.people else parse_student(plan.student)
        self.reads = "words" if student is None else student.reads
        aec = TUTORING.raw_env(
            self.family,
            teacher=plan.teacher,
            instruction_type=plan.instruction_type,
            feedback_type=plan.feedback_type,
            max_cycles=plan.max_turns,
            speech=plan.speech if TEACHER in plan.people else "message",
            text=student is None or student.text,
            render_mode="rgb_array",
            privileged_info=True,
            **found.options,
        )
        self.aec = cast(ShownTutoring, aec)
        self._policy = None if student is None else student.seat(self.family, aec.world)
        self._lab = aec.world.scratch()
        self.undone = 0
        """How many turns were taken back."""
        self._begin()

    def _begin(self) -> None:
        """From the opening on."""
        aec = self.aec
        if self._policy is not None:
            self._policy.reset(Seeds(self.plan.seed).stream("student"))
        aec.reset(self.plan.seed)
        self.moves: list[tuple[str, Any]] = []
        self._moments = [aec.moment]
        self.rows: list[TurnRow] = []
        """Of the turns that are over: the teacher has spoken."""
        self._settle()

    @property
    def over(self) -> bool:
        """Whether the last word has been said."""
        return self.family.is_over(self.aec.moment) and len(self.rows) == self.aec.turn + 1

    @property
    def to_move(self) -> str:
        """Whose turn it is: `STUDENT`, `TEACHER` or `WATCHER`; empty when it is over."""
        if self.over:
            return ""
        return self.aec.agent_selection if self.plan.people else WATCHER

    def move(self, who: str, what: Any) -> None:
        """One turn: a student's text, a teacher's `Saying`; of a watcher anything.

        Raises:
            ValueError: it is not whose turn it is, or it is nothing that can be said; nothing has changed.
        """
        if self.over:
            raise ValueError("the episode is over; begin a new lesson to go on")
        if who != self.to_move:
            raise ValueError("it is the turn of the other seat; wait until it has moved")
        self._play(who, what)
        self.moves.append((who, what))

    def undo(self, who: str) -> None:
        """Take the last turn back: the others are played again.

        Raises:
            ValueError: there is none, or it is not one's own.
        """
        if not self.moves:
            raise ValueError("there is no turn to take back")
        if self.moves[-1][0] != who:
            raise ValueError("the other seat has moved since; only the last turn can be taken back, by who made it")
        *moves, _ = self.moves
        self.undone += 1
        self._begin()
        for mover, what in moves:
            self.move(mover, what)

    def _play(self, who: str, what: Any) -> None:
        if who == TEACHER:
            self._speak(what)
        else:
            self._act(what if who == STUDENT else None)
        self._settle()

    def _settle(self) -> None:
        """Let whoever is no person play, up to where one is to move."""
        if self.aec.agent_selection == TEACHER and TEACHER not in self.plan.people:
            self.aec.take_suggestion()
            self._note()
        if self.plan.people == {TEACHER} and self.to_move == STUDENT:
            self._act(None)

    def _act(self, text: str | None) -> None:
        """The student's turn; None: of the policy."""
        aec, policy = self.aec, self._policy
        action: Any = text if policy is None else policy.act(aec.observe(STUDENT), entitled(policy, aec))
        aec.student_turn(action)
        self._moments.append(aec.moment)

    def _speak(self, saying: Saying) -> None:
        """The turn of a person who teaches."""
        aec, listed = self.aec, len(self.aec.seat.listed())
        if aec.speech == "message":
            if saying is not None and not isinstance(saying, str):
                raise ValueError("in this lesson the teacher speaks in its own words; give a text")
            if saying is None:
                aec.take_suggestion()
            else:
                aec.teacher_turn(saying)
        else:
            if isinstance(saying, str):
                raise ValueError("in this lesson the teacher chooses among claims; give their numbers")
            chosen = range(listed) if saying is None else saying
            if unknown_names := [i for i in chosen if not 0 <= i < listed]:
                raise ValueError(
                    f"there is no claim {unknown_names[0]}; there are {listed} to choose from, counted from 0"
                )
            for i in dict.fromkeys(chosen):
                if aec.agent_selection == TEACHER:
                    aec.teacher_turn(1 + i)
            if aec.agent_selection == TEACHER:
                aec.teacher_turn(0)
        self._note()

    def _note(self) -> None:
        """Put the turn down, now that the teacher has spoken."""
        aec, policy = self.aec, self._policy
        moment = aec.moment
        heard = {"instruction": SILENCE if moment.turn else aec.instruction, "feedback": aec.feedback}
        labelled = tuple((atom, atom.label(self._moments, self._lab)) for atom in aec.said)
        row = turn_row(aec, self.family.name, Scene(moment, heard, labelled), aec.teacher)
        self.rows.append(row._replace(**policy.record()) if policy is not None and moment.turn else row)

    def watch(self, who: str) -> Watch:
        """How the lesson looks from a seat: with the truth, but for a student until it is over."""
        return self.aec.watch if who != STUDENT or self.over else self.aec.watch.without_truth()

    def seen(self) -> str:
        """The world as text, as the student sees it."""
        return self.aec.world.describe(self.aec.world.observe())

    def record(self, spec: EpisodeSpec) -> Record:
        """The episode as a store keeps it.

        Raises:
            ValueError: it is not over.
        """
        if not self.over:
            raise ValueError("the episode is not over; play it to its end first")
        return Record(spec, summary(self.family.name, self.reads, self.rows), tuple(self.rows))

    def film(self, theme: str = "light") -> list[Frame]:
        """A frame of each turn, played again, with the truth.

        Raises:
            ValueError: as `record`.
        """
        if not self.over:
            raise ValueError("the episode is not over; play it to its end first")
        again = _Filmed(self.plan, theme)
        for mover, what in self.moves:
            again.move(mover, what)
        again.close()
        return again.frames

    def close(self) -> None:
        """Close the world."""
        self.aec.close()


class _Filmed(LiveLesson):
    """One that keeps a frame of each turn."""

    def __init__(self, plan: Plan, theme: str) -> None:
        self._theme = theme
        self.frames: list[Frame] = []
        super().__init__(plan)

    def _note(self) -> None:
        super()._note()
        self.frames.append(self.aec.watch.themed(self._theme).frame(self.seen()))
