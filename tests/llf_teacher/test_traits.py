"""Traits: what each does to a student, that they compose, and that studies store them."""

import dataclasses
import pickle
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

import llf_teacher
from llf_teacher.episodes.loop import play_turns
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.gym import TeacherEnv
from llf_teacher.gym.vector.teacher import TeacherVectorEnv
from llf_teacher.registry import family
from llf_teacher.students.builtin.obedient import Obedient
from llf_teacher.students.parsing import TRAITS, parse_student
from llf_teacher.students.student import Policy, Student
from llf_teacher.students.trait import Traited
from llf_teacher.students.traits.mishears import Mishears
from llf_teacher.students.traits.skims import Skims
from llf_teacher.students.traits.stubborn import Stubborn
from llf_teacher.studies import Study
from llf_teacher.studies.definition.names import short_names
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import play_missing
from llf_teacher.studies.store import Store
from pz_envs.parallel_seats import ParallelSeats
from teachers.atoms import Utterance

GRID, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
ALL = "obedient | forgetful(half_life=4) | stubborn(p=0.2) | mishears(p=0.3) | capitulates(after=1.5)"
ALL += " | skims(kinds='hp+fp') | partial_plan(k=3)"
BARE = ("obedient", "text_only", "bayesian", "q_learning(trust=0.5)", "tamer")


def episode(id, student, teacher="oracle", feedback="a", instruction="b", seed=0, turns=10):
    return play(EpisodeSpec(id, teacher, student, instruction, feedback, turns, seed, llf_teacher.__version__))


def actions(*arguments, **settings):
    return [turn.action for turn in episode(*arguments, **settings).turns[1:]]


def test_a_spec_gives_the_same_student_again():
    student = parse_student(ALL)
    assert parse_student(str(student)) == student == pickle.loads(pickle.dumps(student))
    assert Obedient() | Stubborn(p=0.5) | Mishears() == parse_student("obedient | stubborn(p=0.5) | mishears")
    assert str(Obedient() | Skims(kinds="fp+hp")) == "obedient | skims(kinds='hp+fp')"
    assert student.reads == "atoms"
    assert not student.text


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("obedient | stuborn", "unknown trait 'stuborn'; did you mean stubborn\\? allowed: capitulates, forgetful"),
        ("obedient | stubborn(q=1)", "trait 'stubborn': unknown parameter 'q'; allowed: p"),
        ("obedient | stubborn(p=2)", "p must be a number from 0 to 1, got 2"),
        ("obedient | forgetful(half_life=0)", "half_life must be a number from 0.01"),
        ("obedient | capitulates(after=-1)", "after must be a number from 0 to"),
        ("obedient | partial_plan(k=-1)", "k must be a number from 0 to"),
        ("obedient | skims(kinds='n')", "kinds must name kinds of feedback, such as 'fp'"),
        ("obedient | json:loads", "unknown trait in json 'loads'; allowed: none"),
        ("obedient | chat:json:loads", "bad student spec"),
        ("random | mishears", "changes what is heard, and the student random reads nothing; allowed: .* words, atoms"),
        ("q_learning | capitulates", "the student q_learning reads reward"),
        ("oracle | forgetful", "the student oracle reads truth and learns nothing; allowed"),
        ("line_search | stubborn", "line_search needs the reward of each action that it proposes; allowed"),
    ],
)
def test_what_is_refused_is_said(spec, message):
    with pytest.raises(ValueError, match=message):
        parse_student(spec)


def test_only_traits_stand_behind_a_student():
    with pytest.raises(TypeError, match=r"must be a trait, such as Stubborn\(p=0.3\), got Obedient"):
        Traited(Obedient(), (Obedient(),))
    poem = "llf-poem-Haiku-v0"
    with pytest.raises(ValueError, match="the trait stubborn changes actions, and the student line_search"):
        episode(poem, "reward_only | stubborn")


@pytest.mark.parametrize("name", TRAITS.names)
def test_at_no_strength_nothing_changes(name):
    cls = TRAITS[name]
    none = cls(**{cls.strength: cls.absent})
    for number, bare in enumerate(BARE):
        plain, with_none = (episode(GRID if number % 2 else ARMS, student) for student in (bare, f"{bare} | {none}"))
        assert plain._replace(spec=None) == with_none._replace(spec=None)


