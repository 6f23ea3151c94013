"""Primary comparisons: scores that know no first arm, one error rate over comparisons and analyses."""

import math

import numpy as np
import pytest

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.analysis import contrasts
from llf_teacher.studies.analysis.evidence import finding
from llf_teacher.studies.analysis.outcomes import outcomes
from llf_teacher.studies.analysis.primary import enough, least, primary
from llf_teacher.studies.analysis.scores import pairs
from llf_teacher.studies.analysis.sequential import adjusted, levels, levels_of
from llf_teacher.studies.analysis.statistics import holm, paired_difference
from llf_teacher.studies.definition.design import InterimAnalyses
from llf_teacher.studies.definition.study import Study, load_study, to_toml

SPEC = EpisodeSpec("a-v0", "silent", "obedient", "b", "a", 10, 0, "1", "2.1")
ALL = contrasts.Test(frozenset(range(12)))


def rows(regrets, family="toy", **changes):
    """Episodes of the seeds from 0 on, as a store has them, with these regrets."""
    for seed, regret in enumerate(regrets):
        spec = SPEC._replace(seed=seed, id=f"{family}-v0", **changes)
        yield spec._asdict() | {"family": family, "regret": regret, "success": False, "first_success": None}


def study_of(seeds=12, shift=0.0, teachers=("oracle", "hinter"), families=(("toy", 1.0), ("hard", 50.0))):
    rng = np.random.default_rng(3)
    told = []
    for family, scale in families:
        told += rows(scale * rng.uniform(4, 8, seeds), family)
        for teacher in teachers:
            told += rows(scale * (rng.uniform(4, 8, seeds) - shift), family, teacher=teacher)
    return outcomes(told)


def test_scores_are_differences_as_a_share_of_both():
    found = study_of(shift=2.0)
    (one, _) = primary(found, "silent", ALL)
    expected = []
    for cells in found.values():
        own, other = (cells[teacher, "obedient"].regret for teacher in ("oracle", "silent"))
        expected.append((other - own) / (other.mean() + own.mean()))
    assert one.mean == pytest.approx(np.mean(expected))
    assert one.shares == pytest.approx([each.mean() for each in expected])
    assert one.score.estimate.n == 12
    assert one.spread == pytest.approx(np.mean(expected, axis=0).std(ddof=1))


def test_arms_that_change_places_change_the_sign_alone():
    found = study_of(shift=1.0, teachers=("oracle",))
    other = {"oracle": "silent", "silent": "oracle"}
    swapped = {
        group: {(other[teacher], student): cell for (teacher, student), cell in cells.items()}
        for group, cells in found.items()
    }
    (there,), (back,) = (primary(each, "silent", ALL) for each in (found, swapped))
    assert back.mean == -there.mean != 0
    assert back.score.p == there.score.p
    assert back.shares == tuple(-share for share in there.shares)
    assert back.score.estimate.low == pytest.approx(-there.score.estimate.high)


def test_a_third_teacher_changes_no_score():
    both = study_of()
    alone = {group: {pair: cell for pair, cell in c.items() if pair[0] != "hinter"} for group, c in both.items()}
    assert [len(primary(each, "silent", ALL)) for each in (alone, both)] == [1, 2]
    assert primary(alone, "silent", ALL)[0].mean == pytest.approx(primary(both, "silent", ALL)[0].mean, rel=1e-12)


def test_negated_rewards_stand_for_regret():
    """Where the teacher knows no values a success is worth -1, and nothing is 0; units do not matter."""
    found = outcomes([*rows([0.0] * 8), *rows([-5.0] * 8, teacher="oracle"), *rows([-2.5] * 8, teacher="hinter")])
    assert [one.mean for one in primary(found, "silent", None)] == [1, 1]
    (one,) = primary(outcomes([*rows([-1.0] * 8), *rows([-3.0] * 8, teacher="oracle")]), "silent", None)
    assert one.mean == 0.5
    assert one.score.p < 0.01


def test_regret_in_no_arm_is_no_difference():
    found = outcomes([*rows([0.0] * 5), *rows([0.0] * 5, teacher="oracle")])
    (one,) = primary(found, "silent", None)
    assert (one.mean, one.more(1)) == (0, None)


def test_families_with_fewer_seeds_weigh_as_much_as_others():
    told = [*rows([4.0, 6, 4, 6]), *rows([2.0, 3, 2, 3], teacher="oracle")]
    told += [*rows([9.0], "slow"), *rows([9.0], "slow", teacher="oracle")]
    (one,) = primary(outcomes(told), "silent", None)
    plain = (np.array([4.0, 6, 4, 6]) - [2, 3, 2, 3]) / 7.5
    assert one.mean == pytest.approx(plain.mean() / 2) == pytest.approx(np.mean(one.shares))
    assert one.score.estimate.n == 4


