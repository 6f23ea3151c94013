"""The panel: turns, who said what, personalities, budgets, orders, and its parallel forms."""

import pettingzoo
import pytest
from design import sampled
from playing import Fixed, agents

import llf_teacher  # noqa: F401  (registers the environments)
from pz_envs.family import all_families
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import SayAll
from pz_envs.seats import STUDENT
from pz_envs.testing import require_aec, require_parallel
from worlds.testing import plain

GRID, BANDIT = (next(f for f in all_families() if f.name == name) for name in ("gridworld", "bandits"))
LIAR = "mistake(eps=1)"
TEACHERS = ("oracle", LIAR, "only(kinds='fp')")
ALL = 31


def ids():
    return ["{}-panel-{}".format(*f.showcase[0].rsplit("-", 1)) for f in all_families()]


def round_of(env, actions=None):
    """Let every teacher speak; who spoke, in order."""
    spoke = []
    while env.agent_selection != STUDENT:
        spoke.append(env.agent_selection)
        env.step(ALL if actions is None else actions[env.agent_selection])
    return spoke


@sampled(lambda id, speech, text: {(id, speech), (speech, text)})
@pytest.mark.parametrize("id", ids())
@pytest.mark.parametrize("speech", ["kinds", "message"])
@pytest.mark.parametrize("text", [False, True])
def test_pettingzoo_accepts_it(id, speech, text):
    settings = {"teachers": TEACHERS, "order": "random", "max_cycles": 5, "text": text}
    require_aec(lambda: pettingzoo.make("aec", f"llf/{id}", speech=speech, **settings))
    if speech == "kinds":
        require_parallel(lambda: pettingzoo.make("parallel", f"llf/{id}", **settings))


def test_every_teacher_speaks_then_the_student_acts_and_the_teachers_have_the_last_word():
    env = GRID.raw_env(seating="panel", teachers=TEACHERS, max_cycles=2)
    turns = []
    for agent, dead, observation, *_ in agents(env, lambda agent, observation: env.action_space(agent).sample()):
        assert observation in env.observation_space(agent)
        turns.append((agent, dead))
    teachers = [f"teacher_{i}" for i in range(3)]
    assert [agent for agent, dead in turns if not dead] == [*teachers, STUDENT] * 2 + teachers
    assert [agent for agent, dead in turns if dead] == [STUDENT, *teachers]


def test_atoms_keep_who_said_them():
    env = GRID.raw_env(seating="panel", teachers=TEACHERS)
    env.reset(seed=0)
    round_of(env)
    env.step(0)
    round_of(env)
    seen = env.observe(STUDENT)
    atoms = seen["feedback"].atoms
    assert env.infos[STUDENT]["atoms"] == atoms
    assert [atom.speaker for atom in atoms] == sorted(atom.speaker for atom in atoms)
    assert {atom.speaker for atom in atoms} == set(env.teachers)
    for teacher in env.teachers:
        mine = [atom for atom in atoms if atom.speaker == teacher]
        assert seen["said"][teacher] == " ".join(atom.text for atom in mine)
        assert seen["said"][teacher].atoms == tuple(mine)


def test_the_instruction_is_given_once_and_notices_too():
    env = GRID.raw_env(seating="panel", teachers=("oracle", "oracle"), text=True)
    env.reset(seed=0)
    assert env.observe(STUDENT)["instruction"]
    round_of(env)
    env.step("hmm")
    round_of(env)
    atoms = env.observe(STUDENT)["feedback"].atoms
    assert [atom.speaker for atom in atoms if atom.kind is None] == ["teacher_0"]
    env = GRID.raw_env(seating="panel", teachers=("oracle", "oracle"), speech="message")
    env.reset(seed=0)
    for tutor in [each.teacher for each in env.session.teacher_turns]:
        env.step(tutor.speak(env.session.moment))
    seen = env.observe(STUDENT)
    assert [(atom.speaker, atom.kind) for atom in seen["feedback"].atoms] == [
        (teacher, kind) for teacher in env.teachers for kind in ("fp", "fn")
    ]