@pytest.mark.parametrize("trait", ["stubborn(p=0.5)", "mishears(p=0.5)", "skims(p=0.5)", "forgetful(half_life=1.5)"])
@pytest.mark.parametrize("teacher", ["oracle", "delayed(turns=2)"])
def test_atoms_and_words_are_heard_alike(trait, teacher):
    for id in (GRID, ARMS):
        for seed in range(3):
            atoms, words = (
                actions(id, f"{student} | {trait}", teacher, "r+fp", seed=seed) for student in ("obedient", "text_only")
            )
            assert atoms == words


class Listening(Policy):
    """Keeps what it is shown, and takes action 0."""

    def begin(self):
        self.spec.heard.append([])

    def act(self, observation, info):
        self.spec.heard[-1].append((observation["instruction"], observation["feedback"], info.get("atoms")))
        return 0

    def did(self, action):
        self.spec.heard[-1].append(action)


@dataclasses.dataclass(frozen=True)
class Listener(Student):
    """Hears."""

    heard: list = dataclasses.field(default_factory=list)
    reads = "atoms"
    policy = Listening


def listen(*traits, id=ARMS, turns=6, **settings):
    student = Listener()
    for trait in traits:
        student = student | trait
    env = llf_teacher.make(id, **settings)
    turns = list(play_turns(env, student.seat(env.family, env.session.world), seed=3))[:turns]
    return student.student.heard, turns


def test_what_is_misheard_has_words_that_fit():
    (heard,), turns = listen(Mishears(p=1), feedback_type="fp+hn")
    for (_, feedback, atoms), turn in zip(heard, turns, strict=False):
        assert isinstance(feedback, Utterance)
        said = {atom.claim.action for atom in turn.atoms if atom.kind == "fp"}
        for atom in feedback.atoms:
            assert atom in atoms
            assert atom.text in feedback
            if atom.kind == "fp":
                assert f"{atom.claim.action}" in atom.text
                assert atom.claim.action not in said
            else:
                assert atom.kind == "hp"  # blame is heard as praise


def test_each_trait_of_hearing_gets_what_those_before_leave():
    (heard,), _ = listen(Skims(kinds="fp"), Mishears(p=1), feedback_type="r+fp")
    assert not any(feedback for _, feedback, _ in heard)


def test_sentences_without_claims_are_missed_one_by_one():
    env = llf_teacher.make(GRID)
    student = Listener() | Mishears(p=0.5)
    policy = student.seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(1))
    said = [f"Sentence {number}." for number in range(100)]
    policy.act({"state": 0, "instruction": "", "feedback": " ".join(said)}, {"atoms": ()})
    ((_, feedback, atoms),) = student.student.heard[0]
    left = [sentence for sentence in said if sentence in feedback]
    assert 30 < len(left) < 70
    assert " ".join(left) == feedback
    assert atoms == ()


def test_whoever_forgets_begins_anew_and_keeps_the_instruction():
    heard, turns = listen(TRAITS["forgetful"](half_life=0.01), instruction_type="c", feedback_type="fp")
    assert len(heard) >= len(turns) - 1 > 2
    (first,), *others = heard
    assert any(
        atom.claim.action == first[2][-1].claim.action for atom in first[2][:-1] if hasattr(atom.claim, "action")
    )
    for ((instruction, feedback, atoms),) in others:
        assert instruction in first[0]
        assert instruction != first[0]  # without the solution
        assert [atom.about_turn for atom in feedback.atoms] == [0]
        assert atoms == instruction.atoms + feedback.atoms


def test_the_stubborn_repeat_and_students_know_what_was_done():
    moves = actions(GRID, "random | stubborn(p=1)")
    assert len(set(moves)) == 1
    free = actions(GRID, "random | stubborn(p=0.5)", turns=20)
    assert 2 < sum(one == other for one, other in pairwise(free)) < 19
    learner = parse_student("q_learning | stubborn(p=1)")
    env = llf_teacher.make(ARMS)
    policy = learner.seat(env.family, env.session.world)
    taken = [turn.moment.action for turn in play_turns(env, policy, seed=1)][1:]
    assert set(taken) == {taken[0]}
    (values,) = policy.inner._values.values()
    assert [value != 1.0 for value in values] == [arm == taken[0] for arm in range(10)]


