"""Voices: phrases are checked whole at load, and put every claim into words."""

import dataclasses
import inspect
import re
import string
from collections import Counter
from functools import cache
from itertools import islice
from typing import get_args, get_origin

import numpy as np
import pytest
from scipy.stats import chisquare

from pz_envs.family import all_families
from teachers import common
from teachers.atoms import FP, HN, HP, SILENCE, Claim, FeedbackType, Verdict, claim, opposed, slots_of
from teachers.common import Late, Probably, Reward, Solved, TryAgain, hedge
from teachers.oracle import claims_of
from teachers.oracles.bandits import Pull, PulledPoor
from teachers.oracles.poem import PoemOracle
from teachers.oracles.poem.claims import AvoidCount, AvoidLines, Count, LinesRight, Write, WrongLine, WrongNumber
from teachers.phrasebook import Draws, Phrasebook, check_paraphrase, load_phrasebook
from teachers.templates import Template, cache_key
from teachers.testing import Pupil, wording_problems
from teachers.voice import load_tone, voice_names

FAMILIES = {family.name: family for family in all_families()}
BOOKS = [(name, family.oracle_class().__module__) for name, family in FAMILIES.items()]


@claim
class Steps(Claim):
    """True if it takes so many steps to a place."""

    number: int
    place: str
    route: tuple[int, ...] = ()


@claim
class Done(Claim):
    """True if all is done."""


STEPS = ["{number} to {place}", "{place}: {number}", "In {number}, {place}", "To {place} it is {number}"]
DONE = ["Done.", "That is all.", "Over.", "Finished."]


def book(name):
    return load_phrasebook(f"teachers.phrases:{name}.toml", FAMILIES[name].oracle_class().__module__)


def draws(seed=0):
    return Draws(np.random.default_rng(seed))


def say(phrasebook, claims, seed=0, paraphrase="random", turn=3):
    return phrasebook.say(claims, turn, draws(seed), paraphrase)


def example(cls):
    """A claim of the class with plain values of the annotated types."""
    return cls(**{field.name: plain(field.type) for field in dataclasses.fields(cls)})


def plain(of):
    """A plain value of a type; two of those of which there may be any number."""
    values = {str: "some words", int: 3, float: -0.25, bool: True, FeedbackType: FeedbackType.HP}
    if get_origin(of) is tuple:
        return tuple(plain(get_args(of)[0] if each is ... else each) for each in get_args(of))
    return next(iter(of)) if inspect.isclass(of) and of not in values and issubclass(of, int) else values.get(of)


@cache
def real_claims(name):
    """Claims that occur in play, up to 20 of each class, false counterparts included."""
    family = FAMILIES[name]
    found = {}
    worlds = [family.environments[environment] for environment in family.sampled or family.environments]
    if "town" in family.options():
        worlds.append({**family.environments[family.showcase[0]], "town": 1})
    for options in worlds:
        pupil = Pupil(lambda options=options: family.make_world(**options), family.make_teacher, family.max_turns, 60)
        lab = pupil.make_world()
        for oracle, moment in pupil.judged():
            claims = oracle.judge(moment) + oracle.clues(moment.after)
            if moment.turn == 0:
                for type_ in oracle.instruction_types:
                    claims += oracle.brief(moment.after, type_, np.random.default_rng(0))
            for each in claims:
                for one in (each, *each.counterparts(moment, lab), *each.coarser(moment, lab)):
                    found.setdefault(type(one), {})[one] = None
    return {cls: tuple(islice(claims, 20)) for cls, claims in found.items()}


@pytest.mark.parametrize(("name", "module"), BOOKS)
def test_shipped_phrases_word_every_claim_of_family_and_common(name, module):
    phrases = dict(load_phrasebook(f"teachers.phrases:{name}.toml", module).items())
    assert set(phrases) == {*claims_of(module), *claims_of(common.__name__)}
    assert all(4 <= len(templates) <= 20 for templates in phrases.values())
    assert load_phrasebook(f"teachers.phrases:{name}.toml", module, "plain").items() == list(phrases.items())


@pytest.mark.parametrize("name", FAMILIES)
def test_every_template_of_every_claim_says_its_slots(name):
    phrasebook = book(name)
    for cls, templates in phrasebook.items():
        if cls in (Late, Probably):
            continue
        for each in real_claims(name).get(cls) or (example(cls),):
            values = {slot: getattr(each, slot) for slot in slots_of(cls)}
            for i, template in enumerate(templates):
                said = say(phrasebook, [each], paraphrase=i)
                assert said == template.format(**values)
                assert said.strip() == said != ""


