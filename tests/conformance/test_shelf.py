"""Every personality with every family that it serves; both registries, so that new ones are checked by themselves."""

from dataclasses import replace

import gymnasium
import lake
import numpy as np
import pytest
from design import amount, sampled
from lessons import episodes, lab, pupil, taught
from shelf import FAMILIES, pairs

import llf_teacher
from llf_teacher.registry import PREFIX
from llf_teacher.tools.audit import audit
from pz_envs.lesson import Lesson
from pz_envs.text.actions import parse_action
from teachers.common import Example
from teachers.oracle import POSTERIOR
from teachers.personality import PERSONALITIES, parse_personality
from teachers.testing import PERSONALITY_CHECKS
from worlds.testing import plain

TURNS = amount(20, full=40)  # a pair: some worlds are slow
MORE = (
    "mistake(eps=1)",
    "sycophant(p=1)",
    "adversarial(budget=100)",
    "inconsistent(consistency=0)",
    "feature_noise(low=1, high=1)",
    "drifting(after=1, to='mistake(eps=1)')",
    "delayed | vague(q=1)",
    "vague(q=1) | delayed",
    "worked_example(n=5) | delayed(turns=2)",
    "verification | verbose",
    "hinter(level=1)",
    "end_of_episode(top_k=100)",
)
on_every_pair = pytest.mark.parametrize(("name", "spec"), pairs(*MORE))


def said(name, spec):
    return [turn for episode in taught(name, spec, TURNS) for turn in episode]


@sampled(lambda name, spec, check: {(check, name), (check, spec)})
@on_every_pair
@pytest.mark.parametrize("check", PERSONALITY_CHECKS, ids=lambda check: check.__name__)
def test_personality(name, spec, check):
    check(parse_personality(spec), replace(pupil(name), turns=TURNS))


@sampled(lambda name, spec: {name, spec})
@on_every_pair
def test_the_worlds_trace_is_the_same_as_without_a_teacher(name, spec):
    def trace(teacher):
        env = llf_teacher.make(PREFIX + FAMILIES[name].showcase[0], teacher=teacher)
        env.reset(seed=5)
        rng = np.random.default_rng(1)
        turns, done = [], False
        while not done and len(turns) < 12:
            _, reward, terminated, truncated, info = env.step(env.session.world.sample_action(rng))
            turns.append((reward, terminated, truncated, info["success"], plain(env.session.world.truth)))
            done = terminated or truncated
        return turns

    assert trace(spec) == trace("silent")


@sampled(lambda name, spec: {name, spec})
@pytest.mark.parametrize(
    ("name", "spec"), [(n, s) for n in FAMILIES for s in PERSONALITIES.names if not FAMILIES[n].serves(s)]
)
def test_who_cannot_serve_says_so_when_a_teacher_is_made(name, spec):
    family = FAMILIES[name]
    able = family.oracle_class().abilities() | family.posterior_abilities
    missing = sorted(parse_personality(spec).needs - able)
    message = f"needs {', '.join(missing)} of the oracle, which .* does not give"
    if POSTERIOR in missing or not missing:
        message = "needs a posterior: .*(families with one|set the option .*=).*; elsewhere use another, such as oracle"
    for each in (spec, f"oracle | {spec}", f"drifting(to='{spec}')"):
        with pytest.raises(ValueError, match=message):
            family.make_teacher(lab(name), each)


@pytest.mark.parametrize("name", [name for name, spec in pairs() if spec == "worked_example"])
def test_worked_examples_are_written_as_a_student_has_to_write_them(name):
    examples = [a.claim for _, atoms, _ in said(name, "worked_example") for a in atoms if type(a.claim) is Example]
    assert examples
    world = lab(name)
    for example in examples:
        assert plain(example.action) == plain(example.actions[0])
        if name == "movies":  # lists of titles
            assert example.steps == ", then ".join(example.actions)
        elif isinstance(example.action, str):
            assert all(f'"{action}"' in example.steps for action in example.actions)
        else:
            read = [parse_action(step, world) for step in example.steps.split(", then ")]
            assert plain(read) == plain(list(example.actions))


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_serves_what_needs_nothing(name):
    assert {spec for spec in PERSONALITIES.names if not parse_personality(spec).needs} <= {
        spec for spec in PERSONALITIES.names if FAMILIES[name].serves(spec)
    }


def test_the_student_of_these_tests_is_right_and_wrong():
    for name in FAMILIES:
        assert len(episodes(name, TURNS)) >= (2 if FAMILIES[name].max_turns < TURNS else 1)
        assert pupil(name).max_turns == FAMILIES[name].max_turns


@pytest.mark.parametrize("spec", PERSONALITIES.names)
def test_a_users_own_environment_and_oracle_are_served(spec):
    lesson = Lesson(
        lambda: gymnasium.make("FrozenLake-v1", is_slippery=False),
        lake.LakeOracle,
        phrases=lake.PHRASES,
        look=lambda env: int(env.unwrapped.s),
        action_words=lake.WORDS,
    )
    if not lesson.serves(spec):
        assert parse_personality(spec).needs - lake.LakeOracle.abilities() in ({"hints"}, {"clues"}, {POSTERIOR})
        return
    found = audit(lesson, spec, turns=amount(9, full=18))
    assert found.honest == parse_personality(spec).honest
    assert not found.caught, found.examples
