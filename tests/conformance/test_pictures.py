"""Every family's pictures pass the kit that ships; the kit finds what is wrong; and they stay as they were."""

import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from design import sampled
from opengl import with_opengl
from sampling import ENTRIES

from llf_teacher import make
from llf_teacher.registry import entries, family
from llf_teacher.tools.pictures import GOLDEN, dhash, frame_rate, sample
from pz_envs.family import all_families
from pz_envs.frames import HEIGHT, WIDTH
from worlds.gridworld import Gridworld
from worlds.pictures import TextPicture
from worlds.pictures import testing as kit
from worlds.pictures.gridworld import GridworldPicture
from worlds.pictures.themes import THEMES

GOLDENS = Path(__file__).parents[1] / "golden" / GOLDEN
BITS = 6
"""So many of 64 may differ: another version of Pillow or FreeType draws an edge a little differently."""
LIGHT = [family.name for family in all_families() if not family.slow]
RENDERED = [family.name for family in all_families() if family.slow]
"""Those that a simulator draws, for which OpenGL has to be asked for before Python starts."""


def name(value):
    return getattr(value, "id", None) or getattr(value, "__name__", None)


def check(check, id):
    """A check of the kit for an environment; also called by the program below."""
    entry = entries()[id]
    check(partial(entry.family.make_world, **entry.options), entry.family.make_picture)


@sampled(lambda entry, each: {entry.id, (entry.family.name, each)})
@pytest.mark.parametrize("each", kit.CHECKS, ids=name)
@pytest.mark.parametrize("entry", [each for each in ENTRIES if not each.values[0].family.slow])
def test_pictures(entry, each):
    check(each, entry.id)


@pytest.mark.full
@pytest.mark.parametrize("name", RENDERED)
def test_pictures_of_simulators(name):
    code = f"""
import json
from functools import partial
from llf_teacher import make
from llf_teacher.registry import family
from llf_teacher.tools.pictures import dhash, sample
from worlds.pictures.testing import check_picture
world = family({name!r})
options = world.environments[world.showcase[0]]
check_picture(partial(world.make_world, **options), world.make_picture)
print(json.dumps(dhash(sample(world.showcase[0]))))
"""
    close_to_golden(family(name).showcase[0], json.loads(with_opengl(code)))


@pytest.mark.full
@pytest.mark.parametrize("name", RENDERED)
def test_simulators_say_what_they_need_to_draw(name):
    code = f"import llf_teacher\nenv = llf_teacher.make('llf-{family(name).showcase[0]}', render_mode='rgb_array')"
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"} | {"MUJOCO_GL": "glfw"}
    program = [sys.executable, "-c", f"{code}\nenv.reset(seed=0)\nenv.render()"]
    run = subprocess.run(program, capture_output=True, text=True, env=environment, check=False)
    assert "RuntimeError: images need off-screen OpenGL" in run.stderr


@pytest.mark.parametrize("name", LIGHT)
def test_goldens(name):
    environment = family(name).showcase[0]
    close_to_golden(environment, dhash(sample(environment)))


def close_to_golden(environment, found):
    golden = tomllib.loads(GOLDENS.read_text())[environment]
    apart = (int(golden, 16) ^ int(found, 16)).bit_count()
    assert apart <= BITS, f"{environment} looks different, {found} and not {golden}: look at it; see `llf dev golden`"


def test_goldens_are_complete():
    assert [*tomllib.loads(GOLDENS.read_text())] == [each.showcase[0] for each in all_families()]


def test_hashes_tell_pictures_apart():
    goldens = [int(each, 16) for each in tomllib.loads(GOLDENS.read_text()).values()]
    assert all((one ^ other).bit_count() > BITS for i, one in enumerate(goldens) for other in goldens[:i])


@pytest.mark.parametrize("environment", ["gridworld-v0", "optimization-Booth-v0", "reco-movie-v0", "alfworld-v0"])
def test_the_privileged_see_what_is_hidden(environment):
    entry = entries()[f"llf-{environment}"]
    options = {"shift": True} if "optimization" in environment else {}
    world = entry.family.make_world(**entry.options, **options)
    world.reset(seed=5)
    turns, picture = kit.episode(world), entry.family.make_picture(world)
    other = picture.alike(turns, np.random.default_rng(1))
    one, two = (kit.picture_of(picture, kit.sight_of(world, each, True)) for each in (turns, other))
    assert not np.array_equal(one, two)


@pytest.mark.parametrize("name", LIGHT)
def test_thirty_frames_a_second(name):
    assert frame_rate(family(name).showcase[0], 9) > 30


