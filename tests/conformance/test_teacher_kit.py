"""The kit for oracles accepts a good oracle, and each of its checks rejects a liar that the others let pass."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pz_envs.family import all_families
from teachers import testing as kit
from teachers.atoms import FN, FP, HN, HP, KINDS, ActionClaim, Claim, PlanClaim, R, Scope, claim, fast_constructor
from teachers.common import Solved
from teachers.oracle import Oracle
from teachers.oracles.bandits import Among, Avoid, BanditOracle, OneOf, Pull, PulledBest
from teachers.phrasebook import Phrasebook
from teachers.teacher import Teacher

(BANDITS,) = (family for family in all_families() if family.oracle == BanditOracle.__name__)


def pupil(oracle):
    def make_teacher(world, personality="oracle", **settings):
        voice = BANDITS.make_teacher(world).voice | Phrasebook(
            {
                cls.__name__: [f"{cls.__name__} {i}: {{action}}." for i in range(4)]
                for cls in (Strange, Hinted, Recanted, Kindless)
            }
            | {cls.__name__: [f"{cls.__name__} {i}." for i in range(4)] for cls in (Plan, Early)}
            | {"Twofold": [f"No {i} {{action}}." for i in range(4)]},
            [Strange, Hinted, Recanted, Kindless, Plan, Early, Twofold],
            "test",
        )
        return Teacher(oracle(world.scratch), voice, personality, **settings)

    return kit.Pupil(BANDITS.make_world, make_teacher, max_turns=BANDITS.max_turns, turns=200)


@claim
class Strange(ActionClaim):
    """True always."""

    kind = FN
    action: float

    def holds(self, moment, lab):
        return True

    def counterparts(self, moment, lab):
        return (Solved(),) if not moment.success else ()


@claim
class Plan(PlanClaim):
    """True always."""

    actions: tuple[int, ...]

    def holds(self, moment, lab):
        return True


class Misleader(BanditOracle):
    """Looks for the best arm where the worst is."""

    def start(self, truth):
        super().start(truth)
        worst = truth.means.index(min(truth.means))
        self._pull = OneOf(arms=(worst,))


class Incorrigible(BanditOracle):
    """Distorts by telling the truth."""

    def distort(self, claim, moment, rng):
        return claim


class Unordered(BanditOracle):
    """Gives advice before hindsight."""

    def judge(self, moment, kinds=frozenset()):
        return tuple(reversed(super().judge(moment, kinds) if kinds else super().judge(moment)))


class Meddler(BanditOracle):
    """Pulls arms of the taught world."""

    def start(self, truth):
        super().start(truth)
        world = self._scratch.__self__
        if world.np_random_seed is not None:
            world.np_random.random()


class Confused(BanditOracle):
    """Names an action that is none."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        if FN in kinds:
            claims.append(Strange(action=0.5))


class Stammerer(BanditOracle):
    """Says the first thing twice."""

    def _basics(self, truth):
        return (*super()._basics(truth), super()._basics(truth)[0])


class Dreamer(BanditOracle):
    """Plans what has regret, but for the first action."""

    def plan(self, truth, n):
        return (*super().plan(truth, 1), *[min(range(len(truth.means)), key=truth.means.__getitem__)] * n)[:n]


class Exaggerator(BanditOracle):
    """Has more regret than the values say."""

    def regret(self, moment):
        return 2 * super().regret(moment)


class Contrarian(BanditOracle):
    """Values the worst arm most, and gives no feedback that the world could refute."""

    feedback_types = (R,)
    clues = Oracle.clues

    def _hindsight(self, claims, moment, kinds):
        pass

    def _advice(self, claims, moment, kinds):
        pass

    def values(self, truth):
        return tuple(-mean for mean in truth.means)

    def plan(self, truth, n):
        return (truth.means.index(min(truth.means)),) * n


class Restless(BanditOracle):
    """Says something else each time that it is asked anew."""

    count = 0

    def start(self, truth):
        super().start(truth)
        Restless.count += 1
        self._poor = self._poor[Restless.count % 5 :] or self._poor


@claim
class Hinted(Pull):
    """Advice with a hint that says something else."""

    def coarser(self, moment, lab):
        return (Among(low=self.action + 1, high=self.action + 1),)


class Misguided(BanditOracle):
    """Gives hints that are false."""

    def start(self, truth):
        super().start(truth)
        self._pull = Hinted(action=self._best[0])


class Riddler(BanditOracle):
    """Gives a clue that is false."""

    def clues(self, truth):
        worst = truth.means.index(min(truth.means))
        return (*super().clues(truth), OneOf(arms=(worst,)))


@claim
class Early(Claim):
    """True in the first turns."""

    kind = FN
    scope = Scope.WORLD

    def holds(self, moment, lab):
        return moment.turn < 3


