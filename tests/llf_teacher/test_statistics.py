"""Statistics against scipy, against values of the literature, and at the edges."""

import math

import numpy as np
import pytest
from scipy import stats

from llf_teacher.studies.analysis.statistics import (
    Estimate,
    holm,
    mean_band,
    mean_interval,
    paired_difference,
    rate_interval,
    success_interval,
    variance_split,
)


def test_interval_is_that_of_scipy_and_the_same_each_time():
    values = np.random.default_rng(7).exponential(size=12)
    estimate = mean_interval(values)
    theirs = stats.bootstrap((values,), np.mean, random_state=np.random.default_rng(1)).confidence_interval
    assert estimate == mean_interval(list(values))
    assert estimate.mean == pytest.approx(values.mean())
    assert estimate.low == pytest.approx(theirs.low, rel=0.03)
    assert estimate.high == pytest.approx(theirs.high, rel=0.03)
    assert estimate.n == 12


def test_interval_covers_the_true_mean_about_as_often_as_it_says():
    rng = np.random.default_rng(3)
    estimates = mean_band(rng.normal(5, 1, size=(20, 400)))
    assert 0.90 < np.mean((estimates.low <= 5) & (estimates.high >= 5)) < 0.97


@pytest.mark.parametrize("values", [[0.3, 0.1 + 0.2, 0.3], [0, 0, 0], [-2, -2]])
def test_equal_values_give_a_point(values):
    estimate = mean_interval(values)
    assert estimate.low == estimate.mean == estimate.high == pytest.approx(values[0])


def test_one_value_has_no_interval():
    estimate = mean_interval([4])
    assert (estimate.mean, estimate.n) == (4, 1)
    assert math.isnan(estimate.low)
    assert math.isnan(estimate.high)


def test_band_is_pointwise_and_mixes_constant_columns_with_others():
    table = np.array([[0, 1, 2], [0, 3, 2], [0, 8, 2]])
    band = mean_band(table)
    assert band.mean.tolist() == [0, 4, 2]
    assert band.low[[0, 2]].tolist() == band.high[[0, 2]].tolist() == [0, 2]
    assert 1 <= band.low[1] < 4 < band.high[1] <= 8


@pytest.mark.parametrize("values", [[], [[]], [1, 2]])
def test_band_needs_a_table(values):
    with pytest.raises(ValueError, match=r"values must be a non-empty table of shape \(n, m\), got shape"):
        mean_band(values)


def test_mean_needs_values():
    with pytest.raises(ValueError, match="non-empty"):
        mean_interval([])


def test_wilson_has_known_values():
    # By hand: (p + z²/2n ± z √(p(1-p)/n + z²/4n²)) / (1 + z²/n), z = 1.95996.
    assert rate_interval(10, 10)[:2] == (1, pytest.approx(0.72247, abs=1e-5))
    assert rate_interval(10, 10).high == 1
    assert rate_interval(3, 10) == (0.3, pytest.approx(0.10779, abs=1e-5), pytest.approx(0.60322, abs=1e-5), 10)


@pytest.mark.parametrize(("successes", "n"), [(0, 0), (3, 2), (-1, 2)])
def test_rate_needs_counts(successes, n):
    with pytest.raises(ValueError, match="must"):
        rate_interval(successes, n)


def test_seed_stays_the_unit_with_several_environments():
    one = [[True], [False], [True], [True]]
    assert success_interval(one) == rate_interval(3, 4)
    two = [[True, True], [False, True], [True, False], [False, False]]
    assert success_interval(two) == mean_interval([1, 0.5, 0.5, 0])
    assert success_interval(two).n == 4


def test_paired_difference_takes_out_what_the_seeds_share():
    worlds = np.random.default_rng(5).normal(0, 100, size=10)
    difference = paired_difference(worlds - 2 + np.linspace(-0.1, 0.1, 10), worlds)
    assert difference.estimate.mean == pytest.approx(-2)
    assert -2.1 < difference.estimate.low < -2 < difference.estimate.high < -1.9
    assert difference.p == pytest.approx(2 / 2**10)


def test_paired_test_agrees_with_an_exact_count():
    # Of the 8 ways to flip the signs of (1, 2, -4), the sums are ±1, ±3, ±5, ±7: all are at least as far as -1.
    assert paired_difference([1, 2, -4], [0, 0, 0]).p == 1
    # Of (1, 2, 4): only ±7 is as far as 7.
    assert paired_difference([1, 2, 4], [0, 0, 0]).p == pytest.approx(2 / 8)


def test_paired_test_beyond_exact_counts_is_the_same_each_time():
    values = np.random.default_rng(2).normal(0.3, 1, size=30)
    assert paired_difference(values, np.zeros(30)) == paired_difference(values, np.zeros(30))
    assert paired_difference(values, np.zeros(30)).p == pytest.approx(stats.ttest_1samp(values, 0).pvalue, abs=0.02)


def test_no_difference_and_a_single_pair_have_p_1():
    assert paired_difference([1, 2, 3], [1, 2, 3]) == (Estimate(0, 0, 0, 3), 1)
    assert paired_difference([1], [3]).p == 1
    assert paired_difference([1], [3]).estimate.mean == -2


def test_holm():
    # Holm's procedure as R's p.adjust(method = "holm") has it.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.6, 0.7]) == [1, 1]
    assert holm([0.2]) == [0.2]
    assert holm([]) == []


def test_variance_splits_into_what_made_it():
    teachers, students = np.array([0.0, 4.0]).reshape(2, 1, 1), np.array([0.0, 1.0, 2.0]).reshape(1, 3, 1)
    flat = np.zeros((2, 3, 5))
    assert variance_split(flat + teachers) == pytest.approx((1, 0, 0, 0))
    assert variance_split(flat + students) == pytest.approx((0, 1, 0, 0))
    both = teachers.var() + students.var()
    assert variance_split(flat + teachers + students) == pytest.approx(
        (teachers.var() / both, students.var() / both, 0, 0)
    )
    crossed = flat + np.array([[1, 0, -1], [-1, 0, 1]]).reshape(2, 3, 1)
    assert variance_split(crossed) == pytest.approx((0, 0, 1, 0))
    assert variance_split(flat + np.arange(5) + teachers) == pytest.approx((4 / 6, 0, 0, 2 / 6))


def test_no_variance_splits_into_nothing():
    assert variance_split(np.full((2, 3, 4), 0.1)) is None
    with pytest.raises(ValueError, match=r"of shape \(teachers, students, seeds\), got \(2, 3\)"):
        variance_split(np.zeros((2, 3)))
