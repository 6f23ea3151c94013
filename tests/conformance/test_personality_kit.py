"""The kit for personalities accepts good ones, and each of its checks rejects a liar that the others let pass."""

from dataclasses import dataclass

import numpy as np
import pytest
from shelf import FAMILIES, RICH

from teachers import testing as kit
from teachers.atoms import HP
from teachers.common import Late, Right
from teachers.personality import Personality, Stage


def pupil():
    family = next(FAMILIES[name] for name in RICH if FAMILIES[name].repeated)
    return kit.Pupil(family.make_world, family.make_teacher, max_turns=family.max_turns)


class Liar(Personality):
    """Says what it should not."""

    def says(self, claims, view, rng):
        return claims

    class Stage(Stage):
        def speak(self, claims, view):
            return self.spec.says(claims, view, self.rng)


@dataclass(frozen=True)
class Unwritten(Liar):
    """Has a parameter that its spec string does not give back."""

    rate: float = np.float64(0.5)

    def __str__(self):
        return f"unwritten(rate={self.rate!r})"


@dataclass(frozen=True)
class Harmless(Liar):
    """Claims to err, and does not."""

    honest = False


@dataclass(frozen=True)
class Restless(Liar):
    """Draws from a stream of nobody's at the beginning of an episode."""

    class Stage(Stage):
        def begin(self):
            self.most = np.random.default_rng().integers(4)

        def speak(self, claims, view):
            return claims[: self.most]


@dataclass(frozen=True)
class Meddler(Liar):
    """Draws from the taught world's stream."""

    def says(self, claims, view, rng):
        world = view._oracle._scratch.__self__
        if world.np_random_seed is not None:
            world.np_random.random()
        return claims


class Ground:
    """Holds here, and nowhere else."""

    kind = HP

    def __init__(self, here=True):
        self.here = here

    def holds(self, moment, lab):
        return self.here

    def __reduce__(self):
        return Ground, (False,)


@dataclass(frozen=True)
class Homesick(Liar):
    """Says what does not survive the way to another process."""

    def says(self, claims, view, rng):
        moment = view.moment
        return claims if moment.before is None else (*claims, Right.on(Ground(), action=moment.action))


class Diary(list):
    """Is lost on the way."""

    def __reduce__(self):
        return Diary, ()


@dataclass(frozen=True)
class Forgetful(Liar):
    """Says nothing twice in an episode, as far as its memory survives copying."""

    class Stage(Stage):
        def begin(self):
            self.said = Diary()

        def speak(self, claims, view):
            self.said.append(view.turn)
            return claims if len(self.said) < 20 else ()


@dataclass(frozen=True)
class Hasty(Liar):
    """Says what comes late as if it were of now."""

    def says(self, claims, view, rng):
        return [claim.claim if isinstance(claim, Late) else claim for claim in claims]


LIARS = {
    kit.check_spec: Unwritten(),
    kit.check_promise: Harmless(),
    kit.check_draws: Restless(),
    kit.check_hands_off: Meddler(),
    kit.check_words: Homesick(),
    kit.check_twins: Forgetful(),
    kit.check_stages: Hasty(),
}


@pytest.mark.parametrize("spec", ["oracle", "mistake(eps=0.3)", "delayed(turns=2) | vague"])
def test_good_personalities_pass(spec):
    kit.check_personality(spec, pupil())


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.PERSONALITY_CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: getattr(value, "__name__", str(value)))
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.PERSONALITY_CHECKS, liar, pupil()) == [check.__name__]


@dataclass(frozen=True)
class Mistaken(Liar):
    """Errs, and does not say so."""

    def says(self, claims, view, rng):
        return [view.distort(claim, rng) or claim for claim in claims]


@dataclass(frozen=True)
class Inventive(Liar):
    """Says what is true, but not what its oracle said, and calls that a lie."""

    honest = False

    def says(self, claims, view, rng):
        return [view.vague(claim) for claim in claims]


@dataclass(frozen=True)
class Needy(Liar):
    """Needs what no oracle has."""

    needs = frozenset({"telepathy"})


@pytest.mark.parametrize(
    ("check", "liar", "message"),
    [
        (kit.check_promise, Mistaken(), "Mistaken: .* does not hold of"),
        (kit.check_promise, Inventive(), "Inventive: .* holds of"),
        (kit.check_spec, Needy(), "Needy needs .*telepathy.*, not of"),
    ],
    ids=str,
)
def test_what_else_is_refused(check, liar, message):
    with pytest.raises(AssertionError, match=message):
        check(liar, pupil())
