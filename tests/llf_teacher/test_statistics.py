"""Statistics against scipy, against values of the literature, and at the edges."""

import numpy as np
import pytest
from scipy import stats

from llf_teacher.studies.analysis.statistics import (
    exact_p,
    holm,
    mean_band,
    mean_interval,
    paired_difference,
    rate_band,
    rate_differences,
    rate_interval,
    share_interval,
    success_interval,
    variance_split,
)


def test_interval_is_students():
    values = np.random.default_rng(7).normal(3, 1, size=12)
    estimate = mean_interval(values)
    theirs = stats.ttest_1samp(values, 0).confidence_interval(0.95)
    assert estimate[:4] == pytest.approx((values.mean(), *theirs, 12))
    assert (estimate.why, estimate.values) == ("", ())
    assert estimate.text(1) == f"{estimate.mean:.1f} [{estimate.low:.1f}, {estimate.high:.1f}]"
    assert mean_interval([0.0, 0, 0, 0, 3]).text() == "0.60 (no interval: 4 of 5 are 0)"


EXPONENTIAL = np.random.default_rng(1).exponential(size=79)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ([4.0], "one seed"),
        ([1, 2, 4, 3], "4 seeds"),
        ([0.3, 0.1 + 0.2, 0.3, 0.3, 0.3], "all equal"),
        ([0.0] * 6, "all equal"),
        ([0, 0, 0, 0, 0, 0, 1, -1, 1.0], "6 of 9 are 0"),
        (EXPONENTIAL[:40], "skewed"),
        (EXPONENTIAL, "skewed"),
        (-EXPONENTIAL[:20], "skewed"),
        (np.exp(2 * stats.norm.ppf((np.arange(20) + 0.5) / 20)) - 1, "skewed"),
        ([0.0] * 90 + [3.0] * 10, "90 of 100 are 0"),
    ],
)
def test_without_an_interval_stand_the_values_and_the_reason(values, why):
    estimate = mean_interval(values)
    assert estimate.why == why
    assert estimate.mean == pytest.approx(np.mean(values))
    assert estimate.n == len(values)
    assert np.isnan(estimate.low) == np.isnan(estimate.high) == bool(why)
    assert estimate.values == (tuple(sorted(values)) if why else ())


@pytest.mark.parametrize(
    "values",
    [np.append(EXPONENTIAL, 1.0), [11, 12, 13, 14, 15.5], [0, 0, 0, 0, 1, -1, 2, -2, 1.5], [0.0] * 60 + [3.0] * 20],
)
def test_enough_values_that_are_not_skewed_or_very_many_have_an_interval(values):
    estimate = mean_interval(values)
    assert estimate.low < estimate.mean < estimate.high


SHAPES = {
    "normal": (lambda rng, size: rng.normal(size=size), 0.0),
    "normal, mean 5": (lambda rng, size: rng.normal(5, 1, size), 5.0),
    "exponential": (lambda rng, size: rng.exponential(size=size), 1.0),
    "half zeros": (lambda rng, size: with_zeros(0.5, rng, size), 0.5),
    "80 % zeros": (lambda rng, size: with_zeros(0.8, rng, size), 0.2),
    "lognormal": (lambda rng, size: rng.lognormal(size=size), np.exp(0.5)),
    "gamma, skewness 1": (lambda rng, size: rng.gamma(4, size=size), 4.0),
    "difference of exponentials": (lambda rng, size: rng.exponential(size=size) - rng.exponential(size=size), 0.0),
    "half zeros, both signs": (lambda rng, size: with_zeros(0.5, rng, size) * rng.choice((-1.0, 1.0), size), 0.0),
    "exponential less its mean": (lambda rng, size: rng.exponential(size=size) - 1, 0.0),
    "lognormal less its mean": (lambda rng, size: rng.lognormal(size=size) - np.exp(0.5), 0.0),
}
"""Distributions with their means."""


def with_zeros(share, rng, size):
    return np.where(rng.random(size) < share, 0.0, rng.exponential(size=size))


@pytest.mark.parametrize("shape", SHAPES)
def test_intervals_that_are_shown_cover(shape):
    """At most a tenth of draws shows an interval that is wrong; intervals of the common shapes cover in nine tenths."""
    draw, mean = SHAPES[shape]
    rng = np.random.default_rng([3, [*SHAPES].index(shape)])
    for n in (5, 10, 20, 40, 80):
        band = mean_band(draw(rng, (n, 2000)))
        shown = ~np.isnan(band.low)
        covers = (band.low <= mean) & (mean <= band.high)
        assert (shown & ~covers).mean() <= 0.11, n
        if shape in ("normal", "exponential", "half zeros", "80 % zeros", "lognormal") and shown.mean() >= 0.01:
            assert covers[shown].mean() >= 0.9, n
        if shape == "normal" and n == 10:
            assert shown.mean() > 0.85


