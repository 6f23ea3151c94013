"""Voices change the words and never the claims; what a rewriting voice does to numbers and names is reported."""

import copy
import pickle
import string
from functools import cache

import numpy as np
import pytest
from lessons import episodes, pupil
from shelf import COMPLETE, FAMILIES, RICH

from teachers.atoms import HN, HP, Claim, claim
from teachers.common import Reward, Right, Solved, TryAgain
from teachers.oracles.gridworld.claims import Go, NoNearer
from teachers.personality import PERSONALITIES
from teachers.phrasebook import Draws, Phrasebook, Rewriting, make_phrasebook
from teachers.voice import Tone, compare, load_tone, voice_names
from worlds.gridworld import Direction

VOICES = voice_names()
EXCITED = """
[frames]
hp = ["{sentence} Hooray!", "Hooray! {sentence}", "{sentence} Yes!", "Yes! {sentence}"]

[phrases]
TryAgain = ["Again! Again!", "Once more! Yes!", "Try again! Hooray!", "Not solved! Again!"]
"""


@cache
def heard(name, voice, spec="elaborator | mistake(eps=0.2) | delayed", turns=60, instruction_type="p"):
    teacher = pupil(name).make_teacher(pupil(name).make_world(), spec, voice=voice, instruction_type=instruction_type)
    rng = np.random.default_rng(0)
    said = []
    for moments in episodes(name, turns):
        teacher.reset(rng.spawn(1)[0])
        said += [teacher.speak(moment) for moment in moments]
    return said


def shout(sentence):
    return sentence.upper()


def test_the_voices_of_the_shelf():
    assert VOICES == ("plain", "curt", "socratic", "warm")


@pytest.mark.parametrize("voice", [*VOICES, shout], ids=lambda voice: getattr(voice, "__name__", voice))
@pytest.mark.parametrize("name", RICH)
def test_a_voice_never_changes_which_claims_are_made(name, voice):
    for said, plain in zip(heard.__wrapped__(name, voice), heard(name, "plain"), strict=True):
        assert [(a.claim, a.about_turn) for a in said.atoms] == [(a.claim, a.about_turn) for a in plain.atoms]
        assert said == " ".join(atom.text for atom in said.atoms)
        assert not [atom for atom in said.atoms if "{" in atom.text]


@pytest.mark.parametrize("name", FAMILIES)
def test_every_voice_words_every_claim_with_all_its_slots(name):
    plain = FAMILIES[name].phrasebook()
    for voice in VOICES[1:]:
        toned = FAMILIES[name].phrasebook(voice)
        assert [cls for cls, _ in toned.items()] == [cls for cls, _ in plain.items()]
        for _, templates in toned.items():
            assert len(set(templates)) == len(templates) >= 2
        for one, other in zip(toned._templates.values(), plain._templates.values(), strict=True):
            assert {field for t in one for field in names(t)} == {field for t in other for field in names(t)}


def names(template):
    return {field for _, field, _, _ in string.Formatter().parse(template.source) if field}


@pytest.mark.parametrize("name", COMPLETE)
def test_voices_sound_as_they_are_called(name):
    words = {voice: np.mean([len(said.split()) for said in heard(name, voice, "oracle")[1:]]) for voice in VOICES}
    assert words["curt"] < 0.95 * words["plain"] < words["warm"]
    for said in heard(name, "socratic", "only(kinds='hp+hn+fp+fn')", instruction_type="b"):
        assert all("?" in atom.text for atom in said.atoms if atom.kind is not None)


@pytest.mark.parametrize("voice", VOICES)
def test_instructions_are_the_same_in_every_voice_that_has_no_words_for_them(voice):
    for name in FAMILIES:
        said, plain = heard(name, voice, "silent")[0], heard(name, "plain", "silent")[0]
        own = [atom for atom in said.atoms if atom.kind is None and voice != "curt"]
        assert [atom.text for atom in own] == [atom.text for atom in plain.atoms if atom.kind is None and own]


