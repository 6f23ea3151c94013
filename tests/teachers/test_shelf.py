"""Each personality of the shelf against its definition, worked out here a second time, over thousands of turns."""

import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from lessons import ALPHA, CHEAP, fits, lab, of, on_cheap_families, oracles, pupil, rows, taught, turns, without
from scipy.stats import norm
from shelf import FAMILIES

from teachers.atoms import FN, FP, HN, HP, KINDS, ActionClaim, HintClaim, R
from teachers.common import Chance, NoDifference
from teachers.fingerprint import Fingerprints
from teachers.oracles.gridworld.claims import Either, Go
from teachers.personalities.noisy import Noisy
from teachers.personality import parse_personality
from teachers.testing import Pupil
from teachers.view import View

HINDSIGHT = (HP, HN)


def regret(oracle, moment):
    values = oracle.values(moment.before)
    return max(values) - values[moment.action]


def spread(values):
    return max(values) - min(values)


def turns_of(name, spec, budget, worth):
    """In how many turns it speaks: it says all in the first `budget` turns of an episode that are worth it."""
    spoke = 0
    for oracle, episode in rows(name, spec):
        left = budget
        for turn, (_, said, true) in enumerate(episode, 1):
            wanted = left and true and worth(oracle, [moment for moment, _, _ in episode[:turn]])
            assert said == (true if wanted else [])
            left -= bool(wanted)
            spoke += bool(said)
    return spoke


@on_cheap_families
@pytest.mark.parametrize("budget", [0, 1, 5, 1000])
def test_early_speaks_in_the_first_turns(name, budget):
    for _, episode in rows(name, f"early(budget={budget})"):
        for turn, (_, said, true) in enumerate(episode):
            assert said == (true if turn < budget else [])


@on_cheap_families
@pytest.mark.parametrize(("budget", "threshold"), [(3, 0.0), (4, 0.7), (6, 1.5), (1000, 0.9)])
def test_importance_speaks_where_much_is_at_stake(name, budget, threshold):
    def worth(oracle, moments):
        return not moments[-1].over and spread(oracle.values(moments[-1].after)) >= threshold

    spoke = turns_of(name, f"importance(budget={budget}, threshold={threshold})", budget, worth)
    assert spoke > 100 or threshold > 1


@on_cheap_families
@pytest.mark.parametrize(("budget", "threshold"), [(2, 0.0), (4, 0.7), (1000, 0.5)])
def test_mistake_correcting_speaks_after_mistakes_that_matter(name, budget, threshold):
    def worth(oracle, moments):
        last = moments[-1]
        return last.before and spread(oracle.values(last.before)) >= threshold and regret(oracle, last) > 0

    assert turns_of(name, f"mistake_correcting(budget={budget}, threshold={threshold})", budget, worth) > 100


@on_cheap_families
@pytest.mark.parametrize(("budget", "threshold"), [(2, 0.0), (1000, 0.5)])
def test_predictive_speaks_where_it_expects_a_mistake(name, budget, threshold):
    def worth(oracle, moments):
        here, values = moments[-1].after, oracle.values(moments[-1].after)
        done = [(moment.before, moment.action) for moment in moments if moment.before is not None]
        likely = [action for truth, action in done if truth == here] or [action for _, action in done]
        mistake = likely and values[Counter(likely).most_common(1)[0][0]] < max(values)
        return not moments[-1].over and spread(values) >= threshold and mistake

    assert turns_of(name, f"predictive(budget={budget}, threshold={threshold})", budget, worth) > 50


@on_cheap_families
@pytest.mark.parametrize("top_k", [0, 1, 7])
def test_end_of_episode_says_the_weightiest_claims_at_the_end(name, top_k):
    for oracle, episode in zip(oracles(name), taught(name, f"end_of_episode(top_k={top_k})"), strict=True):
        stakes = []
        for turn, (moment, atoms, true) in enumerate(episode):
            stake = oracle.importance(moment.after if moment.before is None else moment.before)
            stakes += [(stake, turn, claim) for claim in true]
            assert moment.over or not atoms
        best = sorted(range(len(stakes)), key=lambda i: (stakes[i][0], i))[len(stakes) - top_k :]
        assert [(a.about_turn, a.claim) for a in atoms] == [stakes[i][1:] for i in sorted(best)]