@pytest.mark.parametrize("words_first", [False, True])
def test_a_notice_is_heard_from_the_first_who_gives_it(words_first):
    env = GRID.raw_env(seating="panel", teachers=["oracle"] * 3, speech="message", text=True)
    env.reset(seed=0)
    for said in ("", "", "", "hmm"):
        env.step(said)
    notice = env.session.teacher.open(env.session.moment)
    for said in ("I see." if words_first else notice, notice, notice):
        env.step(said)
    seen = env.observe(STUDENT)
    assert list(seen["said"].values()) == (["I see.", notice, ""] if words_first else [notice, "", ""])
    speakers = [atom.speaker for atom in seen["feedback"].atoms]
    assert speakers == ["teacher_1" if words_first else "teacher_0"]
    assert [each.budget.spent for each in env.session.teacher_turns] == [int(words_first), 0, 0]


def test_each_pays_for_its_own_words_out_of_its_own_budget():
    env = BANDIT.raw_env(seating="panel", teachers=("oracle", "oracle"), cost=0.5, budget=2)
    env.reset(seed=0)
    env.step(ALL)
    assert env.rewards == {"teacher_0": -1.0, "teacher_1": 0.0, STUDENT: 0.0}
    env.step(0)
    env.step(1)
    assert env.rewards == dict.fromkeys(env.possible_agents, env.session.moment.reward)
    assert [env.observe(teacher)["features"][3] for teacher in env.teachers] == [0, 1]


def test_later_speakers_know_what_was_said():
    env = BANDIT.raw_env(seating="panel", teachers=("oracle", "oracle"))
    env.reset(seed=0)
    assert env.observe("teacher_0")["heard"].tolist() == [0, 0, 0, 0, 0]
    env.step(0b01000)
    assert env.observe("teacher_1")["heard"].tolist() == [0, 0, 0, 1, 0]
    env = BANDIT.raw_env(seating="panel", teachers=("oracle", "oracle"), speech="message")
    env.reset(seed=0)
    env.step("Take the third.")
    assert env.observe("teacher_1")["heard"] == "Take the third."
    env.step("I would not.")
    seen = env.observe(STUDENT)
    assert seen["feedback"] == "Take the third. I would not."
    assert seen["said"] == {"teacher_0": "Take the third.", "teacher_1": "I would not."}


class Peer:
    """Advises an arm in every second turn."""

    def reset(self, rng):
        self.turns = 0

    def act(self, observation, info):
        assert set(observation) == {"state", "action", "heard"}
        self.turns += 1
        return {"claims": [{"type": "Pull", "action": 3}]} if self.turns % 2 else "I am not sure."