def test_a_paraphrase_index_counts_the_templates_of_the_voice():
    book = FAMILIES["gridworld"].phrasebook("warm")
    templates = book.templates(Go)
    plain = FAMILIES["gridworld"].phrasebook().templates(Go)
    assert len(templates) == len(plain) * len(load_tone("warm").frames[Go.kind])
    for i in (0, 7, len(templates) + 1):
        said = book.say([Go(action=Direction.EAST)], 1, Draws(np.random.default_rng(0)), i)
        assert said == templates[i % len(templates)].format(action="east")


def test_a_voice_of_ones_own_is_a_file(tmp_path):
    path = tmp_path / "excited.toml"
    path.write_text(EXCITED)
    said = heard("gridworld", str(path), "only(kinds='hp+hn') | retry_only")
    assert {str(each) for each in said[1:]} - {""} <= {*load_tone(path).phrases["TryAgain"], *map(str, said)}
    texts = [atom for each in heard("gridworld", path, "only(kinds='hp+hn')") for atom in each.atoms]
    texts = [atom for atom in texts if not atom.claim.tried]
    assert all(("Hooray!" in atom.text or "Yes!" in atom.text) == (atom.kind is HP) for atom in texts)
    assert {atom.kind for atom in texts} == {None, HP, HN}
    path.write_text(EXCITED.replace("Hooray!", "Great!"))
    assert any("Great!" in atom.text for each in heard("gridworld", path) for atom in each.atoms)


@claim
class Steps(Claim):
    """True if it takes so many."""

    kind = HN
    number: int


STEPS = ["{number} steps", "steps: {number}", "it takes {number} long steps", "{number} it is"]


def test_a_family_may_have_words_of_its_own_for_a_voice():
    own = ["{number}!", "{number}.", "({number})", "{number}..."]
    book = make_phrasebook({"plain": {"Steps": STEPS}, "curt": {"Steps": own}}, [Steps], "curt")
    assert book.templates(Steps) == tuple(own)
    book = make_phrasebook({"plain": {"Steps": STEPS}}, [Steps], "curt")
    assert book.templates(Steps) == ("{number} steps", "steps: {number}")
    book = make_phrasebook({Steps: STEPS}, [Steps], "warm")
    assert "Don't worry about it. {number} steps" in book.templates(Steps)


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ({"Steps": ["yes", "no", "so", "ay"]}, r"bad phrases in .* \[curt\]:\n  Steps: its slots must be number"),
        ({"Steps": ["{number}"]}, r"bad phrases in .* \[curt\]:\n  Steps: has 1 paraphrases"),
        ({"Stops": STEPS}, r"bad phrases in .* \[curt\]:\n  Stops: there is no claim of this name"),
    ],
)
def test_own_words_are_checked(own, message):
    with pytest.raises(ValueError, match=message):
        make_phrasebook({"plain": {"Steps": STEPS}, "curt": own}, [Steps], "curt")


