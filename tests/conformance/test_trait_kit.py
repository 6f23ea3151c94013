"""The kit for traits accepts those that ship, and each of its checks rejects a liar that the others let pass."""

import random
from dataclasses import dataclass

import pytest

from llf_teacher import testing as kit
from llf_teacher.students.parsing import TRAITS
from llf_teacher.students.trait import Trait
from llf_teacher.students.traits.stubborn import Stubborn
from teachers.atoms import FP, action_of
from teachers.common import Right
from teachers.spec import Share

GRID = "llf-gridworld-v0"


@pytest.mark.parametrize("name", TRAITS.names)
def test_traits_that_ship_pass(name):
    kit.check_trait(GRID, name)


@dataclass(frozen=True)
class Good(Stubborn):
    """Repeats itself."""


class Bare(Good):
    """Lacks its decorator."""


@dataclass(frozen=True)
class Present(Trait):
    """Changes things also where it says that it is absent."""

    p: Share = 0.4
    strength = "p"

    def act(self, action, scene):
        return scene.another(action) if scene.happens(0.3) else action


@dataclass(frozen=True)
class Mumbling(Trait):
    """Hears another action in place of an advised one, in words that leave it out."""

    p: Share = 0.4
    strength = "p"

    def hear(self, atom, scene):
        if atom.kind is FP and scene.happens(self.p):
            return Right.on((), action=scene.another(action_of(atom.claim)))
        return atom.claim


@dataclass(frozen=True)
class Global(Trait):
    """Draws from the global generator."""

    p: Share = 0.4
    strength = "p"

    def act(self, action, scene):
        random.random()
        return action


LIARS = {
    kit.check_trait_value: Bare(),
    kit.check_trait_absent: Present(),
    kit.check_trait_agrees: Mumbling(p=1.0),
    kit.check_trait_student: Global(),
}


def test_a_good_trait_passes():
    kit.check_trait(GRID, Good(p=0.4))


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.TRAIT_CHECKS)


@pytest.mark.parametrize(("check", "trait"), LIARS.items(), ids=lambda value: getattr(value, "__name__", str(value)))
def test_a_liar_is_rejected_by_its_own_check_only(check, trait, rejects):
    assert rejects(kit.TRAIT_CHECKS, trait, GRID) == [check.__name__]


@dataclass(frozen=True)
class Nameless(Good):
    """Names a strength that it has not."""

    strength = "force"


@pytest.mark.parametrize(
    ("check", "trait", "message"),
    [
        (kit.check_trait_value, Bare(), r"Bare needs the decorator @dataclass\(frozen=True\)"),
        (kit.check_trait_value, Nameless(), r"Nameless.strength is 'force'; allowed: one of its fields \['p'\]"),
        (kit.check_trait_absent, Present(), r"obedient \| .*Present\(p=0.0\) acts otherwise than obedient"),
        (
            kit.check_trait_agrees,
            Mumbling(p=1.0),
            "text_only acts otherwise than obedient; `hear` must",
        ),
    ],
)
def test_what_is_refused_is_said(check, trait, message):
    with pytest.raises(AssertionError, match=message):
        check(trait, GRID)