@pytest.mark.parametrize("name", FAMILIES)
def test_most_claims_of_a_family_occur_in_play(name):
    seen = set(real_claims(name))
    claims = set(FAMILIES[name].oracle_class().claims())
    assert len(seen & claims) >= 0.7 * len(claims), claims - seen


@pytest.mark.parametrize("name", FAMILIES)
def test_paraphrases_of_a_claim_differ_and_have_the_same_slots(name):
    for _, templates in book(name).items():
        slots = [{slot for _, slot, _, _ in string.Formatter().parse(template) if slot} for template in templates]
        assert slots == slots[:1] * len(templates)
        assert len(set(templates)) == len(templates)


@pytest.mark.parametrize("voice", voice_names())
@pytest.mark.parametrize("name", FAMILIES)
def test_no_phrase_can_be_misread_as_far_as_a_program_can_tell(name, voice):
    claims = [each for some in real_claims(name).values() for each in some]
    assert list(wording_problems(FAMILIES[name].phrasebook(voice), claims)) == []


@claim
class _Pace(Verdict):
    steps: int


@claim
class Fast(_Pace):
    """True if that was fast."""

    kind = HP


@claim
class Slow(_Pace):
    """True if that was slow."""

    kind = HN


@claim
class Hurry(Claim):
    """True if it is good to be fast."""

    kind = FP
    steps: int


opposed(Fast, Slow)
SOUND = {
    "Fast": ["You took {steps} steps, few.", "{steps}: few.", "Only {steps}.", "Do you see that {steps} are few?"],
    "Slow": ["You took {steps} steps, many.", "{steps}: many.", "All of {steps}.", "Why is {steps} too many?"],
    "Hurry": ["Take {steps} now.", "{steps} next.", "Why not take {steps}?", "What now, when {steps} are enough?"],
}


@pytest.mark.parametrize(
    ("name", "phrase", "problem"),
    [
        ("Hurry", "Take 3 {steps} times.", "has two numbers in a row"),
        ("Hurry", "Go {steps} -1 and on.", "has two numbers in a row"),
        ("Fast", "Was {steps} really few?", "asks and does not assert"),
        ("Slow", "Were {steps} not many?", "asks and does not assert"),
        ("Hurry", "Have you thought of {steps}?", "asks and does not assert"),
        ("Hurry", "Would you see if {steps} are enough?", "asks and does not assert"),
        (
            "Fast",
            "What was good about that? {steps}.",
            "opens with a question that does not speak of the student as you",
        ),
        ("Hurry", "Where did you go? To {steps}.", "opens with a question in the past tense"),
        ("Slow", "What do you get wrong now? {steps}.", "opens with a question in the future tense"),
        ("Fast", "What did you do? Somebody took {steps}.", "opens with a question and speaks of somebody else"),
        ("Fast", "Did you see? An earlier student took {steps}.", "opens with a question and speaks of somebody else"),
        ("Fast", "You took {steps} steps, many?", "has the same words as a phrase of its opposite Slow"),
        ("Slow", "Few steps {steps} took you!", "has the same words as a phrase of its opposite Fast"),
        ("Late", "Of turn {turn}: {text}", "does not say that its turn is past"),
    ],
)
def test_a_phrase_that_can_be_misread_is_found(name, phrase, problem):
    late = {"Late": [f"{word} turn {{turn}}: {{text}}" for word in ("Was of", "Was for", "Said, was of", "Had at")]}
    claims = (Fast, Slow, Hurry, Late)
    said = [cls(steps=5) for cls in claims[:3]]
    assert list(wording_problems(Phrasebook(SOUND | late, claims, "words"), said)) == []
    poor = SOUND | late
    poor[name] = [*poor[name], phrase]
    found = list(wording_problems(Phrasebook(poor, claims, "words"), said))
    assert [each for each in found if each.startswith(f"{name}: ") and problem in each]


def test_quoted_words_are_not_taken_for_numbers():
    quoted = {"Hurry": ["Write '1 {steps}'.", 'Say "1 {steps}".', "Do `1 {steps}`.", "Take {steps}, 2 or 3."]}
    assert list(wording_problems(Phrasebook(quoted, [Hurry], "words"), [Hurry(steps=5)])) == []


