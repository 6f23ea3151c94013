"""What a study declares beside its lists, and lessons before a test."""

import numpy as np
import pytest

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.analysis import transfer
from llf_teacher.studies.analysis.outcomes import outcomes
from llf_teacher.studies.definition.design import SUBSETS
from llf_teacher.studies.definition.study import Study, load_study
from llf_teacher.studies.execution.episode import attend, play
from llf_teacher.studies.report import to_toml
from llf_teacher.studies.store import Store
from teachers.atoms import KINDS

ROOMS = "llf-gridworld-v0"
LEARNER = "q_learning(trust=1.0, forget=False)"


def small(**changes):
    settings = {"ids": [ROOMS], "teachers": ["oracle", "silent", "placebo"], "students": ["random", LEARNER]}
    return Study(**(settings | {"seeds": 4} | changes))


def test_a_baseline_is_one_of_the_teachers():
    assert small().baseline == "silent"
    assert small(baseline=" placebo( ) ").baseline == "placebo"
    with pytest.raises(ValueError, match=r"baseline: unknown teacher 'retry_only'; .*allowed: oracle, silent, placebo"):
        small(baseline="retry_only")
    with pytest.raises(ValueError, match="baseline: unknown teacher 'nobody'; allowed: oracle, silent, placebo"):
        small(baseline="nobody")


def test_a_study_without_the_silent_teacher_needs_no_baseline():
    assert small(teachers=["oracle"]).baseline == "silent"


def test_subsets_are_all_subsets_of_the_kinds():
    study = small(feedback_types="subsets")
    assert study.feedback_types == SUBSETS
    assert len({frozenset(type_.split("+")) for type_ in SUBSETS}) == 2 ** len(KINDS)
    assert SUBSETS[0] == "n"


def test_looks_order_the_episodes():
    study = small(interim_analyses={"at": [1, 4]})
    assert study.interim_analyses == {"at": (1, 4), "spending": "obrien_fleming", "stop": False}
    seeds = [spec.seed for spec in study.episodes()]
    assert seeds == [0] * 6 + [1, 2, 3] * 6
    assert {spec.key for spec in study.episodes()} == {spec.key for spec in small().episodes()}
    with pytest.raises(
        ValueError, match="interim_analyses: at must be ascending numbers of seeds, the last one the study's 4"
    ):
        small(interim_analyses={"at": [1, 2]})


def test_tests_come_beside_the_other_episodes():
    study = small(transfer={"lessons": [2, 5], "teachers": ["oracle", "silent"], "feedback_types": ["fp"]})
    assert study.transfer["students"] == (LEARNER,)
    specs = list(study.episodes())
    plain, tests = ([spec for spec in specs if bool(spec.lessons) is after] for after in (False, True))
    assert plain == list(small().episodes())
    assert len(tests) == 2 * 2 * 4
    assert {(spec.lessons, spec.taught, spec.worlds, spec.feedback_type) for spec in tests} == {
        (number, ROOMS, "same", "fp") for number in (2, 5)
    }
    assert len({spec.key for spec in specs}) == len(specs)


def test_tests_may_have_teachers_and_students_of_their_own():
    rooms, arms = ROOMS, "llf-bandits-BanditTwoArmedHighLowFixed-v0"
    study = small(
        ids=[rooms, arms],
        teachers=["oracle", "placebo"],
        students=["random", LEARNER, "obedient(forget=False)"],
        fewer={"llf-bandits-*": {"students": ["random", "obedient(forget=False)"], "teachers": ["oracle"]}},
        transfer={"lessons": [1], "teachers": ["oracle", "placebo", "silent"], "taught": [rooms]},
    )
    assert study.tests(rooms).teachers == ("oracle", "placebo", "silent")
    assert study.tests(rooms).students == (LEARNER, "obedient(forget=False)")
    assert study.tests(arms).teachers == ("oracle", "silent")
    assert study.tests(arms).students == ("obedient(forget=False)",)
    assert study.tests(arms).taught == ()
    assert {spec.taught for spec in study.episodes() if spec.lessons} == {rooms}
    with pytest.raises(ValueError, match=r"teachers: .* cannot have 'myopic'"):
        small(ids=["llf-poem-Haiku-v0"], transfer={"lessons": [1], "teachers": ["myopic"]})


@pytest.mark.parametrize("student", ["obedient", "text_only"])
@pytest.mark.parametrize("id", [ROOMS, "llf-highway-parking-v0", "llf-optimization-Booth-v0", "llf-poem-Haiku-v0"])
def test_who_believes_may_remember_what_was_said(student, id):
    spec = EpisodeSpec(id, "oracle", f"{student}(forget=False)", "b", "fp", 10, 0, "", "", 3, id, "same")
    remembered = play(spec).episode
    forgot = play(spec._replace(student=student)).episode
    assert remembered.regret < forgot.regret
    assert remembered.words == 0


