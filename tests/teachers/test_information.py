"""How much a claim says: bits by the worlds that a student cannot tell apart, and the regret that it saves."""

import math

import numpy as np
import pytest

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import entries, family
from teachers.atoms import Atom, Moment
from teachers.common import NoDifference, Reward, Right, Solved, TryAgain, Wrong, hedge
from teachers.information import Bits, Gain, Information
from teachers.oracles.bandits import Among, Avoid, Pull, PulledPoor
from teachers.oracles.gridworld.claims import Go, Map
from worlds.bandits import Bandit
from worlds.gridworld import DIRECTIONS, Gridworld, distances_from

GAUSSIAN = {"problem": "TenArmedGaussian"}
FIXED = {"problem": "TwoArmedDeterministicFixed"}


def opened(name, seed=0, worlds=256, **options):
    """A world after its reset, information about it that has seen the opening, and that moment."""
    world = family(name).make_world(**options)
    world.reset(seed=seed)
    information = family(name).make_information(world, seed, worlds)
    moment = Moment.opening(world.truth)
    information.see(moment)
    return world, information, moment


def acted(world, information, moment, action):
    """The moment after an action, which is seen."""
    _, reward, _, _, info = world.step(action)
    after = Moment(moment.after, action, reward, world.truth, info["success"], moment.turn + 1, False)
    information.see(after)
    return after


def heard(information, *claims, turn=0):
    return information.hear([Atom(claim, "words", turn) for claim in claims])


def test_bits_of_an_arm_among_ten():
    world, information, _ = opened("bandits", **GAUSSIAN)
    best = world.truth.best[0]
    said, again, among, avoided = heard(
        information, Pull(action=best), Pull(action=best), Among(low=0, high=9), Avoid(action=(best + 1) % 10)
    )
    low, high = said.interval
    assert low < math.log2(10) < high
    assert said.bits == pytest.approx(-math.log2(said.held / said.worlds))
    assert [each.bits for each in (again, among, avoided)] == [0, 0, 0]  # it is known already
    assert said.saved > 0.5  # by the expected maximum of ten, 1.54, less what a random arm pays
    assert again.saved == 0


def test_vaguer_words_say_less():
    world, information, _ = opened("bandits", seed=1, worlds=1000, **GAUSSIAN)
    best = world.truth.best[0]
    vague, precise = heard(information, Among(low=best - best % 5, high=best - best % 5 + 4), Pull(action=best))
    assert vague.interval[0] < 1 < vague.interval[1]
    assert precise.interval[0] < math.log2(5) < precise.interval[1]


def test_what_is_true_in_no_world_says_at_least_so_much_and_is_not_believed():
    world, information, _ = opened("bandits", **GAUSSIAN)
    impossible, possible = heard(information, Among(low=7, high=6), Pull(action=world.truth.best[0]))
    assert impossible.at_least
    assert impossible.bits == pytest.approx(-math.log2(1 - 0.025 ** (1 / 256)))
    assert impossible.interval[1] == math.inf
    assert impossible.saved is None
    assert f"{impossible}" == "at least 6.1 bits"
    assert possible.held > 0
    assert possible.worlds == 256


def test_a_reward_that_says_nothing_saves_nothing():
    world, information, moment = opened("gridworld", map=True)
    after = acted(world, information, moment, 0)
    (bits,) = heard(information, Reward(reward=after.reward), turn=1)
    assert (bits.bits, bits.saved) == (0, 0)


def test_worlds_that_are_drawn_anew_save_nothing_by_luck():
    """Without news each of ten arms is as good; by the worlds that choose it, the best seems better by .28."""
    saved = []
    for seed in range(60):
        _, information, _ = opened("bandits", seed, worlds=32, **GAUSSIAN)
        information.worlds()
        best = information._best(information._pool)
        information._begin()
        information.worlds()
        saved.append(information._saved_by_others(best))
    assert abs(np.mean(saved)) < 0.1