def test_what_was_tried_before_an_episode_is_not_framed_as_the_students_own():
    for name, family in FAMILIES.items():
        tried = [cls for cls in family.oracle_class().claims() if cls.tried]
        assert {cls.kind for cls in tried} <= {HP, HN}
        assert bool(tried) == ("p" in family.oracle_class().instruction_types), name
        for voice in voice_names():
            for cls in tried:
                assert set(family.phrasebook(voice).templates(cls)) <= set(family.phrasebook().templates(cls))


def test_an_unknown_voice_is_refused():
    with pytest.raises(ValueError, match="unknown voice 'shakespeare'; allowed: plain, curt, socratic, warm"):
        load_phrasebook("teachers.phrases:common.toml", "teachers.common", "shakespeare")


def test_a_claim_without_its_decorator_is_named():
    class Bare(Claim):
        number: int

    with pytest.raises(ValueError, match=r"Bare: \S*\.Bare lacks the decorator @claim; write @claim before the class"):
        Phrasebook({"Bare": ["a", "b", "c", "d"]}, [Bare], "test.toml")


def test_one_error_lists_every_problem():
    phrases = {
        "Steps": [
            *STEPS,
            "To {place} it is {number}",
            "{number} to nowhere",
            "{number} to {city}",
            "{number} by {route} to {place}",
            "{number:>8} to {place}",
            "{number} to {place!s}",
            "{number} to {place",
        ],
        "Done": DONE[:3],
        "Nothing": DONE,
    }
    with pytest.raises(ValueError, match=r"^bad phrases in test\.toml \[plain\]:") as raised:
        Phrasebook(phrases, [Steps, Done, TryAgain], "test.toml [plain]")
    problems = str(raised.value).splitlines()[1:]
    expected = [
        "TryAgain: has no phrases",
        "Nothing: there is no claim of this name",
        "Done: has 3 paraphrases; allowed: 4 to 20",
        "Steps: 'To {place} it is {number}' is also a phrase of Steps",
        "Steps: '{number} to {city}' has a slot 'city'; allowed: number, place",
        "Steps: '{number} by {route} to {place}' has a slot 'route'; allowed: number, place",
        "Steps: '{number:>8} to {place}': slot 'number' has a bad format",
        "Steps: '{number} to {place!s}': slot 'place' has a bad format",
        "Steps: '{number} to {place': ",
        "Steps: '{number} to nowhere' has no slot 'place', which other paraphrases have",
    ]
    for problem in expected:
        assert any(line.strip().startswith(problem) for line in problems), problem


@pytest.mark.parametrize(
    ("phrases", "message"),
    [
        ({"Done": DONE}, "Steps: has no phrases"),
        ({"Steps": STEPS}, "Done: has no phrases"),
        ({"Steps": STEPS, "Done": DONE, "Gone": DONE}, "Gone: there is no claim of this name"),
        ({"Steps": STEPS, "Done": DONE[:3]}, "Done: has 3 paraphrases; allowed: 4 to 20"),
        ({"Steps": STEPS, "Done": [str(i) for i in range(21)]}, "Done: has 21 paraphrases; allowed: 4 to 20"),
        ({"Steps": STEPS, "Done": [*DONE, "Over."]}, "Done: 'Over.' is also a phrase of Done"),
        ({"Steps": STEPS, "Done": "Done."}, "Done: must be a list of strings"),
        ({"Steps": STEPS, "Done": [*DONE, 5]}, "Done: must be a list of strings"),
        ({"Steps": STEPS, "Done": [*DONE, "{}"]}, "Done: '{}' has a slot ''; allowed: none"),
        ({"Steps": STEPS, "Done": [*DONE, "{0}"]}, "Done: '{0}' has a slot '0'; allowed: none"),
        ({"Steps": [*STEPS, "{number} {place.x}"], "Done": DONE}, "'{number} {place.x}' has a slot 'place.x'"),
        ({"Steps": [*STEPS, "{number} {place[0]}"], "Done": DONE}, "'{number} {place[0]}' has a slot 'place[0]'"),
        ({"Steps": [*STEPS, "{number:{place}}"], "Done": DONE}, "slot 'number' has a bad format"),
        ({"Steps": [*STEPS, "{number} {place"], "Done": DONE}, "'{number} {place': "),
        ({"Steps": [*STEPS, "{number} {place}}"], "Done": DONE}, "'{number} {place}}': "),
        ({"Steps": [*STEPS, "{number}"], "Done": DONE}, "'{number}' has no slot 'place', which other paraphrases have"),
    ],
)
def test_the_phrase_with_the_problem_is_named_and_no_other(phrases, message):
    # Today a slot that does not exist is said to be left out by every other template.
    with pytest.raises(ValueError, match="bad phrases in words:") as raised:
        Phrasebook(phrases, [Steps, Done], "words")
    problems = str(raised.value).splitlines()[1:]
    assert message in problems[0]
    assert not [template for template in STEPS + DONE if f"{template!r} has no slot" in str(raised.value)]