def test_forgetting_is_yes_or_no():
    with pytest.raises(ValueError, match="forget must be True or False, got 2"):
        parse_student("obedient(forget=2)")


def test_keys_of_episodes_without_lessons_are_those_of_ever():
    spec = EpisodeSpec("x-v0", "oracle", "random", "b", "a", 5, 0, "0.1.0", "2.1")
    assert spec.key == "3716bf27ed095eaa20a7a1856623a21a"
    assert spec._replace(lessons=1, taught="x-v0", worlds="same").key != spec.key


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ({"taught": [ROOMS]}, "transfer must be a table with `lessons`"),
        ({"lessons": [0]}, r"transfer: lessons must be integers from 1 to 1000000, got \[0\]"),
        ({"lessons": 5}, "transfer: lessons must be a non-empty list, got 5"),
        ({"lessons": [1], "worlds": ["other"]}, "transfer: unknown worlds 'other'; .*allowed: same, next"),
        ({"lessons": [1], "test": []}, "transfer: unknown key 'test'"),
        (
            {"lessons": [1], "students": ["random"]},
            "students must remember earlier episodes, got random; .* with forget=False",
        ),
        ({"lessons": [1], "teachers": ["nobody"]}, "transfer: teachers: unknown personality 'nobody'"),
        ({"lessons": [1], "taught": ["llf-poem-Haiku-v0"]}, "transfer: taught: the study has no id of the family of"),
        ({"lessons": [1], "taught": ["nowhere"]}, "transfer: taught: .*nowhere"),
        ({"lessons": [1], "feedback_types": ["x"]}, "transfer: feedback_types: .* names 'x'"),
    ],
)
def test_a_bad_transfer_is_refused(table, match):
    with pytest.raises(ValueError, match=match):
        small(transfer=table)


def test_a_file_declares_all(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(f"""
ids = ["{ROOMS}"]
teachers = ["oracle", "retry_only"]
students = ["{LEARNER}"]
feedback_types = "subsets"
baseline = "retry_only"
seeds = 10
[interim_analyses]
at = [5, 10]
spending = "pocock"
[transfer]
lessons = [3]
worlds = ["same", "next"]
""")
    study = load_study(path)
    assert (study.baseline, len(study.feedback_types)) == ("retry_only", 32)
    assert study.interim_analyses == {"at": (5, 10), "spending": "pocock", "stop": False}
    assert Study(**study.as_dict()) == study
    path.write_text(to_toml(study))
    assert load_study(path) == study


def test_what_was_learnt_in_the_same_world_is_known_in_the_test(tmp_path):
    study = small(seeds=6, teachers=["oracle", "silent"], transfer={"lessons": [8]})
    tests = [spec for spec in study.episodes() if spec.lessons]
    with Store(tmp_path / "s.db") as store:
        for spec in tests:
            record = play(spec)
            assert not any(turn.feedback for turn in record.turns)
            assert record.episode.claims == 0
            store.add(record)
        told = list(transfer.tested(outcomes(store.rows()), study.baseline))
    fresh = [spec._replace(lessons=0, taught="", worlds="") for spec in tests if spec.teacher == "silent"]
    untaught = np.mean([play(spec).episode.regret for spec in fresh])
    taught, alone = told
    assert (taught.teacher, alone.teacher) == ("oracle", "silent")
    assert taught.regret.mean < alone.regret.mean < untaught
    assert taught.gain.mean == pytest.approx(alone.regret.mean - taught.regret.mean)
    assert alone.gain is None


class Diary:
    """A policy that notes what it goes through and does nothing sensible."""

    def __init__(self):
        self.starts, self.told, self.ends, self.draws = [], [], [], []

    def reset(self, rng):
        self.opening = True
        self.draws.append(rng.random())

    def act(self, observation, info):
        if self.opening:
            self.starts.append(str(observation["state"]))
        self.opening = False
        self.told.append(str(observation["feedback"]))
        return 0

    def finish(self, observation, info, terminated):
        self.ends.append(terminated)


@pytest.mark.parametrize("worlds", ["same", "next"])
def test_lessons_are_in_the_worlds_that_were_asked_for(worlds):
    spec = EpisodeSpec(ROOMS, "oracle", "random", "b", "fp", 3, 7, "", "", 4, ROOMS, worlds)
    diary, again = Diary(), Diary()
    for each in (diary, again):
        attend(spec, parse_student("random"), each)
    env = make(ROOMS)
    start = str(env.reset(seed=7)[0]["observation"])
    assert len(diary.starts) == len(diary.ends) == 4
    assert [start == each for each in diary.starts] == [worlds == "same"] * 4
    assert len(set(diary.starts)) == (1 if worlds == "same" else 4)
    assert all(diary.told)
    assert len(set(diary.draws)) == 4  # each lesson has fresh randomness
    assert vars(diary) == vars(again)
