"""Episodes of a student who is right now and then and repeats itself, and what teachers say of them."""

from functools import cache

import numpy as np
from shelf import FAMILIES

from teachers.testing import Pupil


@cache
def pupil(name):
    family = FAMILIES[name]
    options = family.environments[family.showcase[0]]
    return Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns)


@cache
def episodes(name, turns):
    """Lists of moments, one an episode."""
    return pupil(name).episodes(turns)


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