def test_the_phrase_that_leaves_out_a_slot_is_named_behind_one_with_bad_braces():
    # Today the phrase with bad braces is blamed: it has no entry among those that are compared, which are one off.
    with pytest.raises(ValueError, match="bad phrases") as raised:
        Phrasebook({"Steps": ["{number} to {place", "{number}", *STEPS]}, [Steps], "words")
    assert [line.split(": ", 1)[1] for line in str(raised.value).splitlines() if "has no slot" in line] == [
        "'{number}' has no slot 'place', which other paraphrases have"
    ]


def test_formats_and_percent_signs_are_kept():
    templates = [
        "{number:d} % {place!r}",
        "{number:.2f}%% {place!r}",
        "{{{number:.3g}}} {place!r}",
        "{number}%s {place!r}",
    ]
    phrasebook = Phrasebook({"Steps": templates}, [Steps], "words")
    each = Steps(number=7, place="a 'b'")
    said = [str(say(phrasebook, [each], paraphrase=i)) for i in range(4)]
    assert said == ["7 % \"a 'b'\"", "7.00%% \"a 'b'\"", "{7} \"a 'b'\"", "7%s \"a 'b'\""]


def test_values_are_not_read_as_templates():
    phrasebook = Phrasebook({"Steps": STEPS}, [Steps], "words")
    place = "{number} %s {0} %(x)s"
    assert say(phrasebook, [Steps(number=1, place=place)], paraphrase=0) == f"1 to {place}"


def test_what_is_said_carries_its_claims():
    phrasebook = book("gridworld")
    claims = (Reward(reward=0.5), TryAgain())
    said = say(phrasebook, claims, turn=7)
    assert said == " ".join(atom.text for atom in said.atoms)
    assert tuple(atom.claim for atom in said.atoms) == claims
    assert {atom.about_turn for atom in said.atoms} == {7}
    assert all(
        atom.text in {t.format(reward=0.5) for t in phrasebook.templates(type(atom.claim))} for atom in said.atoms
    )
    assert say(phrasebook, ()) == SILENCE


def test_the_same_stream_gives_the_same_text():
    phrasebook = book("gridworld")
    claims = [Reward(reward=0.5), TryAgain()] * 20
    assert say(phrasebook, claims, seed=1) == say(phrasebook, claims, seed=1) != say(phrasebook, claims, seed=2)


def test_random_paraphrases_are_equally_likely():
    phrasebook = book("gridworld")
    counts = Counter(atom.text for atom in say(phrasebook, [TryAgain()] * 2000).atoms)
    assert set(counts) == set(phrasebook.templates(TryAgain))
    assert chisquare(list(counts.values())).pvalue > 1e-3


@pytest.mark.parametrize("index", [0, 3, 4, 7, 1000, -1])
def test_an_integer_picks_a_paraphrase_modulo_their_number(index):
    phrasebook = book("gridworld")
    for each, values in ((TryAgain(), {}), (Reward(reward=0.5), {"reward": 0.5})):
        templates = phrasebook.templates(type(each))
        assert say(phrasebook, [each], paraphrase=index) == templates[index % len(templates)].format(**values)


def test_a_callable_gets_templates_and_slots():
    asked = []

    def paraphrase(templates, **slots):
        asked.append((templates, slots))
        return f"I say {slots}"

    phrasebook = Phrasebook({"Steps": STEPS, "Done": DONE}, [Steps, Done], "words")
    said = say(phrasebook, [Steps(number=1, place="x"), Done()], paraphrase=paraphrase)
    assert asked == [(STEPS, {"number": 1, "place": "x"}), (DONE, {})]
    assert said == f"I say {asked[0][1]} I say {{}}"
    assert [type(atom.claim) for atom in said.atoms] == [Steps, Done]


@pytest.mark.parametrize("paraphrase", [1, -2, lambda templates, **slots: templates[0].format(**slots)])
def test_the_choice_of_paraphrase_does_not_change_the_draws_that_follow(paraphrase):
    phrasebook, first, second = book("gridworld"), draws(), draws()
    phrasebook.say([TryAgain()] * 3, 1, first, "random")
    phrasebook.say([TryAgain()] * 3, 1, second, paraphrase)
    assert first.take(9) == second.take(9)


