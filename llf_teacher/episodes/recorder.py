"""The recorder of an episode: its turns as they are stored, with every claim checked against the simulator."""

from typing import Any

from llf_teacher.episodes.record import EpisodeRow, TurnRow, as_dict, summary, unchecked
from llf_teacher.serialization import to_json
from pz_envs.student_view import StudentView
from teachers.atoms import Atom, Label, Moment, ParseFailure
from teachers.session import Turn

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

    def forget(self, turns: int = 0) -> None:
        """Keep so many of the first turns."""
        del self._moments[turns:], self.rows[turns:]

    def check(self, turn: Turn) -> tuple[tuple[Atom, Label], ...]:
        """What was said in a turn, each claim with its label; the turns before have to be checked before."""
        self._moments[turn.moment.turn :] = [turn.moment]
        oracle = self._view.session.teacher.oracle
        return tuple((atom, atom.label(self._moments, self._lab, oracle)) for atom in turn.atoms)

    def note(self, **answer: Any) -> TurnRow:
        """Note the session's last turn; `answer` has further columns, of what a model answered."""
        session = self._view.session
        turn, world = session.turn, session.world
        moment, feedback = turn.moment, str(turn.feedback)
        failed = moment.action if type(moment.action) is ParseFailure else None
        atoms = self.check(turn)
        row = TurnRow(
            turn=moment.turn,
            observation=world.describe(turn.state),
            action=None if moment.before is None else to_json(moment.action),
            action_words=None if moment.before is None or isinstance(moment.action, str) else f"{moment.action}",
            reward=moment.reward,
            regret=session.teacher.oracle.regret(moment) if moment.turn else 0.0,
            success=moment.success,
            parse_failure=failed and failed.got,
            instruction=str(turn.instruction) or None,
            feedback=feedback,
            atoms=[as_dict(atom, label, self.family) for atom, label in atoms],
            unchecked=unchecked(feedback, [atom.text for atom, _ in atoms]) or None,
            changes=len(getattr(self._speaker, "changes", ())) or None,
            unbuilt=sum(len(offer.unbuilt) for offer in session.offers) or None,
            withheld=len(getattr(self._speaker, "withheld", ())) or None,
        )._replace(**answer)
        self.rows.append(row)
        return row

    def episode(self, reads: str) -> EpisodeRow:
        """The sums over the turns; `reads`: what the student learns from."""
        return summary(self.family, reads, self.rows)
