"""`llf film`: an episode as an animation."""

import sys
from importlib.util import find_spec

import numpy as np
import pytest
from commands import llf
from PIL import Image

from llf_teacher.tools.film import check_path, film, save

ID = "llf-gridworld-v0"


@pytest.fixture(scope="module")
def frames():
    return film(ID, student="obedient", teacher="oracle", seed=7, privileged_info=True)


def test_the_command(tmp_path):
    options = ("--seed", "7", "--seconds", "0.2", "--max-turns", "3", "--theme", "dark")
    result = llf("film", ID, "out.gif", *options, cwd=tmp_path)
    assert result.stdout.startswith("out.gif: 4 frames, "), result.stderr
    with Image.open(tmp_path / "out.gif") as image:
        assert (image.size, image.n_frames, image.info["loop"]) == ((640, 480), 4, 0)
        assert image.convert("L").resize((1, 1)).getpixel((0, 0)) < 80


def test_how_much_is_said_stands_beside_its_kind():
    shown = {"student": "obedient", "teacher": "oracle", "seed": 7, "privileged_info": True, "max_turns": 2}
    bits, plain = film(ID, worlds=8, **shown), film(ID, options={"map": True}, **shown)
    for one, other in zip(bits[1:], plain[1:], strict=True):  # at the opening, the instruction takes all the room
        rows, columns = np.nonzero((one != other).any(axis=2))
        assert 0 < len(rows) < 4_000
        assert columns.min() > 384  # beside the picture
    with pytest.raises(ValueError, match="'poem' has no posterior"):
        film("llf-poem-Haiku-v0", student="random", seed=0, worlds=8)


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_animations_show_the_frames(frames, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    save(frames, path, 0.5)
    with Image.open(path) as image:
        assert image.n_frames == len(frames)
        times = []
        for i, frame in enumerate(frames):
            image.seek(i)
            image.load()
            times.append(image.info["duration"])
            assert abs(np.array(image.convert("RGB"), int) - frame).mean() < 4
    assert times == [500] * (len(frames) - 1) + [1000]


def test_it_ends_with_the_treasure_and_shows_the_truth_unless_it_is_plain(frames):
    plain = film(ID, student="obedient", teacher="oracle", seed=7)
    assert len(plain) == len(frames) == 7
    assert not any(np.array_equal(one, other) for one, other in zip(plain, frames, strict=True))


def test_students_of_words_can_be_filmed():
    assert len(film("llf-poem-Haiku-v0", student="obedient", seed=1, max_turns=2)) == 3


def test_mp4_says_what_it_needs(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'llf-teacher\[film\]' .*, or write a .gif"):
        check_path(tmp_path / "out.mp4")


def test_mp4_is_written_where_the_extra_is_installed(frames, tmp_path):
    path = tmp_path / "out.mp4"
    if find_spec("imageio_ffmpeg") is None:
        with pytest.raises(ModuleNotFoundError, match="pip install"):
            save(frames, path)
        return
    import imageio_ffmpeg

    save(frames, path, 0.5)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(f"{path}")
    assert count == 5 * (len(frames) + 1)
    assert seconds == pytest.approx(0.5 * (len(frames) + 1), abs=0.2)
