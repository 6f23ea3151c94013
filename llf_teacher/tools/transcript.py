"""The audit of a transcript from elsewhere: its actions are played again, and its sentences are checked."""

import itertools
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.registry import entry, family
from llf_teacher.serialization import to_json
from pz_envs.checking import (
    ALONE,
    MODEL,
    NOT_READ,
    CheckedSentence,
    ClaimReader,
    Model,
    share_false,
)
from pz_envs.subject import Subject
from pz_envs.text_mode import failure, read_exactly
from teachers.atoms import ParseFailure
from teachers.schema import unique_keys
from teachers.session import Session
from teachers.teacher_turn import LONGEST
from worlds.world import World

LONGEST_LINE, MOST_LINES = 262_144, 10_000
"""The most characters of a line, and lines of a transcript."""
_MOST_UNREAD = 10
LAYERS = (*ALONE, MODEL, NOT_READ)
_HEADER = ("id", "family", "options", "seed", "max_turns", "observation", "feedback")
_TURN = ("action", "observation", "feedback")


class TranscriptSentence(NamedTuple):
    """A sentence of a transcript, with what became of it."""

    line: int
    turn: int
    checked: CheckedSentence

    @property
    def layer(self) -> str:
        """One of `LAYERS`."""
        return self.checked.layer or NOT_READ

    def as_dict(self) -> dict[str, Any]:
        """The sentence as JSON values; the claim is empty if there is none."""
        claim = "" if self.checked.claim is None else f"{self.checked.claim}"
        said = self.checked._asdict() | {"layer": self.layer, "claim": claim, "holds": self.checked.holds}
        return {"line": self.line, "turn": self.turn, **said}


class TranscriptAudit(NamedTuple):
    """What was found in a transcript."""

    id: str
    turns: int
    sentences: tuple[TranscriptSentence, ...]
    failures: tuple[int, ...] = ()
    """The lines whose action is none: the world did not step, and the turn counts."""
    problem: str = ""
    """Why nothing is judged from some line on; empty if all was."""

    def count(self, *layers: str, holds: bool | None = None) -> int:
        """Number of sentences of some layers, or of all; true or false ones only."""
        mine = [each.checked for each in self.sentences if not layers or each.layer in layers]
        return len(mine) if holds is None else sum(each.holds is holds for each in mine)

    @property
    def unread(self) -> list[tuple[str, str, int]]:
        """The sentences that no layer read, as they were said most often: text, outcome and number; at most ten."""
        found = Counter((each.checked.text, each.checked.outcome) for each in self.sentences if each.layer == NOT_READ)
        return [(text, outcome, number) for (text, outcome), number in found.most_common(_MOST_UNREAD)]

    @property
    def share(self) -> tuple[float, float, float] | None:
        """The share of what was read without a model that is false, and what it may be by errors of the reader.

        See `share_false`; of other episodes it says nothing. None if nothing was read so.
        """
        read = [(each.checked.text, each.checked.holds is False) for each in self.sentences if each.layer in ALONE]
        return (self.count(*ALONE, holds=False) / len(read), *share_false([read], here=True)) if read else None

    def as_dict(self) -> dict[str, Any]:
        """The audit as JSON values."""
        share = self.share
        return {
            "id": self.id,
            "turns": self.turns,
            "failures": self.failures,
            "problem": self.problem,
            "false_share": share and dict(zip(("of_read", "low", "high"), share, strict=True)),
            "unread": [dict(zip(("text", "outcome", "number"), each, strict=True)) for each in self.unread],
            "sentences": [each.as_dict() for each in self.sentences],
        }


def audit_transcript(path: Path, model: Model | None = None) -> TranscriptAudit:
    """Play a transcript again, and check each sentence.

    The first line is an object with `id` (or `family`), `options`, `seed`, and maybe `max_turns`, `observation` and
    `feedback`; each further line is a turn, with `action`, and maybe `observation` and `feedback`, which the teacher
    said after it. Observations are compared with the world's, as JSON or as its text. From a line on that is not as it
    must be, or where the simulator plays otherwise, nothing is judged; the audit's `problem` names it.

    Args:
        path: the transcript.
        model: reads sentences that are not near the phrases, see `pz_envs.checking`; it sees neither world nor turns.

    Raises:
        ValueError: the first line is not as it must be.
        OSError: the file cannot be read.
    """
    lines = _lines(path)
    number, problem = 1, ""
    try:
        number, text = next(lines, (1, ""))
        if not text:
            raise ValueError("a transcript must begin with a line that has id, options and seed, got an empty file")
        header = _checked(number, text, _HEADER)
        id, subject, options = _subject(header)
        world = subject.make_world(**options)
        session = Session(
            world,
            [subject.make_teacher(world)],
            max_turns=subject.turns(_integer(header, "max_turns", 1, None), **options),
            instructs=True,
            repeated=subject.repeated,
        )
        replay = _Replay(world, session, ClaimReader(subject, world, session.teacher.oracle, model))
        session.open(_integer(header, "seed", 0))
        found = [*replay.checked(number, header)]
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path.name}, line {number}: {error}") from None
    failures = []
    try:
        for number, text in lines:
            turn = _checked(number, text, _TURN)
            failures += [] if replay.act(turn) else [number]
            found += replay.checked(number, turn)
    except (ValueError, TypeError) as error:
        problem = f"{path.name}, line {number}: {error}"
    return TranscriptAudit(id, session.moment.turn, tuple(found), tuple(failures), problem)