def test_who_capitulates_counts():
    said = episode(ARMS, "tamer | capitulates(after=2)", feedback="fp", turns=20)
    (arm,) = {atom["action"] for turn in said.turns for atom in turn.atoms if atom["kind"] == "fp"}
    followed = [turn.action == f"{arm}" for turn in said.turns[1:]]
    assert not any(followed[at : at + 3] == [False] * 3 for at in range(len(followed)))
    assert [False, False, True] in [followed[at : at + 3] for at in range(len(followed))]


def test_a_plan_is_taken_in_in_part():
    whole, part = (actions(GRID, f"obedient{trait}", "silent", "n", "c") for trait in ("", " | partial_plan(k=2)"))
    assert part[:2] == whole[:2]
    assert part != whole
    assert actions(GRID, "obedient | partial_plan(k=0)", "silent", "n", "c") == actions(GRID, "obedient", "silent", "n")


def test_a_study_stores_and_names_them(tmp_path):
    students = ("obedient", "obedient | stubborn", "text_only|mishears( p = 0.5 )")
    study = Study(ids=(GRID,), teachers=("oracle", "silent"), students=students, seeds=3, max_turns=8)
    assert study.students[2] == "text_only | mishears(p=0.5)"
    with Store(tmp_path / "study.db") as store:
        assert play_missing(study, store, workers=2) == 18
        assert {row["student"] for row in store.episodes()} == set(study.students)
    specs = {spec: parse_student(spec) for spec in ("llm(model='m') | stubborn", "llm(model='m')")}
    assert sorted(short_names(specs, {}).values()) == ["llm(m)", "llm(m) | stubborn"]


def test_doors_of_teachers_take_them_or_say_why_not():
    env = TeacherEnv(GRID, student="q_learning(trust=0.5) | stubborn | mishears(p=0.5)", episodes=2)
    env.reset(seed=1)
    for _ in range(8):
        env.step(31)
    with pytest.raises(ValueError, match=r"has no intend\(observation, info\), which announce=True needs"):
        TeacherEnv(GRID, student="obedient | stubborn", announce=True)
    with pytest.raises(ValueError, match="vary needs a student without traits, got q_learning"):
        TeacherEnv(GRID, student="q_learning | stubborn", vary={"alpha": (0.1, 0.5)})
    with pytest.raises(ValueError, match="the trait partial_plan cannot play in arrays; allowed: forgetful"):
        TeacherVectorEnv(GRID, student="tamer | partial_plan")


@pytest.mark.parametrize("trait", TRAITS.names)
def test_a_learner_announces_what_it_means_to_do_and_plays_the_same(trait):
    """Announcing changes no draw; what is announced is what it does unless it is advised, or its trait does other."""
    played = {True: [], False: []}
    announced = []
    for announce, done in played.items():
        spec = f"q_learning(trust=0.5, forget=False, optimism=0.0) | {trait}"
        env = TeacherEnv(GRID, student=spec, episodes=3, announce=announce, max_turns=15)
        _, info = env.reset(seed=4)
        over = False
        while not over:
            silent = info["moment"].turn % 2
            meant = info.get("intention")
            _, _, terminated, truncated, info = env.step(0 if silent else 31)
            over = terminated or truncated
            if info["moment"].action is not None:
                done.append(info["moment"].action)
                announced.append((done[-1] if meant is None or not silent else meant, done[-1]))
    assert played[True] == played[False]
    assert len(played[True]) > 20
    assert trait in ("capitulates", "misconception", "stubborn") or all(meant == taken for meant, taken in announced)


def test_a_class_has_them():
    env = family("gridworld").raw_env(seating="classroom", students=2, attention=2, max_cycles=6)
    specs = {"student_0": "obedient", "student_1": "obedient | stubborn(p=1)"}
    partners = {
        agent: parse_student(spec).seat(family("gridworld"), env.sessions[0].world) for agent, spec in specs.items()
    }
    seats = ParallelSeats(env, partners)
    seats.reset(seed=5)
    done = {agent: [] for agent in specs}
    for agent, policy in partners.items():
        policy.act = partial(noted, policy.act, done[agent])
    while seats.agents:
        seats.step(dict.fromkeys(seats.agents, 31))
    assert len(set(done["student_1"])) == 1
    assert len(set(done["student_0"])) > 1


def noted(act, into, observation, info):
    into.append(act(observation, info))
    return into[-1]