def test_a_reward_that_was_said_is_known_from_then_on():
    """Of two arms that always pay 1 and 0, one reward tells which is which; without words nothing is known."""
    for said in (True, False):
        world, information, moment = opened("bandits", seed=3, **FIXED)
        after = acted(world, information, moment, 0)
        if said:
            (bits,) = heard(information, Reward(reward=after.reward), turn=1)
            assert bits.interval[0] < 1 < bits.interval[1]
            assert bits.saved > 0.3
        (verdict,) = heard(information, Pull(action=world.truth.best[0]), turn=1)
        assert (verdict.bits == 0) == said


def test_numbers_are_taken_to_the_precision_in_which_they_are_said():
    oracle = family("bandits").make_teacher(Bandit(**GAUSSIAN)).oracle
    moment = Moment(None, 0, 0.123441, None, False, 1, False)._replace(before=0)
    assert Reward(reward=0.12344).means(moment, oracle)
    assert not Reward(reward=0.12344).holds(moment, oracle.lab)
    assert not Reward(reward=0.1235).means(moment, oracle)


@pytest.mark.parametrize("cls", [Reward, NoDifference])
def test_that_precision_is_the_one_of_the_phrases(cls):
    for voice in ("plain", "curt", "harsh"):
        try:
            book = family("bandits").phrasebook(voice)
        except ValueError:
            continue
        for template in book.templates(cls):
            for field in ("reward", "mine", "other"):
                assert template.count("{" + field) == template.count("{" + field + ":.4g}")


def test_a_ground_is_neither_bits_nor_known():
    """Same words with other grounds say the same, and leave the same worlds."""
    found = []
    for action in (0, 1, 2):  # a verdict on another action is another ground
        world, information, moment = opened("bandits", seed=2, **GAUSSIAN)
        acted(world, information, moment, 4)
        claim = Wrong.on((PulledPoor(action=action),), action=4)
        advice = Pull(action=world.truth.best[0])
        found.append((heard(information, claim, advice, turn=1), information.worlds()[:20]))
    assert found[0] == found[1] == found[2]
    assert found[0][0][0].bits > 0
    bare = Right.on((), action=4)
    assert heard(opened_after(4), bare, turn=1)[0].held > 0  # no ground is asked


def opened_after(action):
    world, information, moment = opened("bandits", seed=2, **GAUSSIAN)
    acted(world, information, moment, action)
    return information


def test_bits_of_directions_by_counting_rooms():
    """With the plan of the house, what a direction says follows from the rooms where the treasure may be."""
    world, information, moment = opened("gridworld", seed=6, worlds=2000, map=True)
    layout, room = world.truth.layout, world.truth.room
    away = [distances_from(start, layout.doors) for start in range(len(layout.doors))]
    far = [there for there, steps in enumerate(away[room]) if steps >= 4]
    for direction in DIRECTIONS:
        behind = layout.doors[room][direction]
        nearer = [there for there in far if behind >= 0 and away[behind][there] < away[room][there]]
        information.see(moment._replace(turn=0))
        (bits,) = heard(information, Go(action=direction))
        if nearer:
            assert bits.interval[0] <= math.log2(len(far) / len(nearer)) <= bits.interval[1]
        else:
            assert bits.at_least


def test_the_worlds_agree_with_all_that_was_heard():
    world, information, moment = opened("gridworld", seed=4, map=True)
    oracle = family("gridworld").make_teacher(world).oracle
    oracle.start(world.truth)
    rng = np.random.default_rng(0)
    said = []
    for _ in range(6):
        claims = oracle.judge(moment)
        said += [(claim, moment.turn) for claim in claims]
        heard(information, *claims, turn=moment.turn)
        moment = acted(world, information, moment, world.legal(world.sample_action(rng)))
    for draw in information.worlds():
        for claim, turn in said:
            before = draw[turn - 1].truth if turn else None
            action, reward, after, success, _ = draw[turn]
            assert claim.holds(Moment(before, action, reward, after, success, turn, False), world.scratch())
    assert world.truth in {draw[-1].truth for draw in information.worlds()}


