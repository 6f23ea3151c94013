"""The recorder of an episode: its turns as they are stored, with every claim checked against the simulator."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from llf_teacher.episodes.record import EpisodeRow, TurnRow, as_dict, reading_as_dict, summary, unchecked
from llf_teacher.episodes.regret import turn_regret
from llf_teacher.models.replies import Usage
from llf_teacher.serialization import to_json
from llf_teacher.speakers.parsing import NOBODY, parse_reader
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
        speaker: what teaches, if that is not the session's teacher; its `changes` are counted.
    """

    def __init__(self, family: str, view: StudentView, speaker: Any = None) -> None:
        self.family, self._view = family, view
        self._speaker = view.session.teacher if speaker is None else speaker
        self._lab = view.session.world.scratch()
        self._moments: list[Moment[Any]] = []
        self.rows: list[TurnRow] = []
        """What was noted."""
        self._information: Information | None = None
        self._briefed: Moment[Any] | None = None
        self._reader: ClaimReader | None = None
        self.why = ""
        """Why it cannot be measured how much claims say; empty if it is, or is not asked for."""

    def measure(self, family: Subject, seed: int, worlds: int) -> None:
        """Measure from the next opening on how much each claim says, by so many worlds; 0: no more.

        Where that cannot be, the episode says why. It draws from a stream of its own, so that the lesson is the same.
        """
        self._information, self.why = None, ""
        if worlds:
            try:
                self._information = family.make_information(self._view.session.world, seed, worlds)
            except ValueError as error:
                self.why = f"{error}"

    def read(self, family: Subject, reader: str) -> None:
        """Read from the next opening on what is said in the teacher's own words.

        Args:
            family: what is taught.
            reader: as of an episode.
        """
        self._reader = None
        if reader != NOBODY:
            from pz_envs.text.claims import ClaimReader

            session = self._view.session
            self._reader = ClaimReader(family, session.world, session.teacher.oracle, parse_reader(reader))

    def forget(self, turns: int = 0) -> None:
        """Keep so many of the first turns."""
        del self._moments[turns:], self.rows[turns:]

    def check(self, turn: Turn) -> tuple[tuple[Atom, Label], ...]:
        """What was said in a turn, each claim with its label; the turns before have to be checked before."""
        self._moments[turn.moment.turn :] = [turn.moment]
        oracle = self._view.session.teacher.oracle
        return tuple((atom, atom.label(self._moments, self._lab, oracle)) for atom in turn.atoms)

    def holds(self, atom: Atom, label: Label) -> bool:
        """Whether a claim with its label holds; of a hedged one, whether what it hedges does."""
        if label is Label.HEDGED:
            return atom.claim.holds(self._moments[atom.about_turn], self._lab)
        return label is not Label.DISTORTED

    def note(self, **answer: Any) -> TurnRow:
        """Note the session's last turn; `answer` has further columns, of what a model answered."""
        session = self._view.session
        turn, world = session.turn, session.world
        moment, feedback = turn.moment, str(turn.feedback)
        failed = moment.action if type(moment.action) is ParseFailure else None
        atoms = self.check(turn)
        said = self.measured(turn)
        usage = getattr(self._speaker, "usage", None)
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
                as_dict(atom, label, self.holds(atom, label), self.family, said.get(i))
                for i, (atom, label) in enumerate(atoms)
            ],
            unchecked=unchecked(feedback, [atom.text for atom, _ in atoms]) or None,
            changes=len(getattr(self._speaker, "changes", ())) or None,
            unbuilt=sum(len(each.unbuilt) for each in session.teacher_turns) or None,
            withheld=len(getattr(self._speaker, "withheld", ())) or None,
            readings=self._readings(self._reader, turn) or None if self._reader else None,
            paid=usage._asdict() if isinstance(usage, Usage) else None,
        )._replace(**answer)
        self.rows.append(row)
        return row

    def _readings(self, reader: "ClaimReader", turn: Turn) -> list[dict[str, Any]]:
        """What was read of words that are not the voice's own, as those of a function that rewrites are not."""
        session = self._view.session
        judged = [each for each in session.teacher_turns if each.judged]  # asking others may draw random numbers
        reader.see(turn.moment, [claim for each in judged for claim in each.claims()])
        rewritten = isinstance(session.teacher.voice, Rewriting)
        said = [atom.text for atom in turn.atoms if atom.kind is None or not rewritten]
        return [reading_as_dict(each, self.family) for each in reader.read(without(str(turn.feedback), said))]

    def measured(self, turn: Turn) -> "dict[int, Bits]":
        """How much each claim of feedback says, by its place among the atoms of the session's last turn."""
        if self._information is None:
            return {}
        instruction = self._follow(self._information)
        said = [(i, atom) for i, atom in enumerate(turn.atoms) if atom not in instruction]
        found = zip(said, self._information.hear([atom for _, atom in said]), strict=True)
        return {i: bits for (i, atom), bits in found if atom.kind is not None}

    def _follow(self, information: "Information") -> Sequence[Atom]:
        """What the student has seen in the last turn, and the claims of its instruction, which it has heard."""
        session = self._view.session
        moment, instruction = session.moment, getattr(session.turn.instruction, "atoms", ())
        information.see(moment)
        if instruction and moment is not self._briefed:
            information.hear(instruction)
            self._briefed = moment
        return instruction

    def weigh(self, claims: Iterable[Claim[Any]]) -> "list[Bits]":
        """How much each claim would say now; empty if it is not measured."""
        if self._information is None:
            return []
        self._follow(self._information)
        turn = self._view.session.moment.turn
        atoms = (Atom(*((c.claim, "", c.turn) if isinstance(c, Late) else (c, "", turn))) for c in claims)
        return list(map(self._information.weigh, atoms))

    def episode(self, reads: str) -> EpisodeRow:
        """The sums over the turns; `reads`: what the student learns from."""
        return summary(self.family, reads, self.rows, measured=self._information is not None, why=self.why)
