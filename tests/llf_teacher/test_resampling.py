"""Resampling by products of matrices, against SciPy's, which gathers each resample."""

import numpy as np
import pytest
from scipy import stats

from llf_teacher.studies.analysis import statistics
from llf_teacher.studies.analysis.resampling import bca, sign_flips


@pytest.mark.parametrize("n", [30, 200])
@pytest.mark.parametrize("resamples", [999, 9999])
def test_bootstrap_is_scipys_draw_by_draw(n, resamples):
    table = np.random.default_rng(n).exponential(size=(n, 3)) + np.array([0, 1e6, -3])
    theirs = stats.bootstrap(
        (table,), np.mean, axis=0, n_resamples=resamples, batch=100, random_state=np.random.default_rng(0)
    ).confidence_interval
    ours = bca(table, resamples, 0.95)
    spread = table.std(axis=0)
    assert np.allclose(ours[0] / spread, theirs.low / spread, rtol=0, atol=1e-6)
    assert np.allclose(ours[1] / spread, theirs.high / spread, rtol=0, atol=1e-6)


def test_rounding_does_not_break_ties():
    """The mean of 0.1, 0.2 and 0.4 in another order is another number, and the same mean."""
    values = np.array([0.1, 0.2, 0.4, 0.4])
    ends = {tuple(np.ravel(bca(values[order][:, None], 9999, 0.95))) for order in ([0, 1, 2, 3], [0, 1, 3, 2])}
    whole = np.ravel(bca(np.array([[1.0], [2], [4], [4]]), 9999, 0.95)) / 10
    for each in ends:
        assert np.allclose(each, whole)


@pytest.mark.parametrize("n", [2, 9, 13])
def test_few_signs_are_all_counted_as_scipy_does(n):
    pairs = np.random.default_rng(n).integers(-2, 4, size=(n, 4)).astype(float)
    for values, ours in zip(pairs.T, sign_flips(pairs, 9999), strict=True):
        theirs = stats.permutation_test(
            (values, 0 * values), lambda a, b: np.mean(a - b), permutation_type="samples", n_resamples=9999
        )
        assert ours == pytest.approx(theirs.pvalue, abs=1e-12)


def test_values_without_sign_leave_few_to_count():
    """Three of a thousand pairs differ: eight ways, of which two are as far from 0."""
    values = np.zeros((1000, 1))
    values[:3] = 2.5
    assert sign_flips(values, 9999)[0] == 0.25


def test_random_signs_give_the_normal_tail():
    values = np.random.default_rng(5).normal(0.03, 1, size=(2000, 3))
    z = values.sum(axis=0) / np.sqrt((values**2).sum(axis=0))
    assert np.allclose(sign_flips(values, 9999), 2 * stats.norm.sf(abs(z)), atol=0.02)


def test_columns_together_are_as_they_are_alone():
    rng = np.random.default_rng(1)
    columns = [rng.normal(size=n) for n in (5, 40, 5, 1, 40)] + [np.ones(5)]
    for alone, together in zip(columns, statistics.mean_intervals(columns), strict=True):
        assert together == pytest.approx(statistics.mean_interval(alone), nan_ok=True)
    for alone, together in zip(columns, statistics.paired_differences(columns), strict=True):
        single = statistics.paired_difference(alone, 0 * alone)
        assert together.p == single.p
        assert together.estimate == pytest.approx(single.estimate, nan_ok=True)
    tables = [rng.random((6, 2)) < 0.5, rng.random((9, 1)) < 0.5, rng.random((6, 3)) < 0.5]
    for table, together in zip(tables, statistics.success_intervals(tables), strict=True):
        assert together == pytest.approx(statistics.success_interval(table))
