"""The kit for students accepts those that ship, and each of its checks rejects a liar that the others let pass."""

import itertools
import random
from dataclasses import dataclass

import pytest

from llf_teacher import testing as kit
from llf_teacher.students.parsing import STUDENTS, parse_student
from llf_teacher.students.student import Policy, Student

GRID, POEM, BOOTH = "llf-gridworld-v0", "llf-poem-Haiku-v0", "llf-optimization-Booth-v0"
ELSEWHERE = {"line_search": POEM, "nelder_mead": BOOTH, "random_search": BOOTH, "run_and_tumble": BOOTH}
ELSEWHERE |= {"reasoner": "llf-bandits-BanditTwoArmedHighLowFixed-v0"}
ELSEWHERE |= {"ucb": "llf-bandits-BanditTwoArmedHighLowFixed-v0"}
SMALL = {"reasoner": "reasoner(worlds=4)"}  # for speed


@pytest.mark.parametrize("name", sorted({*STUDENTS.names} - {"llm"}))
def test_students_that_ship_pass(name):
    kit.check_student(ELSEWHERE.get(name, GRID), SMALL.get(name, name))


class Walker(Policy):
    """Draws moves, and stays with what it does every third turn."""

    def begin(self):
        self.turns, self.last = 0, 0

    def act(self, observation, info):
        self.turns += 1
        if self.turns % 3:
            self.last = int(self.rng.integers(4))
        return self.last


@dataclass(frozen=True)
class Good(Student):
    """Walks about."""

    reads = "atoms"
    policy = Walker


class Leaping(Walker):
    """Leaps when it hears feedback."""

    def act(self, observation, info):
        return super().act(observation, info) + 4 * bool(observation["feedback"])


class Deaf(Walker):
    """Expects feedback in every turn."""

    def act(self, observation, info):
        return super().act(observation, info) + (0 if info["atoms"] else 4)


class Erratic(Walker):
    drawn = itertools.count()

    def act(self, observation, info):
        return super().act(observation, info) if self.turns else next(self.drawn) // 2 % 4


class Global(Walker):
    def act(self, observation, info):
        random.random()
        return super().act(observation, info)


class Forgetless(Walker):
    """Keeps its memory over episodes."""

    def begin(self):
        self.turns, self.last = getattr(self, "turns", 0), 0


class Scribbler(Walker):
    """Writes into what it is shown."""

    def act(self, observation, info):
        observation["state"] = None
        return super().act(observation, info)


class Uncopied(Walker):
    """Shares its memory with its copies."""

    def begin(self):
        super().begin()
        self.seen = Shared()

    def act(self, observation, info):
        self.seen.append(0)
        return (super().act(observation, info) + len(self.seen)) % 4


class Shared(list):
    def __deepcopy__(self, memo):
        return self


@dataclass(frozen=True)
class Liar(Good):
    """Has one of these policies."""

    name_of_policy: str = Walker.__name__

    @property
    def policy(self):
        return globals()[self.name_of_policy]


def liar(walker):
    return Liar(walker.__name__)


class Bare(Good):
    """Lacks its decorator."""


LIARS = {
    kit.check_value: Bare(),
    kit.check_answers: liar(Leaping),
    kit.check_silence: liar(Deaf),
    kit.check_draws: liar(Global),
    kit.check_reset: liar(Forgetless),
    kit.check_acting_changes_nothing: liar(Scribbler),
    kit.check_copies: liar(Uncopied),
}


def test_a_good_student_passes():
    kit.check_student(GRID, Good())


@dataclass(frozen=True)
class Unread(Good):
    """Reads what there is not."""

    reads = "minds"


@dataclass(frozen=True)
class Undescribed(Good):
    pass


Undescribed.__doc__ = None


@pytest.mark.parametrize(
    ("check", "student", "message"),
    [
        (kit.check_value, Bare(), r"Bare needs the decorator @dataclass\(frozen=True\)"),
        (kit.check_value, Unread(), "Unread.reads is 'minds'; allowed: nothing, reward"),
        (kit.check_value, Undescribed(), "Undescribed needs a docstring of its own"),
        (kit.check_answers, liar(Leaping), r"Leaping'\) answered \d; allowed: one of north, east, west, south"),
        (kit.check_draws, liar(Erratic), "with the same seed .*Erratic.* acts differently; draw from the `rng`"),
        (kit.check_draws, liar(Global), "Global'\\) uses a global random generator"),
        (kit.check_reset, liar(Forgetless), "after .*Forgetless.* has played an episode it acts differently; set up"),
    ],
)
def test_what_is_refused_is_said(check, student, message):
    with pytest.raises(AssertionError, match=message):
        check(student, GRID)


def test_a_student_that_remembers_may_act_differently():
    @dataclass(frozen=True)
    class Wise(Good):
        """Learns over episodes."""

        policy = Forgetless
        remembers = True

    kit.check_reset(Wise(), GRID)


def test_a_student_in_text_mode_answers_with_strings():
    @dataclass(frozen=True)
    class Silent(Good):
        """Plays in text mode, and gives numbers."""

        text = True

    with pytest.raises(AssertionError, match=r"Silent answered \d; allowed: a string"):
        kit.check_answers(Silent(), GRID)


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.STUDENT_CHECKS)


@pytest.mark.parametrize(("check", "student"), LIARS.items(), ids=lambda value: getattr(value, "__name__", str(value)))
def test_a_liar_is_rejected_by_its_own_check_only(check, student, rejects):
    assert rejects(kit.STUDENT_CHECKS, parse_student(student), GRID) == [check.__name__]