def test_one_error_lists_all_that_is_wrong_with_a_voice(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(
        'shortest = 0\ncolour = "red"\n[frames]\nhq = ["{sentence}", "a {sentence}", "b {sentence}", "c {sentence}"]\n'
        'hp = ["{sentence}", "{sentence}", "no", "{sentence} {x}"]\nhn = ["{sentence}"]\nfp = "so"\n'
    )
    with pytest.raises(ValueError, match="bad voice in") as raised:
        load_tone(path)
    problems = str(raised.value)
    for problem in (
        "colour: allowed are shortest, frames, phrases",
        "shortest: must be an integer from 1 to 20, got 0",
        "frames.hq: is no kind of feedback; allowed: r, hp, hn, fp, fn",
        "frames.hp: 'no' must have the slot {sentence} once, and no other",
        "frames.hp: '{sentence} {x}' must have the slot {sentence} once, and no other",
        "frames.hp: '{sentence}' comes twice",
        "frames.hn: has 1 frames; allowed: 4 to 20",
        "frames.fp: must be a list of strings",
    ):
        assert problem in problems


@pytest.mark.parametrize(
    ("voice", "message"),
    [
        ("gruff", "unknown voice 'gruff'; allowed: plain, curt, socratic, warm, the path"),
        ("nowhere.toml", "cannot read the voice nowhere.toml: "),
    ],
)
def test_a_voice_that_is_not_there(voice, message):
    with pytest.raises(ValueError, match=message):
        FAMILIES["gridworld"].phrasebook(voice)


def test_a_broken_file_is_no_voice(tmp_path):
    (tmp_path / "v.toml").write_text("= 5")
    with pytest.raises(ValueError, match=r"cannot read the voice .*v\.toml: "):
        load_tone(tmp_path / "v.toml")


def test_a_voice_with_a_byte_order_mark_is_read(tmp_path):
    (tmp_path / "v.toml").write_text("shortest = 2\n", encoding="utf-8-sig")
    assert load_tone(tmp_path / "v.toml").shortest == 2


def rewriting(voice):
    return Rewriting(FAMILIES["gridworld"].phrasebook(), voice)


def say(book, *claims):
    return book.say(claims, 3, Draws(np.random.default_rng(0)), 0)


def test_a_rewriting_voice_gets_each_sentence_of_feedback_and_no_instruction():
    asked = []
    heard("gridworld", lambda sentence: asked.append(sentence) or sentence, "oracle", 20)
    plain = [atom.text for said in heard("gridworld", "plain", "oracle", 20) for atom in said.atoms if atom.kind]
    assert asked == plain


@pytest.mark.parametrize(
    ("before", "after", "vanished", "appeared"),
    [
        ("Go north next.", "Next, please go North.", (), ()),
        ("Go north next.", "Go on.", ("north",), ()),
        ("Go north next.", "Go north, not south.", (), ("south",)),
        ("Going north from hall-2 was bad.", "Going north from there was bad.", ("hall-2",), ()),
        ("Going north from hall-2 was bad.", "Going north from hall-3 was bad.", ("hall-2",), ("hall-3",)),
        ("That earned you 0.5.", "You got 0.50 points.", (), ()),
        ("That earned you 0.5.", "You got half a point.", ("0.5",), ()),
        ("That earned you -0.5.", "You got 0.5 in turn 3.", ("-0.5",), ("0.5", "3")),
        ("Take 1, then 1e3.", "First 1; 1000 after that.", (), ()),
        ("All is well.", "All is well, says Socrates. I'd agree.", (), ("Socrates",)),
    ],
)
def test_numbers_and_names_that_vanish_or_appear_are_found(before, after, vanished, appeared):
    said = NoNearer(action=Direction.NORTH, room="hall-2")
    assert compare(said, before, after) == (vanished, appeared)


def test_changes_are_those_of_the_last_utterance():
    book = rewriting(lambda sentence: sentence.replace("0.5", "some").replace("east", "west"))
    said = say(book, Reward(reward=0.5), TryAgain(), Go(action=Direction.EAST))
    assert [(change.vanished, change.appeared) for change in book.changes] == [(("0.5",), ()), (("east",), ("west",))]
    assert book.changes[1].before == "Go east next."
    assert book.changes[1].after == "Go west next." == said.atoms[2].text
    assert [atom.claim for atom in said.atoms] == [Reward(reward=0.5), TryAgain(), Go(action=Direction.EAST)]
    say(book, TryAgain())
    assert book.changes == ()


def test_nothing_left_of_a_sentence_is_no_way_to_say_it():
    book = rewriting(lambda sentence: " ")
    assert say(book, TryAgain()) == "That was not it. Try again."
    assert book.changes[0].after == ""


def test_rewriting_teachers_can_be_copied():
    book = rewriting(shout)
    say(book, Solved())
    for twin in (copy.deepcopy(book), pickle.loads(pickle.dumps(book))):
        assert say(twin, Solved()) == say(book, Solved())
    assert copy.deepcopy(book) is not book


def test_tones_are_values():
    assert isinstance(load_tone("warm"), Tone)
    assert load_tone("plain") is None
    assert type(FAMILIES["gridworld"].phrasebook("warm")) is Phrasebook
    assert "Right" in load_tone("curt").phrases
    assert Right.kind is HP
    assert "oracle" in PERSONALITIES.names
