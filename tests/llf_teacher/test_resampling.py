"""Sign flips by products of matrices, against SciPy's, which gathers each resample."""

import numpy as np
import pytest
from scipy import stats

from llf_teacher.studies.analysis import statistics
from llf_teacher.studies.analysis.resampling import sign_flips


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
        single = statistics.mean_interval(alone)
        assert together[:4] == pytest.approx(single[:4], nan_ok=True)
        assert together[4:] == single[4:]
    for alone, together in zip(columns, statistics.paired_differences(columns), strict=True):
        single = statistics.paired_difference(alone, 0 * alone)
        assert together.p == single.p
        assert together.estimate[:4] == pytest.approx(single.estimate[:4], nan_ok=True)
    tables = [rng.random((6, 2)) < 0.5, rng.random((9, 1)) < 0.5, rng.random((6, 3)) < 0.5]
    for table, together in zip(tables, statistics.success_intervals(tables), strict=True):
        assert together[:4] == pytest.approx(statistics.success_interval(table)[:4], nan_ok=True)
