"""Students: what each of them reaches, and what it may see."""

import re
import string
import sys
from dataclasses import asdict
from functools import cache, partial
from itertools import islice, product

import numpy as np
import pytest
from design import COSTLY, amount, sampled
from playing import episode as episode_of
from sampling import IDS, fewer, practice
from shelf import is_complete

import llf_teacher
from llf_teacher.episodes.loop import play_turns
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX, entries, entry
from llf_teacher.students.parsing import STUDENTS, parse_student, student_for
from llf_teacher.studies.execution.episode import play
from pz_envs.family import all_families
from pz_envs.learning import KINDS, Learning, NoRewards
from pz_envs.text.actions import read_exactly
from pz_envs.text.phrases import Reader
from teachers.atoms import EditClaim, ParseFailure
from teachers.phrasebook import Draws
from teachers.voice import voice_names

SHOWCASE = [PREFIX + family.showcase[0] for family in all_families()]
BANDITS = [id for id, (_, family, *_) in entries().items() if family.oracle == "BanditOracle"]
VOICES = voice_names()
POEMS = [id for id, (_, family, *_) in entries().items() if family.oracle == "PoemOracle"]


def episode(id, student, seed, teacher="oracle", instruction_type="b"):
    max_turns = entry(id).family.max_turns
    return play(EpisodeSpec(id, teacher, student, instruction_type, "a", max_turns, seed, ""))


@pytest.mark.parametrize("student", ["obedient", "text_only"])
def test_the_treasure_is_reached_by_a_shortest_path(student):
    """In all of many houses: the regret of a path is the number of moves that it is longer than a shortest one."""
    for seed in range(amount(25, full=80)):
        record = episode("llf-gridworld-v0", student, seed)
        assert record.episode.success
        assert record.episode.regret == 0


@sampled(lambda id, student: {id, student})
@pytest.mark.parametrize("student", ["obedient", "text_only"])
@pytest.mark.parametrize("id", BANDITS)
def test_a_best_arm_is_pulled_from_the_second_turn_on(id, student):
    for seed in range(amount(16, full=50)):
        assert all(turn.success for turn in episode(id, student, seed).turns[2:])


@sampled(lambda id, student: {id, student})
@pytest.mark.parametrize("student", ["obedient", "text_only"])
@pytest.mark.parametrize("id", POEMS)
def test_poems_succeed_within_thirty_turns(id, student):
    for seed in range(amount(16, full=50)):
        assert episode(id, student, seed).episode.first_success <= 30


@pytest.mark.parametrize("seed", range(10))
def test_a_poem_that_is_too_long_is_cut_where_the_teacher_says(seed):
    """A first draft has up to 19 lines; whoever gets hints sends one before it hears of three."""
    assert episode("llf-poem-Haiku-v0", "text_only", seed, "hinter").episode.first_success <= 6


@sampled(lambda id: {entry(id).family.name})
@pytest.mark.parametrize("id", [each for each in IDS if "c" in llf_teacher.supported_types(each.values[0])[0]])
def test_complete_instructions_suffice_and_basic_ones_do_not(id):
    """With `c` and no feedback an obedient student reaches the oracle's return, with `b` it does not do as well."""
    seeds = range(fewer(entry(id).family, amount(4, full=10)))

    @cache
    def played(student, instruction_type):
        return [episode(id, student, seed, "silent", instruction_type).episode for seed in seeds]

    def mean(measure, student, instruction_type):
        return np.mean([getattr(each, measure) for each in played(student, instruction_type)])

    best = mean("total_reward", "oracle", "b")
    assert mean("total_reward", "obedient", "c") == pytest.approx(best)
    assert mean("total_reward", "text_only", "c") == pytest.approx(best)
    assert mean("regret", "obedient", "b") > mean("regret", "oracle", "b")


