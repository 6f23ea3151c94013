"""The kit for seats accepts the good seats, and each of its checks rejects a liar that the others let pass."""

import numpy as np
import pytest

from pz_envs import testing as kit
from pz_envs.family import all_families
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.seats import STUDENT
from teachers.atoms import ParseFailure

FAMILY = next(family for family in all_families() if not family.repeated)


def maker(cls):
    def make(**settings):
        budget, cost = settings.pop("budget", None), settings.pop("cost", 0.01)
        max_cycles = settings.pop("max_cycles", FAMILY.max_turns)
        world = FAMILY.make_world()
        return cls(world, FAMILY.make_teacher(world), budget=budget, cost=cost, max_cycles=max_cycles, **settings)

    return make


class Unseeded(TutoringEnv):
    def reset(self, seed=None, options=None):
        super().reset(np.random.default_rng().integers(2**31).item(), options)


class NoLastWord(TutoringEnv):
    def student_turn(self, action):
        super().student_turn(action)
        if any(self.ended) and type(self.moment.action) is not ParseFailure and self.purse.budget is None:
            terminated, truncated = self.ended
            self.terminations = dict.fromkeys(self.agents, terminated)
            self.truncations = dict.fromkeys(self.agents, truncated)
            self.agent_selection = STUDENT


class Chatterbox(TutoringEnv):
    def teacher_turn(self, action):
        super().teacher_turn(action)
        if self.purse.cost == 0.5 and self.feedback == "":
            self.feedback = "Well."


class Indiscreet(TutoringEnv):
    def teacher_turn(self, action):
        super().teacher_turn(action)
        self.infos[STUDENT]["moment"] = self.moment


class Patient(TutoringEnv):
    def student_turn(self, action):
        super().student_turn(action)
        if self.text and self.max_turns == 2 and type(self.moment.action) is ParseFailure:
            self.ended = (False, False)


class Spendthrift(TutoringEnv):
    def teacher_turn(self, action):
        super().teacher_turn(action)
        self.purse.spent -= self.purse.left == 0


LIARS = {
    kit.check_pettingzoo: Unseeded,
    kit.check_turns: NoLastWord,
    kit.check_silence: Chatterbox,
    kit.check_privilege: Indiscreet,
    kit.check_parse_failure: Patient,
    kit.check_budget: Spendthrift,
}


def test_good_seats_pass():
    kit.check_seats(maker(TutoringEnv))


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: value.__name__)
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.CHECKS, maker(liar)) == [check.__name__]
