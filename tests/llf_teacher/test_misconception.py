"""A misconception ends by words that correct it, and by no others."""

import numpy as np
import pytest

import llf_teacher
from llf_teacher import testing as kit
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX, entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.scene import Scene
from llf_teacher.students.traits.misconception import Misconception
from llf_teacher.studies.execution.episode import play
from pz_envs.family import all_families
from teachers.atoms import FN, HN, Atom
from teachers.common import Better, Probably, Right, Truism, TryAgain, Wrong
from teachers.oracles.bandits import Avoid, PulledPoor

GRID, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
FAMILIES = [each for each in all_families() if not each.missing() and not each.slow]
SHOWCASE = [PREFIX + each.showcase[0] for each in FAMILIES]
STUDENT, NAMES, ADVISES = "obedient | misconception", "only(kinds='fp+hn')", "only(kinds='fp')"
QUIET = (ADVISES, f"{NAMES} | placebo", "retry_only", "silent")
SEEDS = range(2000, 2006)


def episode(id, teacher, student=STUDENT, seed=0, turns=10):
    return play(EpisodeSpec(id, teacher, student, "b", "a", turns, seed, llf_teacher.__version__))


def regret(id, teacher, student=STUDENT):
    return np.mean([episode(id, teacher, student, seed).episode.regret for seed in SEEDS])


def actions(*arguments, **settings):
    return [turn.action for turn in episode(*arguments, **settings).turns[1:]]


def scene(id=ARMS, seed=0):
    found = Scene(np.random.default_rng(seed), entry(id).family.make_world(), text=False)
    found.turn = 1
    return found


def corrected(claim, believed=3, about=0, student=None):
    """Whether a claim ends the belief that arm 3 is right."""
    trait, at = student or Misconception(action=believed), scene()
    trait.act(7, at)
    heard = trait.hear(Atom(claim, "words", about), at)
    assert heard is claim
    return trait.act(7, at) == 7


def test_it_takes_the_believed_action_until_it_is_corrected():
    for claim in (PulledPoor(action=3), Avoid(action=3), Wrong(action=3), Better(this=7, that=3)):
        assert corrected(claim), claim
    assert corrected(Probably(claim=Avoid(action=3), p=0.7))


@pytest.mark.parametrize(
    "claim",
    [
        PulledPoor(action=4),
        Avoid(action=4),
        Wrong(action=4),
        Better(this=3, that=7),
        Right(action=3),
        Right(action=7),
        TryAgain(),
        Truism(kind=HN, fact="ice melts"),
    ],
    ids=lambda claim: type(claim).__name__,
)
def test_other_words_do_not_correct_it(claim):
    for about in (0, 1, 2):
        assert not corrected(claim, about=about)


@pytest.mark.parametrize("id", SHOWCASE)
def test_words_that_name_the_belief_help_and_no_others(id):
    """In each family the oracle's blame and advice lower regret; what never names the belief changes no action."""
    silent = regret(id, "silent")
    assert regret(id, NAMES) < 0.6 * silent
    for teacher in QUIET:
        assert regret(id, teacher) == silent, teacher


@pytest.mark.parametrize("id", [each for each in SHOWCASE if "poem" not in each])
def test_misaligned_words_correct_it_only_by_chance(id):
    """In poems blame names no action and no text, so that blame of another poem cannot be told from that of its own."""
    assert regret(id, f"{NAMES} | misaligned") > 0.8 * regret(id, "silent")


@pytest.mark.parametrize("id", [GRID, ARMS])
def test_it_ends_in_the_turn_in_which_blame_names_it(id):
    for seed in SEEDS:
        turns = episode(id, NAMES, seed=seed).turns
        believed = turns[1].action
        named = [any(a["kind"] in (HN, FN) and a["action"] == int(believed) for a in turn.atoms) for turn in turns]
        first = named.index(True) if True in named else len(turns) - 1
        assert {turn.action for turn in turns[1 : first + 1]} == {believed}
        for before, turn in zip(turns[first:], turns[first + 1 :], strict=False):
            advised = [a["action"] for a in before.atoms if a["kind"] == "fp" and a["action"] is not None]
            assert int(turn.action) in advised or True not in named


def test_the_belief_depends_on_the_seed_alone():
    beliefs = {seed: actions(ARMS, "silent", seed=seed) for seed in range(12)}
    assert all(len(set(each)) == 1 for each in beliefs.values())
    assert len({each[0] for each in beliefs.values()}) > 3
    for seed in range(3):
        assert actions(ARMS, "oracle", seed=seed)[0] == beliefs[seed][0]
        assert actions(ARMS, "silent", "text_only | misconception", seed=seed) == beliefs[seed]


@pytest.mark.parametrize(("given", "id", "taken"), [(3, ARMS, "3"), ("east", GRID, "1"), (2, GRID, "2")])
def test_the_belief_can_be_given(given, id, taken):
    student = f"obedient | misconception(action={given!r})"
    assert set(actions(id, "silent", student)) == {taken}
    assert parse_student(str(parse_student(student))) == parse_student(student)


def test_a_pair_of_numbers_can_be_given():
    student = parse_student("obedient | misconception(action=[1.5, -2.0])")
    assert hash(student) == hash(parse_student("obedient | misconception(action=(1.5, -2.0))"))
    assert set(actions("llf-optimization-Booth-v0", "silent", str(student), turns=3)) == {"[1.5, -2.0]"}


def test_an_action_that_the_world_does_not_take_is_refused():
    with pytest.raises(ValueError, match="action 12 is not in the action space; allowed: "):
        Misconception(action=12).act(0, scene())


def test_a_weak_belief_is_acted_on_in_some_turns():
    taken = actions(ARMS, ADVISES, "obedient | misconception(p=0.5)", seed=1, turns=30)
    believed = actions(ARMS, ADVISES, seed=1)[0]
    assert 5 < taken.count(believed) < 25


def test_it_needs_a_student_that_hears():
    with pytest.raises(ValueError, match="changes what is heard, and the student random reads nothing"):
        parse_student("random | misconception")


@pytest.mark.parametrize("id", [ARMS, "llf-poem-Haiku-v0", "llf-reco-movie-v0"])
def test_students_with_it_pass_the_kit(id):
    for check in kit.STUDENT_CHECKS:
        check(parse_student(STUDENT), id)


def test_practice_in_the_instruction_can_correct_it():
    """The instruction `p` blames actions that were tried: some of them are the believed one."""
    spec = EpisodeSpec(ARMS, "silent", STUDENT, "p", "a", 6, 0, llf_teacher.__version__)
    found = [play(spec._replace(seed=seed)) for seed in range(20)]
    tried = [
        any(a["kind"] == "hn" and a["action"] == believed for a in each.turns[0].atoms)
        for each in found
        for believed in [int(actions(ARMS, "silent", seed=each.spec.seed)[0])]
    ]
    assert 0 < sum(tried) < len(tried)
    for each, named in zip(found, tried, strict=True):
        believed = actions(ARMS, "silent", seed=each.spec.seed)[0]
        assert all(turn.action == believed for turn in each.turns[1:]) is not named