@pytest.mark.parametrize("entry", [each for each in ENTRIES if not each.values[0].family.slow])
def test_frames_hide_what_is_hidden(entry):
    """Whole ones, of seats whose teacher is silent; and each environment can be seen."""
    env = make(entry.id, feedback_type="n", render_mode="rgb_array")
    env.reset(seed=4)
    rng = np.random.default_rng(4)
    for _ in range(4):
        if any(env.step(env.session.world.sample_action(rng))[2:4]):
            break
    frame, watch = env.render(), env.student_view.renderer
    watch.turns = list(watch.picture.alike(watch.turns, rng))
    assert np.array_equal(env.render(), frame)


@pytest.mark.parametrize("name", LIGHT)
def test_no_text_of_a_frame_is_cut_or_on_other_text(name):
    """Of whole frames with the truth and the plan, in fresh episodes."""
    taught = family(name)
    teacher = "mistake(eps=0.3)" if taught.serves("mistake") else "oracle"
    for seed in np.random.SeedSequence().generate_state(2).tolist():
        env = make(f"llf-{taught.showcase[0]}", render_mode="rgb_array", privileged_info=True, teacher=teacher)
        env.reset(seed=seed)
        rng = np.random.default_rng(seed)
        for turn in range(5):
            canvas = kit.Proof(WIDTH, HEIGHT, THEMES["dark"])
            env.student_view.renderer.draw(canvas, env.student_view.description())
            assert canvas.faults() == [], (seed, turn)
            plan = env.session.teacher.oracle.plan(env.session.moment.after, 1) if turn % 2 else ()
            if any(env.step(plan[0] if plan else env.session.world.sample_action(rng))[2:4]):
                break
        env.close()


def test_a_family_without_a_picture_is_shown_in_its_own_words():
    plain = replace(family("gridworld"), picture="")
    world = plain.make_world()
    world.reset(seed=0)
    assert isinstance(plain.make_picture(world), TextPicture)
    kit.check_picture(Gridworld, plain.make_picture)


class Tells(GridworldPicture):
    """Draws where the treasure is."""

    def draw(self, canvas, sight):
        super().draw(canvas, sight._replace(privileged=True))


class Writes(GridworldPicture):
    """Writes where the treasure is."""

    def text(self, sight):
        return ((f"{sight.now.layout.treasure}", ""),)


class Betrays(GridworldPicture):
    """Takes for equal what a student can tell apart."""

    def alike(self, turns, rng):
        return [turn._replace(truth=turn.truth._replace(room=turns[0].truth.layout.treasure)) for turn in turns]


class Blank(GridworldPicture):
    def draw(self, canvas, sight):
        pass


class Bright(GridworldPicture):
    def draw(self, canvas, sight):
        canvas.box((0, 0), (canvas.width, canvas.height), "#ffffff")
        canvas.line([(0, 0), (200, 200)], "#000000", 9)


class Cuts(GridworldPicture):
    """Writes a word for which there is no room."""

    def draw(self, canvas, sight):
        super().draw(canvas, sight)
        canvas.text((20, 20), "bathroom", 14, most=40)


class Outside(GridworldPicture):
    """Writes beyond the edge."""

    def draw(self, canvas, sight):
        super().draw(canvas, sight)
        canvas.text((canvas.width - 20, 200), "bathroom", 14)


class Covers(GridworldPicture):
    """Writes numbers that collide."""

    def draw(self, canvas, sight):
        super().draw(canvas, sight)
        canvas.text((20, 432), "+0.158", 14)
        canvas.text((50, 432), "0.21 m", 14)


class Forgets(GridworldPicture):
    """Draws what it has drawn before."""

    drawn = 0

    def draw(self, canvas, sight):
        Forgets.drawn += 1
        canvas.text((20, 20), f"{Forgets.drawn}", 40)


@pytest.mark.parametrize(
    ("liar", "match"),
    [
        (Tells, "the picture shows what the student may not know"),
        (Writes, "the text shows what the student may not know"),
        (Betrays, "a student can distinguish the turns"),
        (Blank, "is blank"),
        (Bright, "the same in light and dark"),
        (Cuts, "'bathroom' is cut to 'b"),
        (Outside, "'bathroom' lies outside the canvas"),
        (Covers, r"'0.21 m' lies on '\+0.158'"),
        (Forgets, "two pictures of the same sight differ"),
    ],
)
def test_the_kit_finds_liars(liar, match):
    with pytest.raises(AssertionError, match=match):
        kit.check_picture(Gridworld, lambda world: liar(world.scratch()))
