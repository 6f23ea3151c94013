"""The kit for seats accepts the good seats, and each of its checks rejects a liar that the others let pass."""

import numpy as np
import pytest
from gymnasium import spaces

from pz_envs import testing as kit
from pz_envs.assembly import assemble
from pz_envs.family import all_families
from pz_envs.lifetime_env import LifetimeEnv
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings
from teachers.atoms import ActionClaim, Atom, EditClaim, ParseFailure, PlanClaim, Utterance, claim

WORLDS = [
    (family, world)
    for family in all_families()
    if isinstance((world := family.make_world()).action_space, spaces.Discrete)
]
FAMILY = next(family for family, _ in WORLDS if not family.repeated)
WORLD = WORLDS[0][1]


def maker(cls):
    def make(*, episodes=1, max_cycles=None, **settings):
        settings = Settings(max_turns=max_cycles, **settings)
        seats = cls(assemble(FAMILY, settings), settings, FAMILY.name)
        return seats if episodes == 1 else LifetimeEnv(seats, episodes)

    return make


class Unseeded(TutoringEnv):
    def reset(self, seed=None, options=None):
        if self.speech == "message":
            seed = np.random.default_rng().integers(2**31).item()
        super().reset(seed, options)


class NoLastWord(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        session = self.session
        unread = type(session.moment.action) is ParseFailure
        if agent == STUDENT and session.over and not unread and session.teacher_turns[0].budget.limit is None:
            self.terminations = dict.fromkeys(self.agents, session.terminated)
            self.truncations = dict.fromkeys(self.agents, session.truncated)
            self.agent_selection = STUDENT


class Chatterbox(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        if agent == TEACHER and self.session.teacher_turns[0].budget.cost == 0.5 and self.session.feedback == "":
            self.session.feedback = "Well."


class Indiscreet(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        if agent == TEACHER:
            self.infos[STUDENT]["moment"] = self.session.moment


class Patient(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        session = self.session
        if self.student_view.text and self.max_turns == 2 and type(session.moment.action) is ParseFailure:
            session.terminated = session.truncated = False


class Spendthrift(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        if agent == TEACHER:
            budget = self.session.teacher_turns[0].budget
            budget.spent -= budget.left == 0


class Wanderer(TutoringEnv):
    def start_next_episode(self, start=None, options=None):
        super().start_next_episode(None, options)


class Mumbler(TutoringEnv):
    def _act(self, agent, action):
        super()._act(agent, action)
        said = self.session.feedback
        if agent == TEACHER and isinstance(said, Utterance):
            self.session.feedback = Utterance.of([atom._replace(text="Do that.") for atom in said.atoms])


LIARS = {
    kit.check_pettingzoo: Unseeded,
    kit.check_turns: NoLastWord,
    kit.check_silence: Chatterbox,
    kit.check_privilege: Indiscreet,
    kit.check_parse_failure: Patient,
    kit.check_budget: Spendthrift,
    kit.check_lifetime: Wanderer,
    kit.check_roles: Mumbler,
}


def test_good_seats_pass():
    kit.check_seats(maker(TutoringEnv))


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: value.__name__)
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.CHECKS, maker(liar)) == [check.__name__]


@claim
class Go(ActionClaim):
    action: int

    @property
    def action_in_words(self):
        return f"number {self.action}"


class GoInWords(Go):
    action_slot = "action_in_words"


class GoSomewhere(Go):
    action_slot = ""


@claim
class Way(PlanClaim):
    actions: tuple[int, ...]

    @property
    def listing(self):
        return ", ".join(str(action) for action in self.actions[:2])


@claim
class Write(EditClaim):
    line: int
    words: str
    ordinal: str
    line_slot = "ordinal"


@claim
class Cut(EditClaim):
    line: int
    cuts = True


@pytest.mark.parametrize(
    ("claim", "text", "message"),
    [
        (Go(action=1), "Go 1.", None),
        (Cut(line=2), "Stop after line 2.", None),
        (Cut(line=2), "Stop there.", "the slot 'line' of Cut is '2', not 2 in 'Stop there.'"),
        (GoSomewhere(action=1), "Go there.", None),
        (Way(actions=(0, 1)), "The way: 0, 1.", None),
        (Write(line=2, words="two words", ordinal="2"), "Line 2: two words.", None),
        (Go(action=1), "Go there.", "the slot 'action' of Go is '1', in 'Go there.': it is not in the sentence"),
        (
            GoInWords(action=1),
            "Go number 1.",
            "'action_in_words' of GoInWords .* a student reads .*ParseFailure.*, not .1.",
        ),
        (Way(actions=(0, 1, 0)), "The way: 0, 1.", r"'listing' of Way .* a student reads \[0, 1\], not \[0, 1, 0\]"),
        (Write(line=2, words="two words", ordinal="two"), "Line two: two words.", "'ordinal' of Write is 'two', not 2"),
        (
            Write(line=2, words="two words", ordinal="2"),
            "Line 2.",
            "'words' of Write is 'two words', not 'two words' in",
        ),
    ],
)
def test_what_declares_a_slot_has_it(claim, text, message):
    atom, world = Atom(claim, text, 0), WORLD
    if message is None:
        kit.require_role(atom, world)
    else:
        with pytest.raises(AssertionError, match=message):
            kit.require_role(atom, world)
