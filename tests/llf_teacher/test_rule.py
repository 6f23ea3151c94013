"""The verdict of a row, on numbers whose outcome is known."""

import numpy as np
import pytest
from design import amount
from scipy.stats import binom

from llf_teacher.reproductions.rule import Expectation, Rule, judge, saves, verdict

NORMAL = (np.random.default_rng(0).permutation(np.linspace(-1, 1, 41)), np.linspace(-1, 1, 41))


def measured(**columns):
    """Measurements with one number per seed, by setting."""
    tables = {name: np.asarray(column, float)[:, None] for name, column in columns.items()}
    return lambda name: tables[name]


def outcome(values, *comparisons):
    """The overall verdict, and those of the comparisons."""
    rule = Rule(seeds=len(values("a")), comparisons=comparisons)
    judged = judge(rule, values, ["moves"])
    return verdict(judged), [each.verdict for each in judged]


def less(setting, than, least=0.1):
    return saves(f"{setting} wastes less than {than}", {"name": setting}, {"name": than}, "moves", least)


@pytest.mark.parametrize(
    ("mean", "expected"), [(5.0, "yes"), (8.0, "yes"), (8.98, "open"), (9.02, "open"), (9.9, "no"), (12.0, "no")]
)
def test_an_effect_is_tested_against_the_smallest_that_counts(mean, expected):
    """A tenth of 10 is 1: who wastes 9 saves as much, and 9.9 is significantly less than 10 and too little."""
    noise = 0.2 * NORMAL[0]
    values = measured(a=mean + noise, b=np.full(41, 10.0))
    assert outcome(values, less("a", "b")) == (expected, [expected])


def test_a_rule_holds_if_all_of_it_holds():
    values = measured(a=5 + NORMAL[0], b=10 + NORMAL[1], c=9 + NORMAL[1], d=20 + NORMAL[0])
    assert outcome(values, less("a", "b"), less("b", "d")) == ("yes", ["yes", "yes"])
    assert outcome(values, less("a", "b"), less("c", "b")) == ("open", ["yes", "open"])
    assert outcome(values, less("a", "b"), less("c", "b"), less("d", "a")) == ("no", ["yes", "open", "no"])


def test_p_values_are_adjusted_for_all_comparisons():
    """Alone the effect is significant, at p = 0.031; beside others that are not it is open."""
    small = [0.0, -1.0, -2.0, -3.0, -4.0, -5.0]
    values = measured(a=small, b=[0.1] * 6, c=[3.0, -3.0, 2.0, -2.0, 1.0, -1.0])
    above = Expectation(expects="", more=({"name": "b"},), less=({"name": "a"},), measure="moves", least=0.05)
    noise = Expectation(expects="", more=({"name": "c"},), measure="moves", least=0.05)
    assert outcome(values, above) == ("yes", ["yes"])
    assert outcome(values, above, noise) == ("open", ["open", "open"])
    rule = Rule(seeds=6, comparisons=(above, noise))
    assert judge(rule, values, ["moves"])[0].p == pytest.approx(2 * 2 / 2**6)


def test_a_loss_may_be_too_small_to_count():
    """The smallest effect is below 0 where a claim says that hardly anything is lost."""
    values = measured(a=10.2 + 0.2 * NORMAL[0], b=np.full(41, 10.0), c=12 + 0.2 * NORMAL[0])
    assert outcome(values, less("a", "b", -0.1)) == ("yes", ["yes"])
    assert outcome(values, less("c", "b", -0.1)) == ("no", ["no"])


def test_several_settings_are_added():
    """The gap of a and b is twice that of c and d, on each seed."""
    values = measured(a=20 + NORMAL[0], b=10 + NORMAL[0], c=9 + NORMAL[1], d=4 + NORMAL[1])
    wider = Expectation(
        expects="",
        more=({"name": "a"}, {"name": "d"}),
        less=({"name": "b"}, {"name": "c"}),
        measure="moves",
        least=4.9,
    )
    rule = Rule(seeds=41, comparisons=(wider,))
    (judged,) = judge(rule, values, ["moves"])
    assert judged.effects == pytest.approx(np.full(41, 5.0))
    assert judged.verdict == "yes"


def test_what_decides_nothing_is_open():
    values = measured(a=[1.0, 1.0, 1.0], b=[9.0, 8.0, 7.0])
    assert outcome(values, less("a", "b")) == ("open", ["open"])  # three seeds are too few
    assert outcome(measured(a=[9.0] * 20, b=[10.0] * 20), less("a", "b")) == ("open", ["open"])  # no more and no less
    assert outcome(measured(a=[0.0] * 20, b=[0.0] * 20), less("a", "b")) == ("open", ["open"])


def test_a_verdict_on_noise_is_rare():
    """Of many rows with four effects that are just as great as the smallest that counts, 5 % have a verdict on any."""
    rng, rows = np.random.default_rng(1), amount(120, full=400)
    comparisons = [
        Expectation(expects="", more=({"name": name},), measure="moves", least=1.0) for name in ("a", "b", "c", "d")
    ]
    wrong = sum(
        set(outcome(measured(**{name: 1 + rng.normal(size=10) for name in "abcd"}), *comparisons)[1]) != {"open"}
        for _ in range(rows)
    )
    assert 0 < wrong <= binom.ppf(0.975, rows, 0.05)
