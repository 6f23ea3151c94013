"""The record of an episode: what determines it, its turns, their sums, and their forms as JSON and as bytes."""

import dataclasses
import hashlib
import json
import math
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.models.asked import restored, shortened
from llf_teacher.models.replies import LENGTH
from llf_teacher.speakers.speaker import CUT, EMPTY, REPEATS
from teachers import common
from teachers.atoms import FP, KINDS, Atom, Claim, Label, action_of
from teachers.schema import sentences_of, storable, without

if TYPE_CHECKING:
    from pz_envs.text.claims import CheckedSentence
    from teachers.information import Bits


class EpisodeSpec(NamedTuple):
    """Everything that determines an episode."""

    id: str
    teacher: str
    student: str
    instruction_type: str
    feedback_type: str
    max_turns: int
    seed: int
    version: str
    """Version of this package, and of the distribution of the family; another version may play differently."""
    rules: str = ""
    """Versions of the tree of seeds and of the family's rules, as in `2.1`; only equal versions are comparable."""
    lessons: int = 0
    """Number of lessons before this episode; if above 0, the episode is a test without teacher and feedback."""
    taught: str = ""
    """Id of the environment of the lessons; empty without lessons."""
    worlds: str = ""
    """Worlds of the lessons, one of `llf_teacher.studies.definition.design.WORLDS`; empty without lessons."""
    sample: int = 0
    """Number of the sample; samples differ only in the student's random stream."""
    options: str = ""
    """Options of the environment, as JSON, beside its id's; empty: none."""
    draws: int = 0
    """Number of worlds for measuring the information of each claim, without effect on the lesson; 0: no measurement."""
    reader: str = "exact"
    """The reader of a teacher's own words, see `llf_teacher.speakers.parsing.parse_reader`; no effect on the lesson."""

    @property
    def key(self) -> str:
        """A digest that identifies the episode in a store."""
        fields = self._asdict()
        later = (name for name in _LATER if fields[name] == self._field_defaults[name])
        for name in (*(() if self.lessons else _OF_LESSONS), *later):
            del fields[name]
        return hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()[:32]


_OF_LESSONS = ("lessons", "taught", "worlds")
_LATER = ("sample", "options", "draws", "reader")
"""Newer fields, whose defaults leave the keys of older episodes unchanged."""


class TurnRow(NamedTuple):
    """One turn as it is stored; turn 0 is the opening."""

    turn: int
    observation: str
    """The world as text, as the student saw it after this turn."""
    action: str | None
    """JSON, in the form of `World.step`; null at the opening and for a text that was not an action."""
    action_words: str | None
    """The action in words; null if it is a text itself."""
    reward: float
    regret: float
    """The action's loss of value, in the family's unit; the negated reward if the oracle has no values."""
    success: bool
    parse_failure: str | None
    """The text that was not an action."""
    instruction: str | None
    feedback: str
    atoms: list[dict[str, Any]]
    """The claims that were said, each by `as_dict`; those of feedback have `information`, if it is measured."""
    answer: str | None = None
    """The answer of a model, without thoughts; this and the rest are null for students without a model."""
    thought: str | None = None
    """Its thoughts, if they are marked or separate."""
    finish: str | None = None
    """Why it ended; `length` if it was cut."""
    input_tokens: int | None = None
    """Null if the endpoint does not report it; likewise the next field."""
    output_tokens: int | None = None
    usd: float | None = None
    """Null if tokens or prices are unknown."""
    seconds: float | None = None
    """From the request to the answer, when the answer was paid for."""
    unchecked: int | None = None
    """Number of sentences of feedback without a claim; null if there are none, like the next field."""
    changes: int | None = None
    """Number of sentences in which a rewriting voice changed numbers or names."""
    invented: str | None = None
    """The turns of others that a model invented, cut from its answer; null if there are none."""
    unbuilt: int | None = None
    """Number of claims in messages that could not be made; null if there are none, like the next field."""
    withheld: int | None = None
    """Number of false claims that a teacher's filter kept back."""
    readings: list[dict[str, Any]] | None = None
    """The sentences of feedback in the teacher's own words, each by `reading_as_dict`; null if there are none."""
    paid: dict[str, Any] | None = None
    """The cost of a model in the teacher's seat: the fields of `Usage`; null without a model."""
    form: str | None = None
    """The form in which a model was asked for its answer: `json`, `tool` or `text`."""
    reply: dict[str, Any] | None = None
    """The answer of a model in the teacher's seat: the fields of `TeacherReply`; null without a model."""
    asked: dict[str, Any] | None = None
    """What a model in the student's seat was asked, see `llf_teacher.models.asked`; null without a model."""
    teacher_asked: dict[str, Any] | None = None
    """Likewise for the teacher's seat."""
    problems: list[str] | None = None
    """Why claims in messages could not be made, a reason for each; null if there are none."""


