"""The student that weighs the worlds it may be in: what it makes of words, whom it believes, and what it cannot see."""

import numpy as np
import pytest

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import family
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study
from teachers.atoms import Atom, Moment
from teachers.belief import DRAWS, Belief
from teachers.common import Reward, hedge
from teachers.information import DrawnWorld
from teachers.oracles.bandits import Among, Avoid, Pull
from worlds.world import WorldTurn

HOUSE, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
MAP = {HOUSE: {"map": True}, ARMS: {}}


def regret(id, student, seeds, **settings):
    """The regret of each episode, and the policy of the last."""
    found = []
    for seed in seeds:
        env = StudentEnv(id, **MAP[id], **settings)
        policy = parse_student(student).seat(env.family, env.session.world)
        oracle = env.family.make_teacher(env.session.world).oracle
        total = 0.0
        for turn in play_turns(env, policy, seed):
            if turn.moment.turn:
                total += oracle.regret(turn.moment)
            else:
                oracle.start(turn.moment.after)
        found.append(total)
    return np.array(found), policy


def believing(trust=1.0, worlds=64, seed=0, **options):
    """A bandit, and a belief that has seen its opening."""
    arms = family("bandits")
    world = arms.make_world(problem="TenArmedGaussian", **options)
    world.reset(seed=seed)
    belief = Belief(arms.make_posterior_context(world), np.random.default_rng(seed), worlds, trust)
    belief.see(Moment.opening(world.truth))
    return world, belief


def told(belief, *claims, turn=0):
    belief.learn([Atom(claim, "words", turn) for claim in claims])


@pytest.mark.parametrize(
    ("id", "kinds", "others"),
    [
        (HOUSE, "hp", ("random", "tamer")),
        (HOUSE, "hn", ("random", "tamer")),
        (
            ARMS,
            "hn",
            ("random",),
        ),  # blame of one arm says nothing of the others: who avoids what was blamed does as well
        (ARMS, "r", ("random",)),
    ],
)
def test_it_learns_where_nothing_is_advised(id, kinds, others):
    """Less regret than of random actions, and of a learner that hears the same."""
    settings = {"feedback_type": kinds, "max_turns": 12}
    own, _ = regret(id, "reasoner(worlds=32)", range(12), **settings)
    for other in others:
        less = regret(id, other, range(12), **settings)[0] - own
        assert less.mean() > 1.96 * less.std(ddof=1) / len(less) ** 0.5


@pytest.mark.parametrize("id", [HOUSE, ARMS])
def test_advice_is_taken(id):
    assert regret(id, "reasoner(worlds=16)", range(6), feedback_type="fp", max_turns=8)[0].max() == 0


@pytest.mark.parametrize("id", [HOUSE, ARMS])
def test_the_true_world_keeps_its_weight_with_an_honest_teacher(id):
    for seed in range(3):
        env = StudentEnv(id, max_turns=6, **MAP[id])
        policy = parse_student("reasoner(worlds=16)").seat(env.family, env.session.world)
        turns, moments = [], []
        for turn in play_turns(env, policy, seed):
            moment = turn.moment
            if turns:  # the policy has weighed all up to this turn, which it has yet to see
                truth = DrawnWorld(tuple(turns), moments)
                assert policy.belief.weight(truth) == 1
            action = moment.action if moment.turn else None
            turns.append(WorldTurn(action, moment.reward, moment.after, moment.success))
            moments.append(moment)


@pytest.mark.parametrize("town", [None, 3])
@pytest.mark.parametrize("id", [HOUSE, ARMS])
def test_it_acts_alike_in_worlds_that_it_cannot_distinguish(id, town):
    """The truths of two lessons are other draws of the posterior, of other towns; it sees and hears the same."""
    env = StudentEnv(
        id, max_turns=6, feedback_type="m", teacher="oracle" if town is None else "ruler", town=town, **MAP[id]
    )
    spec = f"reasoner(worlds=16, trust=0.9, forget={town is None})"
    student = parse_student(spec).seat(env.family, env.session.world)
    posterior = env.family.make_posterior(env.session.world)
    differs, lessons = 0, []
    for seed in range(4):
        shown = [
            (turn.moment, turn.atoms, env.student_view.observe(), env.student_view.info_for(student))
            for turn in play_turns(env, student, seed)
        ]
        turns = [  # some rewards are said
            WorldTurn(m.action if m.turn else None, m.reward, m.after, m.success, any(a.kind == "r" for a in atoms))
            for m, atoms, *_ in shown
        ]
        (other,) = posterior.take(turns, np.random.default_rng(seed), 1)
        differs += other[0].truth != turns[0].truth
        swapped = [
            m._replace(
                before=m.before and other[m.turn - 1].truth,
                after=other[m.turn].truth,
                reward=-9.0,
                success=not m.success,
            )
            for m, *_ in shown
        ]
        lessons.append((shown, swapped))
    there = StudentEnv(id, town=town and town + 1, **MAP[id]).session.world
    assert (there.law != env.session.world.law) == (town is not None)
    twins = [parse_student(spec).seat(env.family, world) for world in (env.session.world, there)]
    acted = [[], []]
    for seed, (shown, swapped) in enumerate(lessons):
        for twin, did, moments in zip(twins, acted, ([m for m, *_ in shown], swapped), strict=True):
            twin.reset(np.random.default_rng(seed))
            for moment, (_, _, observation, info) in zip(moments, shown, strict=True):
                if not moment.over:
                    did.append(twin.act(observation, info | {"sealed": moment}))
                    did.append(twin.belief.regrets().tobytes())
            twin.finish(observation, info, True)
    assert acted[0] == acted[1]
    assert differs
    assert bool(twins[0].belief.rules) == (town is not None)


