"""Playing one episode of a study, with every claim checked against the simulator."""

import dataclasses
import json
import math
import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.gym import StudentEnv, make
from llf_teacher.models.replies import LENGTH
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.design import TEST_TYPE, TESTER
from llf_teacher.studies.lessons import attend
from llf_teacher.studies.options import read_options
from llf_teacher.studies.own import arguments_of, parse_teacher
from llf_teacher.studies.study import EpisodeSpec
from pz_envs.seatings.tutoring.env import TutoringEnv
from pz_envs.seats import STUDENT, entitled
from teachers import common
from teachers.atoms import FP, KINDS, Atom, Label, Moment, ParseFailure, action_of
from teachers.seeds import Seeds


class TurnRow(NamedTuple):
    """One turn as it is stored; turn 0 is the opening."""

    turn: int
    observation: str
    """The world as text, as the student saw it after this turn."""
    action: str | None
    """JSON, in the form that `World.step` takes; null at the opening and for a text that was no action."""
    action_words: str | None
    """The action in words, where it is not itself a text."""
    reward: float
    regret: float
    success: bool
    parse_failure: str | None
    """What was received instead of an action."""
    instruction: str | None
    feedback: str
    atoms: str
    """JSON: what was said, a list of objects as `as_dict` makes them."""
    answer: str | None = None
    """What a model answered, without thoughts; this and the rest is null of students that ask none."""
    thought: str | None = None
    """What it thought before, where that was marked or given apart."""
    finish: str | None = None
    """Why it ended; `length` if it was cut."""
    input_tokens: int | None = None
    """Null if the endpoint does not say, as is the next."""
    output_tokens: int | None = None
    usd: float | None = None
    """Null if tokens or prices are unknown."""
    seconds: float | None = None
    """From asking to having the answer, when it was paid for."""
    unchecked: int | None = None
    """Sentences of feedback that no claim vouches for; null if there are none, as is the next."""
    changes: int | None = None
    """Sentences in which a rewriting voice changed numbers or names."""


class EpisodeRow(NamedTuple):
    """One episode as it is stored."""

    family: str
    reads: str
    """What the student learns from."""
    turns: int
    success: bool
    """Success at the last turn."""
    first_success: int | None
    """The turn of the first success."""
    total_reward: float
    regret: float
    """Sum over the turns, in the family's unit."""
    parse_failures: int
    claims: int
    """Atoms of some kind of feedback; with `p` the instruction has some, too."""
    claims_held: int
    words: int
    """Words of feedback."""
    said_r: int
    """Claims by kind."""
    said_hp: int
    said_hn: int
    said_fp: int
    said_fn: int
    truthful: int
    """Claims by label."""
    late: int
    placebo: int
    distorted: int
    unchecked: int
    """Sentences of feedback without a claim, of models, persons and policies of one's own."""
    changes: int
    """Sentences in which a rewriting voice changed numbers or names."""
    advised: int
    """Turns before which the teacher advised actions."""
    followed: int
    """Those of them in which the student took one."""
    answers: int | None
    """Answers of a model; this and the rest is null of students that ask none."""
    truncated: int | None
    """Those of them that were cut for their length."""
    input_tokens: int | None
    """Sum over the answers, as are the next; null if one is unknown."""
    output_tokens: int | None
    usd: float | None
    seconds: float | None
    regrets: bytes
    """Of each turn, as `pack_regrets` makes them."""


class Record(NamedTuple):
    """A played episode."""

    spec: EpisodeSpec
    episode: EpisodeRow
    turns: tuple[TurnRow, ...]


class Scene(NamedTuple):
    """One turn as it was played; the first is the opening."""

    moment: Moment[Any]
    observation: dict[str, Any]
    """The student's, as `StudentEnv` gives it."""
    atoms: tuple[tuple[Atom, Label], ...]
    """What was said, with what the simulator says of it."""


def scenes(
    env: StudentEnv, student: Any, seed: int, options: dict[str, Any] | None = None, sample: int = 0
) -> Iterator[Scene]:
    """Play an episode and check what is said; it stops at success, as LLF-Bench's evaluation does, unless the task is
    asked repeatedly.

    Args:
        env: with a teacher in the other seat.
        student: a policy with `reset(rng)` and `act(observation, info)`.
        seed: of the episode, for all who take part.
        options: those of the world's `reset`.
        sample: which of the streams that the student may draw from.
    """  # noqa: D205
    aec = env.aec
    lab = aec.world.scratch()
    student.reset(Seeds(seed).stream("student", sample))
    observation, info = env.reset(seed=seed, options=options)
    moments = [aec.moment]
    done = False
    while True:
        yield Scene(aec.moment, observation, tuple((atom, atom.label(moments, lab)) for atom in info["atoms"]))
        if done:
            break
        action = student.act(aec.observe(STUDENT), entitled(student, aec))
        observation, _, _, _, info = env.step(action)
        moments.append(aec.moment)
        done = env.family.is_over(aec.moment)


