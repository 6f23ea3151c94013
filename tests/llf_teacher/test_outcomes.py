"""Outcomes of episodes by teacher and student, what a comparison can show, and how many seeds it needs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.analysis.contrasts import can_differ, least_p
from llf_teacher.studies.analysis.outcomes import outcomes, paired
from llf_teacher.studies.analysis.power import equal, needs, power, seeds_needed
from llf_teacher.studies.analysis.primary import primary, primary_needs
from llf_teacher.studies.analysis.statistics import paired_difference
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store

SPEC = EpisodeSpec("a-v0", "silent", "obedient", "b", "a", 5, 0, "1", "2.1")


def row(regret, **changes):
    """An episode as a store has it; it succeeds at turn 2 if it has no regret."""
    spec = SPEC._replace(**changes)
    return spec._asdict() | {
        "family": "toy",
        "regret": regret,
        "success": regret == 0,
        "first_success": None if regret else 2,
    }


def test_environments_are_averaged_within_a_seed_that_all_have():
    rows = [row(float(seed), id=id, seed=seed) for id in ("a-v0", "b-v0") for seed in (2, 0, 1)]
    rows += [row(6.0, id="a-v0", seed=3), row(6.0, id="a-v0", seed=0)]  # one seed has half, one episode comes again
    ((group, cells),) = outcomes(rows).items()
    cell = cells["silent", "obedient"]
    assert group.ids == ("a-v0", "b-v0")
    assert cell.seeds.tolist() == [0, 1, 2]
    assert cell.regret.tolist() == [0, 1, 2]
    assert cell.success.tolist() == [1, 0, 0]
    assert cell.first.tolist() == [[2, 2], [np.inf] * 2, [np.inf] * 2]


def test_samples_are_averaged_within_their_seed():
    rows = [row(regret, seed=seed, sample=sample) for seed, sample, regret in ((0, 1, 4.0), (0, 0, 0.0), (1, 0, 3.0))]
    (cells,) = outcomes(rows).values()
    cell = cells["silent", "obedient"]
    assert cell.seeds.tolist() == [0, 1]
    assert cell.regret.tolist() == [2, 3]
    assert cell.success.tolist() == [0.5, 0]
    assert cell.first.tolist() == [[2], [np.inf]]


def test_environments_with_other_teachers_stand_apart():
    rows = [row(1.0), row(1.0, id="b-v0"), row(1.0, id="b-v0", teacher="oracle")]
    assert [group.ids for group in outcomes(rows)] == [("a-v0",), ("b-v0",)]
    ((group, cells),) = outcomes(rows, alike=len).items()
    assert group.ids == ("a-v0", "b-v0")
    assert list(cells) == [("silent", "obedient")]


@pytest.mark.parametrize(
    "name", ["version", "rules", "max_turns", "feedback_type", "instruction_type", "lessons", "options"]
)
def test_what_is_not_comparable_stands_apart(name):
    other = 9 if isinstance(getattr(SPEC, name), int) else "9"
    assert len(outcomes([row(1.0), row(1.0, teacher="oracle", **{name: other})])) == 2


def test_pairs_have_the_same_seeds():
    rows = [row(10.0 + seed, seed=seed) for seed in (0, 2, 3)]
    rows += [row(float(seed), seed=seed, teacher="oracle") for seed in (1, 2, 3)]
    (cells,) = outcomes(rows).values()
    silent, oracle = paired(cells["silent", "obedient"], cells["oracle", "obedient"])
    assert silent.regret.tolist() == [12, 13]
    assert oracle.regret.tolist() == [2, 3]
    assert oracle.first.shape == (2, 1)


@pytest.mark.parametrize(
    ("teacher", "baseline", "student", "feedback_type", "can"),
    [
        ("oracle", "silent", "obedient", "a", True),
        ("oracle", "placebo", "text_only", "hp", True),
        ("silent", "silent", "obedient", "a", False),
        ("oracle", "silent", "reward_only", "a", False),
        ("oracle", "silent", "oracle", "a", False),
        ("oracle", "silent", "obedient", "n", False),
        ("oracle | silent", "silent", "obedient", "a", False),
        ("oracle | silent", "oracle", "obedient", "a", True),
    ],
)
def test_a_comparison_needs_somebody_who_hears_something(teacher, baseline, student, feedback_type, can):
    assert can_differ(teacher, baseline, student, feedback_type) is can


@pytest.mark.parametrize("n", [1, 2, 5, 13, 20, 40])
def test_the_least_p_is_that_of_differences_of_one_sign(n):
    assert paired_difference(np.arange(1.0, n + 1), np.zeros(n)).p == pytest.approx(least_p(n))


def test_power_is_that_of_simulated_studies():
    rng = np.random.default_rng(0)
    draws = rng.normal(0.4, 1.0, (20_000, 30))
    found = (stats.ttest_1samp(draws, 0, axis=1).pvalue <= 0.05).mean()
    assert power(30, 0.4, 1.0) == pytest.approx(found, abs=0.012)


@pytest.mark.parametrize("seeds", [3, 20, 100])
def test_power_grows_with_the_effect_however_large(seeds):
    found = [power(seeds, effect, 1.0, 0.05 / 9) for effect in np.linspace(0, 20, 101)]
    assert found == sorted(found)
    assert found[0] == pytest.approx(0.05 / 9)
    assert 0.99 < found[-1] <= 1


def test_so_many_seeds_find_the_effect_by_the_test_that_is_used():
    seeds = seeds_needed(0.5, 1.0)
    assert power(seeds - 1, 0.5, 1.0) < 0.8 <= power(seeds, 0.5, 1.0)
    rng = np.random.default_rng(1)
    draws = rng.normal(0.5, 1.0, (1500, seeds))
    flips = rng.choice([-1.0, 1.0], (1500, seeds))
    means = np.abs(flips @ draws.T) >= np.abs(draws.sum(axis=1))  # flips by studies
    assert (means.mean(axis=0) <= 0.05).mean() == pytest.approx(0.8, abs=0.035)


def test_more_is_asked_of_a_smaller_effect_and_of_a_stricter_level():
    assert seeds_needed(0.25, 1.0) > seeds_needed(0.5, 1.0) > seeds_needed(5.0, 1.0) == seeds_needed(0.1, 0.0) == 6
    assert seeds_needed(0.5, 1.0, alpha=0.005) > seeds_needed(0.5, 1.0)
    assert least_p(seeds_needed(0.1, 0.0, alpha=0.005)) <= 0.005


def test_a_pilot_says_what_its_comparisons_need():
    rng = np.random.default_rng(2)
    rows = [row(10.0, seed=seed, student=student) for seed in range(8) for student in ("obedient", "random")]
    regrets = 8 + rng.normal(0, 2, 8)
    rows += [row(regret, seed=seed, teacher="oracle") for seed, regret in enumerate(regrets)]
    rows += [row(1.0, seed=seed, teacher="oracle", student="random") for seed in range(8)]
    (need,) = needs(outcomes(rows), "silent", 0.1)
    assert (need.teacher, need.other, need.student, need.pairs) == ("oracle", "silent", "obedient", 8)
    assert need.spread == pytest.approx(np.std(regrets, ddof=1) / (10 + regrets.mean()))  # of scores
    assert need.seeds == seeds_needed(0.1, need.spread) < need.safe
    (in_unit,) = needs(outcomes(rows), "silent", 1.0, "regret")
    assert in_unit.spread == pytest.approx(np.std(regrets, ddof=1))
    (turned,) = needs(outcomes(rows), "none", 0.1, compare=[("silent", "oracle")])
    assert turned.spread == pytest.approx(need.spread)


def test_teachers_that_are_equal_at_every_seed_need_no_number_of_seeds():
    """Their spread of 0 would ask for the fewest seeds of all."""
    rows = [row(5.0 + seed, seed=seed, teacher=name) for seed in range(8) for name in ("silent", "placebo")]
    rows += [row(4.0 + seed / 2, seed=seed, teacher="oracle") for seed in range(8)]
    found = outcomes(rows)
    for measure in ("score", "regret"):
        assert [each.teacher for each in needs(found, "silent", 0.1, measure)] == ["oracle"]
        assert equal(found, "silent", measure) == 1
    assert [each.teacher for each in primary_needs(found, "silent", 0.1)] == ["oracle"]


def test_a_score_needs_regret_with_the_other_teacher():
    rows = [row(0.01 + seed / 1000, seed=seed) for seed in range(8)]
    rows += [row(5.0 + seed, seed=seed, teacher="hinter") for seed in range(8)]
    assert list(needs(outcomes(rows), "silent", 0.1)) == primary_needs(outcomes(rows), "silent", 0.1) == []
    (need,) = needs(outcomes(rows), "silent", 1.0, "regret")
    assert need.seeds == seeds_needed(1.0, need.spread)
    (found,) = primary(outcomes(rows), "silent", None)
    assert not found.ratio
    assert found.differences[0].mean == pytest.approx(8.5 - 0.0135)
    (turned,) = primary(outcomes(rows), "hinter", None)
    assert turned.ratio


def test_primary_comparisons_need_what_their_scores_need():
    rng = np.random.default_rng(5)
    silent, oracle = rng.uniform(8, 12, 9), rng.uniform(4, 8, 9)
    rows = [row(regret, seed=seed) for seed, regret in enumerate(silent)]
    rows += [row(regret, seed=seed, teacher="oracle") for seed, regret in enumerate(oracle)]
    (found,) = primary_needs(outcomes(rows), "silent", 1 / 3)
    assert (found.family, found.pairs) == ("all", 9)
    assert found.spread == pytest.approx(np.std((silent - oracle) / (silent.mean() + oracle.mean()), ddof=1))
    assert found.seeds == seeds_needed(1 / 3, found.spread)
    assert primary_needs(outcomes(rows), "silent", 0.5, patterns=[{"teacher": "hinter"}]) == []


def test_the_safe_number_is_enough_in_four_pilots_of_five():
    rng = np.random.default_rng(3)
    true = seeds_needed(0.5, 1.0)
    enough = 0
    for _ in range(100):
        regrets = 10 - 10 * rng.normal(0.5, 1.0, 10)
        rows = [row(10.0, seed=seed) for seed in range(10)]
        rows += [row(regret, seed=seed, teacher="oracle") for seed, regret in enumerate(regrets)]
        (need,) = needs(outcomes(rows), "silent", 5.0, "regret")
        enough += need.safe >= true
    assert enough / 100 == pytest.approx(0.8, abs=0.08)


def test_the_command_reads_a_pilot(tmp_path):
    study = Study(
        ids=["llf-gridworld-v0"], teachers=["oracle", "silent", "vague"], students=["obedient", "random"], seeds=3
    )
    study = replace(study, names={"vague": "the vague one"})
    with Store(tmp_path / "pilot.db") as store:
        store.write_manifest({"study": study.as_dict()})
        for spec in study.episodes():
            store.add(play(spec))
        (vague, oracle) = sorted(needs(outcomes(store.rows()), "silent", 0.2), key=lambda need: -need.safe)
        together = primary_needs(outcomes(store.rows()), "silent", 0.2)
    said = CliRunner().invoke(app, ["study", "power", str(tmp_path / "pilot.db"), "--effect", "0.2"]).output
    assert said.splitlines()[3].split()[-4:] == ["3", f"{vague.spread:.3f}", f"{vague.seeds}", f"{vague.safe}"]
    assert "  the vague one  " in said, "as in the report"
    assert "  vague  " not in said
    for which, found in (
        ("primary comparison, of all families together", together),
        ("comparison of a family", [vague, oracle]),
    ):
        needed = max(each.seeds for each in found), max(each.safe for each in found)
        end = f"in every {which}, use {needed[0]} seeds, or {needed[1]} to be safe."
        assert f"To find a score of 0.2 with a probability of 0.8 {end}" in said
    with pytest.raises(ValueError, match=r"has too few episodes: .* with 'placebo' and with another teacher"):
        CliRunner().invoke(
            app,
            ["study", "power", str(tmp_path / "pilot.db"), "--effect", "0.2", "--baseline", "placebo"],
            catch_exceptions=False,
        )


def test_a_measure_is_one_of_three():
    with pytest.raises(ValueError, match=r"unknown measure 'gain'; .*allowed: score, regret, success"):
        list(needs({}, "silent", 0.1, "gain"))
