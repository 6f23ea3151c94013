"""Frames: what they show, to whom, and that looking changes nothing."""

import copy
import sys
from types import ModuleType, SimpleNamespace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import AddRenderObservation, RecordVideo, RenderCollection
from pettingzoo.test import render_test

import llf_teacher
from llf_teacher.registry import family
from pz_envs.assembly import assemble
from pz_envs.frames import HEIGHT, WIDTH, SpokenSentence
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.settings import Settings
from teachers.atoms import FP, HN, SILENCE, Label, Utterance
from worlds.pictures.canvas import THEMES

GRID = family("gridworld")
ID = "llf-gridworld-v0"
SIZE = (HEIGHT, WIDTH, 3)


@pytest.fixture(autouse=True)
def no_screen(monkeypatch):
    """Windows open where nobody sees them."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def started(**settings):
    env = GRID.raw_env(render_mode="rgb_array", **settings)
    env.reset(seed=0)
    return env


def wrong(env):
    """An action that an oracle would blame."""
    return env.session.teacher.oracle.values(env.session.moment.after).index(
        min(env.session.teacher.oracle.values(env.session.moment.after))
    )


@pytest.mark.parametrize("seating", ["tutoring", "classroom", "panel"])
def test_pettingzoo_renders(seating, monkeypatch):
    monkeypatch.setattr("pygame.time.Clock", lambda: SimpleNamespace(tick=lambda fps: None))  # nobody looks: no waiting
    render_test(lambda render_mode: GRID.env(seating=seating, speech="kinds", render_mode=render_mode))
    env = GRID.parallel_env(seating=seating, speech="kinds", render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape[2] == 3


def test_ids_render():
    env = gymnasium.make(ID, render_mode="rgb_array", feedback_type="hp")
    env.reset(seed=0)
    frame = env.render()
    assert frame.shape == SIZE
    assert frame.dtype == np.uint8
    assert env.metadata["render_fps"] > 0
    check_env(env.unwrapped)
    teacher = llf_teacher.TeacherEnv(ID, render_mode="rgb_array")
    teacher.reset(seed=0)
    teacher.step(31)
    assert teacher.render().shape == SIZE


def test_gymnasium_records(tmp_path, monkeypatch):
    """What `RecordVideo` hands to moviepy, which is not needed for anything else, are the frames."""
    clips = []

    class Clip:
        def __init__(self, frames, fps):
            clips.append((frames, fps))

        def write_videofile(self, path, logger):
            pass

    encoder = ModuleType("moviepy.video.io.ImageSequenceClip")
    encoder.ImageSequenceClip = Clip
    for name in ("moviepy", "moviepy.video", "moviepy.video.io"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setitem(sys.modules, encoder.__name__, encoder)
    monkeypatch.delitem(sys.modules, "gymnasium.utils.save_video", raising=False)
    env = RecordVideo(llf_teacher.make(ID, render_mode="rgb_array", max_turns=3), str(tmp_path / "videos"))
    env.reset(seed=0)
    while not any(env.step(1)[2:4]):
        pass
    env.close()
    [(frames, fps)] = clips
    assert [frame.shape for frame in frames] == [SIZE] * 4
    assert fps == env.metadata["render_fps"]
    del sys.modules["gymnasium.utils.save_video"]


def test_frames_are_observations():
    env = AddRenderObservation(llf_teacher.make(ID, render_mode="rgb_array"), render_only=True)
    assert env.observation_space.shape == SIZE
    assert env.reset(seed=0)[0] in env.observation_space
    collected = RenderCollection(llf_teacher.make(ID, render_mode="rgb_array"))
    collected.reset(seed=0)
    collected.step(1)
    assert len(collected.render()) == 2


def test_looking_changes_nothing():
    """Neither what is said nor what is drawn next."""
    plain, shown = (
        llf_teacher.make(ID, teacher="mistake(eps=0.5)", **settings)
        for settings in ({}, {"render_mode": "rgb_array", "privileged_info": True})
    )
    one, other = plain.reset(seed=3), shown.reset(seed=3)
    for action in (0, 1, 2, 3, 0, 1):
        shown.render()
        assert np.array_equal(shown.render(), shown.render())
        assert one[0]["feedback"] == other[0]["feedback"]
        one, other = plain.step(action), shown.step(action)


def test_a_frame_shows_what_was_said():
    env = started()
    before = env.frame()
    env.step(SILENCE)
    silent = env.frame()
    assert not np.array_equal(before, silent)
    env.reset(seed=0)
    env.step(Utterance("Look north."))
    assert env.student_view.renderer.sentences == (SpokenSentence("Look north.", None, Label.UNCHECKED),)
    assert not np.array_equal(env.frame(), silent)
    assert np.array_equal(env.frame()[:, : WIDTH // 2], silent[:, : WIDTH // 2])  # the world is the same


def test_each_sentence_has_its_kind_and_only_the_privileged_see_whether_it_holds():
    for privileged, verdict in ((False, Label.UNCHECKED), (True, Label.DISTORTED)):
        env = started(teacher="mistake(eps=1.0)", feedback_type="fp", privileged_info=privileged)
        env.step(env.infos["teacher_0"]["suggestion"])
        env.step(0)
        env.step(env.infos["teacher_0"]["suggestion"])
        assert [(each.kind, each.verdict) for each in env.student_view.renderer.sentences] == [(FP, verdict)]
    assert started().student_view.renderer.lab is not env.session.teacher.oracle.lab


def test_what_was_said_fades_when_the_student_has_acted():
    env = started()
    env.step(env.infos["teacher_0"]["suggestion"])
    assert env.student_view.renderer.heard
    env.step(wrong(env))
    assert not env.student_view.renderer.heard
    env.step(env.infos["teacher_0"]["suggestion"])
    assert env.student_view.renderer.heard
    assert HN in {each.kind for each in env.student_view.renderer.sentences}


def test_the_instruction_is_shown_where_the_seat_says_it_itself():
    env = started(speech="kinds")
    told = len(env.student_view.renderer.sentences)
    assert told
    env.step(31)
    assert len(env.student_view.renderer.sentences) > told


def test_asking_keeps_the_turn():
    env = llf_teacher.make(ID, render_mode="rgb_array", ask_cost=0.1, text=True)
    env.reset(seed=0)
    env.step("ask")
    assert len(env.student_view.renderer.moments) == 1
    env.step("north")
    assert len(env.student_view.renderer.moments) == 2
    assert env.render().shape == SIZE


def test_an_episode_that_is_taken_up_is_shown():
    env = llf_teacher.make(ID, render_mode="rgb_array", privileged_info=True)
    env.reset(seed=0)
    env.step(1)
    moment = env.session.moment
    env.step(1)
    env.reset(seed=0)
    env.resume_from(moment)
    assert env.student_view.renderer.moments == [moment]
    assert env.render().shape == SIZE


def test_themes():
    frames = [started(theme=theme).frame() for theme in THEMES]
    assert frames[0].mean() > 200 > 100 > frames[1].mean()
    with pytest.raises(ValueError, match="theme 'loud' is unknown; allowed: light, dark"):
        started(theme="loud")
    with pytest.raises(ValueError, match="privileged_info must be True or False, got 'yes'"):
        started(privileged_info="yes")


def test_copies_are_drawn_alike():
    env = started()
    env.step(env.infos["teacher_0"]["suggestion"])
    env.step(1)
    other = copy.deepcopy(env)
    assert np.array_equal(other.frame(), env.frame())
    other.step(SILENCE)
    assert not np.array_equal(other.frame(), env.frame())


def test_classrooms_have_a_frame_a_desk():
    env = GRID.raw_env(seating="classroom", students=3, render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == (2 * HEIGHT, 2 * WIDTH, 3)
    env = GRID.raw_env(seating="classroom", students=5, render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == (HEIGHT, 3 * WIDTH // 2, 3)


def test_in_a_panel_each_sentence_has_its_speaker():
    env = started(seating="panel", teachers=("oracle", "oracle"), feedback_type="fp")
    for _ in env.teachers:
        env.step(31)
    speakers = [each.speaker for each in env.student_view.renderer.sentences if each.kind is not None]
    assert speakers == ["teacher_0", "teacher_1"]
    assert env.render().shape == SIZE


def test_an_environment_of_ones_own_is_drawn_by_itself_for_the_privileged():
    lake = gymnasium.make("FrozenLake-v1", render_mode="rgb_array")
    frames = []
    for privileged in (False, True):
        env = llf_teacher.teach(lake, render_mode="rgb_array", privileged_info=privileged)
        env.reset(seed=0)
        env.step(1)
        frames.append(env.render())
    assert frames[0][240:, : WIDTH // 2].std() < 10 < frames[1][240:, : WIDTH // 2].std()


def test_long_descriptions_are_cut():
    lake = gymnasium.make("FrozenLake-v1")
    env = llf_teacher.teach(lake, describe=lambda seen: "word " * 100_000, render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == SIZE


def test_without_a_mode_there_is_a_warning():
    env = llf_teacher.make(ID)
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="shows nothing without a render mode"):
        assert env.render() is None


def test_a_bare_environment_says_how_to_get_pictures():
    settings = Settings(render_mode="rgb_array")
    env = TutoringEnv(assemble(GRID, Settings()), settings)
    env.reset(seed=0)
    with pytest.raises(RuntimeError, match="make it with render_mode='rgb_array'"):
        env.render()


def test_human_opens_a_window(monkeypatch):
    import pygame

    env = llf_teacher.make(ID, render_mode="human", max_turns=2)
    env.reset(seed=0)
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert np.array_equal(shown, env.student_view.frame())
    assert env.render() is None
    env.close()
    assert pygame.display.get_surface() is None
    monkeypatch.setenv("SDL_VIDEODRIVER", "none-such")
    with pytest.raises(RuntimeError, match=r"which failed with .*; it needs a display"):
        env.reset(seed=0)


def test_human_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    env = llf_teacher.make(ID, render_mode="human")
    with pytest.raises(ModuleNotFoundError, match="pip install pygame-ce"):
        env.reset(seed=0)


def test_text_shows_turn_action_and_map():
    env = llf_teacher.make(ID, render_mode="ansi")
    env.reset(seed=7)
    env.step(3)
    text = env.render()
    assert text.startswith("Turn 1 of 20, 19 left; reward 0 in all\nThe student: south (reward 0)\n")
    room = env.session.world.truth.layout.names[env.session.world.truth.room]
    assert f"[{room}]" in text
    assert f"Room: {room}\n" in text
    assert text.endswith(f"Teacher: {env.session.feedback}")
