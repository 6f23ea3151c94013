"""Liars: the kit for personalities accepts good ones; each of its checks rejects a liar that the others let pass."""

import itertools
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from shelf import FAMILIES, RICH

from teachers import testing as kit
from teachers.atoms import FP, HN, HP
from teachers.common import Chance, Late, PartlyRight, Right, Truism
from teachers.oracle import POSTERIOR
from teachers.personality import Personality, Stage, personality


def pupil():
    family = next(FAMILIES[name] for name in RICH if FAMILIES[name].repeated)
    return kit.Pupil(family.make_world, family.make_teacher, max_turns=family.max_turns)


class Frank(Stage):
    """Says everything."""

    def speak(self, claims, view):
        return claims


@dataclass(frozen=True)
class Unwritten(Personality):
    """Has a parameter that its spec string does not give back."""

    rate: float = np.float64(0.5)
    stage = Frank

    def __str__(self):
        return f"unwritten(rate={self.rate!r})"


@personality(honest=False)
def harmless(claims, view):
    """Claims to err, and does not."""
    return claims


BEGUN = itertools.count()
EPISODES = -(-kit.Pupil.turns // pupil().max_turns)


class Memory(Stage):
    """Speaks until it has said enough."""

    def begin(self):
        self.most = self.spec.most()
        self.said = Diary()

    def speak(self, claims, view):
        self.said.append(view.turn)
        return claims if len(self.said) < self.most else ()


class Diary(list):
    """Is lost on the way."""

    def __reduce__(self):
        return Diary, ()


@dataclass(frozen=True)
class Restless(Personality):
    """Goes by how many episodes it has begun before, of whomever."""

    stage = Memory

    def most(self):
        """Nothing and everything take turns, as many episodes each as the kit plays, so that no two plays are alike."""
        return 100 * (next(BEGUN) // EPISODES % 2)


@dataclass(frozen=True)
class Forgetful(Personality):
    """Has a memory that copies do not have."""

    stage = Memory

    def most(self):
        return 20


@personality()
def meddler(claims, view):
    """Draws from the taught world's stream."""
    world = view._oracle._scratch.__self__
    if world.np_random_seed is not None:
        world.np_random.random()
    return claims


class Ground:
    """Holds here, and nowhere else."""

    relative = False

    def __init__(self, here=True):
        self.here = here

    def holds(self, moment, lab):
        return self.here

    def __reduce__(self):
        return Ground, (False,)


@personality()
def homesick(claims, view):
    """Says what does not survive the way to another process."""
    return (*claims, *(Chance.on(Ground()) for claim in claims if claim.kind is FP))


@personality()
def content(claims, view):
    """Calls every action right, since ice is cold."""
    moment = view.moment
    right = Right.on((Truism(kind=HP, fact="ice is cold"),), action=moment.action)
    return claims if moment.before is None else (right, *(claim for claim in claims if claim.kind is not HN))


@personality()
def hasty(claims, view):
    """Says what comes late as if it were of now."""
    return [claim.claim if isinstance(claim, Late) else claim for claim in claims]


@dataclass(frozen=True)
class Homebound(Personality):
    """Says that its claims are those of other moments, and says what is true here."""

    honest = False
    elsewhere = True
    stage = Frank


@dataclass(frozen=True)
class Peeking(Personality):
    """Says that it goes by what the student sees, and says all that is true."""

    needs = frozenset((POSTERIOR,))
    evidence = "student"
    stage = Frank


LIARS = {
    kit.check_spec: Unwritten(),
    kit.check_promise: harmless(),
    kit.check_elsewhere: Homebound(),
    kit.check_meaning: content(),
    kit.check_draws: Restless(),
    kit.check_speaking_changes_nothing: meddler(),
    kit.check_words: homesick(),
    kit.check_copies: Forgetful(),
    kit.check_stages: hasty(),
    kit.check_evidence: Peeking(),
}


@pytest.mark.parametrize("spec", ["oracle", "mistake(eps=0.3)", "delayed(turns=2) | vague", "misaligned"])
def test_good_personalities_pass(spec):
    kit.check_personality(spec, pupil())


def test_a_good_personality_that_does_not_see_the_truth_passes():
    """Where its worlds are listed: of drawn ones it may say flatly what is false."""
    house = FAMILIES["gridworld"]
    taught = kit.Pupil(partial(house.make_world, map=True), house.make_teacher, max_turns=house.max_turns)
    kit.check_personality("partial", taught)


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.PERSONALITY_CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: getattr(value, "__name__", str(value)))
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.PERSONALITY_CHECKS, liar, pupil()) == [check.__name__]


@personality()
def mistaken(claims, view, rng):
    """Errs, and does not say so."""
    return [view.distort(claim, rng) or claim for claim in claims]


@personality(honest=False)
def inventive(claims, view):
    """Says what is true, but not what its oracle said, and calls that a lie."""
    return [view.vague(claim) for claim in claims]


@personality()
def torn(claims, view):
    """Calls each action right and partly right."""
    ground = (Truism(kind=HP, fact="ice is cold"),)
    return [cls.on(ground, action=view.moment.action) for cls in (PartlyRight, Right)]


@personality(reveals=False)
def whispering(claims, view):
    """Promises to keep back what to do, and tells it."""
    return claims


class Fibbing(Stage):
    """Takes claims elsewhere, and changes them into false ones."""

    def speak(self, claims, view):
        elsewhere = view.elsewhere(self.rng)
        elsewhere.go_on()
        there = elsewhere.moments[0].moment
        return [view.displace(claim, claim, there) for claim in claims]


@dataclass(frozen=True)
class Mixing(Personality):
    """Says what is true here, and calls it the words of another moment."""

    honest = False
    elsewhere = True
    stage = Fibbing


@pytest.mark.parametrize(
    ("check", "liar", "message"),
    [
        (kit.check_promise, mistaken(), "mistaken: .* does not hold of"),
        (kit.check_promise, inventive(), "inventive: .* holds of"),
        (kit.check_promise, whispering(), "whispering does not reveal, but says"),
        (kit.check_elsewhere, Homebound(), "Homebound says .* of no other moment"),
        (kit.check_elsewhere, Mixing(), "Mixing: .* does not hold elsewhere"),
        (kit.check_meaning, torn(), "torn contradicts itself of"),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_what_else_is_refused(check, liar, message):
    with pytest.raises(AssertionError, match=message):
        check(liar, pupil())
