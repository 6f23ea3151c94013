"""Episodes of a student who is right now and then and repeats itself, and what teachers say of them."""

from functools import cache, lru_cache

import numpy as np
import pytest
from scipy.stats import binomtest
from shelf import FAMILIES

from teachers.testing import Pupil

ALPHA = 1e-4
CHEAP = ("bandits", "gridworld")
on_cheap_families = pytest.mark.parametrize("name", CHEAP)


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
def oracles(name, turns=2000):
    """Per episode an oracle that has begun it."""
    begun = []
    for moments in episodes(name, turns):
        oracle = pupil(name).make_teacher(pupil(name).make_world()).oracle
        oracle.start(moments[0].after)
        begun.append(oracle)
    return begun


@cache
def truths(name, turns):
    """Per episode and turn the oracle's claims, which are the same whatever the personality."""
    played = zip(oracles(name, turns), episodes(name, turns), strict=True)
    return [[oracle.judge(moment) for moment in moments] for oracle, moments in played]


@lru_cache(
    maxsize=2
)  # of a hundred teachers, whose words over thousands of turns take much memory; few are asked twice
def taught(name, spec, turns=2000, feedback_type="a"):
    """Per episode and turn the moment, the atoms of feedback and the oracle's claims."""
    teacher = pupil(name).make_teacher(pupil(name).make_world(), spec, feedback_type=feedback_type)
    rng = np.random.default_rng(0)
    heard = []
    for moments, true in zip(episodes(name, turns), truths(name, turns), strict=True):
        teacher.reset(rng.spawn(1)[0])
        said = [tuple(atom for atom in teacher.speak(moment).atoms if atom.kind is not None) for moment in moments]
        heard.append(list(zip(moments, said, true, strict=True)))
    return heard


def rows(name, spec, **settings):
    """Per episode its oracle, and per turn the moment, the claims said and the oracle's claims."""
    for oracle, episode in zip(oracles(name), taught(name, spec, **settings), strict=True):
        yield oracle, [(moment, [atom.claim for atom in atoms], list(true)) for moment, atoms, true in episode]


def turns(name, spec, **settings):
    for oracle, episode in rows(name, spec, **settings):
        for moment, said, true in episode:
            yield oracle, moment, said, true


def of(claims, *kinds):
    return [claim for claim in claims if claim.kind in kinds]


def without(claims, *kinds):
    return [claim for claim in claims if claim.kind not in kinds]


def fits(successes, trials, p):
    return binomtest(int(successes), trials, p).pvalue > ALPHA