def play(spec: EpisodeSpec, begins: Callable[[int], object] = abs) -> Record:
    """Play an episode of a study, and account for it; the lessons before a test are played, and not told of.

    Args:
        spec: the episode.
        begins: is called with the number of each turn that begins.
    """
    player = parse_student(spec.student)
    teacher, feedback_type = (TESTER, TEST_TYPE) if spec.lessons else (spec.teacher, spec.feedback_type)
    env = make(
        spec.id,
        **arguments_of(parse_teacher(teacher), feedback_type),
        instruction_type=spec.instruction_type,
        feedback_type=feedback_type,
        max_turns=spec.max_turns,
        text=player.text,
        **read_options(spec.options, spec.id, player.text),
    )
    student = player.seat(env.family, env.aec.world)
    if spec.lessons:
        attend(spec, player, student)
    rows = []
    for scene in scenes(env, student, spec.seed, sample=spec.sample):
        turn = scene.moment.turn
        said = student.record() if turn else {}
        rows.append(turn_row(env.aec, env.family.name, scene, env.teacher)._replace(**said))
        begins(turn + 1)
    env.close()
    return Record(spec, summary(env.family.name, student.reads, rows), tuple(rows))


def turn_row(aec: TutoringEnv, family: str, scene: Scene, speaker: Any = None) -> TurnRow:
    """The turn that has just been played, as it is stored; the `changes` of the speaker are counted, if it has any."""
    moment = scene.moment
    failed = moment.action if type(moment.action) is ParseFailure else None
    return TurnRow(
        turn=moment.turn,
        observation=aec.state_now if aec.text else aec.world.describe(aec.state_now),
        action=None if moment.before is None else to_json(moment.action),
        action_words=None if moment.before is None or isinstance(moment.action, str) else f"{moment.action}",
        reward=moment.reward,
        regret=aec.teacher.oracle.regret(moment) if moment.turn else 0.0,
        success=moment.success,
        parse_failure=failed and failed.got,
        instruction=str(scene.observation["instruction"]) or None,
        feedback=str(scene.observation["feedback"]),
        atoms=to_json([as_dict(atom, label, family) for atom, label in scene.atoms]),
        unchecked=unchecked(str(scene.observation["feedback"]), [atom.text for atom, _ in scene.atoms]) or None,
        changes=len(getattr(speaker, "changes", ())) or None,
    )


def unchecked(feedback: str, texts: Iterable[str]) -> int:
    """The number of sentences of what was said that are not among those of claims."""
    for text in texts:
        feedback = feedback.replace(text, "", 1)
    return sum(any(map(str.isalnum, sentence)) for sentence in _SENTENCES.split(feedback))


_SENTENCES = re.compile(r"(?<=[.!?])[\"')\]]*\s+|\n+")


def as_dict(atom: Atom, label: Label, family: str) -> dict[str, Any]:
    """An atom as JSON values.

    `claim` names the claim's class with its family, or with `common` if any teacher makes such claims; `action` is the
    action that it is about, of a plan the first one, null if it is about none.
    """
    claim = atom.claim
    home = "common" if type(claim).__module__ == common.__name__ else family
    fields = {field.name: getattr(claim, field.name) for field in dataclasses.fields(claim)}  # type: ignore[arg-type]
    return {
        "kind": atom.kind,
        "claim": f"{home}.{type(claim).__name__}",
        "fields": fields,
        "action": action_of(claim),
        "text": atom.text,
        "about_turn": atom.about_turn,
        "holds": label is not Label.DISTORTED,
        "label": label,
    }


def to_json(value: Any) -> str:
    """JSON of a value that may hold NumPy arrays and numbers."""
    return json.dumps(value, default=lambda item: item.tolist(), ensure_ascii=False)


def summary(family: str, reads: str, rows: Sequence[TurnRow]) -> EpisodeRow:
    """What is told of an episode as a whole."""
    heard = [[atom for atom in json.loads(row.atoms) if atom["kind"] is not None] for row in rows]
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
        claims_held=sum(atom["holds"] for atom in said),
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
    )


def _costs(rows: Sequence[TurnRow]) -> dict[str, Any]:
    """What the answers of a model cost in all."""
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
    """Whether an atom that is said at a turn advises an action for the next one."""
    return atom["kind"] == FP and atom["about_turn"] == turn and atom["action"] is not None


def pack_regrets(regrets: Sequence[float]) -> bytes:
    """Doubles of the regret of each turn, compressed."""
    return zlib.compress(np.array(regrets, "<f8").tobytes())


def unpack_regrets(packed: bytes) -> NDArray[np.float64]:
    """The regret of each turn, the opening not included; shape (turns,)."""
    return np.frombuffer(zlib.decompress(packed), "<f8")


def turns_as_dicts(rows: Iterable[TurnRow]) -> list[dict[str, Any]]:
    """Turns as JSON values, without what is null."""
    turns = [{name: value for name, value in row._asdict().items() if value is not None} for row in rows]
    for turn in turns:
        turn["atoms"] = json.loads(turn["atoms"])
    return turns


def pack_turns(rows: Iterable[TurnRow]) -> bytes:
    """Turns as JSON, without what is null, compressed."""
    return zlib.compress(json.dumps(turns_as_dicts(rows), ensure_ascii=False, separators=(",", ":")).encode(), 9)


def unpack_turns(packed: bytes) -> list[dict[str, Any]]:
    """The turns, with all fields of `TurnRow`, `action` and `atoms` decoded."""
    turns = [dict.fromkeys(TurnRow._fields) | turn for turn in json.loads(zlib.decompress(packed))]
    for turn in turns:
        turn["action"] = None if turn["action"] is None else json.loads(turn["action"])
    return turns
