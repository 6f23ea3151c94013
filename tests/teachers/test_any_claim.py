"""The check of a claim gives an answer whatever its fields: a claim that names what does not exist is false."""

import dataclasses
import math
import warnings
from collections import Counter, defaultdict
from enum import Enum

import numpy as np
import pytest
from design import amount
from shelf import FAMILIES, lightest

import llf_teacher
from llf_teacher.registry import PREFIX
from teachers.atoms import Claim, action_of, claim
from teachers.common import Better, Example
from teachers.oracles.bandits import Avoid
from teachers.personality import PERSONALITIES

EXTREMES = {
    bool: (True, False),
    int: (-1, 0, 1, 10**6, 2**70),
    float: (-1.0, 0.0, math.nan, math.inf, 1e300),
    str: ("", "nonsense", "0", "é\n", '["a"]'),
}


def other_values(value):
    """Values of the same type, hardly any of which fits."""
    if isinstance(value, Enum):
        return [each for each in type(value) if each is not value]
    if isinstance(value, tuple):
        ends = [(other, *value[1:]) for other in other_values(value[0])[:4]] if value else []
        return [(), value[:1], value[::-1], value * 2, *ends]
    return list(EXTREMES.get(type(value), ()))


def said(family, env, turns):
    """Claims, the moments that they are about, and the truths of their episodes.

    They come from oracles and all personalities, in random play.
    """
    found = []
    specs = [lightest(name) for name in PERSONALITIES.names if family.serves(lightest(name))]
    types = sorted(env.session.teacher.oracle.instruction_types)
    for number, spec in enumerate(["oracle", *specs]):
        teacher = family.make_teacher(env.session.world, spec, instruction_type=types[number % len(types)])
        session = type(env.session)(env.session.world, [teacher], max_turns=family.max_turns)
        rng, moments = np.random.default_rng(number), []
        moments.append(session.open(number))
        while True:
            session.speak()
            found += [(atom.claim, moments[atom.about_turn], moments[0].after) for atom in session.atoms]
            if session.over or session.moment.turn >= turns:
                break
            moments.append(session.act(session.world.sample_action(rng)))
    return found


@pytest.mark.parametrize("name", FAMILIES)
def test_no_check_raises(name):
    family = FAMILIES[name]
    few = amount(1 if family.slow else 2, full=6)
    rng, checked = np.random.default_rng(0), Counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = llf_teacher.make(PREFIX + family.showcase[0])
        lab, oracle = env.session.world.scratch(), env.session.teacher.oracle
        claims = said(family, env, turns=amount(2, full=6))
        moments = [moment for _, moment, _ in claims]
        pool = defaultdict(list)
        for each, *_ in claims:
            for field in dataclasses.fields(each):
                pool[type(each), field.name].append(getattr(each, field.name))
        for each, moment, truth in claims:
            if checked[type(each)] >= few:
                continue
            checked[type(each)] += 1
            oracle.start(truth)
            for field in dataclasses.fields(each):
                own = pool[type(each), field.name]
                drawn = [own[i] for i in rng.integers(len(own), size=2)]
                for value in [*other_values(getattr(each, field.name)), *drawn]:
                    try:
                        changed = dataclasses.replace(each, **{field.name: value})
                    except (TypeError, ValueError):  # the class refuses such a field
                        continue
                    about = (moment, moments[int(rng.integers(len(moments)))])[int(rng.integers(2))]
                    assert changed.holds(about, lab) in (True, False), changed
                    assert changed.means(about, oracle) in (True, False), changed
    assert len(checked) > 4


@claim
class Third(Claim):
    """True if the third number is 1."""

    numbers: tuple[int, ...]

    def holds(self, moment, lab):
        if not self.numbers:
            raise RuntimeError("broken")
        return self.numbers[2] == 1


def test_what_does_not_exist_is_false_and_a_broken_check_is_an_error():
    assert [Third(numbers=each).holds(None, None) for each in ((0, 0, 1), (0, 0, 2), (1,))] == [True, False, False]
    with pytest.raises(RuntimeError, match="broken"):
        Third(numbers=()).holds(None, None)


def test_no_number_counts_actions_from_the_end():
    """-1 is no action: a comparison with it is false, not one with the last action."""
    env = llf_teacher.make("llf-bandits-BanditTenArmedRandomRandom-v0")
    moment = env.session.open(0)
    oracle = env.session.teacher.oracle
    oracle.start(moment.after)
    values = list(oracle.values(moment.after))
    last, worst = len(values) - 1, values.index(min(values))
    assert last != worst
    assert Better(this=last, that=worst).means(moment, oracle)
    assert not Better(this=-1, that=worst).means(moment, oracle)
    assert not Better(this=last, that=99).means(moment, oracle)


def test_a_plan_without_actions_excludes_nothing():
    empty, warning = Example(actions=()), Avoid(action=0)
    assert action_of(empty) is None
    assert not empty.excludes(warning)
    assert not warning.excludes(empty)
