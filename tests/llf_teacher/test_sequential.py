"""Sequential designs: boundaries by another computation, the error rate, and the tables that declare a design."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

from llf_teacher.studies.analysis.sequential import levels, levels_of
from llf_teacher.studies.definition.design import InterimAnalyses, check_interim_analyses

FIFTHS = (0.2, 0.4, 0.6, 0.8, 1.0)


SPENT = {  # of the error on one side, as Lan & DeMets (1983) give both functions, by the normal tail and by logarithm
    "obrien_fleming": lambda t: math.erfc(stats.norm.isf(0.0125) / math.sqrt(2 * t)),
    "pocock": lambda t: 0.025 * math.log(1 + (math.e - 1) * t),
}


@pytest.mark.parametrize("spending", SPENT)
@pytest.mark.parametrize("shares", [(1.0,), (0.5, 1.0), FIFTHS, (0.1, 0.35, 0.9, 1.0)])
def test_boundaries_spend_what_they_should(shares, spending):
    """By the chance that a normal vector leaves a box (Genz 1992), without recursion over analyses."""
    bounds = stats.norm.isf(np.array(levels(shares, spending)) / 2)
    correlation = np.sqrt(np.minimum.outer(shares, shares) / np.maximum.outer(shares, shares))
    for k, share in enumerate(shares, start=1):
        vectors = type(stats.multivariate_normal)(seed=0)  # SciPy 1.13 takes the precision here alone
        box = {"cov": correlation[:k, :k], "lower_limit": -bounds[:k]}
        inside = vectors.cdf(bounds[:k], **box, maxpts=1_000_000, abseps=1e-6, releps=0)
        assert 1 - inside == pytest.approx(2 * SPENT[spending](share), abs=2e-5)


def test_two_analyses_by_a_plane_integral():
    first, second = stats.norm.isf(np.array(levels((0.5, 1.0))) / 2)
    density = stats.multivariate_normal(cov=[[1, 0.5**0.5], [0.5**0.5, 1]]).pdf
    inside, _ = integrate.dblquad(lambda y, x: density([x, y]), -first, first, -second, second, epsabs=1e-9)
    assert 1 - inside == pytest.approx(0.05, abs=1e-7)


@pytest.mark.parametrize("spending", ["obrien_fleming", "pocock"])
def test_interim_analyses_keep_the_error_rate(spending):
    at = (10, 20, 40)
    draws = np.random.default_rng(0).normal(size=(40_000, 40)).cumsum(axis=1)
    crossed = np.zeros(len(draws), bool)
    for seeds, level in zip(at, levels_of(InterimAnalyses(at, spending)), strict=True):
        crossed |= 2 * stats.norm.sf(abs(draws[:, seeds - 1]) / seeds**0.5) <= level
    assert crossed.mean() == pytest.approx(0.05, abs=0.004)


def test_an_interim_analysis_needs_its_seeds():
    design = InterimAnalyses((10, 20, 40))
    assert [design.last(seeds) for seeds in (9, 10, 39, 40)] == [None, 0, 1, 2]


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ([10, 20], r"interim_analyses must be a table with `at`, as in \{at = \[10, 20, 40\]\}, got \[10, 20\]"),
        ({"spending": "pocock"}, "interim_analyses must be a table with `at`"),
        ({"at": [10, 40], "spend": 1}, "interim_analyses: unknown key 'spend'; .*allowed: at, spending, stop"),
        ({"at": [10, 40], "spending": "pocok"}, "interim_analyses: unknown spending 'pocok'; did you mean pocock"),
        ({"at": [20, 10, 40]}, "interim_analyses: at must be ascending numbers of seeds"),
        ({"at": [10, 20]}, r"the last one the study's 40, got \[10, 20\]"),
        ({"at": [0.5, 40]}, "interim_analyses: at must be ascending"),
        ({"at": [10, 40], "stop": 1}, "interim_analyses: stop must be true or false, got 1"),
        ({"at": []}, "interim_analyses: at must be ascending"),
    ],
)
def test_a_bad_design_is_refused(table, match):
    problems = []
    check_interim_analyses(table, 40, problems)
    with pytest.raises(ValueError, match=match):
        raise ValueError("; ".join(problems))


def test_a_good_design():
    problems = []
    assert check_interim_analyses({"at": [10, 40]}, 40, problems) == InterimAnalyses((10, 40), "obrien_fleming")
    assert check_interim_analyses({"at": [10, 40], "stop": True}, 40, problems) == InterimAnalyses((10, 40), stop=True)
    assert check_interim_analyses({}, 40, problems) is None
    assert not problems
