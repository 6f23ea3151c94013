"""Every environment of the registry passes the kits that ship with the packages."""

from itertools import product

import numpy as np
import pytest
from design import COSTLY, amount, sampled
from gymnasium.utils.env_checker import check_env
from sampling import ENTRIES, fewer, practice

import llf_teacher
from llf_teacher.registry import PREFIX, entries, family
from pz_envs import testing as seat_kit
from pz_envs.family import all_families
from teachers import testing as teacher_kit
from teachers.feedback import parse_kinds
from worlds import testing as world_kit

SHOWCASE = [entries()[PREFIX + family.showcase[0]] for family in all_families()]


def name(value):
    return getattr(value, "id", None) or getattr(value, "__name__", None)


def pupil(entry, turns=1000):
    family, options = entry.family, entry.options
    turns = fewer(family, turns)
    return teacher_kit.Pupil(
        lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns, turns=turns
    )


@sampled(lambda entry, check: {entry.id, (entry.family.name, check)})
@pytest.mark.parametrize("check", world_kit.CHECKS, ids=name)
@pytest.mark.parametrize("entry", ENTRIES)
def test_world(entry, check):
    check(lambda: entry.family.make_world(**entry.options))


@sampled(lambda entry, check: {entry.id, (entry.family.name, check)})
@pytest.mark.parametrize("check", teacher_kit.CHECKS, ids=name)
@pytest.mark.parametrize("entry", ENTRIES)
def test_oracle(entry, check):
    check(pupil(entry, turns=amount(60, full=120)))


@pytest.mark.full
@pytest.mark.parametrize("check", teacher_kit.CHECKS, ids=name)
@pytest.mark.parametrize("entry", SHOWCASE, ids=name)
def test_oracle_for_long(entry, check):
    check(pupil(entry, turns=1000))


@sampled(lambda entry, check: {entry.id, (entry.family.name, check)})
@pytest.mark.parametrize("check", seat_kit.CHECKS, ids=name)
@pytest.mark.parametrize("entry", ENTRIES)
def test_seats(entry, check):
    check(lambda **settings: entry.family.env(**entry.options, **settings))


# A box has the units and the bounds, if any, of its world; Gymnasium would rather see actions from -1 to 1.
@pytest.mark.filterwarnings("ignore:.*we recommend using a symmetric and normalized space:UserWarning")
@pytest.mark.filterwarnings("ignore:.*A Box observation space (minimum|maximum) value is -?infinity:UserWarning")
@pytest.mark.parametrize("entry", ENTRIES)
@pytest.mark.parametrize("text", [False, True])
def test_gymnasium_check_env(entry, text):
    check_env(llf_teacher.make(entry.id, text=text), skip_render_check=True)


def options(entry):
    """All options that an environment's oracle supports."""
    oracle = entry.family.oracle_class()
    feedback = ("a", "n", "m", "r", "hp", "hn", "fp", "fn", "r+hp+hn", ["fp", "fn"])
    given = [each for each in feedback if each in ("a", "n", "m") or parse_kinds(each) <= {*oracle.feedback_types}]
    return product([entry], oracle.instruction_types, given, ["oracle", "mix", "mistake"])


@sampled(
    lambda entry, instruction_type, feedback_type, teacher: {
        (entry.id, each) for each in (instruction_type, str(feedback_type), teacher)
    }
)
@pytest.mark.parametrize(
    ("entry", "instruction_type", "feedback_type", "teacher"),
    [case for entry in SHOWCASE for case in options(entry)],
    ids=name,
)
def test_cross_of_options(entry, instruction_type, feedback_type, teacher):
    settings = {"instruction_type": instruction_type, "feedback_type": feedback_type, "teacher": teacher}
    env = llf_teacher.make(entry.id, **settings, max_turns=fewer(entry.family, 19) + 1, privileged_info=True)
    wanted = env.teacher._kinds | {None}
    rng = np.random.default_rng(0)
    lab = env.session.world.scratch()
    observation, info = env.reset(seed=0)
    assert observation["instruction"]
    said = [atom for atom in info["atoms"] if atom.text in observation["feedback"]]
    moments = [info["moment"]]
    done = False
    while not done:
        assert {atom.kind for atom in said} <= wanted
        if teacher != "mistake":
            assert all(atom.claim.holds(moments[atom.about_turn], lab) for atom in said)
        observation, _, terminated, truncated, info = env.step(env.session.world.sample_action(rng))
        moments.append(info["moment"])
        said = info["atoms"]
        assert " ".join(atom.text for atom in said) == observation["feedback"]
        done = terminated or truncated


@pytest.mark.parametrize("entry", SHOWCASE, ids=name)
def test_what_mistake_says_with_certainty_is_false(entry):
    turns = amount(30 if entry.family.name in COSTLY else 120, full=300)
    feedback = [
        (atom, moment, lab)
        for atom, moment, lab in pupil(entry, turns=turns).atoms(personality="mistake(eps=1)")
        if atom.kind is not None
    ]
    assert len(feedback) > fewer(entry.family, turns)
    assert not [atom for atom, moment, lab in feedback if atom.claim.holds(moment, lab)]


@sampled(lambda entry, settings, paraphrase: {(entry.id, str(settings)), (entry.id, str(paraphrase))})
@pytest.mark.parametrize("entry", SHOWCASE, ids=name)
@pytest.mark.parametrize("settings", [{"instruction_type": practice}, {"personality": "mistake"}], ids=["p", "mistake"])
@pytest.mark.parametrize("paraphrase", ["random", 3, lambda templates, **slots: templates[-1].format(**slots)])
def test_the_worlds_trace_does_not_depend_on_teacher_or_voice(entry, settings, paraphrase):
    def trace(**settings):
        teacher = settings.pop("personality", "oracle")
        settings = {key: value(entry.family) if value is practice else value for key, value in settings.items()}
        env = llf_teacher.make(entry.id, teacher=teacher, **settings)
        env.reset(seed=5)
        seen = []
        for action in world_kit.some_actions(env.session.world, env.session.max_turns):
            outcome = env.step(action)[1:4]
            seen.append(world_kit.plain((outcome, env.session.world.truth)))
            if any(outcome[1:]):
                break
        return seen

    assert trace(**settings, paraphrase=paraphrase) == trace()


def test_ids_follow_llf_bench():
    assert "llf-gridworld-v0" in llf_teacher.ids()
    assert len(llf_teacher.ids()) == len(set(llf_teacher.ids())) == sum(len(f.environments) for f in all_families())


def test_a_family_is_found_by_its_name():
    assert [family(each.name) for each in all_families()] == list(all_families())
    near = all_families()[0].name
    with pytest.raises(ValueError, match=f"unknown family '{near}s'; did you mean {near}.*? allowed: {near}, "):
        family(f"{near}s")