def test_turns_that_are_taken_back_are_forgotten():
    world, information, moment = opened("gridworld", seed=4, map=True)
    go = Go(action=DIRECTIONS[0])
    first = heard(information, go)
    acted(world, information, moment, DIRECTIONS[1])
    information.see(moment._replace(ask_cost=None))
    assert heard(information, go)[0].worlds == first[0].worlds
    assert len(information.worlds()[0]) == 1


def test_a_second_hearing_of_a_moment_goes_on():
    world, information, moment = opened("bandits", **GAUSSIAN)
    pull = Pull(action=world.truth.best[0])
    heard(information, pull)
    information.see(moment)
    assert heard(information, pull)[0].bits == 0


def test_contradictions_leave_no_world_and_say_so():
    _, information, _ = opened("bandits", worlds=20, **GAUSSIAN)
    information._heard = [(Pull(action=0), 0, 0), (Avoid(action=0), 0, 0)]
    (bits,) = heard(information, Pull(action=1))
    assert (bits.bits, bits.worlds, f"{bits}") == (None, 0, "bits unknown")
    assert bits.why == "what was heard is true in none of 800 drawn worlds"
    assert Gain.of("Pull it.", bits) == Gain(unknown=1)


def test_by_too_few_worlds_nothing_is_measured():
    """One world in which all holds would say that each claim is known already."""
    world, information, _ = opened("bandits", seed=5, worlds=100, **GAUSSIAN)
    best = world.truth.best[0]
    assert heard(information, Pull(action=best), Pull(action=best))[1].bits == 0
    information._pool, information._left = information._pool[:3], 0
    bits, again = heard(information, Avoid(action=(best + 1) % 10), Avoid(action=(best + 1) % 10))
    assert (bits.bits, bits.worlds) == (None, 0)
    assert bits.why == "what was heard is true in 3 of 4,000 drawn worlds"
    assert again.bits is None


def test_what_is_seen_and_impossible_says_why():
    world, information, moment = opened("bandits", seed=3, worlds=20, **FIXED)
    after = acted(world, information, moment, 0)
    information.see(after._replace(reward=0.25))
    heard(information, Reward(reward=0.25), turn=1)
    (bits,) = heard(information, Pull(action=1), turn=1)
    assert bits.why == "no order of the arms pays these rewards"


def test_success_is_not_seen():
    world, information, moment = opened("bandits", seed=3, **FIXED)
    after = acted(world, information, moment, world.truth.best[0])
    solved, again = heard(information, Solved(), TryAgain(), turn=1)
    assert after.success
    assert solved.interval[0] < 1 < solved.interval[1]
    assert again.at_least


def test_gains_add_up():
    one = Gain.of("Pull arm 1 now.", Bits(8, 2, 0.5))
    other = Gain.of("Pull it.", Bits(8, 8))
    both = one + other
    assert both == Gain(2, 0, 2.0, 0, 6, 1, 2.0, 0.5)
    assert (both.bits_per_word, both.saved_per_bit) == (2 / 6, 0.25)
    assert (Gain().bits_per_word, Gain().saved_per_bit) == (None, None)


@pytest.mark.parametrize("worlds", [0, -1, 2.5, True])
def test_numbers_of_worlds_are_checked(worlds):
    world = Bandit()
    with pytest.raises(ValueError, match="worlds must be an integer of at least 1, got"):
        family("bandits").make_information(world, 0, worlds)


def test_measuring_changes_nothing():
    def play(measures):
        env = StudentEnv("llf-gridworld-v0", map=True, teacher="mistake(eps=0.3)")
        env.reset(seed=5)
        session = env.session
        information = env.family.make_information(session.world, 5, 8) if measures else None
        said = []
        for _ in range(6):
            if information is not None:
                information.see(session.moment)
                information.hear(session.atoms)
            said.append((session.feedback, session.moment))
            env.step(0)
        return said

    assert play(False) == play(True)