@pytest.mark.parametrize("paraphrase", ["random", 0, lambda templates, **slots: templates[-1].format(**slots)])
def test_late_claims_are_framed_and_filed_by_their_turn(paraphrase):
    phrasebook = book("gridworld")
    late = Late(claim=Reward(reward=0.5), turn=2)
    for seed in range(20):
        (atom,) = say(phrasebook, [late], seed, paraphrase, turn=5).atoms
        assert (atom.claim, atom.about_turn, atom.kind) == (Reward(reward=0.5), 2, "r")
        sentences = {template.format(reward=0.5) for template in phrasebook.templates(Reward)}
        frames = phrasebook.templates(Late)
        assert atom.text in {frame.format(turn=2, text=sentence) for frame in frames for sentence in sentences}


def test_frames_of_late_claims_vary_independently_of_the_sentence():
    phrasebook = book("gridworld")
    said = say(phrasebook, [Late(claim=Solved(), turn=1)] * 2000).atoms
    pairs = len(phrasebook.templates(Late)) * (len(phrasebook.templates(Solved)) - 1)  # one says "now"
    assert len({atom.text for atom in said}) == pairs


def test_words_are_counted_over_all_paraphrases():
    phrasebook = Phrasebook({"Done": ["One.", "One two.", "One two three.", "One two three four."]}, [Done], "words")
    assert phrasebook.words(Done()) == 2.5


@pytest.mark.parametrize("paraphrase", ["random", 0, -3, 10**9, print])
def test_ways_to_paraphrase(paraphrase):
    assert check_paraphrase(paraphrase) is paraphrase


@pytest.mark.parametrize("paraphrase", ["Random", "", "0", None, 1.5, True, ["random"]])
def test_other_ways_to_paraphrase_are_refused(paraphrase):
    with pytest.raises(ValueError, match=r"paraphrase must be 'random', an integer or a callable .*, got "):
        check_paraphrase(paraphrase)


def test_draws_do_not_depend_on_how_many_are_taken_at_once():
    def take(stream, n):
        at = stream.take(n)
        return stream.numbers[at : at + n]

    assert all(0 <= draw < 1 for draw in take(draws(), 1000))
    assert len(set(take(draws(), 1000))) == 1000
    one, other = draws(), draws()
    assert [take(one, 1)[0] for _ in range(5)] == [take(other, 1)[0] for _ in range(5)]
    assert take(one, 0) == []


@pytest.mark.parametrize("voice", ["plain", "curt", "socratic"])
def test_one_syllable_and_one_line_are_no_plural(voice):
    """Poems of one line and lines of one syllable are poems, too."""
    book = next(family for family in FAMILIES.values() if family.oracle == PoemOracle.__name__).phrasebook(voice)
    for said in (
        WrongLine(line=1, counted=1, required=5),
        Count(line=1, syllables=1),
        AvoidCount(line=1, counted=1),
        Write(action="la", line=1, syllables=1),
        WrongNumber(lines=1, required=3),
        AvoidLines(lines=1),
    ):
        slots = {name: getattr(said, name) for name in slots_of(type(said))}
        for template in book.templates(type(said)):
            assert re.search(r"\b1 (syllable|line)\b", template.format(**slots)), template


def test_a_list_of_lines_is_a_part_of_the_sentence():
    book = next(family for family in FAMILIES.values() if family.oracle == PoemOracle.__name__).phrasebook()
    assert not [template for template in book.templates(LinesRight) if ": {listing}" in template]


@claim
class Turned(Claim):
    """True if somebody turned so often, in this sense and by way of these places."""

    times: int
    kind_of: FeedbackType
    by: tuple[int, ...]


def test_claims_of_numbers_and_members_come_again():
    assert cache_key(Turned)(Turned(times=2, kind_of=FeedbackType.HP, by=(1,))) == (2, FeedbackType.HP, (1,))
    for cls in (Steps, Done, Reward, Late):
        assert cache_key(cls) is None


STATED = {
    Pull(action=3): {
        "curt": ["Arm 3 next."],
        "plain": [
            "Your next choice should be arm 3.",
            "Arm 3 is what you should go for now.",
            "The arm for your next turn is 3.",
        ],
    },
    PulledPoor(action=3): {
        "curt": [
            "Arm 3 was not a best arm.",
            "Wrong: arm 3 is beaten.",
            "Pulled arm 3: not a best one.",
            "Poor pull: arm 3.",
        ],
        "plain": [
            "Arm 3 was the wrong choice: some arm pays more on average.",
            "You pulled arm 3, which does not have the greatest expected reward. That was a mistake.",
            "Pulling arm 3 was not as good as it gets, for on average another is better.",
            "You did badly with arm 3. Its mean is exceeded by another.",
            "That was not a best arm: 3.",
        ],
    },
}


