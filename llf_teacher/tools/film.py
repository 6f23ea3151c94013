"""Films: play an episode as frames, and save frames as an animation or a video."""

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from PIL import Image

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from worlds.extras import pip_install
from worlds.pictures.canvas import Frame

__all__ = ["SUFFIXES", "check_path", "film", "save"]

SUFFIXES = (".gif", ".webp", ".mp4")
"""Endings of the names of films."""
_COLOURS = 128
_FPS = 10  # frames per second of a video, which repeats each frame


def film(id: str, *, student: str, seed: int, worlds: int = 0, **settings: Any) -> list[Frame]:
    """A frame for the opening and for each turn of an episode, each after the feedback.

    Args:
        id: an environment.
        student: the spec of the student.
        seed: the seed of the episode.
        worlds: number of worlds for measuring the information of each claim, which frames show; 0: no measurement. It
            sets the options that measuring needs.
        settings: settings of `StudentEnv`: `teacher`, `feedback_type`, `theme`, `privileged_info`, ...

    Raises:
        ValueError: the information of claims cannot be measured.
    """
    family = entry(id).family
    if worlds:
        settings["options"] = {**family.posterior_needs, **settings.get("options", {})}
    player = parse_student(student)
    env = StudentEnv(id, text=player.text, render_mode="rgb_array", **settings)
    information = family.make_information(env.session.world, seed, worlds) if worlds else None
    frames = []
    for turn in play_turns(env, player.seat(env.family, env.session.world), seed):
        if information is not None:
            information.see(turn.moment)
            heard = zip(turn.atoms, information.hear(turn.atoms), strict=True)
            remarks = {atom.text: bits.short for atom, bits in heard if atom.kind is not None}
            env.student_view.require_renderer().remark(remarks)
        frames.append(env.render())
    env.close()
    return frames


def check_path(path: Path) -> None:
    """Check, before an episode begins, that a film can be written.

    Raises:
        ValueError: the name does not end in one of `SUFFIXES`.
        ModuleNotFoundError: the encoder for mp4 is not installed.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"a film's name must end in one of {', '.join(SUFFIXES)}, got {path.name!r}")
    if path.suffix.lower() == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                f"mp4 needs 'imageio_ffmpeg', which is not installed; run: {pip_install('film')}, or write a .gif or a "
                ".webp",
                name=error.name,
            ) from error


def save(frames: Sequence[Frame], path: Path, seconds: float = 1.5) -> None:
    """Write frames as an animation that repeats, or as a video.

    Args:
        frames: at least one frame; all have the same size.
        path: the file to write; see `SUFFIXES`.
        seconds: time for which each frame is shown; the last one is shown twice as long.

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
        lossless=True,  # only for webp
        optimize=False,  # keeps one palette for all frames, so that only changes are stored
    )


def _indexed(images: Sequence[Image.Image]) -> list[Image.Image]:
    """The images with one common palette."""
    width, height = images[0].size
    whole = Image.new("RGB", (width, height * len(images)))
    for i, image in enumerate(images):
        whole.paste(image, (0, i * height))
    palette = whole.quantize(_COLOURS, dither=Image.Dither.NONE)
    return [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]


def _video(frames: Sequence[Frame], path: Path, times: Sequence[float]) -> None:
    import imageio_ffmpeg

    height, width, _ = frames[0].shape
    with closing(imageio_ffmpeg.write_frames(f"{path}", (width, height), fps=_FPS)) as writer:
        writer.send(None)
        for frame, each in zip(frames, times, strict=True):
            for _ in range(max(round(each * _FPS), 1)):
                writer.send(frame.tobytes())
