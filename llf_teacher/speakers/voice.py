"""voice(tone): words a personality's claims in one of the built-in tones: `curt`, `socratic`, `warm`."""

from dataclasses import dataclass

from llf_teacher.speakers.speaker import Wording
from teachers.spec import unknown
from teachers.voice import PLAIN, voice_names


@dataclass(frozen=True)
class Toned(Wording):
    """One of the voices that come with the package."""

    tone: str = PLAIN
    """Name of the voice."""
    own_words = False

    def __post_init__(self) -> None:
        if self.tone not in voice_names():
            raise ValueError(unknown("voice", self.tone, voice_names()))

    def voice(self) -> str:
        """The name of the voice."""
        return self.tone