ASKED = ("asked", "teacher_asked")
"""The fields that have whole prompts, which tables leave out."""


class EpisodeRow(NamedTuple):
    """One episode as it is stored."""

    family: str
    reads: str
    """What the student reads."""
    turns: int
    success: bool
    """Success at the last turn."""
    first_success: int | None
    """The turn of the first success."""
    total_reward: float
    regret: float
    """Sum of the turns' regrets, in the family's unit."""
    parse_failures: int
    claims: int
    """Number of atoms with a kind of feedback; with `p` also those of the instruction."""
    claims_held: int
    """Number of these that hold; hedged claims are left out, also in `distorted`."""
    words: int
    """Number of words of feedback."""
    said_r: int
    """Number of claims by kind."""
    said_hp: int
    said_hn: int
    said_fp: int
    said_fn: int
    truthful: int
    """Number of claims by label; the rest of `claims` is hedged."""
    late: int
    placebo: int
    distorted: int
    unchecked: int
    """Number of sentences of feedback without a claim, from models, persons and custom policies."""
    changes: int
    """Number of sentences in which a rewriting voice changed numbers or names."""
    advised: int
    """Number of turns after advice of an action."""
    followed: int
    """Number of these turns with an advised action of the student."""
    answers: int | None
    """Number of answers of a model; this and the costs are null for students without a model."""
    truncated: int | None
    """Number of answers that were cut at the greatest length."""
    input_tokens: int | None
    """Sum over the answers, like the next fields; null if one is unknown."""
    output_tokens: int | None
    usd: float | None
    seconds: float | None
    regrets: bytes
    """The regret of each turn, packed by `pack_regrets`."""
    unbuilt: int | None = None
    """Number of claims in messages that could not be made."""
    withheld: int | None = None
    """Number of false claims that a teacher's filter kept back."""
    teacher_answers: int | None = None
    """Number of answers of a model in the teacher's seat; null, like the next fields, without such a model."""
    teacher_cut: int | None = None
    """Number of these that were cut at the greatest length."""
    teacher_empty: int | None = None
    """Number of these that say nothing."""
    teacher_repeats: int | None = None
    """Number of these that repeat what the student sees."""
    teacher_seconds: float | None = None
    """Time from the requests to the answers."""
    read_exact: int | None = None
    """Number of sentences in the teacher's own words that the phrases read, and whose claim was checked; null, as all
    of `READINGS`, if there was nothing to read, or it was not to be read.
    """
    read_false: int | None = None
    """Number of these whose claim is false."""
    read_model: int | None = None
    """Likewise by a model."""
    model_false: int | None = None
    """Number of these whose claim is false."""
    unread: int | None = None
    """Number of the other sentences: not read, hedged, or without a single claim that can be checked."""
    measured: int | None = None
    """Number of claims of feedback with measured information, see `teachers.information.Gain`; null, like all following
    fields, without a measurement.
    """
    unmeasured: int | None = None
    """Number of claims without a measurement: too few worlds were found."""
    bits: float | None = None
    """Sum of their bits."""
    at_least: int | None = None
    """Number of claims whose bits are only a bound from below."""
    measured_words: int | None = None
    """Number of words of the measured claims."""
    valued: int | None = None
    """Number of measured claims with known savings."""
    valued_bits: float | None = None
    """Sum of the bits of these claims."""
    saved: float | None = None
    """Sum of the regret that they save in the next action, in the family's unit."""
    bits_r: float | None = None
    """Sum of bits by kind."""
    bits_hp: float | None = None
    bits_hn: float | None = None
    bits_fp: float | None = None
    bits_fn: float | None = None
    why: str = ""
    """Why the information could not be measured; empty if it was measured, or not requested."""


class Record(NamedTuple):
    """A played episode."""

    spec: EpisodeSpec
    episode: EpisodeRow
    turns: tuple[TurnRow, ...]


READINGS = ("read_exact", "read_false", "read_model", "model_false", "unread")
"""Columns about readings of a teacher's own words."""


_COMMON = f"{common.__name__}."


def unchecked(feedback: str, texts: Iterable[str]) -> int:
    """Number of sentences of feedback that are not texts of claims."""
    return len(sentences_of(without(feedback, texts)))


def claim_name(claim: Claim, family: str) -> str:
    """The name of a claim's class with its family, or with `common` for claims of all families."""
    home = "common" if type(claim).__module__.startswith(_COMMON) else family
    return f"{home}.{type(claim).__name__}"


