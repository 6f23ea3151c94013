"""A teacher who chooses the very claims."""

import numpy as np
import pytest
from playing import earned

import llf_teacher
from pz_envs.family import all_families
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.teacher_view import CLAIM_COLUMNS
from teachers.atoms import ActionClaim
from teachers.teacher_turn import CLAIMS

MANY = next(family for family in all_families() if "reco-movie-v0" in family.environments)
GRID = next(family for family in all_families() if "gridworld-v0" in family.environments)
TITLES = '["Titanic", "Toy Story", "Jaws"]'


def after_a_list(**settings):
    """Seats whose student has named some titles, of which there is much to say."""
    env = MANY.raw_env(speech="claims", **settings)
    env.reset(seed=1)
    env.step(0)
    env.step(TITLES)
    return env


def test_one_claim_of_several_of_a_kind_is_said():
    env = after_a_list(cost=0.5)
    claims = env.infos[TEACHER]["claims"]
    kinds = [claim.kind for claim in claims]
    assert max(map(kinds.count, kinds)) > 1
    chosen = (len(claims) - 1, 1)
    for i in chosen:
        env.step(1 + i)
        assert env.rewards[TEACHER] == -0.5
        assert env.agent_selection == TEACHER
        assert env.observe(TEACHER)["action_mask"][1 + i] == 0
    env.step(0)
    said = [atom.claim for atom in env.observe(STUDENT)["feedback"].atoms]
    assert said == [claims[i] for i in sorted(chosen)]
    assert env.agent_selection == STUDENT


@pytest.mark.parametrize("paraphrase", [2, "random"])
@pytest.mark.parametrize("chosen", [(1,), (0, 2)])
def test_candidates_are_said_in_the_sentences_shown(paraphrase, chosen):
    env = after_a_list(paraphrase=paraphrase)
    for _ in range(3):
        info = env.infos[TEACHER]
        assert len(info["sentences"]) == len(info["claims"]) > 2
        for number in chosen:
            env.step(1 + number)
        env.step(0)
        assert [atom.text for atom in env.observe(STUDENT)["feedback"].atoms] == [info["sentences"][i] for i in chosen]
        env.step(TITLES)


def test_the_words_of_a_claim_do_not_depend_on_what_else_is_chosen():
    said = []
    for chosen in ((2,), (0, 2)):
        env = after_a_list()
        for number in chosen:
            env.step(1 + number)
        env.step(0)
        said.append(env.observe(STUDENT)["feedback"].atoms[-1].text)
    assert said[0] == said[1]


def test_sentences_of_candidates_are_drawn_once_and_ask_no_voice():
    asked = []
    env = after_a_list(voice=lambda sentence: asked.append(sentence) or sentence.upper())
    assert len(env.infos[TEACHER]["sentences"]) > 1
    assert asked == []
    env.step(1)
    env.step(0)
    assert len(asked) == 1
    twin, first = after_a_list(), after_a_list()
    for _ in range(3):
        twin.teacher_view.teacher_turn.sentences()
    for one in (first, twin):
        one.step(1)
        one.step(0)
    assert first.observe(STUDENT)["feedback"] == twin.observe(STUDENT)["feedback"]


def test_a_turn_ends_by_itself():
    env = after_a_list()
    for i in range(len(env.infos[TEACHER]["claims"])):
        assert env.agent_selection == TEACHER
        env.step(1 + i)
    assert env.agent_selection == STUDENT
    spent = after_a_list(budget=1)
    spent.step(1)
    assert spent.agent_selection == STUDENT
    assert len(spent.observe(STUDENT)["feedback"].atoms) == 1
    spent.step(TITLES)
    assert spent.observe(TEACHER)["action_mask"].tolist() == [1] + [0] * CLAIMS


@pytest.mark.parametrize("wrong", [CLAIMS, 2])
def test_what_cannot_be_said_ends_the_turn(wrong):
    env = after_a_list()
    env.step(2)
    env.step(wrong)
    assert env.agent_selection == STUDENT
    assert len(env.observe(STUDENT)["feedback"].atoms) == 1


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_the_table_tells_kind_and_role_of_each_claim(family):
    options = family.environments[family.showcase[0]]
    env = family.raw_env(speech="claims", **options)
    env.reset(seed=2)
    env.step(0)
    env.step(env.session.world.sample_action(np.random.default_rng(0)))
    claims, table = env.infos[TEACHER]["claims"], env.observe(TEACHER)["claims"]
    assert 0 < len(claims) <= CLAIMS
    for claim, row in zip(claims, table, strict=False):
        assert next(trait for trait, bit in zip(CLAIM_COLUMNS, row, strict=True) if bit) == claim.kind
        assert bool(row[CLAIM_COLUMNS.index("action")]) == isinstance(claim, ActionClaim)
    assert not table[len(claims) :].any()


def test_a_student_succeeds_by_one_claim_a_turn():
    def advise(observation, info):
        advice, mask = observation["claims"][:, CLAIM_COLUMNS.index("fp")], observation["action_mask"]
        wanted = [i for i in np.flatnonzero(advice) if mask[1 + i]]
        return 1 + int(wanted[0]) if wanted else 0

    env = llf_teacher.TeacherEnv("llf-gridworld-v0", student="obedient", speech="claims", cost=0.01, until_success=True)
    total = earned(env, advise, seed=4)
    assert env.session.moment.success
    assert total == pytest.approx(1 - 0.01 * env.teacher_view.teacher_turn.budget.spent)


def test_a_class_is_told_a_claim_at_a_time():
    env = GRID.raw_env(seating="classroom", students=2, attention=2, speech="claims")
    env.reset(seed=5)
    observation = env.observe(TEACHER)
    assert observation["claims"].shape == (2, CLAIMS, len(CLAIM_COLUMNS))
    env.step(env.address(1, 1))
    (atom,) = env.observe("student_1")["feedback"].atoms
    assert atom.claim == env.sessions[1].teacher_turns[0].listed()[0]
    assert not env.observe(TEACHER)["action_mask"][env.address(1, 1) : env.address(1, CLAIMS) + 1].any()
    env.step(0)
    assert env.agent_selection == "student_0"