def test_p_is_adjusted_by_holm_over_what_is_declared():
    found = study_of(shift=1.0)
    raw = [each.score.p for each in primary(found, "silent", ALL, [{"teacher": "none"}])]
    every = primary(found, "silent", ALL)
    assert [each.score.p for each in every] == holm(raw)
    one, other = primary(found, "silent", ALL, [{"teacher": "hint*", "student": "obedient"}])
    assert (one.declared, other.declared) == (False, True)
    assert [one.score.p, other.score.p] == raw


def test_p_is_adjusted_for_the_analyses():
    design = InterimAnalyses((6, 12), "pocock")
    waves = frozenset(range(6)), frozenset(range(12))
    found = study_of(shift=1.5, teachers=("oracle",))
    (first,), (last,) = (
        primary(found, "silent", test)
        for test in (contrasts.Test(waves[0], 1, (), design), contrasts.Test(waves[1], 2, waves[:1], design))
    )
    ps = []
    for seeds in (6, 12):
        scores = []
        for cells in found.values():
            own, other = (cells[teacher, "obedient"].regret[:seeds] for teacher in ("oracle", "silent"))
            scores.append((other - own) / (other.mean() + own.mean()))
        ps.append(paired_difference(np.mean(scores, axis=0), np.zeros(seeds)).p)
    assert first.score.p == adjusted(ps[0], 1, design)
    assert last.score.p == min(adjusted(ps[0], 1, design), adjusted(ps[1], 2, design))
    assert last.score.estimate.n == 12
    assert first.score.estimate.n == 6


@pytest.mark.parametrize("spending", ["obrien_fleming", "pocock"])
@pytest.mark.parametrize("at", [(10, 20, 40), (5, 6, 30), (1, 100)])
def test_adjusted_p_is_the_error_of_the_design_that_finds_it(at, spending):
    design, shares = InterimAnalyses(at, spending), tuple(seeds / at[-1] for seeds in at)
    for analysis, level in enumerate(levels_of(design), start=1):
        if level < 1e-12:
            continue
        assert adjusted(level, analysis, design) == pytest.approx(0.05)
        for alpha in (0.0003, 0.004, 0.3):
            p = levels(shares, spending, alpha)[analysis - 1]
            if p > 1e-12:
                assert adjusted(p, analysis, design) == pytest.approx(alpha, rel=2e-3)
    ps = np.geomspace(1e-8, 1, 200)
    for analysis in range(1, len(at) + 1):
        found = [adjusted(p, analysis, design) for p in ps]
        assert found == sorted(found)
        assert found[-1] == 1
    assert adjusted(0.03, 1, InterimAnalyses((40,), spending)) == 0.03


def test_what_can_be_found_is_known_before():
    assert [enough(n) for n in (1, 2, 10, 100)] == [6, 7, 9, 12]
    found = primary(study_of(seeds=6), "silent", contrasts.Test(frozenset(range(6))))
    assert least(found, contrasts.Test(frozenset(range(6)))) == 2 * 2 / 2**6
    (one,) = primary(study_of(teachers=("oracle",), shift=0.1), "silent", ALL)
    more = one.more(1)
    effect = abs(one.mean) / one.spread
    assert more + 12 == pytest.approx((1.96 + 0.84) ** 2 / effect**2, rel=0.05)
    assert one.more(5) > more
    assert not math.isnan(one.spread)


STUDY = Study(ids=["llf-gridworld-v0"], teachers=["oracle", "placebo", "silent"], students=["obedient"], seeds=2)


def test_a_study_declares_its_primary_comparisons(tmp_path):
    study = Study(
        **{**STUDY.as_dict(), "primary": [{"teacher": "ora*"}, {"student": "obedient", "teacher": "placebo"}]}
    )
    (tmp_path / "s.toml").write_text(to_toml(study))
    assert load_study(tmp_path / "s.toml") == study
    assert Study(**study.as_dict()) == study
    assert STUDY.primary == ()


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ("oracle", r"primary must be a list of tables, got 'oracle'"),
        ([{}], r"primary must be tables with some of teacher, student, instruction_type, feedback_type, got \{\}"),
        ([{"teachers": "x"}], r"primary: unknown key 'teachers'; did you mean teacher"),
        ([{"teacher": "silent"}], r"primary: teacher must be a pattern of one of oracle, placebo, got 'silent'"),
        ([{"student": 3}], r"primary: student must be a pattern of one of obedient, got 3"),
    ],
)
def test_bad_declarations_are_refused(given, match):
    with pytest.raises(ValueError, match=match):
        Study(**{**STUDY.as_dict(), "primary": given})


def test_single_families_of_many_comparisons_are_adjusted_for_all_of_them():
    """What an answer says about single families is true of all answers of a study together."""
    teachers = [f"mistake(eps=0.{i})" for i in range(1, 9)]
    found = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        told = [
            row
            for family in "abcd"
            for teacher in ("silent", *teachers)
            for row in rows(rng.normal(5, 1, 12), family, teacher=teacher)
        ]
        there = outcomes(told)
        both = pairs(there, "silent")
        every = [finding(each, len(teachers), ALL, both) for each in primary(there, "silent", ALL)]
        found += any(each.against or each.along for each in every)
    assert found <= 5, "of 40 studies without an effect, 5 % may name a family"
