"""The audit of a transcript from elsewhere: its actions are played again, and its sentences are checked."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from scipy.stats import binomtest

from llf_teacher.registry import entry, family
from llf_teacher.serialization import to_json
from pz_envs.reading import build_claim, make_reader, said_by
from pz_envs.subject import Subject
from pz_envs.text_mode import read_exactly
from teachers.atoms import Claim, Moment, ParseFailure
from teachers.reading import SentenceReading
from teachers.session import LONGEST, Session
from worlds.world import World

LONGEST_LINE, MOST_LINES = 262_144, 10_000
"""The most characters of a line, and lines of a transcript."""
READ, READ_RIGHT = 96, 91
"""How many sentences were read that no choice was made by, and how many of these right; all by the near layer.

Measured by `llf dev reading tests/reading/last.txt`. No sentence there is of the exact layer, which is taken to be no
better.
"""
LAYERS = ("exact", "near", "not read")
_HEADER = ("id", "family", "options", "seed", "observation", "feedback")
_TURN = ("action", "observation", "feedback")


class CheckedSentence(NamedTuple):
    """A sentence of a transcript with what became of it."""

    line: int
    turn: int
    text: str
    layer: str
    """One of `LAYERS`."""
    claim: str
    """The claim that was made of it; empty: it was not read."""
    holds: bool | None
    """Whether the claim is true; None: it was not read."""
    candidates: tuple[str, ...]
    """If it was not read, what came nearest, or why its claim cannot be checked."""


class TranscriptAudit(NamedTuple):
    """What was found in a transcript."""

    id: str
    turns: int
    sentences: tuple[CheckedSentence, ...]

    def count(self, layer: str | None = None, holds: bool | None = None) -> int:
        """Number of sentences of a layer, or of all; true or false ones only."""
        mine = [each for each in self.sentences if layer in (None, each.layer)]
        return len(mine) if holds is None else sum(each.holds is holds for each in mine)

    @property
    def share(self) -> tuple[float, float, float] | None:
        """The share of what was read that is false, and its interval; see `share_false`. None if nothing was read."""
        false, true = self.count(holds=False), self.count(holds=True)
        return (false / (false + true), *share_false(false, false + true)) if false + true else None

    def as_dict(self) -> dict[str, Any]:
        """The audit as JSON values."""
        share = self.share
        return {
            "id": self.id,
            "turns": self.turns,
            "false_share": share and dict(zip(("of_read", "low", "high"), share, strict=True)),
            "sentences": [each._asdict() for each in self.sentences],
        }


def share_false(false: int, read: int, right: int = READ_RIGHT, known: int = READ) -> tuple[float, float]:
    """An interval of at least 95 % for the share of a teacher's sentences that are false, by those that were read.

    Let p be the share of readings that are right, and a the share that is called false. Then a = p s (share of the
    sentences that are read right and false, s) + (1 - p) m, as in Rogan and Gladen, Estimating prevalence from the
    results of a screening test, American Journal of Epidemiology 107 (1978), 71-76. How often a misreading is called
    false, m, is not known, so that s lies between (a - (1 - p)) / p and a / p. Both a and p are uncertain: the bounds
    take the ends of an interval of 97.5 % (Clopper and Pearson, by quantiles of the beta distribution) for a, and the
    lower bound of 97.5 % for p, which together hold with 95 % (Bonferroni).

    Args:
        false: sentences that were read and called false.
        read: sentences that were read.
        right: readings that were right, of those whose truth is known.
        known: number of those.
    """
    called = binomtest(false, read).proportion_ci(0.975, "exact")
    p = binomtest(right, known, alternative="greater").proportion_ci(0.975, "exact").low
    if not p:
        return 0.0, 1.0
    return max(0.0, float((called.low - (1 - p)) / p)), min(1.0, float(called.high / p))


def audit_transcript(path: Path) -> TranscriptAudit:
    """Play a transcript again, and check each sentence.

    The first line is an object with `id` (or `family`), `options`, `seed`, and maybe `observation` and `feedback`; each
    further line is a turn, with `action`, and maybe `observation` and `feedback`, which the teacher said after it.
    Observations are compared with the world's, as JSON or as its text.

    Raises:
        ValueError: a line is not as it must be, or the simulator plays otherwise; the message has its number.
        OSError: the file cannot be read.
    """
    lines = _lines(path)
    number, header = next(lines, (1, None))
    try:
        if header is None:
            raise ValueError("a transcript must begin with a line that has id, options and seed, got an empty file")
        id, subject, options = _subject(_checked(header, _HEADER))
        world = subject.make_world(**options)
        session = Session(
            world,
            [subject.make_teacher(world)],
            max_turns=subject.turns(None, **options),
            instructs=True,
            repeated=subject.repeated,
        )
        replay = _Replay(subject, world, session)
        session.open(_seed(header))
        found = [*replay.checked(number, header)]
        for number, turn in lines:
            replay.act(_checked(turn, _TURN))
            found += replay.checked(number, turn)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path.name}, line {number}: {error}") from None
    return TranscriptAudit(id, session.moment.turn, tuple(found))


class _Replay:
    """A transcript that is played again."""

    def __init__(self, subject: Subject, world: World[Any, Any, Any], session: Session) -> None:
        self._subject, self._world, self._session = subject, world, session
        self._vocabulary = session.offers[0].vocabulary
        self._reader = make_reader(subject, self._vocabulary)
        self._moments: list[tuple[Moment[Any], tuple[Claim[Any], ...]]] = []  # with the oracle's own claims

    def act(self, turn: dict[str, Any]) -> None:
        """The student's action of a line."""
        if "action" not in turn:
            raise ValueError("a turn must have the key 'action'")
        action = turn["action"]
        if isinstance(action, str):
            action = read_exactly(action, self._world)
            if type(action) is ParseFailure:
                raise ValueError(f"action must be {self._world.action_syntax}, got {turn['action']!r:.80}")
        if self._session.over:
            raise ValueError(f"the episode ended with turn {self._session.moment.turn}; leave out the turns after it")
        self._session.act(action)

    def checked(self, number: int, line: dict[str, Any]) -> Iterator[CheckedSentence]:
        """The sentences of a line."""
        self._compare(line)
        self._session.speak()  # so that the teacher's oracle follows
        moment = self._session.moment
        oracle = self._session.teacher.oracle
        self._moments.append((moment, (*self._session.offers[0].claims(), *oracle.clues(moment.after))))
        words = line.get("feedback") or ""
        if not isinstance(words, str) or len(words) > LONGEST:
            raise ValueError(f"feedback must be a text of at most {LONGEST} characters, got {words!r:.80}")
        for reading in self._reader.read(words):
            yield self._check(number, reading)

    def _check(self, number: int, reading: SentenceReading) -> CheckedSentence:
        about = self._session.moment.turn if reading.about_turn is None else reading.about_turn
        place = number, self._session.moment.turn, reading.text
        if not 0 <= about < len(self._moments):
            return CheckedSentence(*place, "not read", "", None, (f"there is no turn {about} yet",))
        moment, own = self._moments[about]
        built = build_claim(reading, self._subject, self._vocabulary, moment)
        if built.claim is None:
            return CheckedSentence(*place, "not read", "", None, built.candidates)
        try:
            # Rounded as it is said, a number may be just wrong: what the oracle itself would say so is true.
            holds = bool(
                said_by(reading, self._subject, own) or built.claim.means(moment, self._session.teacher.oracle)
            )
        except Exception as error:  # the check of a claim need not be ready for any field
            return CheckedSentence(*place, "not read", "", None, (f"it cannot be checked: {error!s:.80}",))
        return CheckedSentence(*place, reading.layer, f"{built.claim}", holds, ())

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


def _lines(path: Path) -> Iterator[tuple[int, Any]]:
    """The lines that are not empty, each with its number and its JSON value."""
    with path.open(encoding="utf-8", errors="replace") as file:
        for number in range(1, MOST_LINES + 2):
            text = file.readline(LONGEST_LINE + 1)
            if not text:
                return
            where = f"{path.name}, line {number}:"
            if number > MOST_LINES:
                raise ValueError(f"{where} a transcript must have at most {MOST_LINES} lines; split it")
            if len(text) > LONGEST_LINE:
                raise ValueError(f"{where} a line must have at most {LONGEST_LINE} characters; this one is longer")
            if text.strip():
                try:
                    yield number, json.loads(text)
                except (ValueError, RecursionError):
                    raise ValueError(f"{where} each line must be a JSON object, got {text.strip()!r:.80}") from None


def _checked(line: Any, keys: tuple[str, ...]) -> dict[str, Any]:
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


def _seed(header: dict[str, Any]) -> int:
    seed = header.get("seed")
    if type(seed) is not int or seed < 0:
        raise ValueError(f"seed must be an integer of at least 0, got {seed!r:.80}")
    return seed