@on_cheap_families
@pytest.mark.parametrize("fade", [0.0, 0.2, 0.35, 1.0])
def test_scaffold_helps_less_after_success_and_more_after_failure(name, fade):
    sizes = set()
    for _, episode in rows(name, f"scaffold(fade={fade})"):
        help_ = 1.0
        for _, said, true in episode:
            verdicts = of(true, *HINDSIGHT)
            if verdicts:
                help_ = min(1.0, max(0.0, help_ + (fade if of(verdicts, HN) else -fade)))
            kinds = (R, HP, HN, FN, FP)[: math.ceil(round(help_ * 5, 6))]
            assert said == of(true, *kinds)
            sizes.add(len(kinds))
    assert sizes >= {0.0: {5}, 0.2: {0, 1, 2, 3, 4, 5}, 0.35: {0, 4, 5}, 1.0: {0, 5}}[fade]


@pytest.mark.parametrize("level", [0, 1, 2])
def test_hinter_climbs_from_the_vague_to_the_plain(level):
    seen = set()
    for _, episode in rows("gridworld", f"hinter(level={level})"):
        rung = level
        for _, said, true in episode:
            if verdicts := of(true, *HINDSIGHT):
                rung = rung + 1 if of(verdicts, HN) else level
            hints = [hint for hint in of(said, FP) if isinstance(hint, Either)]
            told = [claim for claim in without(true, FP) if not any(hint.excludes(claim) for hint in hints)]
            assert without(said, FP) == told
            assert not any(claim.action in hint.ways for claim in of(said, FN) for hint in hints)
            for hint, advice in zip(of(said, FP), of(true, FP), strict=True):
                assert type(hint) is (Either if rung < 2 else Go)
                assert len(hint.ways) == 3 - rung if rung < 2 else hint == advice
                assert rung >= 2 or advice.action in hint.ways
                seen.add(min(rung, 2))
    assert seen == set(range(level, 3))


@pytest.mark.parametrize("n", [1, 2, 4])
def test_worked_example_shows_the_plan(n):
    shown = 0
    for oracle, moment, said, true in turns("gridworld", f"worked_example(n={n})"):
        assert without(said, FP) == without(true, FP)
        for example in of(said, FP):
            assert example.actions == oracle.plan(moment.after, n)
            shown += len(example.actions) == n
    assert shown > 50


@on_cheap_families
@pytest.mark.parametrize("p", [0.0, 0.3, 1.0])
def test_sycophant_flatters_at_its_rate_and_whenever_it_is_pushed(name, p):
    counts = {True: [0, 0], False: [0, 0]}
    for _, episode in rows(name, f"sycophant(p={p})"):
        advised = [[getattr(claim, "action", None) for claim in of(said, FP)] for _, said, _ in episode]
        for turn, (moment, said, true) in enumerate(episode):
            assert not of(said, HN)
            before = next((each for each in reversed(advised[:turn]) if each), [])
            insists = turn > 1 and moment.action == episode[turn - 1][0].action
            pushed = insists and bool(before) and moment.action not in before
            rejected = [claim for claim in of(true, FP) if pushed and claim.action in before]
            assert of(said, R, FP, FN) == [claim for claim in of(true, R, FP, FN) if claim not in rejected]
            if of(true, HN):
                counts[pushed][0] += 1
                counts[pushed][1] += len(of(said, HP))
                assert all(not claim.holds(moment, lab(name)) for claim in of(said, HP))
            else:
                assert of(said, HP) == of(true, HP)
    assert counts[True][0] == counts[True][1] > 100
    assert fits(counts[False][1], counts[False][0], p)


@on_cheap_families
@pytest.mark.parametrize("budget", [0, 1, 4])
def test_adversarial_gives_its_number_of_worst_tips(name, budget):
    for oracle, episode in rows(name, f"adversarial(budget={budget})"):
        false = chances = total = 0
        for turn, (moment, said, true) in enumerate(episode, 1):
            total += spread(oracle.values(moment.after))
            chances += bool(of(true, FP)) and spread(oracle.values(moment.after)) * turn >= total - 1e-9
            assert without(said, FP) == without(true, FP)
            for tip in of(said, FP):
                if tip not in true:
                    false += 1
                    values = oracle.values(moment.after)
                    assert values[tip.action] == min(values)
                    assert not tip.holds(moment, lab(name))
        assert false == min(budget, chances)


