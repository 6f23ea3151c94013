"""Sequential designs: published boundaries, the error that is promised."""

import numpy as np
import pytest
from scipy import stats

from llf_teacher.studies.design import Looks, check_looks
from llf_teacher.studies.sequential import levels, levels_of

FIFTHS = (0.2, 0.4, 0.6, 0.8, 1.0)


@pytest.mark.parametrize(
    ("shares", "spending", "bounds"),
    [
        # Five looks, two-sided 5 %: Reboussin, DeMets, Kim & Lan (2000) for O'Brien and Fleming's spending; Pocock's.
        (FIFTHS, "obrien_fleming", [4.8769, 3.3569, 2.6803, 2.2898, 2.0310]),
        (FIFTHS, "pocock", [2.4380, 2.4268, 2.4101, 2.3966, 2.3859]),
        ((0.5, 1.0), "obrien_fleming", [2.9626, 1.9686]),
        ((1.0,), "pocock", [1.9600]),
    ],
)
def test_boundaries_are_the_published_ones(shares, spending, bounds):
    found = stats.norm.isf(np.array(levels(shares, spending)) / 2)
    np.testing.assert_allclose(found, bounds, atol=6e-4)


@pytest.mark.parametrize("spending", ["obrien_fleming", "pocock"])
def test_looking_often_finds_nothing_more_often_than_promised(spending):
    at = (10, 20, 40)
    draws = np.random.default_rng(0).normal(size=(40_000, 40)).cumsum(axis=1)
    crossed = np.zeros(len(draws), bool)
    for seeds, level in zip(at, levels_of(Looks(at, spending)), strict=True):
        crossed |= 2 * stats.norm.sf(abs(draws[:, seeds - 1]) / seeds**0.5) <= level
    assert crossed.mean() == pytest.approx(0.05, abs=0.004)


def test_a_look_needs_its_seeds():
    looks = Looks((10, 20, 40))
    assert [looks.last(seeds) for seeds in (9, 10, 39, 40)] == [None, 0, 1, 2]


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ([10, 20], r"looks must be a table with `at`, as in \{at = \[10, 20, 40\]\}, got \[10, 20\]"),
        ({"spending": "pocock"}, "looks must be a table with `at`"),
        ({"at": [10, 40], "spend": 1}, "looks: unknown key 'spend'; .*allowed: at, spending"),
        ({"at": [10, 40], "spending": "pocok"}, "looks: unknown spending 'pocok'; did you mean pocock"),
        ({"at": [20, 10, 40]}, "looks: at must be ascending numbers of seeds"),
        ({"at": [10, 20]}, r"the last one the study's 40, got \[10, 20\]"),
        ({"at": [0.5, 40]}, "looks: at must be ascending"),
        ({"at": []}, "looks: at must be ascending"),
    ],
)
def test_a_bad_design_is_refused(table, match):
    problems = []
    check_looks(table, 40, problems)
    with pytest.raises(ValueError, match=match):
        raise ValueError("; ".join(problems))


def test_a_good_design():
    problems = []
    assert check_looks({"at": [10, 40]}, 40, problems) == Looks((10, 40), "obrien_fleming")
    assert check_looks({}, 40, problems) is None
    assert not problems
