"""Pictures of a few episodes for the documents, and their hashes, which ignore small differences, for the tests."""

import contextlib
import time
import tomllib
from collections.abc import Collection
from pathlib import Path

import numpy as np
from PIL import Image

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import PREFIX
from pz_envs.family import all_families
from worlds.pictures.canvas import Frame

__all__ = ["GOLDEN", "contact_sheet", "dhash", "frame_rate", "sample", "write"]

GOLDEN = "pictures.toml"
_SEED, _TURNS = 7, 5


def sample(environment: str, *, theme: str = "light", privileged: bool = True) -> Frame:
    """A frame of the fifth turn; the first and the third action are random, the others follow the plan."""
    env = StudentEnv(
        f"{PREFIX}{environment}", render_mode="rgb_array", privileged_info=privileged, theme=theme, paraphrase=0
    )
    env.reset(seed=_SEED)
    rng = np.random.default_rng(_SEED)
    for turn in range(_TURNS):
        plan = env.session.teacher.oracle.plan(env.session.moment.after, 1) if turn not in (0, 2) else ()
        action = plan[0] if plan else env.session.world.sample_action(rng)
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            break
    frame: Frame = env.render()
    env.close()
    return frame


def dhash(frame: Frame) -> str:
    """A hash of 64 bits, in hexadecimal: whether each of 8 x 8 parts is darker than its neighbour to the right."""
    small = np.asarray(Image.fromarray(frame).convert("L").resize((9, 8), Image.Resampling.BOX), float)
    bits = (small[:, 1:] > small[:, :-1]).ravel()
    return f"{int(''.join('01'[bit] for bit in bits.astype(int)), 2):016x}"


def write(folder: Path, which: Collection[str] = ()) -> Path:
    """Write the hash of a frame of each family's first showcase, or only for the given ids.

    Other families, and families that cannot be drawn on this machine, keep their hashes.
    """
    path = folder / GOLDEN
    hashes = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    shown = [family.showcase[0] for family in all_families() if not family.missing()]
    for environment in shown:
        if not which or f"{PREFIX}{environment}" in which:
            with contextlib.suppress(RuntimeError):  # a simulator without OpenGL
                hashes[environment] = dhash(sample(environment))
    lines = [f'"{environment}" = "{hashes[environment]}"\n' for environment in shown if environment in hashes]
    path.write_text("".join(lines), encoding="utf-8")
    return path


def contact_sheet(path: Path | str, columns: int = 2, share: float = 0.75) -> None:
    """Write a sheet with a frame of each family's first showcase, by turns light and dark, scaled by `share`.

    Raises:
        RuntimeError: a simulator has no OpenGL.
    """
    tiles = []
    for i, family in enumerate(all_families()):
        theme = ("light", "dark")[(i + i // columns) % 2]
        frame = Image.fromarray(sample(family.showcase[0], theme=theme))
        tiles.append(frame.resize((round(frame.width * share), round(frame.height * share)), Image.Resampling.LANCZOS))
    width, height = tiles[0].size
    sheet = Image.new("RGB", (width * columns, height * -(-len(tiles) // columns)))
    for i, tile in enumerate(tiles):
        sheet.paste(tile, (i % columns * width, i // columns * height))
    sheet.save(path, optimize=True)


def frame_rate(environment: str, frames: int = 40) -> float:
    """Privileged frames per second of CPU time: the median over `frames` frames of different turns."""
    env = StudentEnv(f"{PREFIX}{environment}", render_mode="rgb_array", privileged_info=True)
    env.reset(seed=_SEED)
    rng = np.random.default_rng(_SEED)
    spent = []
    for _ in range(frames):
        _, _, terminated, truncated, _ = env.step(env.session.world.sample_action(rng))
        begun = time.process_time()
        env.render()
        spent.append(time.process_time() - begun)
        if terminated or truncated:
            env.reset()
    env.close()
    return 1 / float(np.median(spent))