@on_cheap_families
def test_drifting_turns_at_its_turn(name):
    for episode, late in zip(
        rows(name, "drifting(after=7, to='early(budget=3)')"), rows(name, "drifting(after=7)"), strict=True
    ):
        for turn, ((_, said, true), (_, silent, _)) in enumerate(zip(episode[1], late[1], strict=True)):
            assert said == (true if turn < 10 else [])
            assert silent == (true if turn < 7 else [])


@on_cheap_families
@pytest.mark.parametrize("scaled", [True, False])
@pytest.mark.parametrize("beta", [0.0, 1.0, 3.0, 1e6])
def test_noisy_judges_by_bradley_and_terry(name, beta, scaled):
    observed, expected, variance = 0, 0.0, 0.0
    for oracle, episode in rows(name, f"noisy(beta={beta}, scaled={scaled})"):
        variances = []
        for moment, said, true in episode:
            assert without(said, *HINDSIGHT) == without(true, *HINDSIGHT)
            if moment.before is None:
                continue
            values = oracle.values(moment.before)
            variances.append(np.var(values))
            if not of(true, *HINDSIGHT):
                continue
            mine = values[moment.action]
            rivals = [value for value in values if value != mine]
            unit = math.sqrt(np.mean(variances)) if scaled else 1.0
            good = 1.0 if not rivals else 1 / (1 + math.exp(min(beta * (max(rivals) - mine) / unit, 700)))
            assert len(of(said, *HINDSIGHT)) == 1
            observed += len(of(said, HP))
            expected += good
            variance += good * (1 - good)
            if beta == 1e6:
                assert said == true
    assert abs(observed - expected) <= norm.isf(ALPHA / 2) * math.sqrt(variance) + 1e-6


class InUnits(View):
    """A view with values in another unit."""

    unit = 1.0

    def past_values(self):
        values = super().past_values()
        return values and tuple(self.unit * value for value in values)


@on_cheap_families
@pytest.mark.parametrize("unit", [2.0**-10, 2.0**10])
def test_noisy_says_the_same_in_every_unit_of_values(name, unit):
    differ = Counter()
    for oracle, episode in rows(name, "oracle"):
        for spec in (Noisy(), Noisy(scaled=False)):
            views = InUnits(oracle, len), InUnits(oracle, len)
            views[1].unit = unit
            stages = [spec.start(np.random.default_rng(0)) for _ in views]
            for moment, _, true in episode:
                for view in views:
                    view.see(moment, frozenset(KINDS))
                one, other = (stage.speak(true, view) for stage, view in zip(stages, views, strict=True))
                differ[spec.scaled] += one != other
    assert differ[True] == 0
    assert differ[False] > 20


@on_cheap_families
@pytest.mark.parametrize("eps", [0.0, 0.1, 0.6, 1.0])
def test_skip_is_silent_when_neither_action_is_good(name, eps):
    skipped = 0
    for oracle, episode in rows(name, f"skip(eps={eps})"):
        stakes, worth = [], [0.0]
        for moment, said, true in episode:
            if moment.before is None:
                assert said == true
                continue
            values = oracle.values(moment.before)
            stakes.append(spread(values))
            worth.append(values[moment.action] - min(values))
            silent = max(worth[-2:]) < eps * sum(stakes) / len(stakes) - 1e-7
            assert said == ([] if silent else true)
            skipped += silent
    assert (skipped > 50) == (eps > 0)


@on_cheap_families
@pytest.mark.parametrize("eps", [0.0, 0.1, 0.6, 1.0])
def test_equal_sees_no_difference_within_its_margin(name, eps):
    same = 0
    for oracle, episode in rows(name, f"equal(eps={eps})"):
        stakes = []
        for moment, said, true in episode:
            if moment.before is None:
                assert said == true
                continue
            values = oracle.values(moment.before)
            stakes.append(spread(values))
            mine = values[moment.action]
            other = max(np.delete(values, moment.action))
            if of(true, *HINDSIGHT) and abs(mine - other) < eps * sum(stakes) / len(stakes) - 1e-7:
                (claim,) = of(said, *HINDSIGHT)
                assert type(claim) is NoDifference
                assert (claim.mine, claim.other) == (mine, other)
                same += 1
            else:
                assert said == true
            assert without(said, *HINDSIGHT) == without(true, *HINDSIGHT)
    assert (same > 50) == (eps > 0)


