"""The control `misaligned` in panels, vectors, environments of one's own, and studies."""

import gymnasium
import numpy as np
import pytest
from commands import llf

import llf_teacher
from llf_teacher import teach
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.gym import StudentEnv
from llf_teacher.studies import Study, load, run
from llf_teacher.studies.execution.episode import play
from llf_teacher.theme.turns import prepare_turns
from pz_envs.family import all_families
from teachers.session import Session

GRID = "llf-gridworld-v0"
FP = "only(kinds='fp')"


def test_in_a_panel_each_claim_is_traced_to_its_speaker():
    family = next(each for each in all_families() if each.name == "gridworld")
    world = family.make_world()
    teachers = [family.make_teacher(world), family.make_teacher(world, personality="misaligned")]
    session = Session(world, teachers, max_turns=20)
    session.open(1)
    session.speak()
    session.act(1)
    session.speak()
    assert {(atom.speaker, session.origin(atom) is not None) for atom in session.atoms} == {
        ("teacher_0", False),
        ("teacher_1", True),
    }


def test_rows_of_a_vector_hear_what_single_environments_hear():
    rows = gymnasium.make_vec(GRID, num_envs=2, vectorization_mode="sync", teacher="misaligned")
    rows.reset(seed=[4, 5])
    heard = [rows.step(np.array([1, 1]))[0]["feedback"] for _ in range(3)]
    for row, seed in enumerate((4, 5)):
        env = StudentEnv(GRID, teacher="misaligned")
        env.reset(seed=seed)
        assert [env.step(1)[0]["feedback"] for _ in range(3)] == [str(each[row]) for each in heard]


@pytest.mark.parametrize("name", ["FrozenLake-v1", "CliffWalking-v1"])
def test_an_environment_of_ones_own_has_other_moments_too(name):
    env = teach(gymnasium.make(name), oracle="auto", teacher="misaligned")
    env.reset(seed=1)
    lab = env.session.world.scratch()
    said = 0
    for _ in range(6):
        _, _, terminated, truncated, info = env.step(env.action_space.sample())
        for atom in info["atoms"]:
            if atom.kind is not None:
                said += 1
                assert atom.claim.holds(env.session.origin(atom), lab)
        if terminated or truncated:
            break
    assert said


def test_what_the_student_is_shown_does_not_tell_where_a_claim_is_from():
    """Not even a claim that was taken from elsewhere has the moment in it."""
    env = StudentEnv(GRID, teacher="misaligned")
    env.reset(seed=1)
    observation, _, _, _, info = env.step(1)
    plain = StudentEnv(GRID)
    plain.reset(seed=1)
    shown = plain.step(1)[4]
    assert set(info) == set(shown)
    assert {type(atom) for atom in info["atoms"]} == {type(atom) for atom in shown["atoms"]}
    assert "Truth" not in repr((observation, info))


def test_a_study_has_it_as_its_baseline(tmp_path):
    study = Study(
        ids=[GRID, "llf-bandits-BanditTenArmedGaussian-v0"],
        teachers=[FP, f"{FP} | misaligned", f"{FP} | placebo", "silent"],
        students=["obedient", "obedient | misconception"],
        baseline=f"{FP} | misaligned",
        seeds=tuple(range(6)),
        max_turns=8,
    )
    run(study, tmp_path / "study.db", workers=1)
    with load(tmp_path / "study.db") as results:
        lost = results.episodes.groupby(["student", "teacher"])["regret"].mean()
        words = results.episodes.groupby("teacher")["words"].mean()
    assert lost["obedient", FP] == 0
    assert min(lost["obedient", each] for each in (f"{FP} | misaligned", f"{FP} | placebo", "silent")) > 5
    # Advice never names the belief, so that nobody is better than silence.
    assert lost["obedient | misconception", FP] == lost["obedient | misconception", "silent"]
    assert words[f"{FP} | misaligned"] / words[f"{FP} | placebo"] == pytest.approx(1, rel=0.15)


def test_a_watched_lesson_says_where_each_sentence_is_true(tmp_path):
    result = llf("play", GRID, "--student", "obedient", "--teacher", "misaligned", "--seed", "3", cwd=tmp_path)
    assert "[✗ false here, true elsewhere]" in result.stdout
    assert "[✓ true here, true elsewhere]" in result.stdout


def test_a_report_names_claims_of_other_lessons():
    spec = EpisodeSpec(GRID, "misaligned", "random", "b", "a", 3, 3, llf_teacher.__version__)
    turns = prepare_turns([turn._asdict() for turn in play(spec).turns], "gridworld")
    codes = [atom["code"] for turn in turns for atom in turn["atoms"] if atom["kind"] is not None]
    assert codes
    assert all(code.endswith(" of another world, true there") for code in codes)
