"""Golden transcripts: readable records of one short episode an environment, which tests replay."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from llf_teacher.gym import make
from llf_teacher.registry import entries
from llf_teacher.serialization import to_json
from teachers.atoms import Atom, Moment
from worlds.world import World

SEED, TURNS = 7, 6


def transcript(id: str, seed: int = SEED, turns: int = TURNS) -> str:
    """An episode as text: a student that obeys every second turn, a teacher that says everything.

    The instruction is complete (`c`), so that its claims are in the record, too.
    """
    env = make(id, instruction_type="c", max_turns=turns)
    world, family = env.aec.world, env.family
    lab = world.scratch()
    rng = np.random.default_rng(seed)
    observation, info = env.reset(seed=seed)
    moments = [env.aec.moment]
    lines = [f"environment: {id}", f"seed: {seed}", "", "== opening", f"instruction: {observation['instruction']!r}"]
    lines += _seen(world.describe(observation["observation"]), observation["feedback"], info["atoms"], moments, lab)
    for turn in range(1, turns + 1):
        plan = env.teacher.oracle.plan(moments[-1].after, 1) if turn % 2 == 0 else ()
        action = plan[0] if plan else world.sample_action(rng)
        observation, reward, _, _, info = env.step(action)
        moments.append(env.aec.moment)
        lines += [
            "",
            f"== turn {turn}",
            f"action: {to_json(action)}",
            f"reward: {reward!r}",
            f"success: {info['success']}",
        ]
        lines += _seen(world.describe(observation["observation"]), observation["feedback"], info["atoms"], moments, lab)
        if info["success"] and not family.repeated:
            break
    env.close()
    return "\n".join(lines) + "\n"


def _seen(text: str, feedback: str, atoms: tuple[Atom, ...], moments: list[Moment[Any]], lab: World[Any]) -> list[str]:
    lines = [f"observation: {text!r}", f"feedback: {feedback!r}"]
    for atom in atoms:
        claim = atom.claim
        said = {field.name: getattr(claim, field.name) for field in dataclasses.fields(claim)}  # type: ignore[arg-type]
        held = "holds" if claim.holds(moments[atom.about_turn], lab) else "FALSE"
        lines.append(f"  {atom.kind or '-':2} {type(claim).__name__} {to_json(said)} {held}")
    return lines


def write(folder: Path, which: tuple[str, ...] = ()) -> list[Path]:
    """Write transcripts of the given environments, or of all that are sampled; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for id in which or [each.id for each in entries().values() if each.sampled and not each.family.missing()]:
        path = folder / f"{id}.txt"
        path.write_text(transcript(id), encoding="utf-8")
        paths.append(path)
    return paths
