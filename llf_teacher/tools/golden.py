"""Golden transcripts: for each environment a readable record of a short episode, which the tests replay."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv, make
from llf_teacher.registry import entries, supported_types
from llf_teacher.serialization import to_json
from teachers.atoms import Atom, Moment
from worlds.world import World

SEED, TURNS, MISALIGNED_TURNS = 7, 6, 2


def transcript(id: str, seed: int = SEED, turns: int = TURNS) -> str:
    """An episode as text: the student follows the plan in every second turn, the teacher gives all feedback.

    The instruction is complete (`c`) if possible, so that the record has its claims, too. At the end is the feedback of
    a misaligned teacher in the first turns.
    """
    types = supported_types(id)[0]
    env = make(id, instruction_type="c" if "c" in types else types[-1], max_turns=turns)
    session = env.session
    moments: list[Moment[Any]] = []
    lab = session.world.scratch()
    lines = [f"environment: {id}", f"seed: {seed}"]
    for turn in play_turns(env, _Follower(env), seed):
        moments.append(turn.moment)
        lines.append("")
        if turn.moment.turn:
            lines += [
                f"== turn {turn.moment.turn}",
                f"action: {to_json(turn.moment.action)}",
                f"reward: {turn.moment.reward!r}",
                f"success: {turn.moment.success}",
            ]
        else:
            lines += ["== opening", f"instruction: {turn.instruction!r}"]
        lines += _seen(session.world.describe(turn.state), turn.feedback, turn.atoms, moments, lab)
    env.close()
    return "\n".join(lines + _misaligned(id, seed)) + "\n"


def _misaligned(id: str, seed: int) -> list[str]:
    env = make(id, max_turns=MISALIGNED_TURNS, teacher="misaligned")
    lab = env.session.world.scratch()
    lines: list[str] = []
    for turn in play_turns(env, _Follower(env), seed):
        lines += ["", f"== misaligned, turn {turn.moment.turn}", f"feedback: {str(turn.feedback)!r}"]
        for atom in turn.atoms:
            there = env.session.origin(atom)
            if there is not None:
                held = "holds elsewhere" if atom.claim.holds(there, lab) else "FALSE"
                lines.append(f"{_claim(atom)} {held}, {'and' if atom.claim.holds(turn.moment, lab) else 'not'} here")
    env.close()
    return lines


class _Follower:
    """Takes the first action of the oracle's plan in every second turn, a random one in the others."""

    def __init__(self, env: StudentEnv) -> None:
        self._session = env.session

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""
        self._rng = np.random.default_rng(SEED)

    def act(self, observation: Any, info: dict[str, Any]) -> Any:
        """The action."""
        session = self._session
        plan = session.teacher.oracle.plan(session.moment.after, 1) if session.moment.turn % 2 else ()
        return plan[0] if plan else session.world.sample_action(self._rng)


def _seen(text: str, feedback: str, atoms: tuple[Atom, ...], moments: list[Moment[Any]], lab: World[Any]) -> list[str]:
    lines = [f"observation: {text!r}", f"feedback: {feedback!r}"]
    for atom in atoms:
        held = "holds" if atom.claim.holds(moments[atom.about_turn], lab) else "FALSE"
        lines.append(f"{_claim(atom)} {held}")
    return lines


def _claim(atom: Atom) -> str:
    claim = atom.claim
    said = {field.name: getattr(claim, field.name) for field in dataclasses.fields(claim)}  # type: ignore[arg-type]
    return f"  {atom.kind or '-':2} {type(claim).__name__} {to_json(said)}"


def write(folder: Path, which: tuple[str, ...] = ()) -> list[Path]:
    """Write transcripts of the given environments, or of all sampled ones; returns the written files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for id in which or [each.id for each in entries().values() if each.sampled and not each.family.missing()]:
        path = folder / f"{id}.txt"
        path.write_text(transcript(id), encoding="utf-8")
        paths.append(path)
    return paths
