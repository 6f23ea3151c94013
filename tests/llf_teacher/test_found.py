"""What is found without reading the source: names, signatures, representations, and the nearest to a misspelt name."""

import copy
import dataclasses
import inspect
import pickle
import subprocess
import sys

import gymnasium
import pettingzoo
import pytest

import llf_teacher
from llf_teacher.registry import family
from llf_teacher.students.parsing import STUDENTS, parse_student
from pz_envs.family import all_families
from pz_envs.settings import Settings, SettingsKeywords
from teachers.personality import PERSONALITIES, parse_personality

GRIDWORLD = "llf-gridworld-v0"
TUTOR = "Teacher(GridworldOracle, 'mistake(eps=0.2)', instruction_type='b', feedback_type='hp+fp')"
SETTINGS = {"teacher": "mistake(eps=0.2)", "feedback_type": "hp+fp"}


def test_the_front_door_is_what_dir_shows():
    shown = [name for name in dir(llf_teacher) if not name.startswith("__")]
    assert shown == sorted(llf_teacher.__all__)
    assert "__version__" in dir(llf_teacher)


def test_dir_shows_it_before_anything_was_asked_for():
    code = "import llf_teacher; print(*(name for name in dir(llf_teacher) if name[0] != '_'))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.split() == sorted(llf_teacher.__all__)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: llf_teacher.make(GRIDWORLD, **SETTINGS), f"<StudentEnv {GRIDWORLD} {TUTOR}>"),
        (
            lambda: llf_teacher.TeacherEnv(GRIDWORLD, student="q_learning(alpha=0.3)", **SETTINGS),
            f"<TeacherEnv {GRIDWORLD} student='q_learning(alpha=0.3)' {TUTOR}>",
        ),
        (
            lambda: family("gridworld").raw_env(**SETTINGS),
            f"<TutoringEnv llf/gridworld-v0 speech='message' {TUTOR}>",
        ),
        (
            lambda: pettingzoo.make("aec", "llf/gridworld-v0", speech="kinds", **SETTINGS),
            f"<OrderEnforcing <TutoringEnv llf/gridworld-v0 speech='kinds' {TUTOR}>>",
        ),
        (
            lambda: pettingzoo.make("parallel", "llf/gridworld-v0", **SETTINGS),
            f"<TurnBasedParallelEnv <TutoringEnv llf/gridworld-v0 speech='message' {TUTOR}>>",
        ),
        (
            lambda: pettingzoo.make("aec", "llf/gridworld-classroom-v0", students=2, **SETTINGS),
            f"<OrderEnforcing <ClassroomEnv llf/gridworld-classroom-v0 speech='kinds' students=2 {TUTOR}>>",
        ),
        (
            lambda: pettingzoo.make("parallel", "llf/gridworld-classroom-v0", students=2, **SETTINGS),
            f"<ParallelSeats <ClassroomEnv llf/gridworld-classroom-v0 speech='kinds' students=2 {TUTOR}>, "
            "with teacher_0: Attention('round_robin')>",
        ),
        (
            lambda: pettingzoo.make(
                "parallel", "llf/gridworld-panel-v0", teachers=["mistake(eps=0.2)"], feedback_type="hp+fp"
            ),
            f"<ParallelSeats <PanelEnv llf/gridworld-panel-v0 speech='kinds' [{TUTOR}]>, with teacher_0: SayAll()>",
        ),
        (
            lambda: gymnasium.make_vec(GRIDWORLD, 2, feedback_type="fp"),
            f"<StudentVectorEnv {GRIDWORLD} num_envs=2 teacher='oracle' feedback_type='fp'>",
        ),
        (
            lambda: llf_teacher.TeacherVectorEnv(GRIDWORLD, 2, student="q_learning", feedback_type="fp"),
            f"<TeacherVectorEnv {GRIDWORLD} num_envs=2 student='q_learning' teacher='oracle' feedback_type='fp'>",
        ),
        (lambda: llf_teacher.TeacherEnv(GRIDWORLD).student, "<policy of obedient in gridworld>"),
        (lambda: llf_teacher.teach(gymnasium.make("CliffWalking-v1")).family, "<Lesson CliffWalking>"),
    ],
)
def test_what_it_is_says_its_repr(make, said):
    assert repr(make()) == said


def test_a_policy_in_the_teachers_seat_is_who_speaks():
    class Mute:
        def reset(self, rng):
            pass

        def act(self, observation, info):
            return ""

        def __repr__(self):
            return "Mute()"

    env = llf_teacher.make(GRIDWORLD, teacher=Mute(), feedback_type="r")
    assert repr(env) == f"<StudentEnv {GRIDWORLD} Mute() feedback_type='r'>"


@pytest.mark.parametrize("one", all_families(), ids=lambda one: one.name)
def test_each_environment_is_called_by_its_id(one):
    """By the options that make it, without making it."""
    for name, options in one.environments.items():
        assert one.label("tutoring", {**options, "teacher": "oracle"}) == f"llf/{name}"


def test_teachers_and_students_show_their_parameters():
    """As what makes them anew."""
    for name in PERSONALITIES.names:
        spec = PERSONALITIES[name]()
        assert str(parse_personality(str(spec))) == str(spec)
        assert repr(spec).partition("(")[0] == type(spec).__name__
    for name in STUDENTS.names:
        if name != "llm":  # whose model has to be given
            assert parse_student(name) == STUDENTS[name]()
    assert repr(parse_student("ucb(trust=0.5)")) == "Ucb(trust=0.5, forget=True, scale=0.5)"


