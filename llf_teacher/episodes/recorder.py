"""The recorder of an episode: its turns as they are stored, with every claim checked against the simulator."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from llf_teacher.episodes.record import EpisodeRow, TurnRow, as_dict, reading_as_dict, summary, unchecked
from llf_teacher.episodes.regret import turn_regret
from llf_teacher.models.replies import Usage
from llf_teacher.serialization import to_json
from llf_teacher.speakers.parsing import NOBODY, parse_reader
from llf_teacher.speakers.speaker import TeacherReply
from pz_envs.student_view import StudentView
from pz_envs.subject import Subject
from teachers.atoms import Atom, Claim, Label, Moment, ParseFailure
from teachers.common import Late
from teachers.phrasebook import Rewriting
from teachers.schema import without
from teachers.session import Turn

if TYPE_CHECKING:
    from pz_envs.text.claims import ClaimReader
    from teachers.information import Bits, Information

__all__ = ["Recorder"]


class Recorder:
    """Keeps the turns of an episode.

    Args:
        family: name of the family.
        view: the student's seat.
        speaker: the teaching policy or voice, if it is not the session's teacher; its `changes` are counted.
    """

    def __init__(self, family: str, view: StudentView, speaker: Any = None) -> None:
        self.family, self._view = family, view
        self._speaker = view.session.teacher if speaker is None else speaker
        self._lab = view.session.world.scratch()
        self._moments: list[Moment[Any]] = []
        self.rows: list[TurnRow] = []
        """The recorded turns."""
        self._information: Information | None = None
        self._briefed: Moment[Any] | None = None
        self._reader: ClaimReader | None = None
        self.why = ""
        """Why the information of claims cannot be measured; empty if it is measured, or not requested."""

    def measure(self, family: Subject, seed: int, worlds: int) -> None:
        """From the next opening on, measure the information of each claim with so many worlds; 0: stop measuring.

        If it cannot be measured, the episode states the reason. Measuring draws from its own stream and so does not
        change the lesson.
        """
        self._information, self.why = None, ""
        if worlds:
            try:
                self._information = family.make_information(self._view.session.world, seed, worlds)
            except ValueError as error:
                self.why = f"{error}"

    def read(self, family: Subject, reader: str) -> None:
        """From the next opening on, read the teacher's own words.

        Args:
            family: the subject.
            reader: the reader, as in `EpisodeSpec`.
        """
        self._reader = None
        if reader != NOBODY:
            from pz_envs.text.claims import ClaimReader

            session = self._view.session
            self._reader = ClaimReader(family, session.world, session.teacher.oracle, parse_reader(reader))

    def forget(self, turns: int = 0) -> None:
        """Keep only the first turns."""
        del self._moments[turns:], self.rows[turns:]

    def check(self, turn: Turn) -> tuple[tuple[Atom, Label], ...]:
        """The sentences of a turn, each claim with its label; check earlier turns first."""
        self._moments[turn.moment.turn :] = [turn.moment]
        oracle = self._view.session.teacher.oracle
        return tuple((atom, atom.label(self._moments, self._lab, oracle)) for atom in turn.atoms)

    def holds(self, atom: Atom, label: Label) -> bool:
        """Whether a claim with its label holds; for a hedged claim, whether the hedged one does."""
        if label is Label.HEDGED:
            return atom.claim.holds(self._moments[atom.about_turn], self._lab)
        return label is not Label.DISTORTED

    def elsewhere(self, atom: Atom) -> bool | None:
        """Whether a claim of another moment holds there; None if it was made of this lesson."""
        moment = self._view.session.origin(atom)
        return None if moment is None else atom.claim.holds(moment, self._lab)

    def note(self, **answer: Any) -> TurnRow:
        """Record the session's last turn; `answer` has further columns about a model's answer."""
        session = self._view.session
        turn, world = session.turn, session.world
        moment, feedback = turn.moment, str(turn.feedback)
        failed = moment.action if type(moment.action) is ParseFailure else None
        atoms = self.check(turn)
        said = self.measured(turn)
        usage, reply = getattr(self._speaker, "usage", None), getattr(self._speaker, "reply", None)
        row = TurnRow(
            turn=moment.turn,
            observation=world.describe(turn.state),
            action=None if moment.before is None else to_json(moment.action),
            action_words=None if moment.before is None or isinstance(moment.action, str) else f"{moment.action}",
            reward=moment.reward,
            regret=turn_regret(session.teacher.oracle, moment),
            success=moment.success,
            parse_failure=failed and failed.got,
            instruction=str(turn.instruction) or None,
            feedback=feedback,
            atoms=[
                as_dict(atom, label, self.holds(atom, label), self.family, said.get(i), self.elsewhere(atom))
                for i, (atom, label) in enumerate(atoms)
            ],
            unchecked=unchecked(feedback, [atom.text for atom, _ in atoms]) or None,
            changes=len(getattr(self._speaker, "changes", ())) or None,
            unbuilt=sum(len(each.unbuilt) for each in session.teacher_turns) or None,
            withheld=len(getattr(self._speaker, "withheld", ())) or None,
            readings=self._readings(self._reader, turn) or None if self._reader else None,
            paid=usage._asdict() if isinstance(usage, Usage) else None,
            reply=reply._asdict() | {"faults": [*reply.faults]} if isinstance(reply, TeacherReply) else None,
            teacher_asked=getattr(self._speaker, "asked", None),
            problems=[why for each in session.teacher_turns for why in each.unbuilt] or None,
        )._replace(**answer)
        self.rows.append(row)
        return row

    def _readings(self, reader: "ClaimReader", turn: Turn) -> list[dict[str, Any]]:
        """Readings of words that the voice did not make, such as those of a rewriting function."""
        session = self._view.session
        judged = [each for each in session.teacher_turns if each.judged]  # asking others may draw random numbers
        reader.see(turn.moment, [claim for each in judged for claim in each.claims()])
        rewritten = isinstance(session.teacher.voice, Rewriting)
        said = [atom.text for atom in turn.atoms if atom.kind is None or not rewritten]
        return [reading_as_dict(each, self.family) for each in reader.read(without(str(turn.feedback), said))]

    def measured(self, turn: Turn) -> "dict[int, Bits]":
        """The information of each claim of feedback, by its index among the atoms of the session's last turn."""
        if self._information is None:
            return {}
        instruction = self._follow(self._information)
        said = [(i, atom) for i, atom in enumerate(turn.atoms) if atom not in instruction]
        found = zip(said, self._information.hear([atom for _, atom in said]), strict=True)
        return {i: bits for (i, atom), bits in found if atom.kind is not None}

    def _follow(self, information: "Information") -> Sequence[Atom]:
        """The student's view of the last turn, and the claims of its instruction."""
        session = self._view.session
        moment, instruction = session.moment, getattr(session.turn.instruction, "atoms", ())
        information.see(moment)
        if instruction and moment is not self._briefed:
            information.hear(instruction)
            self._briefed = moment
        return instruction

    def weigh(self, claims: Iterable[Claim[Any]]) -> "list[Bits]":
        """The information of each given claim now; empty if it is not measured."""
        if self._information is None:
            return []
        self._follow(self._information)
        turn = self._view.session.moment.turn
        atoms = (Atom(*((c.claim, "", c.turn) if isinstance(c, Late) else (c, "", turn))) for c in claims)
        return list(map(self._information.weigh, atoms))

    def episode(self, reads: str) -> EpisodeRow:
        """The sums over the turns; `reads`: what the student learns from."""
        return summary(self.family, reads, self.rows, measured=self._information is not None, why=self.why)
