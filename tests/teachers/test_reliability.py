"""Reliability finds hedges that are overconfident or timid, and hardly ever finds fault with calibrated ones."""

import pytest
from scipy.stats import binom

from teachers.common import Late, Reward, Solved, bend, hedge
from teachers.reliability import LEVEL, Bin, Reliability, share_of_clusters

STREAMS = 100


def stream(rng, factor, episodes=60, alike=False):
    """The calibration of a teacher that multiplies log-odds; if `alike`, all claims of an episode hold, or none."""
    found = Reliability()
    for _ in range(episodes):
        hedges, luck = [], rng.random()
        for true in rng.integers(55, 90, size=rng.integers(0, 30)) / 100:
            said = bend(hedge(Solved(), 0.7 if alike else true), factor).p
            hedges.append((said, bool((luck if alike else rng.random()) < (0.7 if alike else true))))
        found.add(hedges)
    return found


@pytest.mark.parametrize("alike", [False, True])
def test_calibrated_streams_are_hardly_ever_found_fault_with(alike, rng):
    wrong = sum(stream(rng, 1, alike=alike).verdict != "calibrated" for _ in range(STREAMS))
    assert wrong <= binom.ppf(1 - 1e-6, STREAMS, LEVEL + 0.02), wrong  # of about 60 sums the test is not exact


@pytest.mark.parametrize(("factor", "verdict"), [(2, "overconfident"), (0.5, "timid")])
def test_what_is_bent_is_found(factor, verdict, rng):
    found = [stream(rng, factor).verdict for _ in range(50)]
    assert found.count(verdict) >= 48, found


def test_intervals_are_judged_apart(rng):
    """Few certain lies among timid truth cancel in the sum of all, and show in their interval."""
    found = Reliability()
    for _ in range(40):
        found.add([(0.99, False), *[(0.6, True)] * 14])
    assert found.verdict == "timid"
    assert found.overstated < 1e-6
    calibrated = []
    for _ in range(300):
        found = Reliability()
        for _ in range(20):
            sure = rng.choice([0.55, 0.65, 0.75, 0.85, 0.95, 0.99], size=8)
            found.add((float(p), bool(rng.random() < p)) for p in sure)
        calibrated.append(found.overstated < 0.01)
    assert sum(calibrated) <= 12
    assert Reliability().overstated == 1


def test_scores_and_table_are_those_of_their_definitions():
    found = Reliability()
    found.add([(0.6, True), (0.6, False), (0.69, True)])
    found.add([])
    found.add([(0.9, True)])
    assert found.sentences == 4
    assert found.brier == pytest.approx((0.16 + 0.36 + 0.31**2 + 0.01) / 4)
    assert found.bins == (
        Bin(0.6, 3, pytest.approx(0.63), pytest.approx(2 / 3)),
        Bin(0.9, 1, pytest.approx(0.9), 1.0),
    )
    assert found.error == pytest.approx((3 * (2 / 3 - 0.63) + 0.1) / 4)
    assert found.scores == pytest.approx([0.4 * -0.2 + -0.6 * -0.2 + 0.31 * -0.38, 0.1 * -0.8])
    assert found.as_dict()["episodes"] == 2


def test_without_hedges_nothing_is_judged():
    found = Reliability()
    assert (found.sentences, found.brier, found.error, found.p_value, found.verdict) == (0, None, None, 1.0, "")
    found.add([(0.99, False)] * 100)
    assert found.verdict == "too few to tell"


def test_bending_multiplies_log_odds_and_leaves_a_hedge():
    assert bend(hedge(Solved(), 0.8), 2).p == 0.94  # odds of 4 become 16
    assert bend(hedge(Solved(), 0.8), 0.5).p == 0.67  # and 2
    assert bend(hedge(Solved(), 0.9), 100).p == 0.99
    assert bend(hedge(Solved(), 0.9), 0.01).p == 0.51
    flat, late = Reward(reward=1.0), Late(claim=Solved(), turn=1)
    assert (bend(flat, 2), bend(late, 2)) == (flat, late)
    assert bend(hedge(late, 0.8), 2) == hedge(late, 0.94)


def test_intervals_take_an_episode_for_one_cluster(rng):
    """Where all claims of an episode hold or none does, an interval of as many independent ones would be too short."""
    covered, alone = 0, 0
    for _ in range(200):
        clusters = [(size, size * (rng.random() < 0.8)) for size in rng.integers(1, 20, 40).tolist()]
        sentences, held = map(sum, zip(*clusters, strict=True))
        low, high = share_of_clusters(clusters)
        assert low < held / sentences <= high  # where all hold, both are 1
        covered += low <= 0.8 <= high
        low, high = share_of_clusters([(1, 1)] * held + [(1, 0)] * (sentences - held))
        alone += low <= 0.8 <= high
    assert covered >= binom.ppf(1e-6, 200, 0.93), covered
    assert alone < covered


def test_ends_of_intervals_where_all_claims_hold_or_none_or_there_is_one_episode():
    one = share_of_clusters([(2, 1)])
    assert one[0] < 0.5 < one[1]
    assert share_of_clusters([(1, 1)]) == (pytest.approx(0.025), 1.0)
    assert share_of_clusters([(2, 0)]) == (0.0, pytest.approx(0.975))
