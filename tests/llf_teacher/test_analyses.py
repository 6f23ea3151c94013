"""Analyses of outcomes: attempts, ablation of kinds, the matrix of students and teachers, one number over all."""

import itertools

import numpy as np
import pytest
from scipy import stats

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.analysis.ablation import ablations, shapley
from llf_teacher.studies.analysis.matrix import matrices
from llf_teacher.studies.analysis.outcomes import Endings, outcomes
from llf_teacher.studies.analysis.overall import overall
from llf_teacher.studies.analysis.time_to_success import attempts, tries_of
from llf_teacher.studies.definition.design import SUBSETS
from teachers.atoms import KINDS

SPEC = EpisodeSpec("a-v0", "silent", "obedient", "b", "a", 10, 0, "1", "2.1")


def rows(regrets, **changes):
    """Episodes of the seeds from 0 on, as a store has them, with these regrets."""
    for seed, regret in enumerate(regrets):
        spec = SPEC._replace(seed=seed, **changes)
        yield spec._asdict() | {"family": "toy", "regret": regret, "success": regret == 0, "first_success": None}


def test_attempts_count_who_has_solved_it_by_then():
    def cell(first):
        zeros = np.zeros(len(first))
        return Endings(np.arange(len(first)), zeros, zeros, np.array(first, float)[:, None])

    cells = {
        ("oracle", "obedient"): cell([1, 2, 3, np.inf]),
        ("retry_only", "obedient"): cell([4, 10, 3, np.inf, 1]),
    }
    found = attempts(cells, 10)
    told = found["oracle", "obedient"]
    assert told.tries == (1, 2, 4, 8, 10)
    assert told.solved.mean.tolist() == [0.25, 0.5, 0.75, 0.75, 0.75]
    assert told.gain.mean.tolist() == [0.25, 0.5, 0.25, 0.25, 0.0]  # the fifth seed is the control's alone
    assert found["retry_only", "obedient"].gain is None


def test_tries_double():
    assert tries_of(1) == (1,)
    assert tries_of(8) == (1, 2, 4, 8)
    assert tries_of(9) == (1, 2, 4, 8, 9)


def test_environments_count_within_a_seed():
    cell = Endings(np.arange(2), np.zeros(2), np.zeros(2), np.array([[1.0, np.inf], [2.0, 2.0]]))
    assert attempts({("oracle", "x"): cell}, 2)["oracle", "x"].solved.mean.tolist() == [0.25, 0.75]


def test_shapley_values_average_over_all_orders():
    rng = np.random.default_rng(0)
    players = "abcde"
    values = {frozenset(chosen): rng.normal(size=3) for n in range(6) for chosen in itertools.combinations(players, n)}
    expected = dict.fromkeys(players, 0.0)
    orders = list(itertools.permutations(players))
    for order in orders:
        for i, player in enumerate(order):
            added = values[frozenset(order[: i + 1])] - values[frozenset(order[:i])]
            expected[player] += added / len(orders)
    found = shapley(values)
    for player in players:
        np.testing.assert_allclose(found[player], expected[player])
    np.testing.assert_allclose(sum(found.values()), values[frozenset(players)] - values[frozenset()])


def test_shapley_values_need_every_subset():
    with pytest.raises(ValueError, match=r"values must have every subset of a, b, got none for \['b'\]"):
        shapley({frozenset(each): np.zeros(1) for each in ("", "a", "ab")})


def test_kinds_share_the_gain():
    def worth(kinds):  # fp is worth 3, hn 1, and r and hp 2 if both are said
        return 3 * ("fp" in kinds) + ("hn" in kinds) + 2 * ({"r", "hp"} <= set(kinds))

    assert len(SUBSETS) == 32
    told = [
        row
        for type_ in SUBSETS
        for row in rows(
            [9.0 - worth(type_.split("+")), 8.0 - worth(type_.split("+"))], feedback_type=type_, teacher="oracle"
        )
    ]
    told += rows([0.0, 0.0], feedback_type="m", teacher="oracle")
    (found,) = ablations(outcomes(told))
    assert {kind: share.mean for kind, share in found.shares.items()} == pytest.approx(
        {"r": 1, "hp": 1, "hn": 1, "fp": 3, "fn": 0}
    )
    assert found.total.mean == pytest.approx(6) == pytest.approx(sum(share.mean for share in found.shares.values()))
    assert found.gains["hp+fp"].mean == pytest.approx(3)
    assert found.gains["n"].mean == 0
    assert (found.teacher, found.student, found.group.feedback_type) == ("oracle", "obedient", "+".join(KINDS))


