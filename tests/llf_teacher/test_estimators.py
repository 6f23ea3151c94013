"""Estimators over many tasks, each against an independent computation."""

import numpy as np
import pytest
from scipy import integrate, stats

from llf_teacher.studies.analysis.estimators import (
    bootstrap_seeds,
    curve_areas,
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)

RNG = np.random.default_rng(3)
SCORES = [RNG.normal(task, 1, 10) for task in range(3)]


@pytest.mark.parametrize("runs", [1, 4, 7, 10, 13])
def test_the_interquartile_mean_is_the_trimmed_mean_of_all_runs(runs):
    scores = RNG.normal(size=(3, runs))
    assert interquartile_mean(scores).mean == pytest.approx(stats.trim_mean(scores, 0.25, axis=None))


def test_a_task_with_fewer_runs_weighs_as_much():
    short, long = np.array([0.0, 1.0, 2.0, 3.0]), np.array([4.0, 5.0])
    each = np.concatenate([short, np.repeat(long, 2)])  # as if the other had been run twice
    assert interquartile_mean([short, long]).mean == pytest.approx(stats.trim_mean(each, 0.25))


def test_its_interval_is_that_of_a_plain_stratified_bootstrap():
    rng = np.random.default_rng(8)
    samples = [
        stats.trim_mean(np.concatenate([rng.choice(task, len(task)) for task in SCORES]), 0.25) for _ in range(4000)
    ]
    estimate = interquartile_mean(SCORES)
    assert estimate.low == pytest.approx(np.quantile(samples, 0.025), abs=0.03)
    assert estimate.high == pytest.approx(np.quantile(samples, 0.975), abs=0.03)
    assert estimate == interquartile_mean(SCORES)
    assert estimate.n == 30


def test_a_profile_counts_runs_above():
    thresholds = np.linspace(-2, 4, 9)
    profile = performance_profile(SCORES, thresholds)
    counted = [np.mean([sum(run > level for run in task) / len(task) for task in SCORES]) for level in thresholds]
    np.testing.assert_allclose(profile.band.mean, counted)
    rng = np.random.default_rng(8)
    middle = [np.mean([(rng.choice(task, len(task)) > thresholds[4]).mean() for task in SCORES]) for _ in range(4000)]
    assert profile.band.low[4] == pytest.approx(np.quantile(middle, 0.025), abs=0.035)
    assert profile.band.high[4] == pytest.approx(np.quantile(middle, 0.975), abs=0.035)


def test_a_score_at_the_threshold_is_not_above_it():
    assert performance_profile([[1.0, 1.0, 2.0]], [1.0]).band.mean == pytest.approx([1 / 3])


def test_the_probability_of_improvement_is_that_of_mann_and_whitney():
    others = [task.round() for task in SCORES[::-1]]
    scores = [task.round() for task in SCORES]
    expected = [stats.mannwhitneyu(a, b).statistic / (len(a) * len(b)) for a, b in zip(scores, others, strict=True)]
    assert probability_of_improvement(scores, others).mean == pytest.approx(np.mean(expected))


def test_its_interval_draws_pairs():
    a, b = SCORES[0][:10], SCORES[1][:10]
    wins = (a[:, None] > b) + 0.5 * (a[:, None] == b)
    rng = np.random.default_rng(6)
    samples = [wins[np.ix_(drawn, drawn)].mean() for drawn in rng.integers(0, 10, (4000, 10))]
    estimate = probability_of_improvement([a], [b])
    assert estimate.low == pytest.approx(np.quantile(samples, 0.025), abs=0.04)
    assert estimate.high == pytest.approx(np.quantile(samples, 0.975), abs=0.04)


def test_few_runs_have_no_interval():
    for runs in (np.arange(9.0), np.arange(10.0)):
        estimate = interquartile_mean([SCORES[0][:10], runs])
        assert np.isnan(estimate.low) == (len(runs) < 10)
        assert estimate.why == ("9 runs of a task" if len(runs) < 10 else "")


def test_one_run_has_no_interval():
    for estimate in (interquartile_mean([[1.0]]), probability_of_improvement([[1.0]], [[0.0]])):
        assert np.isnan(estimate.low)
        assert np.isnan(estimate.high)
    assert np.isnan(performance_profile([[1.0]], [0.5]).band.low).all()


@pytest.mark.parametrize("scores", [[], [[1.0], []], [1.0]])
def test_a_task_needs_runs(scores):
    with pytest.raises(ValueError, match="a non-empty array of runs for each task"):
        interquartile_mean(scores)


def test_others_need_the_same_runs():
    with pytest.raises(ValueError, match=r"as many runs per task as scores, \[2\], got \[1\]"):
        probability_of_improvement([[1.0, 2.0]], [[1.0]])


def test_an_area_is_that_of_the_trapezoid_rule():
    curves = np.cumsum(RNG.random((4, 7)), axis=1)
    expected = [integrate.trapezoid([0, *curve]) / 7 for curve in curves]
    np.testing.assert_allclose(curve_areas(curves), expected)
    with pytest.raises(ValueError, match=r"shape \(runs, turns\), got shape \(3,\)"):
        curve_areas([1, 2, 3])


def test_seeds_are_drawn_whole():
    table = np.array([[1.0, 2, 3, 4], [1, 2, 3, 4]])
    low, high = bootstrap_seeds(table, lambda drawn: np.ptp(drawn, axis=0).max())
    assert low == high == 0
