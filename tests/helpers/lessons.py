"""Episodes of a student who is right now and then and repeats itself, and what teachers say of them."""

from functools import cache

import numpy as np
from shelf import FAMILIES

from teachers.atoms import Moment
from teachers.testing import Pupil


@cache
def pupil(name):
    family = FAMILIES[name]
    options = family.environments[family.showcase[0]]
    return Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns)


@cache
def episodes(name, turns):
    """Lists of moments, one an episode. The student follows a plan, tries something, or does the same again."""
    world = pupil(name).make_world()
    oracle = pupil(name).make_teacher(world).oracle
    rng = np.random.default_rng(0)
    played = []
    while sum(map(len, played)) - len(played) < turns:
        world.reset(seed=int(rng.integers(2**31)))
        oracle.start(world.truth)
        moments = [Moment.opening(world.truth)]
        for turn in range(1, pupil(name).max_turns + 1):
            draw, plan = rng.random(), oracle.plan(world.truth, 1)
            if draw < 0.4 and plan:
                action = plan[0]
            elif draw < 0.7 and turn > 1:
                action = moments[-1].action
            else:
                action = world.sample_action(rng)
            before, action = world.truth, world.legal(action)
            _, reward, terminated, truncated, info = world.advance(action)
            over = terminated or truncated or turn == pupil(name).max_turns
            moments.append(Moment(before, action, reward, world.truth, info["success"], turn, over))
            if over:
                break
        played.append(moments)
    return played


@cache
def lab(name):
    return pupil(name).make_world()


@cache
def taught(name, spec, turns=2000, feedback_type="a"):
    """Per episode and turn the moment, the atoms of feedback and the oracle's claims."""
    teacher = pupil(name).make_teacher(pupil(name).make_world(), spec, feedback_type=feedback_type)
    rng = np.random.default_rng(0)
    heard = []
    for moments in episodes(name, turns):
        teacher.reset(rng.spawn(1)[0])
        heard.append([])
        for moment in moments:
            atoms = tuple(atom for atom in teacher.speak(moment).atoms if atom.kind is not None)
            heard[-1].append((moment, atoms, teacher.oracle.judge(moment)))
    return heard


@cache
def oracles(name, turns=2000):
    """Per episode an oracle that has begun it."""
    begun = []
    for moments in episodes(name, turns):
        oracle = pupil(name).make_teacher(pupil(name).make_world()).oracle
        oracle.start(moments[0].after)
        begun.append(oracle)
    return begun
