"""Episodes of a setting share their environment, and none can be told from one that is played alone."""

import threading

import pytest

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import entries
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution import episode
from llf_teacher.studies.execution.episode import close_lessons, play
from llf_teacher.studies.execution.worker import Packed, run_episode

ID = "llf-gridworld-v0"
IDS = [each.id for each in entries().values() if each.sampled and not each.family.missing()]


@pytest.fixture
def made(monkeypatch):
    """The ids of the environments that are made."""
    made = []

    class Counted(StudentEnv):
        def __init__(self, id, **keywords):
            made.append(id)
            super().__init__(id, **keywords)

    close_lessons()
    monkeypatch.setattr(episode, "StudentEnv", Counted)
    yield made
    close_lessons()


def alone(spec):
    """An episode that shares nothing with those before it."""
    close_lessons()
    return run_episode(spec)


def untimed(packed):
    """An episode without how long it was played."""
    return packed._replace(seconds=0.0)


@pytest.mark.parametrize("id", IDS)
def test_an_episode_does_not_depend_on_those_before_it(id):
    slow = entries()[id].family.slow
    teachers = ["mistake(eps=0.5) | delayed(turns=1)"] if slow else ["oracle", "mistake(eps=0.5) | delayed(turns=1)"]
    students = ["random", "faulty:Agent"]  # the second one reads and writes texts
    study = Study(ids=[id], teachers=teachers, students=students, feedback_types=["m"], seeds=3, max_turns=4)
    specs = list(study.episodes())
    close_lessons()
    together = [run_episode(spec) for spec in specs]
    assert all(isinstance(each, Packed) for each in together), together
    assert [untimed(each) for each in together] == [untimed(alone(spec)) for spec in specs]


@pytest.mark.parametrize("worlds", ["same", "next"])
def test_a_test_does_not_depend_on_those_before_it(worlds, made):
    study = Study(
        ids=[ID],
        teachers=["oracle"],
        students=["q_learning(forget=False)"],
        seeds=3,
        max_turns=6,
        transfer={"lessons": [2], "worlds": [worlds]},
    )
    tests = [spec for spec in study.episodes() if spec.lessons]
    together = [run_episode(spec) for spec in tests]
    assert len(made) == 2, "one for the lessons, one for the tests"
    assert [untimed(each) for each in together] == [untimed(alone(spec)) for spec in tests]


def test_an_environment_is_made_once_for_a_setting(made):
    study = Study(ids=[ID], teachers=["oracle", "silent"], students=["random", "obedient", "faulty:Agent"], seeds=5)
    for spec in study.episodes():
        play(spec)
    assert len(made) == 4, "a teacher with students who act natively and with those who read texts"


def test_what_an_error_has_left_is_not_used_again(made, monkeypatch):
    first, second, third = Study(ids=[ID], teachers=["oracle"], students=["random"], seeds=3).episodes()
    play(first)

    def stop(turn):
        if turn == 2:
            raise KeyError(turn)

    with pytest.raises(KeyError):
        play(second, stop)
    assert len(made) == 1
    assert untimed(run_episode(third)) == untimed(alone(third))
    assert len(made) == 3


def test_a_teacher_that_is_defined_anew_teaches_anew(tmp_path, monkeypatch):
    """As in a notebook, where a name may stand for another class in the next run."""
    code = """
from teachers.personality import personality

@personality(source="folk")
def mine(claims, view):
    return claims[:{most}]
"""
    (tmp_path / "notes.py").write_text(code.format(most=0))
    monkeypatch.syspath_prepend(tmp_path)
    import notes

    (spec,) = Study(ids=[ID], teachers=["notes:mine"], students=["random"], seeds=1).episodes()
    close_lessons()
    assert not play(spec).episode.claims
    exec(code.format(most=9), vars(notes))
    assert play(spec).episode.claims


def test_threads_share_nothing(made):
    specs = list(Study(ids=[ID], teachers=["oracle"], students=["random"], seeds=4).episodes())
    expected = [alone(spec) for spec in specs]
    found = {}
    threads = [
        threading.Thread(target=lambda spec=spec: found.update({spec.seed: [play(spec) for _ in range(3)]}))
        for spec in specs
    ]
    made.clear()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == len(threads)
    assert [each.episode for spec in specs for each in found[spec.seed]] == [
        each.episode for each in expected for _ in range(3)
    ]
