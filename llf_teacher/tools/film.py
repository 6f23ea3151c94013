"""Films: an episode as frames, and frames as a file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from llf_teacher.episodes.scenes import scenes
from llf_teacher.gym import StudentEnv
from llf_teacher.students.parsing import parse_student
from worlds.pictures.canvas import Frame

__all__ = ["SUFFIXES", "check_path", "film", "save"]

SUFFIXES = (".gif", ".webp", ".mp4")
"""What a film's file can be."""
_COLOURS = 128
_FPS = 10  # of a video, which shows each frame for a while


def film(id: str, *, student: str, seed: int, **settings: Any) -> list[Frame]:
    """A frame of each turn of an episode, the opening first, each after the teacher has spoken.

    Args:
        id: an environment.
        student: the spec of who plays.
        seed: of the episode.
        settings: those of `StudentEnv`: `teacher`, `feedback_type`, `theme`, `privileged_info`, ...
    """
    player = parse_student(student)
    env = StudentEnv(id, text=player.text, render_mode="rgb_array", **settings)
    frames = [env.render() for _ in scenes(env, player.seat(env.family, env.aec.world), seed)]
    env.close()
    return frames


def check_path(path: Path) -> None:
    """Make sure, before anything is played, that a film can be written.

    Raises:
        ValueError: the name has an unknown ending.
        ModuleNotFoundError: it is to be an mp4, and its encoder is not installed.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"a film is named as one of *{', *'.join(SUFFIXES)}, got {path.name!r}")
    if path.suffix.lower() == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                "mp4 needs 'imageio_ffmpeg', which is not installed; run: pip install 'llf-teacher[film]', or write a "
                ".gif or a .webp",
                name=error.name,
            ) from error


def save(frames: Sequence[Frame], path: Path, seconds: float = 1.5) -> None:
    """Write frames as an animation that begins anew when it is over, or as a video.

    Args:
        frames: at least one, all of the same size.
        path: where to; see `SUFFIXES`.
        seconds: how long each is shown, the last one twice as long.

    Raises:
        ValueError, ModuleNotFoundError: as `check_path`.
    """
    check_path(path)
    times = [seconds] * (len(frames) - 1) + [2 * seconds]
    if path.suffix.lower() == ".mp4":
        _video(frames, path, times)
        return
    images = [Image.fromarray(frame) for frame in frames]
    if path.suffix.lower() == ".gif":
        images = _indexed(images)
    images[0].save(
        path,
        save_all=True,
        append_images=images[1:],
        duration=[round(1000 * each) for each in times],
        loop=0,
        lossless=True,  # of a webp
        optimize=False,  # so that all frames keep one palette, and what does not change is left out
    )


def _indexed(images: Sequence[Image.Image]) -> list[Image.Image]:
    """Images of one palette, that of all of them together."""
    width, height = images[0].size
    whole = Image.new("RGB", (width, height * len(images)))
    for i, image in enumerate(images):
        whole.paste(image, (0, i * height))
    palette = whole.quantize(_COLOURS, dither=Image.Dither.NONE)
    return [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]


def _video(frames: Sequence[Frame], path: Path, times: Sequence[float]) -> None:
    import imageio_ffmpeg

    height, width, _ = frames[0].shape
    writer = imageio_ffmpeg.write_frames(f"{path}", (width, height), fps=_FPS)
    writer.send(None)
    for frame, each in zip(frames, times, strict=True):
        for _ in range(max(round(each * _FPS), 1)):
            writer.send(frame.tobytes())
    writer.close()