@pytest.mark.parametrize("rate", [0.02, 0.1, 0.3, 0.5])
def test_intervals_of_rates_cover(rate):
    for n in (5, 10, 20, 40, 80):
        intervals = [rate_interval(count, n) for count in range(n + 1)]
        covers = [interval.low <= rate <= interval.high for interval in intervals]
        assert stats.binom.pmf(range(n + 1), n, rate) @ covers >= 0.95


def test_the_rule_does_not_depend_on_the_unit_or_the_sign():
    rng = np.random.default_rng(4)
    sparse = np.arange(10.0) * (rng.random(10) < 0.3)
    for values in (rng.normal(size=10), rng.exponential(size=10), np.zeros(10), sparse):
        assert len({mean_interval(scale * values).why for scale in (1, -1, 1e9, 1e-9)}) == 1


@pytest.mark.parametrize("values", [[], [[]], [1, 2]])
def test_band_needs_a_table(values):
    with pytest.raises(ValueError, match=r"values must be a non-empty table of shape \(n, m\), got shape"):
        mean_band(values)


def test_mean_needs_values():
    with pytest.raises(ValueError, match="non-empty"):
        mean_interval([])


def test_band_is_pointwise_and_mixes_constant_columns_with_others():
    table = np.array([[0, 11, 2], [0, 13, 2], [0, 18, 2], [0, 15, 2], [0, 13, 2]])
    band = mean_band(table)
    assert band.mean.tolist() == [0, 14, 2]
    assert np.isnan(band.low[[0, 2]]).all()
    assert np.isnan(band.high[[0, 2]]).all()
    assert band.low[1] < 14 < band.high[1]


def test_rates_have_exact_intervals():
    # Clopper & Pearson (1934): of 10 of 10 the lower end is 0.025^(1/10); of 3 of 10 by quantiles of the beta.
    assert rate_interval(10, 10)[:3] == (1, pytest.approx(0.025**0.1), 1)
    ends = stats.beta.ppf(0.025, 3, 8), stats.beta.ppf(0.975, 4, 7)
    assert rate_interval(3, 10)[:4] == (0.3, pytest.approx(ends[0]), pytest.approx(ends[1]), 10)
    assert share_interval([1, 0, 0, 1, 0]) == rate_interval(2, 5)
    assert share_interval([1, 0.9, 0.9, 1, 0.8]) == mean_interval([1, 0.9, 0.9, 1, 0.8])
    band = rate_band([[1, 0], [1, 0], [0, 0], [1, 0], [0, 0]])
    assert (band.low[0], band.high[1]) == (rate_interval(3, 5).low, rate_interval(0, 5).high)


def test_few_rates_have_no_interval():
    found = rate_interval(3, 4)
    assert (found.mean, found.why, found.values) == (0.75, "4 seeds", (0, 1, 1, 1))
    assert np.isnan(rate_differences(np.ones((4, 1)), np.zeros((4, 1))).low[0])


@pytest.mark.parametrize(("one", "other"), [(0.5, 0.1), (0.05, 0.05), (0.5, 0.0), (0.3, 0.7)])
def test_intervals_of_paired_rates_cover(one, other):
    """By all tables of 8 pairs, with their probabilities."""
    n, covered = 8, 0.0
    for gained in range(n + 1):
        for lost in range(n + 1 - gained):
            counts = [gained, lost, n - gained - lost]
            first, second = np.repeat([[1, 0, 0], [0, 1, 0]], counts, axis=1)
            band = rate_differences(first[:, None], second[:, None])
            assert band.mean[0] == pytest.approx((gained - lost) / n)
            if band.low[0] <= one - other <= band.high[0]:
                covered += stats.multinomial.pmf(counts, n, [one, other, 1 - one - other])
    assert covered >= 0.95


@pytest.mark.parametrize(("successes", "n"), [(0, 0), (3, 2), (-1, 2)])
def test_rate_needs_counts(successes, n):
    with pytest.raises(ValueError, match="must"):
        rate_interval(successes, n)


def test_seed_stays_the_unit_with_several_environments():
    one = [[True], [False], [True], [True], [False]]
    assert success_interval(one) == rate_interval(3, 5)
    two = [[True, True], [False, True], [True, False], [False, False]]
    assert success_interval(two).values == (0, 0.5, 0.5, 1)
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
    assert exact_p(values) == paired_difference(values, np.zeros(30)).p
    assert paired_difference(values, np.zeros(30)).p == pytest.approx(stats.ttest_1samp(values, 0).pvalue, abs=0.02)


def test_no_difference_and_a_single_pair_have_p_1():
    assert paired_difference([1, 2, 3], [1, 2, 3]).p == 1
    assert paired_difference([1, 2, 3], [1, 2, 3]).estimate.values == (0, 0, 0)
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