def test_a_policy_may_be_among_the_teachers():
    """The others say what they say without it, to the byte; it speaks in its turn, and only its claims are atoms."""
    said = {}
    for last in ("silent", Peer()):
        env = BANDIT.parallel_env(
            seating="panel", teachers=["oracle", LIAR, last], feedback_type="fp", max_cycles=4, text=True
        )
        observations, infos = env.reset(seed=3)
        turns = said[last] = []
        while env.agents:
            assert observations[STUDENT] in env.observation_space(STUDENT)
            turns.append((dict(observations[STUDENT]["said"]), infos[STUDENT]["atoms"]))
            observations, *_, infos = env.step({STUDENT: "0"})
    alone, together = said.values()
    assert [list(words.values())[:2] for words, _ in alone] == [list(words.values())[:2] for words, _ in together]
    assert [words["teacher_2"] != "" for words, _ in alone] == [False] * len(alone)
    mine = [[atom.claim.action for atom in atoms if atom.speaker == "teacher_2"] for _, atoms in together]
    assert mine == [[3], []] * (len(together) // 2)
    assert [words["teacher_2"] for words, _ in together][1::2] == ["I am not sure."] * (len(together) // 2)


def test_a_teacher_may_be_given_as_it_is():
    tutor = GRID.make_teacher(GRID.taught_world(), "only(kinds='fn')", feedback_type="fn")
    env = GRID.parallel_env(seating="panel", teachers=["only(kinds='fp')", tutor])
    _, infos = env.reset(seed=1)
    said = [(atom.speaker, atom.kind) for atom in infos[STUDENT]["atoms"] if atom.kind is not None]
    assert said == [("teacher_0", "fp"), ("teacher_1", "fn")]


@pytest.mark.parametrize(
    ("door", "settings", "match"),
    [
        ("parallel_env", {"teachers": [Peer]}, r"teachers\[0\] must be a spec string, .* got <class .*Peer'>"),
        ("parallel_env", {"teachers": ["oracle", 3]}, r"teachers\[1\] must be a spec string, .* got 3"),
        ("parallel_env", {"teachers": [Peer()], "speech": "claims"}, "speech 'claims' has no parallel form"),
        ("raw_env", {"teachers": ["oracle", Peer()]}, r"teachers\[1\] is a policy, .* and act for teacher_1, or take"),
    ],
)
def test_a_teacher_that_is_none_is_refused(door, settings, match):
    with pytest.raises(ValueError, match=match):
        getattr(BANDIT, door)(seating="panel", **settings)


def test_orders():
    def orders(order, seed):
        env = GRID.raw_env(seating="panel", teachers=["oracle"] * 4, order=order)
        env.reset(seed=seed)
        found = []
        for _ in range(8):
            found.append(round_of(env))
            env.step(0)
        return found

    assert orders("fixed", 0) == [[f"teacher_{i}" for i in range(4)]] * 8
    drawn = orders("random", 0)
    assert drawn == orders("random", 0) != orders("random", 1)
    assert len(set(map(tuple, drawn))) > 1
    assert all(sorted(each) == [f"teacher_{i}" for i in range(4)] for each in drawn)


def test_the_order_and_the_others_do_not_change_the_world():
    def trace(**settings):
        env = GRID.raw_env(seating="panel", **settings)
        env.reset(seed=9)
        states = []
        for turn in range(6):
            round_of(env)
            env.step(turn % 4)
            states.append(plain((env.session.world.truth, env.rewards[STUDENT])))
        return states

    assert trace(teachers=("oracle",)) == trace(teachers=TEACHERS, order="random") == trace(teachers=(LIAR, "silent"))


def test_forms_in_parallel():
    """The student alone, or the teachers at once, who then do not hear each other."""
    env = GRID.parallel_env(seating="panel", teachers=TEACHERS)
    observations, _ = env.reset(seed=0)
    assert list(observations) == [STUDENT]
    assert {atom.speaker for atom in observations[STUDENT]["feedback"].atoms} == {f"teacher_{i}" for i in range(3)}

    teachers = ParallelSeats(GRID.raw_env(seating="panel", teachers=TEACHERS, max_cycles=2), {STUDENT: Fixed(0)})
    observations, _ = teachers.reset(seed=0)
    rounds = 0
    while teachers.agents:
        acts = {agent: SayAll().act(observations[agent], {}) for agent in teachers.agents}
        observations, rewards, _, _, _ = teachers.step(acts)
        rounds += 1
    assert rounds == 3
    assert list(rewards) == [f"teacher_{i}" for i in range(3)]


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"teachers": ["oracle"] * 17}, "teachers must be 1 to 16, got 17"),
        ({"teachers": []}, "teachers must be 1 to 16, got 0"),
        ({"teachers": "oracle"}, r"teachers must be a list of 1 to 16, such as \['oracle', 'silent'\], got 'oracle'"),
        ({"teachers": None}, "teachers must be a list of 1 to 16, .* got None"),
        ({"order": "loudest"}, "order 'loudest' is unknown; allowed: fixed, random"),
        ({"teachers": ["wise"]}, "wise"),
    ],
)
def test_bad_arguments(settings, match):
    with pytest.raises(ValueError, match=match):
        GRID.raw_env(seating="panel", **settings)


def test_rendering():
    env = GRID.raw_env(seating="panel", render_mode="ansi", speech="message")
    env.reset(seed=0)
    env.step("Left!")
    env.step("Right!")
    assert "teacher_0: Left!\nteacher_1: Right!" in env.render()