def as_dict(
    atom: Atom, label: Label, holds: bool, family: str, bits: "Bits | None" = None, elsewhere: bool | None = None
) -> dict[str, Any]:
    """An atom as JSON values.

    `claim` is as in `claim_name`; `action` is the action of the claim, for a plan the first one; null without an
    action. A hedged claim contains the hedged one as a field; `holds` then says whether that holds. `information`, the
    bits of the atom and the fields of `Bits`, is present only if it was measured; `elsewhere`, whether the claim holds
    of the moment from which it was taken, only if that is another lesson's. `holds` and `label` are always of this one.
    """
    return {
        "kind": _plain(atom.kind),
        **_as_data(atom.claim, family),
        "action": _plain(action_of(atom.claim)),
        "text": str(atom.text),
        "about_turn": atom.about_turn,
        "holds": holds,
        "label": label.value,
        **({} if bits is None else {"information": {"bits": bits.bits, **bits._asdict()}}),
        **({} if elsewhere is None else {"elsewhere": elsewhere}),
    }


def reading_as_dict(sentence: "CheckedSentence", family: str) -> dict[str, Any]:
    """A sentence in the teacher's own words as JSON values: its fields, `holds`, and the claim as for an atom."""
    known = sentence.claim
    claim = {"kind": None} if known is None else {"kind": _plain(known.kind), **_as_data(known, family)}
    return sentence._asdict() | {"candidates": list(sentence.candidates), "holds": sentence.holds, **claim}


def _as_data(claim: Claim, family: str) -> dict[str, Any]:
    """The name and the fields of a claim as JSON values."""
    values = {field.name: getattr(claim, field.name) for field in dataclasses.fields(claim)}  # type: ignore[arg-type]
    fields = {
        name: _as_data(value, family) if isinstance(value, Claim) else _plain(value) for name, value in values.items()
    }
    return {"claim": claim_name(claim, family), "fields": fields}


def _plain(value: Any) -> Any:
    """A value of a claim as JSON's."""
    if isinstance(value, Enum):
        return value.value
    return list(map(_plain, value)) if isinstance(value, tuple) else value


def summary(family: str, reads: str, rows: Sequence[TurnRow], *, measured: bool = False, why: str = "") -> EpisodeRow:
    """The sums of an episode's turns.

    Args:
        family: the family's name.
        reads: what the student reads.
        rows: the turns.
        measured: whether the information of claims was measured.
        why: why it could not be measured.
    """
    heard = [[atom for atom in row.atoms if atom["kind"] is not None] for row in rows]
    said = [atom for atoms in heard for atom in atoms]
    kinds, labels = (Counter(atom[name] for atom in said) for name in ("kind", "label"))
    advice = [
        [atom["action"] for atom in atoms if _advises(atom, row.turn)] for row, atoms in zip(rows, heard, strict=True)
    ]
    taken = [None if row.action is None else json.loads(row.action) for row in rows[1:]]
    return EpisodeRow(
        family=family,
        reads=reads,
        turns=len(rows) - 1,
        success=rows[-1].success,
        first_success=next((row.turn for row in rows if row.success), None),
        total_reward=math.fsum(row.reward for row in rows),
        regret=math.fsum(row.regret for row in rows),
        parse_failures=sum(row.parse_failure is not None for row in rows),
        claims=len(said),
        claims_held=sum(atom["holds"] and atom["label"] != Label.HEDGED for atom in said),
        words=sum(len(row.feedback.split()) for row in rows),
        **{f"said_{kind}": kinds[kind] for kind in KINDS},
        truthful=labels[Label.TRUTHFUL],
        late=labels[Label.LATE],
        placebo=labels[Label.PLACEBO],
        distorted=labels[Label.DISTORTED],
        unchecked=sum(row.unchecked or 0 for row in rows),
        changes=sum(row.changes or 0 for row in rows),
        advised=sum(map(bool, advice[:-1])),
        followed=sum(action in actions for actions, action in zip(advice[:-1], taken, strict=True)),
        **_costs([row for row in rows if row.answer is not None]),
        regrets=pack_regrets([row.regret for row in rows[1:]]),
        unbuilt=sum(row.unbuilt or 0 for row in rows),
        withheld=sum(row.withheld or 0 for row in rows),
        **_replies([row.reply for row in rows if row.reply is not None]),
        **_readings(rows),
        **(_gains(said, rows) if measured else {}),
        why=why,
    )