def test_an_ablation_of_some_kinds_and_of_too_few():
    types = ("n", "hp", "fp", "hp+fp")
    told = [row for type_ in types for row in rows([9.0 - len(type_)], feedback_type=type_)]
    (found,) = ablations(outcomes(told))
    assert list(found.shares) == ["hp", "fp"]
    assert not list(ablations(outcomes(row for row in told if row["feedback_type"] != "hp")))


def gains(table):
    """Episodes in which the control has a regret of 20, and others as much less as the table (teacher, student, seed)
    says.
    """
    teachers, students = ("oracle", "vague", "hinter"), ("obedient", "text_only")
    for t, teacher in enumerate(teachers[: len(table)]):
        for s, student in enumerate(students):
            yield from rows(20 - table[t, s], teacher=teacher, student=student)
    for student in students:
        yield from rows([20.0] * table.shape[2], teacher="retry_only", student=student)
    yield from rows([3.0] * table.shape[2], teacher="retry_only", student="random")


def test_the_gain_is_split_between_teachers_and_students():
    table = np.zeros((3, 2, 8))
    table[0], table[1] = 6.0, 3.0
    (found,) = matrices(outcomes(gains(table)))
    assert found.teachers == ("oracle", "vague", "hinter")
    assert found.students == ("obedient", "text_only")
    assert found.gains["vague", "text_only"].mean == 3
    assert found.split.teachers == pytest.approx(1) == found.low.teachers == found.high.teachers
    assert found.agreement == pytest.approx(1)

    table[:, 1] = table[::-1, 1]  # the other student ranks them the other way round
    (found,) = matrices(outcomes(gains(table)))
    assert found.split.interaction == pytest.approx(1)
    assert found.order == {"obedient": ("oracle", "vague", "hinter"), "text_only": ("hinter", "vague", "oracle")}
    assert found.agreement == pytest.approx(0)


def test_shares_have_intervals_over_seeds():
    table = np.random.default_rng(0).normal(np.array([[[3.0], [2]], [[1], [0]], [[0], [0]]]), 1.0, (3, 2, 30))
    (found,) = matrices(outcomes(gains(table)))
    rng = np.random.default_rng(5)
    drawn = []
    for _ in range(1000):  # sums of squares by hand
        sample = table[..., rng.integers(0, 30, 30)]
        between = 60 * ((sample.mean(axis=(1, 2)) - sample.mean()) ** 2).sum()
        drawn.append(between / ((sample - sample.mean()) ** 2).sum())
    assert found.low.teachers == pytest.approx(np.quantile(drawn, 0.025), abs=0.03)
    assert found.high.teachers == pytest.approx(np.quantile(drawn, 0.975), abs=0.03)
    assert found.low.seeds < found.split.seeds < found.high.seeds
    assert found.lead[0] < found.split.students - found.split.teachers < found.lead[1]
    assert found.lead[0] > found.low.students - found.high.teachers


def test_a_matrix_needs_two_of_each():
    assert not list(matrices(outcomes(gains(np.ones((1, 2, 3))))))
    assert not list(matrices(outcomes(rows([1.0]))))


def test_one_number_over_all_tasks():
    rng = np.random.default_rng(1)
    told, scores = [], []
    for student, scale in (("obedient", 1.0), ("text_only", 50.0)):
        silent, oracle = scale * rng.uniform(5, 9, 10), scale * rng.uniform(1, 5, 10)
        told += [*rows(silent, student=student), *rows(oracle, student=student, teacher="oracle")]
        scores.append((silent - oracle) / (silent.mean() + oracle.mean()))
    told += [*rows([1.0] * 10, student="random"), *rows([1.0] * 10, student="random", teacher="oracle")]
    (found,) = overall(outcomes(told), "silent")
    assert (found.teacher, found.tasks) == ("oracle", 2)
    assert found.middle.mean == pytest.approx(stats.trim_mean(scores, 0.25, axis=None))
    assert found.better.mean == 1
    middle = list(found.profile.thresholds).index(0.5)
    assert found.profile.band.mean[middle] == pytest.approx(np.mean(np.array(scores) > 0.5))


def test_a_baseline_without_regret_gives_no_score():
    assert not list(overall(outcomes([*rows([0.0]), *rows([1.0], teacher="oracle")]), "silent"))