def test_what_is_in_no_world_is_looked_for_and_then_ignored_and_counted():
    world, belief = believing()
    best = world.truth.best[0]
    told(belief, Among(low=7, high=6), Pull(action=best))
    assert belief.ignored == 1
    assert belief.regrets().argmin() == best
    assert len(belief._pool) == DRAWS * 64  # looked for once
    told(belief, Avoid(action=(best + 1) % 10))
    assert belief.ignored == 1
    assert len(belief._pool) < DRAWS * 64


def test_the_weight_of_a_world_falls_with_each_claim_that_does_not_hold():
    world, belief = believing(trust=0.75)
    best, *others = np.argsort(world.truth.means)[::-1].tolist()
    told(belief, Pull(action=best), Avoid(action=others[0]))
    for means, expected in ((best, 1), (others[1], 0.25), (others[0], 0.25**2)):
        truth = world.problem.truth(np.ones(10), np.eye(10)[means])
        assert belief.weight(DrawnWorld((WorldTurn(None, 0.0, truth),), belief._moments)) == pytest.approx(expected)


def test_without_trust_nothing_is_heard():
    world, belief = believing(trust=0.0)
    told(belief, Pull(action=world.truth.best[0]))
    assert belief.ignored == 0
    assert np.isfinite(belief.regrets()).sum() > 5


def test_a_reward_that_no_world_pays_is_ignored_and_counted():
    arms = family("bandits")
    world = arms.make_world(problem="TwoArmedDeterministicFixed")
    world.reset(seed=0)
    belief = Belief(arms.make_posterior_context(world), np.random.default_rng(0), 16)
    before = Moment.opening(world.truth)
    belief.see(before)
    told(belief)
    belief.see(Moment(world.truth, 0, 0.5, world.truth, False, 1, False))
    told(belief, Reward(reward=0.25), turn=1)
    assert belief.ignored == 1
    assert np.isfinite(belief.regrets()).all()


def test_with_a_liar_a_lower_trust_wastes_less():
    """Rewards are true, and all advice is for the worst arm."""
    settings = {"teacher": "adversarial(budget=1000)", "feedback_type": "r+fp", "max_turns": 12}
    much, little = (regret(ARMS, f"reasoner(worlds=16, trust={t})", range(12), **settings)[0] for t in (1, 0.1))
    less = much - little
    assert less.mean() > 1.96 * less.std(ddof=1) / len(less) ** 0.5


def test_forgetting_leaves_what_was_seen():
    own, policy = regret(HOUSE, "reasoner(worlds=16) | forgetful(half_life=2)", range(4), feedback_type="hp+hn")
    assert own.sum() < regret(HOUSE, "random", range(4), feedback_type="hp+hn")[0].sum()
    assert len(policy.inner.belief._moments) > 1


def test_a_study_says_what_is_missing():
    def study(id, **settings):
        return Study(ids=[id], teachers=["oracle"], students=["reasoner | stubborn(p=0.3)"], seeds=1, **settings)

    with pytest.raises(
        ValueError, match=r'set the option map=True; in the study.s file:\n.options."llf-gridworld-v0".\nmap = true'
    ):
        study(HOUSE)
    assert study(HOUSE, options={HOUSE: MAP[HOUSE]})
    allowed = "allowed: bandits, gridworld; elsewhere use another student, such as obedient"
    with pytest.raises(ValueError, match=f"movies has no values of actions; {allowed}"):
        study("llf-reco-movie-v0")
    with pytest.raises(ValueError, match=f"optimization has no posterior; {allowed}"):
        study("llf-optimization-Booth-v0")


@pytest.mark.parametrize("given", ["worlds=0", "trust=1.5", "trust=-1"])
def test_parameters_are_checked(given):
    with pytest.raises(ValueError, match=given.partition("=")[0]):
        parse_student(f"reasoner({given})")


@pytest.mark.parametrize("trust", [0.0, 0.5, 1.0])
def test_a_hedge_weighs_a_world_by_its_probability(trust):
    world, belief = believing(trust, worlds=512)
    best = world.truth.best[0]
    second, third = (best + 1) % 10, (best + 2) % 10
    told(belief, hedge(Pull(action=best), 0.8), hedge(Avoid(action=second), 0.6), Avoid(action=third))
    factors = {p: 1 - trust + trust * (1 - p) / p for p in (0.8, 0.6, 1.0)}
    seen = set()
    for drawn in belief._pool:
        top = drawn.draw[0].truth.best
        false = [best not in top, second in top, third in top]
        expected = np.prod([factors[p] for p, wrong in zip((0.8, 0.6, 1.0), false, strict=True) if wrong])
        assert belief.weight(drawn) == pytest.approx(expected)
        seen.add(tuple(false))
    assert len(seen) == 4
    assert belief._weights == pytest.approx([belief.weight(drawn) for drawn in belief._pool])
    assert belief.ignored == 0


def test_a_hedge_that_no_world_has_changes_nothing():
    _, belief = believing(0.9)
    told(belief, hedge(Among(low=7, high=6), 0.9))
    assert len(set(belief._weights)) == 1
    assert belief.ignored == 0


def test_more_probable_hedges_lead_to_less_regret_and_false_ones_astray():
    lost = {}
    for p, true in ((0.95, True), (0.6, True), (0.95, False)):
        lost[p, true] = 0.0
        for seed in range(20):
            world, belief = believing(worlds=64, seed=seed)
            best = world.truth.best[0]
            told(belief, hedge(Pull(action=best if true else (best + 1) % 10), p))
            values = np.array(belief._oracle.values(world.truth))
            lost[p, true] += values.max() - values[belief.regrets().argmin()]
    assert lost[0.95, True] <= lost[0.6, True] < lost[0.95, False]