@pytest.mark.parametrize(
    "id", [pytest.param(id, marks=pytest.mark.full if entry(id).family.slow else ()) for id in SHOWCASE]
)
def test_learning_from_rewards_beats_chance(id):
    turns = 2000 if entry(id).family.name in COSTLY else amount(1000, full=2000)  # with fewer it may be luck
    seeds = range(turns // entry(id).family.max_turns)

    @cache
    def regret(student):
        return np.mean([episode(id, student, seed, "silent").episode.regret for seed in seeds])

    assert regret("oracle") == 0 < regret("reward_only")
    if type(entry(id).family.learning) is not NoRewards:  # or no reward comes before the end
        assert regret("reward_only") < regret("random")


@pytest.mark.parametrize("id", SHOWCASE)
def test_the_learner_who_suits_a_family_learns_from_rewards_and_plays(id):
    learning = entry(id).family.learning
    student = student_for(learning)
    assert student == parse_student(str(student))
    assert student.reads == ("nothing" if learning == NoRewards() else "reward")
    assert {name: getattr(student, name) for name in asdict(learning)} == asdict(learning)
    played, named = (episode(id, spec, 0, "silent").turns for spec in ("reward_only", str(student)))
    assert played == named
    assert played


@pytest.mark.parametrize("kind", KINDS)
def test_one_student_suits_each_thing_that_rewards_teach(kind):
    assert [STUDENTS[name].suits for name in STUDENTS.names].count(kind) == 1


def test_nobody_learns_from_what_is_unknown():
    with pytest.raises(ValueError, match=r"no student learns from Learning\(\)"):
        student_for(Learning())


def test_q_learning_finds_a_shortest_path_in_a_house_that_stays():
    env = llf_teacher.make("llf-gridworld-v0", teacher="silent", max_turns=200)
    policy = parse_student("q_learning(forget=False, optimism=0.0)").seat(env.family, env.session.world)

    def act(observation, info):
        return policy.act(env.student_view.observe(), env.student_view.info_for(policy))

    rng = np.random.default_rng(0)
    for _ in range(300):
        policy.reset(rng)
        successes = [info["success"] for *_, info in episode_of(env, act)]
    env.reset(seed=0)
    assert successes.index(True) + 1 == len(env.teacher.oracle.plan(env.session.world.truth, 99))


@pytest.mark.parametrize("id", SHOWCASE)
@pytest.mark.parametrize("student", ["random", "reward_only", "text_only", "obedient", "oracle"])
def test_students_see_what_they_are_entitled_to(id, student):
    env = llf_teacher.make(id)
    env.reset(seed=0)
    policy = parse_student(student).seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    info = env.student_view.info_for(policy)
    reads = policy.reads
    assert reads == (student_for(env.family.learning) if student == "reward_only" else parse_student(student)).reads
    assert ("atoms" in info) == (reads in ("atoms", "atoms and reward", "truth"))
    assert ("reward" in info) == (reads in ("reward", "atoms and reward"))
    assert ("moment" in info) == (reads == "truth")
    assert "atoms" in env.student_view.info()
    assert env.session.world.legal(policy.act(env.student_view.observe(), info)) is not None


@sampled(lambda id, teacher: {id, (entry(id).family.name, teacher)})
@pytest.mark.parametrize("id", IDS)
@pytest.mark.parametrize("teacher", ["oracle", "mistake(eps=0.5)", "placebo", "retry_only", "delayed(turns=2)"])
def test_reading_recovers_every_sentence(id, teacher):
    """A reader of words hears exactly the claims that were said, in order, with the turn they are about."""
    env = llf_teacher.make(id, teacher=teacher, instruction_type=practice(entry(id).family))
    recovers(env, Reader(env.family.phrasebook), fewer(env.family, amount(2, full=5)))


@sampled(lambda id, voice: {id, voice})
@pytest.mark.parametrize("id", SHOWCASE)
@pytest.mark.parametrize("voice", VOICES[1:])
def test_reading_recovers_every_sentence_of_every_voice(id, voice):
    """With the same reader, who does not know beforehand which voice it will hear."""
    reader = None
    family = entry(id).family
    for teacher in filter(family.serves, ("mistake(eps=0.5) | delayed(turns=2)", "verification", "vague")):
        env = llf_teacher.make(id, teacher=teacher, instruction_type=practice(family), voice=voice)
        reader = reader or Reader(env.family.phrasebook, VOICES, partial(is_action, env.session.world))
        recovers(env, reader, fewer(env.family, amount(1, full=3)))


def said_slots(heard):
    """Those slots of a sentence that a reader of words acts upon, as the roles of its claim declare them."""
    roles = ("action_slot", "plan_slot", "line_slot", "words_slot")
    return heard.slots.keys() & {getattr(heard.claim, role, "") for role in roles}


def is_action(world, text):
    return type(read_exactly(text, world)) is not ParseFailure


def recovers(env, reader, episodes):
    rng = np.random.default_rng(0)
    for seed in range(episodes):
        observation, info = env.reset(seed=seed)
        done = False
        while not done:
            text = " ".join(filter(None, (observation["instruction"], observation["feedback"])))
            heard = list(reader.read(text))
            assert [each.claim for each in heard] == [type(atom.claim) for atom in info["atoms"]], text
            for each, atom in zip(heard, info["atoms"], strict=True):
                assert each.about_turn in (None, atom.about_turn)
                for slot in said_slots(each):
                    assert each.slots[slot] == f"{getattr(atom.claim, slot)}"
            observation, _, terminated, truncated, info = env.step(env.session.world.sample_action(rng))
            done = terminated or truncated


SPECS = ("oracle", "mistake", "hinter", "vague", "verification", "worked_example", "retry_only", "placebo", "equal")


@pytest.mark.parametrize("id", SHOWCASE)
def test_every_paraphrase_of_every_voice_is_read_as_the_claim_that_it_words(id):
    """Whichever voice was heard before."""
    family = entry(id).family
    said = {}
    for spec in filter(family.serves, SPECS):
        for type_ in family.oracle_class().instruction_types:
            env = llf_teacher.make(id, teacher=spec, instruction_type=type_)
            student = parse_student("random").seat(family, env.session.world)
            for turn in islice(play_turns(env, student, seed=0), 10):
                for atom in turn.atoms:
                    said.setdefault(type(atom.claim), set()).add(atom.claim)
    assert len(said) > (15 if is_complete(family) else len(family.oracle_class().claims()))
    for before, voice in amount(
        list(zip(VOICES[1:] + VOICES[:1], VOICES, strict=True)), full=list(product(VOICES, VOICES))
    ):
        reader = Reader(family.phrasebook, [before, *VOICES], partial(is_action, family.make_world()))
        book = family.phrasebook(voice)
        for claim in (claim for claims in said.values() for claim in sorted(claims, key=repr)[:1]):
            for i in range(len(book.templates(type(claim)))):
                text = str(book.say([claim], 1, Draws(np.random.default_rng(0)), i))
                (heard,) = reader.read(text)
                assert heard.claim is type(claim), text
                for slot in said_slots(heard):
                    assert heard.slots[slot] == f"{getattr(claim, slot)}", text


@pytest.mark.parametrize("voice", VOICES)
@pytest.mark.parametrize("id", SHOWCASE)
def test_a_reader_of_words_understands_every_voice(id, voice):
    """It does as well with each as with the plain one, to which it was listening before."""
    family = entry(id).family
    policy = parse_student("text_only").seat(family, family.make_world())

    def rewards(voice):
        env = llf_teacher.make(id, voice=voice)
        return [turn.moment.reward for turn in play_turns(env, policy, seed=3)]

    assert rewards("plain") == rewards(voice)


DISCRETE = ["llf-bandits-BanditTenArmedRandomFixed-v0", "llf-gridworld-v0"]


def skill(id, teacher, seed, field):
    """What the Bayesian student thinks of a teacher after an episode."""
    env = llf_teacher.make(id, teacher=teacher)
    policy = parse_student("bayesian").seat(env.family, env.session.world)
    for _ in play_turns(env, policy, seed):
        pass
    return policy.skill[field]


@pytest.mark.parametrize("id", DISCRETE)
def test_the_bayesian_student_finds_liars_out(id):
    """It does better than the obedient one with a liar, better than without a teacher, and trusts an honest one."""

    @cache
    def regret(student, teacher):
        return np.mean([episode(id, student, seed, teacher).episode.regret for seed in range(amount(12, full=25))])

    for liar in ("mistake(eps=0.3)", "mistake(eps=1)"):
        assert regret("bayesian", liar) < regret("obedient", liar)
        assert regret("bayesian", liar) < regret("bayesian", "silent")
    assert regret("bayesian", "oracle") < 0.25 * regret("bayesian", "silent")


@pytest.mark.parametrize("field", range(3))
def test_the_bayesian_student_learns_whom_to_trust(field):
    id = DISCRETE[0] if field == 1 else DISCRETE[1]
    honest, lying, unheard = (
        np.mean([skill(id, teacher, seed, field) for seed in range(15)])
        for teacher in ("oracle", "mistake(eps=1)", "silent")
    )
    assert lying < 0.7 < unheard < honest
    assert unheard == pytest.approx(0.8)


@pytest.mark.parametrize("id", ["llf-poem-Haiku-v0", "llf-optimization-Booth-v0"])
def test_the_bayesian_student_says_where_it_cannot_play(id):
    env = llf_teacher.make(id)
    with pytest.raises(ValueError, match=r"weighs discrete actions.*use another student there"):
        parse_student("bayesian").seat(env.family, env.session.world)


@pytest.mark.parametrize("id", DISCRETE)
@pytest.mark.parametrize("teacher", ["worked_example", "verification", "verification | delayed(turns=1)"])
def test_words_are_understood_like_claims(id, teacher):
    for seed in range(10):
        regrets = {episode(id, student, seed, teacher).episode.regret for student in ("obedient", "text_only")}
        assert len(regrets) == 1


def work(reader, text):
    """What reading takes: the calls that are made, and the characters that regular expressions pass over."""
    calls = passed = 0

    def note(frame, event, arg):
        nonlocal calls, passed
        calls += event in ("call", "c_call")
        if event == "c_call" and arg.__name__ == "search":
            begin = frame.f_locals["at"]
            found = frame.f_locals["pattern"].search(text, begin)
            passed += (found.end() if found else len(text)) - begin

    sys.setprofile(note)
    try:
        list(reader.read(text))
    finally:
        sys.setprofile(None)
    return calls, passed


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_reading_takes_work_linear_in_hostile_texts(family):
    """Whatever begins like sentences and never ends; regular expressions took minutes for it."""
    reader = Reader(family.phrasebook, VOICES, partial(is_action, family.make_world()))
    list(reader.read("What nobody says."))  # now it has learned all voices
    size = 16_384
    texts = ["The quick brown fox, they say, jumps over the lazy dog. ", '"a. ', '"', "a", ": "]
    for _, templates in family.phrasebook("plain").items():
        literals = [literal for literal, *_ in string.Formatter().parse(templates[0])]
        if len(literals) > 2:
            texts += [literals[0] + literals[1] * (2 * size // len(literals[1])), "x".join(literals[:-1])]
    for text in texts:
        whole = (text * 2 * size)[: 2 * size] if len(text) < 1000 else text[: 2 * size]
        calls, passed = work(reader, whole[:size])
        more_calls, more_passed = work(reader, whole)
        assert calls < 2 * size  # what begins no sentence is passed over by one search, not letter by letter
        assert passed < 20 * size
        assert more_calls < 2.1 * calls + 2000
        assert more_passed < 2.1 * passed + 2000


def test_a_turn_that_is_no_number_is_no_turn():
    reader = Reader(entry("llf-gridworld-v0").family.phrasebook, VOICES)
    assert not list(reader.read("Turn the page: it is blank. On turn 2.5: nothing."))
    (heard,) = reader.read("What I had to say at turn 3: Go north next.")
    assert heard.about_turn == 3


def test_reading_skips_what_it_does_not_know():
    env = llf_teacher.make("llf-gridworld-v0")
    heard = list(Reader(env.family.phrasebook).read("Hello there! Go north next. What a day. Do not go east next."))
    assert [each.slots for each in heard] == [{"action": "north"}, {"action": "east"}]


def test_bad_specs():
    with pytest.raises(ValueError, match="unknown student 'obediant'; did you mean obedient"):
        parse_student("obediant")
    with pytest.raises(ValueError, match=r"unknown trait 'oracle'; .*allowed: capitulates, forgetful"):
        parse_student("random | oracle")
    with pytest.raises(ValueError, match="alpha must be a number from 0 to 1, got 3"):
        parse_student("q_learning(alpha=3)")
    with pytest.raises(ValueError, match="lengths must be a tuple of positive integers"):
        parse_student("line_search(lengths=(0,))")
    assert str(parse_student("ucb(scale=2)")) == "ucb(scale=2)"


@pytest.mark.parametrize("number", ["0", "9" * 5000, "1000", "two", "²"])
def test_a_line_that_no_text_has_is_not_written(number):
    """A liar may tell of line 10**5000: nothing is filled with blanks, and the episode goes on."""
    poem = entry(POEMS[0])
    world = poem.family.make_world(**poem.options)
    student = parse_student("text_only").seat(poem.family, world)
    student.reset(np.random.default_rng(0))
    (template, *_) = [
        each
        for claim, templates in poem.family.phrasebook("plain").items()
        if issubclass(claim, EditClaim) and not claim.cuts
        for each in templates
    ]
    said = re.sub(r"\{line[^}]*\}", number, re.sub(r"\{(?!line)[^}]*\}", "word", template))
    world.reset(seed=0)
    observation = {"state": world.describe(world.observe()), "instruction": "", "feedback": said}
    student.act(observation | {"feedback": ""}, {})
    assert len(student.act(observation, {})) < 10_000