@pytest.mark.parametrize("claim", STATED)
@pytest.mark.parametrize("voice", ["plain", "curt", "warm", "socratic"])
def test_a_hedge_covers_a_statement_and_neither_comfort_nor_order_nor_question(voice, claim):
    phrasebook = FAMILIES["bandits"].phrasebook(voice)
    hedges = [phrase for phrase in phrasebook.templates(Probably) if phrase.partition("{")[0] in BARE]
    assert len(hedges) == (4 if voice == "curt" else 5)
    tone = load_tone(voice)
    frames = tone.frames.get(claim.kind, ["{sentence}"]) if tone and claim.kind is FP else ["{sentence}"]
    stated = STATED[claim]["curt" if voice == "curt" else "plain"]
    both = {
        frame.format(sentence=phrase.format(percent=80, text=text))
        for frame in frames
        for phrase in hedges
        for text in stated
    }
    hedged = hedge(claim, 0.8)
    assert set(phrasebook.sentences(hedged)) == both
    assert {atom.text for atom in say(phrasebook, [hedged] * 4000).atoms} == both
    (atom,) = say(phrasebook, [Late(claim=hedged, turn=1)]).atoms
    assert (atom.claim, atom.about_turn) == (hedged, 1)
    assert any(atom.text.endswith(text) for text in both)


BARE = {
    *("Probably (about ", "This is right with a probability of about ", "I am about "),
    *("There is a chance of about ", "", "Probably, ", "Chance "),
}
"""What stands before the probability in hedges without a frame."""


@pytest.mark.parametrize("voice", ["plain", "curt", "warm", "socratic"])
@pytest.mark.parametrize("name", FAMILIES)
def test_what_is_said_late_does_not_speak_of_now_if_it_can_be_said_without(name, voice):
    phrasebook, said = FAMILIES[name].phrasebook(voice), 0
    for cls, templates in phrasebook.items():
        if cls.kind is None or cls in (Late, Probably):
            continue
        without = [
            each for each in templates if not re.search(r"\b(now|here|at present)\b", re.sub(r"\{.*?\}", "", each))
        ]
        for each in real_claims(name).get(cls, ())[:1] if without else ():
            late = phrasebook.sentences(Late(claim=each, turn=1))
            values = {slot: getattr(each, slot) for slot in slots_of(cls)}
            own = {template.format(**values) for template in without}
            assert {sentence.partition(": ")[2] for sentence in late} <= own
            said += 1
    assert said > 2


def test_a_hedged_order_is_said_as_it_is_if_there_is_no_statement():
    wording = {"Hurry": ["Take {steps} steps.", "Do {steps}.", "Why not {steps}?", "Go, {steps} times."]}
    phrasebook = Phrasebook(wording, [Hurry], "words") | load_phrasebook(
        f"teachers.phrases:{BOOKS[0][0]}.toml", BOOKS[0][1]
    )
    assert len(phrasebook.sentences(hedge(Hurry(steps=3), 0.8))) == 5 * 4


def test_a_sentence_is_made_once_for_claims_that_come_again_and_not_for_ever():
    wording = ["{times} times {kind_of}", "{kind_of}: {times}", "{times}, {kind_of}", "so often: {times}, {kind_of}"]
    phrasebook = Phrasebook({"Turned": wording, "Steps": STEPS}, [Turned, Steps], "words")

    def sentence(number, cls=Turned):
        fields = {"times": number, "kind_of": FeedbackType.HP, "by": ()}
        said = cls(**(fields if cls is Turned else {"number": number, "place": "town"}))
        (atom,) = say(phrasebook, [said]).atoms
        assert atom.claim is said
        return atom.text

    first = sentence(1)
    assert sentence(1) is first
    assert sentence(1, Steps) is not sentence(1, Steps)
    for number in range(3000):
        assert str(number) in sentence(number)
    kept = [len(template.cache) for template in phrasebook._templates[Turned]]
    assert 0 < sum(kept) <= 1024
    assert sentence(1) == first


def test_a_template_caches_its_sentences():
    template = Template("{number} to {place}")
    assert template.format_cached("a key", Steps(number=3, place="town")) is template.cache["a key"] == "3 to town"
