"""Playing one episode of a study, with every claim checked against the simulator."""

import dataclasses
import json
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.registry import make
from llf_teacher.student import entitled, parse_student
from llf_teacher.studies.study import EpisodeSpec
from pz_envs.tutoring import STUDENT, TutoringEnv
from teachers.atoms import Atom, Moment, ParseFailure
from worlds.world import World

_STUDENT_STREAM = 1  # spawn key beside the environment's own


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
    """JSON: what was said, a list of objects with `kind`, `claim`, `fields`, `text`, `about_turn`, `holds`."""


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


class Record(NamedTuple):
    """A played episode."""

    spec: EpisodeSpec
    episode: EpisodeRow
    turns: tuple[TurnRow, ...]


def play(spec: EpisodeSpec) -> Record:
    """Play an episode; it stops at success, as LLF-Bench's evaluation does, unless the task is asked repeatedly."""
    player = parse_student(spec.student)
    env = make(
        spec.id,
        teacher=spec.teacher,
        instruction_type=spec.instruction_type,
        feedback_type=spec.feedback_type,
        max_turns=spec.max_turns,
        text=player.text,
    )
    aec, family = env.aec, env.family
    world = aec.world
    student = player.seat(family, world)
    student.reset(np.random.default_rng(np.random.SeedSequence(spec.seed, spawn_key=(_STUDENT_STREAM,))))
    oracle = family.oracle_class()(world.scratch)
    observation, info = env.reset(seed=spec.seed)
    oracle.start(aec.moment.after, np.random.default_rng(spec.seed))
    lab = world.scratch()
    moments = [aec.moment]
    rows = [_row(aec.moment, 0.0, _seen(aec), observation, info["atoms"], moments, lab)]
    done = False
    while not done:
        action = student.act(aec.observe(STUDENT), entitled(student, aec))
        observation, _, terminated, truncated, info = env.step(action)
        moment = aec.moment
        moments.append(moment)
        rows.append(_row(moment, oracle.regret(moment), _seen(aec), observation, info["atoms"], moments, lab))
        done = terminated or truncated or (moment.success and not family.repeated)
    env.close()
    return Record(spec, _summary(family.name, student.reads, rows), tuple(rows))


def _seen(aec: TutoringEnv) -> str:
    """The world as text, as the student sees it."""
    return aec.state_now if aec.text else aec.world.describe(aec.state_now)


def _row(
    moment: Moment,
    regret: float,
    text: str,
    observation: dict[str, Any],
    atoms: tuple[Atom, ...],
    moments: list[Moment],
    lab: World,
) -> TurnRow:
    failed = moment.action if type(moment.action) is ParseFailure else None
    return TurnRow(
        turn=moment.turn,
        observation=text,
        action=None if moment.before is None else to_json(moment.action),
        action_words=None if moment.before is None or isinstance(moment.action, str) else f"{moment.action}",
        reward=moment.reward,
        regret=regret,
        success=moment.success,
        parse_failure=failed and failed.got,
        instruction=str(observation["instruction"]) or None,
        feedback=str(observation["feedback"]),
        atoms=to_json([as_dict(atom, atom.claim.holds(moments[atom.about_turn], lab)) for atom in atoms]),
    )


def as_dict(atom: Atom, holds: bool) -> dict[str, Any]:
    """An atom as JSON values."""
    claim = atom.claim
    fields = {field.name: getattr(claim, field.name) for field in dataclasses.fields(claim)}  # type: ignore[arg-type]
    return {
        "kind": atom.kind,
        "claim": type(claim).__name__,
        "fields": fields,
        "text": atom.text,
        "about_turn": atom.about_turn,
        "holds": holds,
    }


def to_json(value: Any) -> str:
    """JSON of a value that may hold NumPy arrays and numbers."""
    return json.dumps(value, default=lambda item: item.tolist(), ensure_ascii=False)


def _summary(family: str, reads: str, rows: list[TurnRow]) -> EpisodeRow:
    said = [atom for row in rows for atom in json.loads(row.atoms) if atom["kind"] is not None]
    return EpisodeRow(
        family=family,
        reads=reads,
        turns=len(rows) - 1,
        success=rows[-1].success,
        first_success=next((row.turn for row in rows if row.success), None),
        total_reward=sum(row.reward for row in rows),
        regret=sum(row.regret for row in rows),
        parse_failures=sum(row.parse_failure is not None for row in rows),
        claims=len(said),
        claims_held=sum(atom["holds"] for atom in said),
        words=sum(len(row.feedback.split()) for row in rows),
    )