class _Replay:
    """A transcript that is played again."""

    def __init__(self, world: World[Any, Any, Any], session: Session, reader: ClaimReader) -> None:
        self._world, self._session, self._reader = world, session, reader

    def act(self, turn: dict[str, Any]) -> bool:
        """The student's action of a line; whether it is one. If it is none, its turn counts."""
        if "action" not in turn:
            raise ValueError("a turn must have the key 'action'")
        if self._session.over:
            raise ValueError(
                f"the episode ended with turn {self._session.moment.turn}; leave out the turns after it, or say in the "
                "first line how many there can be (max_turns)"
            )
        given = turn["action"]
        try:
            action = read_exactly(given, self._world) if isinstance(given, str) else self._session.read(given)
        except (ValueError, TypeError, OverflowError):
            action = failure(f"{given!r:.80}", self._world)
        self._session.act(action)
        return type(action) is not ParseFailure

    def checked(self, number: int, line: dict[str, Any]) -> Iterator[TranscriptSentence]:
        """The sentences of a line."""
        self._compare(line)
        self._session.speak()  # so that the teacher's oracle follows
        self._reader.see(self._session.moment, self._session.teacher_turns[0].claims())
        words = "" if line.get("feedback") is None else line["feedback"]
        if not isinstance(words, str) or len(words) > LONGEST:
            raise ValueError(f"feedback must be a text of at most {LONGEST} characters, got {words!r:.80}")
        for each in self._reader.read(words):
            yield TranscriptSentence(number, self._session.moment.turn, each)

    def _compare(self, line: dict[str, Any]) -> None:
        if "observation" not in line:
            return
        given, state = line["observation"], self._session.state
        text, data = self._world.describe(state), json.loads(to_json(state))
        if given != data and given != text:
            raise ValueError(
                f"the observation differs: the world shows {text!r:.200}, the transcript has {given!r:.200}; "
                "options, seed and all actions must be those of the transcript, with the same version of the world"
            )


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines that are not empty, each with its number, and cut where it is too long."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number in itertools.count(1):
            if not (text := file.readline(LONGEST_LINE + 1)):
                return
            if text.strip():
                yield number, text


def _checked(number: int, text: str, keys: tuple[str, ...]) -> dict[str, Any]:
    """The JSON object of a line."""
    if number > MOST_LINES:
        raise ValueError(f"a transcript must have at most {MOST_LINES} lines; split it")
    if len(text) > LONGEST_LINE:
        raise ValueError(f"a line must have at most {LONGEST_LINE} characters; this one is longer")
    try:
        line = json.loads(text, object_pairs_hook=unique_keys)
    except (json.JSONDecodeError, RecursionError):
        line = text.strip()
    if not isinstance(line, dict):
        raise ValueError(f"each line must be a JSON object, got {line!r:.80}")
    if strange := [key for key in line if key not in keys]:
        raise ValueError(f"the key {strange[0]!r:.80} is unknown; allowed: {', '.join(keys)}")
    return line


def _subject(header: dict[str, Any]) -> tuple[str, Subject, dict[str, Any]]:
    """The name of what was taught, the subject, and all options of its world."""
    given = header.get("options", {})
    if not isinstance(given, dict):
        raise ValueError(f"options must be an object, got {given!r:.80}")
    if ("id" in header) == ("family" in header):
        raise ValueError(f"the first line must have either id or family, got the keys {', '.join(header) or 'none'}")
    if (name := header.get("family")) is not None:
        subject: Subject = family(str(name))
        return subject.name, subject, given
    found = entry(header["id"])
    return found.id, found.family, {**found.options, **given}


def _integer(header: dict[str, Any], name: str, least: int, *default: None) -> Any:
    if default and name not in header:
        return None
    value = header.get(name)
    if type(value) is not int or value < least:
        raise ValueError(f"{name} must be an integer of at least {least}, got {value!r:.80}")
    return value