def _readings(rows: Sequence[TurnRow]) -> dict[str, Any]:
    """The readings of the teacher's own words; empty without any."""
    read = [each for row in rows for each in row.readings or ()]
    if not read:
        return {}
    layers, false = (
        Counter(each["layer"] for each in read if each["layer"] and holds in (None, each["holds"]))
        for holds in (None, False)
    )
    return {
        "read_exact": layers["exact"],
        "read_false": false["exact"],
        "read_model": layers["model"],
        "model_false": false["model"],
        "unread": len(read) - layers.total(),
    }


def _gains(said: Sequence[Mapping[str, Any]], rows: Sequence[TurnRow]) -> dict[str, Any]:
    """The sums of the information of claims, if it was measured."""
    from teachers.information import Bits, Gain

    total, kinds = Gain(), dict.fromkeys(KINDS, 0.0)
    for atom in said:
        if "information" in atom:
            gain = Gain.of(atom["text"], Bits._make(map(atom["information"].get, Bits._fields)))
            total, kinds[atom["kind"]] = total + gain, kinds[atom["kind"]] + gain.bits
    if any("information" in atom and not atom["text"] for atom in said):  # their words are unknown: count all
        total = total._replace(words=sum(len(row.feedback.split()) for row in rows))
    sums = total._asdict()
    named = {"claims": "measured", "unknown": "unmeasured", "words": "measured_words"}
    return {named.get(name, name): value for name, value in sums.items()} | {
        f"bits_{kind}": bits for kind, bits in kinds.items()
    }


def _replies(replies: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The sums over the answers of a model in the teacher's seat; empty without one."""
    if not replies:
        return {}
    faults = Counter(fault for reply in replies for fault in reply["faults"])
    sums: dict[str, Any] = {f"teacher_{fault}": faults[fault] for fault in (CUT, EMPTY, REPEATS)}
    return {
        "teacher_answers": len(replies),
        **sums,
        "teacher_seconds": math.fsum(reply["seconds"] for reply in replies),
    }


def _costs(rows: Sequence[TurnRow]) -> dict[str, Any]:
    """The sums of the costs of a model's answers."""
    sums: dict[str, Any] = dict.fromkeys(("answers", "truncated", *_SUMMED))
    if rows:
        sums |= {"answers": len(rows), "truncated": sum(row.finish == LENGTH for row in rows)}
        for name, add in _SUMMED.items():
            values = [getattr(row, name) for row in rows]
            sums[name] = None if None in values else add(values)
    return sums


_SUMMED: dict[str, Callable[[list[Any]], float]] = {
    "input_tokens": sum,
    "output_tokens": sum,
    "usd": math.fsum,
    "seconds": math.fsum,
}


def _advises(atom: Mapping[str, Any], turn: int) -> bool:
    """Whether an atom of a turn advises an action for the next one."""
    return atom["kind"] == FP and atom["about_turn"] == turn and atom["action"] is not None


def pack_regrets(regrets: Sequence[float]) -> bytes:
    """The regret of each turn as compressed doubles."""
    return zlib.compress(np.array(regrets, "<f8").tobytes())


def unpack_regrets(packed: bytes) -> NDArray[np.float64]:
    """The regret of each turn, the opening not included; shape (turns,).

    Raises:
        ValueError: the bytes are damaged.
    """
    try:
        return np.frombuffer(zlib.decompress(packed), "<f8")
    except zlib.error as error:
        raise ValueError(f"the regrets of an episode cannot be read, {error}; `llf study check` names it") from None


def turns_as_dicts(rows: Iterable[TurnRow]) -> list[dict[str, Any]]:
    """Turns as JSON values, without null fields."""
    return [{name: value for name, value in row._asdict().items() if value is not None} for row in rows]


def pack_turns(rows: Iterable[TurnRow]) -> bytes:
    """Turns as compressed JSON, without null fields, and without what a prompt shares with the one before."""
    turns = turns_as_dicts(rows)
    for name in ASKED:
        short = shortened([turn.get(name) for turn in turns])
        turns = [turn if each is None else turn | {name: each} for turn, each in zip(turns, short, strict=True)]
    text = json.dumps(turns, ensure_ascii=False, separators=(",", ":"))
    return zlib.compress(storable(text).encode(), 9)


def unpack_turns(packed: bytes) -> list[dict[str, Any]]:
    """Unpack turns, with all fields of `TurnRow`; `action` and `atoms` are decoded."""
    turns = [dict.fromkeys(TurnRow._fields) | turn for turn in json.loads(zlib.decompress(packed))]
    for name in ASKED:
        for turn, asked in zip(turns, restored([turn[name] for turn in turns]), strict=True):
            turn[name] = asked
    for turn in turns:
        turn["action"] = None if turn["action"] is None else json.loads(turn["action"])
    return turns