class Fickle(BanditOracle):
    """Says of what holds of the moment that it holds for the whole episode."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        if FN in kinds and moment.turn < 3:
            claims.append(Early())


@claim
class Twofold(Avoid):
    """A warning whose phrases have two numbers in a row."""


class Mumbler(BanditOracle):
    """Warns in words that can be misread."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        claims[:] = [Twofold(action=each.action) if type(each) is Avoid else each for each in claims]


@claim
class Recanted(Avoid):
    """True if some arm pays more, but meant to take another warning back."""

    def excludes(self, other):
        return type(other) is Avoid


class Wavering(BanditOracle):
    """Takes back what it says."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        if FN in kinds:
            claims.append(Recanted(action=self._poor[0]))


class Trusting(BanditOracle):
    """Announces warnings, and gives none."""

    def judge(self, moment, kinds=frozenset(KINDS)):
        return super().judge(moment, kinds - {FN})


class Unannounced(BanditOracle):
    """Warns without announcing it."""

    feedback_types = tuple(kind for kind in KINDS if kind is not FN)


class Shameless(BanditOracle):
    """Knows nothing false to warn of."""

    def distort(self, claim, moment, rng):
        return None if claim.kind is FN else super().distort(claim, moment, rng)


LIARS = {
    kit.check_honesty: Misleader,
    kit.check_contradictions: Wavering,
    kit.check_distortion: Incorrigible,
    kit.check_hints: Misguided,
    kit.check_clues: Riddler,
    kit.check_scope: Fickle,
    kit.check_kinds: Unordered,
    kit.check_judging_changes_nothing: Meddler,
    kit.check_claims: Confused,
    kit.check_instructions: Stammerer,
    kit.check_plans: Dreamer,
    kit.check_values: Exaggerator,
    kit.check_returns: Contrarian,
    kit.check_determinism: Restless,
    kit.check_wording: Mumbler,
}


def test_a_good_oracle_passes():
    kit.check_oracle(pupil(BanditOracle))


def test_what_is_said_late_is_checked_of_its_turn():
    good = pupil(BanditOracle)
    kit.check_honesty(replace(good, make_teacher=partial(good.make_teacher, personality="delayed(turns=2)")))


class Overpromising(BanditOracle):
    """Tells the truth but in the complete instruction."""

    def _solution(self, truth):
        return (Pull(action=truth.means.index(min(truth.means))),)


def test_every_type_of_instruction_is_checked():
    with pytest.raises(AssertionError, match="does not hold of"):
        kit.check_honesty(pupil(Overpromising))


class Offended(BanditOracle):
    """Misleads those who do one thing only: write what is no action, take a zero, act twice alike or as warned."""

    def judge(self, moment, kinds=frozenset(KINDS)):
        claims = super().judge(moment, kinds)
        if moment.turn and self.minds(moment):
            claims += (Pull(action=self._poor[0]),)
        self._last, self._warned = moment.action, [claim.action for claim in claims if type(claim) is Avoid]
        return claims

    def start(self, truth):
        super().start(truth)
        self._last, self._warned, self._strikes = None, [], 0


class ByText(Offended):
    def minds(self, moment):
        return moment.before is None


class ByRepeats(Offended):
    def minds(self, moment):
        self._strikes = self._strikes + 1 if moment.action == self._last else 0
        return self._strikes >= 4


class ByContraries(Offended):
    def minds(self, moment):
        self._strikes = self._strikes + 1 if moment.action in self._warned else 0
        return self._strikes >= 4


class ByExtremes(Offended):
    def minds(self, moment):
        self._strikes = self._strikes + 1 if moment.action in (0, len(moment.after.means) - 1) else 0
        return self._strikes >= 5


@pytest.mark.parametrize(
    ("liar", "habit"),
    [(ByText, "garbling"), (ByRepeats, "repeating"), (ByContraries, "contrary"), (ByExtremes, "extreme")],
)
def test_honesty_towards_unusual_students_is_checked(liar, habit):
    random = pupil(liar)
    assert all(claim.holds(moment, lab) for (claim, moment, lab) in judged(random))
    with pytest.raises(AssertionError, match=r"does not hold of .* \((?!random)\w+ play\)"):
        kit.check_honesty(random)
    assert not all(claim.holds(moment, lab) for (claim, moment, lab) in judged(random, habit))


def judged(pupil, habit=""):
    return [(atom.claim, moment, lab) for said in pupil.said({}, habit=habit) for atom, moment, lab in said]


class Lenient(BanditOracle):
    """Does not mind a text that is no action."""

    def regret(self, moment):
        return 0.0 if moment.before is None else super().regret(moment)


class Secretive(BanditOracle):
    """Adds nothing to the basic instruction."""

    def _solution(self, truth):
        return ()


class Impatient(BanditOracle):
    """Praises in the complete instruction."""

    def _solution(self, truth):
        return (PulledBest(action=truth.best[0]),)


class Flatterer(BanditOracle):
    """Passes what was tried before off as the student's own."""

    def _practice(self, truth, rng):
        return (PulledBest(action=truth.best[0]),)