@on_cheap_families
def test_no_difference_is_false_of_other_values(name):
    """Those that are 41 apart, or that a teacher made up, whatever margin it allows itself."""
    checked = 0
    for _, episode in rows(name, "equal(eps=1.0)"):
        for moment, said, _ in episode:
            for claim in said:
                if type(claim) is NoDifference:
                    assert claim.holds(moment, lab(name))
                    for mine, other in ((claim.mine, claim.other - 41), (claim.mine + 0.01, claim.other + 0.01)):
                        fields = {"action": claim.action, "mine": mine, "other": other, "margin": 99.0}
                        assert not NoDifference.on(claim._ground, **fields).holds(moment, lab(name))
                    checked += 1
    assert checked > 20


@pytest.mark.parametrize(("gamma", "horizon"), [(0.0, 1), (0.5, 2), (0.8, 5), (0.99, 100)])
def test_myopic_does_not_see_harm_behind_its_horizon(gamma, horizon):
    kept, dropped = 0, 0
    for oracle, moment, said, true in turns("gridworld", f"myopic(gamma={gamma})"):
        assert without(said, HN) == without(true, HN)
        if of(true, HN):
            steps = [1 - value for value in oracle.values(moment.before)]
            sees = min(steps) <= horizon  # the best way is within sight, and this one is longer
            assert of(said, HN) == (of(true, HN) if sees else [])
            kept, dropped = kept + sees, dropped + (not sees)
    assert kept > 20
    assert (dropped > 20) == (horizon < 100)


@on_cheap_families
@pytest.mark.parametrize(("likelihood", "consistency"), [(0.8, 0.9), (0.3, 0.5), (1, 1), (0, 0.5), (1, 0)])
def test_inconsistent_speaks_and_is_right_at_its_rates(name, likelihood, consistency):
    claims = right = wrong = 0
    for _, _, said, true in turns(name, f"inconsistent(likelihood={likelihood}, consistency={consistency})"):
        claims += len(true)
        right += sum(claim in true for claim in said)
        wrong += sum(claim not in true for claim in said)
    assert claims > 5000
    assert fits(right, claims, likelihood * consistency)
    assert fits(wrong, claims, likelihood * (1 - consistency))


@on_cheap_families
@pytest.mark.parametrize(
    ("spec", "plus", "minus"),
    [
        ("reward_focused", 0.1, 0.9),
        ("punishment_focused", 0.9, 0.1),
        ("inactive", 0.9, 0.9),
        ("inactive(plus=0.3, minus=0.6)", 0.3, 0.6),
        ("reward_focused(plus=0, minus=1)", 0, 1),
    ],
)
def test_silence_has_its_rates(name, spec, plus, minus):
    there, kept = Counter(), Counter()
    for _, _, said, true in turns(name, spec):
        assert without(said, *HINDSIGHT) == without(true, *HINDSIGHT)
        there.update(claim.kind for claim in of(true, *HINDSIGHT))
        kept.update(claim.kind for claim in of(said, *HINDSIGHT))
    assert min(there.values()) > 400
    assert fits(there[HP] - kept[HP], there[HP], plus)
    assert fits(there[HN] - kept[HN], there[HN], minus)


@on_cheap_families
@pytest.mark.parametrize("rate", [0.0, 0.3, 1.0])
def test_policy_dependent_compares_with_the_students_habit(name, rate):
    for oracle, episode in rows(name, f"policy_dependent(rate={rate})"):
        habit, greatest = None, 0.0
        for moment, said, true in episode:
            assert without(said, *HINDSIGHT) == without(true, *HINDSIGHT)
            if moment.before is None:
                continue
            lost = regret(oracle, moment)
            greatest = max(greatest, lost)
            gain = None if habit is None else habit - lost
            habit = lost if habit is None else (1 - rate) * habit + rate * lost
            if gain is None:
                assert said == true
            elif abs(abs(gain) - 0.05 * greatest) > 1e-9:
                assert of(said, HP) == (of(true, HP) if gain > 0.05 * greatest else [])
                assert of(said, HN) == (of(true, HN) if gain < -0.05 * greatest else [])