@pytest.mark.parametrize("door", ["env", "raw_env", "parallel_env"])
def test_a_family_says_what_it_takes(door):
    signature = inspect.signature(getattr(family("gridworld"), door))
    shown = list(signature.parameters)
    assert shown[:4] == ["seating", "teacher", "instruction_type", "feedback_type"]
    assert {"speech", "text", "max_cycles", "cost", "budget", "render_mode"} < set(shown)


@pytest.mark.parametrize(
    "door",
    [llf_teacher.make, llf_teacher.StudentEnv, llf_teacher.TeacherEnv, family("gridworld").raw_env],
    ids=["make", "StudentEnv", "TeacherEnv", "raw_env"],
)
def test_doors_show_the_defaults_of_the_settings(door):
    shown = inspect.signature(door).parameters
    named = {"max_turns": "max_cycles"} if "max_cycles" in shown else {}
    for field in dataclasses.fields(Settings):
        if field.name not in ("speech", "options", "teacher_numbers"):  # of the teacher's seat
            assert shown[named.get(field.name, field.name)].default == getattr(Settings(), field.name)


def test_settings_have_the_same_names_as_keywords_and_as_fields():
    """With the same types, for editors and type checkers."""
    assert {field.name for field in dataclasses.fields(Settings)} == SettingsKeywords.__optional_keys__


@pytest.mark.parametrize("door", [llf_teacher.make, llf_teacher.TeacherEnv], ids=["make", "TeacherEnv"])
def test_doors_take_settings_as_one_value_or_as_keywords(door):
    settings = Settings(feedback_type="fp", teacher="mistake(eps=0.2)", options={"num_rooms": 12})
    given = {"speech": "kinds"} if door is llf_teacher.TeacherEnv else {}
    one = door(GRIDWORLD, settings=dataclasses.replace(settings, **given))
    other = door(GRIDWORLD, feedback_type="fp", teacher="mistake(eps=0.2)", num_rooms=12)
    assert one.settings == other.settings
    assert door(GRIDWORLD, settings=settings, feedback_type="r", **given).session.teacher.feedback_type == "r"


MISSPELT = {
    "make": lambda **given: llf_teacher.make(GRIDWORLD, **given),
    "teacher": lambda **given: llf_teacher.TeacherEnv(GRIDWORLD, **given),
    "aec": lambda **given: pettingzoo.make("aec", "llf/gridworld-v0", **given),
    "parallel": lambda **given: pettingzoo.make("parallel", "llf/gridworld-v0", **given),
    "classroom": lambda **given: pettingzoo.make("aec", "llf/gridworld-classroom-v0", **given),
    "panel": lambda **given: pettingzoo.make("parallel", "llf/gridworld-panel-v0", **given),
}


@pytest.mark.parametrize("make", MISSPELT.values(), ids=MISSPELT)
@pytest.mark.parametrize(
    ("given", "meant"),
    [("txt", "text"), ("speach", "speech"), ("feedbak_type", "feedback_type"), ("rooms", "num_rooms")],
)
def test_a_misspelt_setting_names_the_nearest(make, given, meant):
    if make is MISSPELT["make"] and meant == "speech":
        given, meant = "paraphrse", "paraphrase"  # the student's seat has no speech
    with pytest.raises(ValueError, match=rf"unknown option '{given}'; did you mean ({meant}|\w+ or {meant})\b"):
        make(**{given: 1})


@pytest.mark.parametrize(
    "arrays", [llf_teacher.TeacherVectorEnv, lambda *given, **more: gymnasium.make_vec(*given, **more)]
)
def test_a_misspelt_setting_of_arrays_names_the_nearest(arrays):
    with pytest.raises(ValueError, match=r"unknown option 'feedbak_type'; did you mean feedback_type"):
        arrays(GRIDWORLD, 2, feedbak_type="fp")


def test_an_unknown_id_is_answered_by_the_nearest():
    with pytest.raises(ValueError, match="did you mean llf-gridworld-v0") as caught:
        llf_teacher.make("llf-gridwrld-v0")
    assert "metaworld" not in str(caught.value)
    assert f"see `llf list` and llf_teacher.ids() for all {len(llf_teacher.ids())}" in str(caught.value)


def test_settings_are_copied_pickled_and_keep_their_own_options():
    options = {"num_rooms": 12}
    settings = Settings(max_turns=2, options=options)
    options["num_rooms"] = 9
    assert settings.options == {"num_rooms": 12}
    for each in (settings, Settings()):
        assert copy.deepcopy(each) == pickle.loads(pickle.dumps(each)) == each
    env = gymnasium.make(GRIDWORLD, settings=Settings(max_turns=2))
    gymnasium.make(env.spec)
    assert llf_teacher.rollout(lambda prompts: ["1"] * len(prompts), GRIDWORLD, 1, settings=Settings(max_turns=2))


def test_a_door_has_its_own_defaults_whether_it_takes_settings_or_keywords():
    teacher = llf_teacher.TeacherEnv(GRIDWORLD, settings=Settings(max_turns=2), episodes=2)
    assert (teacher.settings.speech, teacher.settings.until_success) == ("kinds", True)
    assert family("gridworld").raw_env(seating="classroom", settings=Settings(max_turns=2)).speech == "kinds"


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"settings": {"text": True}}, "settings must be a Settings, got"),
        ({"options": None}, "options must be a mapping of the world's options, got None"),
        ({"ask_cost": -1}, "ask_cost must be a finite number of at least 0, got -1"),
        ({"speech": "kinds"}, "does not use speech from this seat; leave it out"),
    ],
)
def test_settings_that_are_none_are_refused(given, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.StudentEnv(GRIDWORLD, **given)


def test_the_teachers_environment_has_no_policy_in_its_own_seat():
    with pytest.raises(ValueError, match="bad personality spec"):
        llf_teacher.TeacherEnv(GRIDWORLD, teacher=object())