class Disordered(BanditOracle):
    """Names the types of its instructions in another order."""

    instruction_types = ("c", "b", "p")


class Numeric(BanditOracle):
    """Has numbers of NumPy's in its claims."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        made = fast_constructor(Avoid)
        claims[:] = [made(np.int64(each.action)) if type(each) is Avoid else each for each in claims]


class Flipped(BanditOracle):
    """Says what is so, and values its opposite."""

    said = frozenset(KINDS)
    planned = 1

    def values(self, truth):
        return tuple(-mean for mean in truth.means)

    def regret(self, moment):
        return BanditOracle.values(self, moment.past)[moment.action] - min(moment.past.means) if moment.turn else 0.0

    def judge(self, moment, kinds=frozenset(KINDS)):
        return super().judge(moment, kinds & self.said)

    def plan(self, truth, n):
        return super().plan(truth, n * self.planned)


class FlippedAdvice(Flipped):
    said, planned = frozenset([FP]), 0


class FlippedWarning(Flipped):
    said, planned = frozenset([FN]), 0


class FlippedVerdicts(Flipped):
    said, planned = frozenset([HP, HN]), 0


@claim
class Kindless(ActionClaim):
    """True always."""

    action: int

    def holds(self, moment, lab):
        return True


class Vague(BanditOracle):
    """Gives feedback that is of no kind."""

    def _advice(self, claims, moment, kinds):
        super()._advice(claims, moment, kinds)
        claims.append(Kindless(action=0))


class Anxious(BanditOracle):
    """Finds more at stake than the values say."""

    def importance(self, truth):
        return super().importance(truth) + 1


class Wordy(BanditOracle):
    """Has a value too many."""

    def values(self, truth):
        return (*truth.means, 0.0)


class Planless(BanditOracle):
    """States a plan of nothing."""

    def _solution(self, truth):
        return (Plan(actions=()),)


class Overrating(BanditOracle):
    """Values arms by more than they pay."""

    def values(self, truth):
        return tuple(2 * mean for mean in truth.means)


@pytest.mark.parametrize(
    ("check", "liar", "message"),
    [
        (kit.check_plans, Overrating, "finds a worth of .* for 0, the oracle a value of"),
        (kit.check_plans, Lenient, "a text that is no action has regret 0.0, and .* is at stake"),
        (kit.check_instructions, Secretive, "the instruction c adds nothing to that of type b"),
        (kit.check_instructions, Impatient, "the instruction c adds claims of kinds .*'hp'.*; allowed: {None}"),
        (kit.check_instructions, Flatterer, "the instruction p adds {'PulledBest'}, .*; set tried = True"),
        (kit.check_instructions, Disordered, r"instruction_types \('c', 'b', 'p'\) are not b, p, c"),
        (
            kit.check_claims,
            Numeric,
            r"the field 'action' of the claim Avoid holds \S+ of type int64; allowed: str, int",
        ),
        (
            kit.check_kinds,
            Vague,
            r"test_teacher_kit\.Kindless is feedback, but has no kind; set `kind` of the class to R, HP, HN, FP or FN",
        ),
        (
            kit.check_kinds,
            Trusting,
            "the oracle's feedback_types have fn, of which it says nothing in 200 random turns",
        ),
        (kit.check_kinds, Unannounced, "the oracle says fn, which its feedback_types lack"),
        (kit.check_oracle, Wordy, r"there are \d+ values for Discrete\(\d+\)"),
        (kit.check_oracle, Vague, r"test_teacher_kit\.Kindless is feedback, but has no kind"),
        (
            kit.check_contradictions,
            Wavering,
            r"Avoid\(action=\d\) and Recanted\(action=\d\) contradict each other .*, and are",
        ),
        (kit.check_distortion, Shameless, "no claim of the kind fn had a false counterpart in 200 random turns"),
        (kit.check_values, Flipped, r"the plan is \(\d,\), but the values are"),
        (kit.check_values, FlippedAdvice, r"Pull\(action=\d\) \(fp\) contradicts the values"),
        (kit.check_values, FlippedWarning, r"Avoid\(action=\d\) \(fn\) contradicts the values"),
        (kit.check_values, FlippedVerdicts, r"by the values praised actions lose 0\.\d+, and blamed ones 0\.\d+"),
        (kit.check_values, Exaggerator, "the regret is .*, but by the values"),
        (kit.check_values, Anxious, "the importance is .*, but by the values"),
        (kit.check_values, Wordy, r"there are \d+ values for Discrete\(\d+\)"),
        (
            kit.check_returns,
            Contrarian,
            "actions of the greatest value have 0 successes .*; greater values must be better",
        ),
        (kit.check_claims, Planless, r"Plan\(actions=\(\)\) is a plan of no action"),
    ],
)
def test_what_else_is_refused(check, liar, message):
    with pytest.raises(AssertionError, match=message):
        check(pupil(liar))


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: value.__name__)
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.CHECKS, pupil(liar)) == [check.__name__]