def test_praise_for_the_same_good_action_has_diminishing_returns():
    streaks = []
    for _, episode in rows("bandits", "policy_dependent(rate=0.5)"):
        for (_, _, earlier), *good in zip(*(episode[i:] for i in range(9)), strict=False):
            if of(earlier, HN) and all(of(true, HP) for _, _, true in good):
                streaks.append([bool(of(said, HP)) for _, said, _ in good])
    assert streaks
    assert all(not (later and not sooner) for streak in streaks for sooner, later in pairwise(streak))
    assert not any(streak[-1] for streak in streaks)


def state(claim, moment):
    return moment.after if claim.kind in (FP, FN) or moment.before is None else moment.before


@on_cheap_families
@pytest.mark.parametrize(("low", "high"), [(0.0, 0.5), (0.2, 1.0), (0.3, 0.3)])
def test_feature_noise_errs_as_the_state_has_it(name, low, high):
    prints = Fingerprints()
    observed, expected, variance = 0, 0.0, 0.0
    for _, moment, said, true in turns(name, f"feature_noise(low={low}, high={high})"):
        for claim in true:
            eps = low + (high - low) * prints.share(state(claim, moment))
            expected, variance = expected + eps, variance + eps * (1 - eps)
            observed += claim not in said
    assert abs(observed - expected) <= norm.isf(ALPHA / 2) * math.sqrt(variance)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.8, 1.0])
def test_limited_knowledge_knows_its_share_of_the_states(fraction):
    known = {}
    for oracle, moment, said, true in turns("gridworld", f"limited_knowledge(fraction={fraction})"):
        assert of(said, R) == of(true, R)
        for claim in without(true, R):
            truth = state(claim, moment)
            assert known.setdefault((id(oracle), truth), claim in said) == (claim in said)
    assert len(known) > 500
    assert fits(sum(known.values()), len(known), fraction)


def test_pupils_play_long_enough():
    assert all(sum(len(e) for e in taught(name, "oracle")) > 2000 for name in CHEAP)
    assert {pupil(name).max_turns for name in CHEAP} == {20, 30}


def hints_said(name, **options):
    """What `hinter` says in turns with a hint, and what it withholds, in random play."""
    each = FAMILIES[name]
    pupil = Pupil(lambda: each.make_world(**options), each.make_teacher, max_turns=10)
    for episode in pupil.taught(parse_personality("hinter"), 60):
        for heard in episode:
            claims = [atom.claim for atom in heard.atoms]
            oracle = [claim for claim in of(heard.true, HN, FN) if isinstance(claim, ActionClaim)]  # without clues
            if hints := [claim for claim in claims if isinstance(claim, HintClaim | Chance)]:
                yield hints, claims, [claim for claim in oracle if claim not in claims]


@pytest.mark.parametrize("name", ["gridworld", "bandits", "alfworld"])
def test_no_hint_is_made_an_answer_by_a_warning(name):
    withheld = 0
    for hints, claims, missing in hints_said(name):
        warned = {claim.action for claim in claims if claim.kind is FN and isinstance(claim, ActionClaim)}
        assert not any(hint.leaves(action) for hint in hints if isinstance(hint, HintClaim) for action in warned)
        assert all(any(hint.excludes(claim) for hint in hints) for claim in missing)
        withheld += len(missing)
    assert withheld > 3


def test_of_two_arms_a_hint_does_not_come_with_a_warning_and_of_a_pair_not_with_blame():
    for hints, claims, missing in hints_said("bandits", problem="TwoArmedHighLowFixed"):
        assert all(type(hint) is Chance for hint in hints)
        assert not of(claims, FN)
        assert len(missing) == 1
    pairs = [(hint, claims) for (hint, *_), claims, _ in hints_said("bandits") if hint.high - hint.low == 1]
    assert pairs
    assert not any(hint.leaves(blame.action) for hint, claims in pairs for blame in of(claims, HN))
