"""Words of a lesson: what a teacher sees in words, and its opening words."""

from gymnasium import spaces

from pz_envs.teacher_seat import PROSE
from teachers.atoms import FN, FP, SILENCE, Atom, Utterance
from worlds.spaces import Prose


def words_space() -> spaces.Dict:
    """The space of the world and the student's last action as text."""
    return spaces.Dict({"state": Prose(PROSE), "action": Prose(PROSE)})


def split(said: str, atoms: tuple[Atom, ...]) -> tuple[str, Utterance]:
    """An opening utterance as instruction and feedback: advice for the first action is feedback."""
    advice = [atom for atom in atoms if atom.kind in (FP, FN)]
    if not advice:
        return said, SILENCE
    return Utterance.of([atom for atom in atoms if atom.kind not in (FP, FN)]), Utterance.of(advice)