def test_equal_seeds_measure_equally():
    found = []
    for _ in range(2):
        world, information, _ = opened("movies", seed=1, worlds=50)
        oracle = family("movies").make_teacher(world).oracle
        oracle.start(world.truth)
        found.append(heard(information, *oracle.judge(Moment.opening(world.truth))))
    assert found[0] == found[1]
    assert all(each.saved is None for each in found[0])  # recommendations have no values
    assert max(each.bits for each in found[0]) > 0


def test_the_map_is_said_where_it_is_wanted_and_is_checked():
    world = Gridworld(map=True)
    world.reset(seed=0)
    moment, lab = Moment.opening(world.truth), world.scratch()
    (plan,) = (
        each for each in family("gridworld").make_teacher(world).oracle.brief(world.truth, "b") if type(each) is Map
    )
    assert plan.holds(moment, lab)
    wrong = ("nowhere",) * 4
    for other in (
        Map(rooms=plan.rooms[::-1], doors=plan.doors, objects=plan.objects),
        Map(rooms=plan.rooms, doors=(wrong, *plan.doors[1:]), objects=plan.objects),
        Map(rooms=plan.rooms, doors=plan.doors, objects=(("sword",), *plan.objects[1:])),
        Map(rooms=(*plan.rooms, "x"), doors=(*plan.doors, wrong), objects=(*plan.objects, ())),
    ):
        assert not other.holds(moment, lab)
    with pytest.raises(ValueError, match="map must be True or False, got 1"):
        Gridworld(map=1)


def test_every_environment_with_a_posterior_can_be_measured():
    for entry in entries().values():
        if entry.family.posterior:
            world = entry.family.make_world(**{**entry.options, **entry.family.posterior_needs})
            world.reset(seed=0)
            assert isinstance(entry.family.make_information(world, 0, 4), Information)


@pytest.mark.parametrize("p", [0.6, 0.9])
def test_a_hedge_says_as_much_as_it_changes_what_is_probable(p):
    """Of two arms one is best: the share of worlds goes from 1/2 to p, by 1 - H(p) bits."""
    world, information, _ = opened("bandits", seed=1, worlds=2000, **FIXED)
    claim = hedge(Pull(action=world.truth.best[0]), p)
    (bits,) = heard(information, claim)
    low, high = bits.interval
    entropy = -p * math.log2(p) - (1 - p) * math.log2(1 - p)
    assert low - 1e-9 <= bits.bits <= high + 1e-9
    assert bits.bits == pytest.approx(1 - entropy, abs=0.06)
    assert bits.saved == pytest.approx((2 * p - 1) * (bits.saved > 0), abs=0.1)
    assert not bits.at_least
    (flat,) = heard(information, claim.claim)
    assert flat.held / flat.worlds == pytest.approx(p, abs=0.04)
    assert flat.bits == pytest.approx(-math.log2(p), abs=0.1)


def test_hedges_are_heard_in_later_turns_and_two_of_them_add_up():
    world, information, moment = opened("bandits", seed=1, worlds=2000, **FIXED)
    best = world.truth.best[0]
    heard(information, hedge(Pull(action=best), 0.8), hedge(Avoid(action=1 - best), 0.8))
    acted(world, information, moment, 0)
    (flat,) = heard(information, Pull(action=best), turn=1)
    assert flat.held / flat.worlds == pytest.approx(16 / 17, abs=0.03)  # odds of 4 times 4


def test_what_no_world_has_is_believed_no_more_if_it_is_hedged():
    _, information, _ = opened("bandits", **GAUSSIAN)
    (bits,) = heard(information, hedge(Among(low=7, high=6), 0.9))
    assert (bits.held, bits.bits, bits.at_least) == (0, 0, False)


def test_the_interval_of_a_hedge_holds_the_bits_between_its_ends():
    bits = Bits(256, 128, p=0.8)
    low, high = bits.interval
    assert low < bits.bits <= high
    assert Bits(256, 64, p=0.999999).bits == pytest.approx(Bits(256, 64).bits, abs=1e-3)
