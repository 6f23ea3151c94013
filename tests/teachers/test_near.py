"""Reading what people say: near the phrases it is read, and where it is ambiguous it is not."""

import re
import time
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llf_teacher.tools.reading import (
    LEFT_OUT,
    SENTENCES,
    Result,
    curve,
    labelled,
    read_left_out,
    read_sentences,
    score,
)
from pz_envs.family import own_families
from pz_envs.reading import make_reader
from teachers.near import Near, load_synonyms
from teachers.oracles.bandits import Pull
from teachers.reading import own_phrases
from teachers.schema import Vocabulary
from teachers.templates import Template

FAMILIES = {each.name: each for each in own_families()}
FILES = sorted((Path(__file__).parents[1] / "reading").glob("*.txt"))
FILE = Path(__file__).parents[1] / "reading" / "sentences.txt"
BANDITS, GRID, OPTIMIZATION, POEM = "bandits", "gridworld", "optimization", "poem"


@cache
def reader(name):
    """The reader of a family, which takes a second to make."""
    return make_reader(FAMILIES[name])


def read(name, text):
    return [(each.layer, each.claim and each.claim.__name__, each.slots) for each in reader(name).read(text)]


@pytest.mark.parametrize(
    ("name", "text", "layer", "claim", "slots"),
    [
        (BANDITS, "Pull arm 3 next.", "exact", "Pull", {"action": "3"}),
        (BANDITS, "go for arm three", "near", "Pull", {"action": "3"}),
        (BANDITS, "Please don't pull arm 3 next", "near", "Avoid", {"action": "3"}),
        (BANDITS, "The best arm is among those from 2 to 5", "near", "Among", {"low": "2", "high": "5"}),
        (GRID, "go esat now", "near", "Go", {"action": "east"}),
        (GRID, "go south now", "near", "Go", {"action": "south"}),
        (POEM, "Give seven syllables to line two.", "near", "Count", {"amount": "7 syllables", "line": "2"}),
        (
            OPTIMIZATION,
            "you did not lower the loss, it went from 4 to 6",
            "near",
            "Rose",
            {"before": "4", "after": "6"},
        ),
        (POEM, "Give 7 syllables to line 2.", "exact", "Count", {"amount": "7 syllables", "line": "2"}),
    ],
)
def test_numbers_order_spelling_and_synonyms_are_read(name, text, layer, claim, slots):
    assert read(name, text) == [(layer, claim, slots)]


def test_a_text_is_read_sentence_by_sentence():
    found = read(GRID, "Hello there. Go north next. What a day! You should not head west now. Which way is it?")
    assert found == [
        ("", None, {}),
        ("exact", "Go", {"action": "north"}),
        ("", None, {}),
        ("near", "Avoid", {"action": "west"}),
        ("", None, {}),
    ]


def test_what_is_ambiguous_is_not_read_and_has_candidates():
    (reading,) = reader(GRID).read("south or rather not")
    assert (reading.layer, reading.claim) == ("", None)
    assert "Avoid" in reading.candidates
    for text in ("go north or maybe not", "north is fine but 3 is a number", "go north and then east"):
        assert [each.claim for each in reader(GRID).read(text)] == [None], text


def test_a_word_that_turns_the_sense_is_never_overlooked():
    """Advice that is denied is not read as advice."""
    for phrase in FAMILIES["bandits"].phrasebook("plain").templates(Pull):
        for denied in ("Never: {}", "It would be wrong: {}", "{} Not!"):
            text = denied.format(Template(phrase).format(Pull(action=3)))
            assert reader(BANDITS)._near.read(text).claim != "Pull", text


@pytest.mark.parametrize("text", ["the loss rose from 5 to 3", "the loss fell from 3 to 5", "the loss rose, 5 and 5"])
def test_numbers_that_contradict_the_words_are_not_read(text):
    assert read(OPTIMIZATION, text) == [("", None, {})]


@pytest.mark.parametrize("name", FAMILIES)
def test_every_table_is_about_the_family(name):
    table = load_synonyms(name)
    classes = Vocabulary(FAMILIES[name].oracle_class().claims()).classes.values()
    slots = {name for cls in classes for slot in dir(cls) for name in (slot, f"{cls.__name__}.{slot}")}
    assert set(table.slots) <= slots
    ordered = {
        f"{claim}.{slot}" for pair, claims in table.less.items() for claim in claims for slot in pair.split(" < ")
    }
    assert ordered <= slots
    assert set(table.words) >= set(load_synonyms("none").words)
    assert all(others and word not in others for word, others in table.words.items())


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (BANDITS, "no hurry at all"),
        (BANDITS, "I once pulled arm 6 for a whole evening"),
        (GRID, "you will like it here"),
        (POEM, "a nice poem it is, with the sea and all"),
    ],
)
def test_what_states_nothing_is_not_read(name, text):
    assert read(name, text) == [("", None, {})]


DOUBTED = {
    "another person": "the other player should go south now",
    "saying": "a wise owl says go south now",
    "a supposition": "if you are tired, go south now",
    "another time": "yesterday: go south now",
    "irony": "wow, go south now, how clever",
    "taking back": "go south now, just kidding",
    "denial of a denial": "it isn't wrong to go south now",
    "about so much": "anything but go south now",
}


@pytest.mark.parametrize("kind", load_synonyms(GRID).doubts)
def test_a_sentence_with_a_doubt_is_not_read(kind):
    near = reader(GRID)._near
    assert kind in near._marks_of(DOUBTED[kind]) - near._marks_of("go south now")
    assert near.read("go south now").claim == "Go"
    assert near.read(DOUBTED[kind]).claim is None


def test_doubts_that_the_phrases_of_a_claim_have_are_none():
    """Praise that asks "Can you imagine ...?" would be read, if a phrase of its claim asked so."""
    classes = Vocabulary(FAMILIES[BANDITS].oracle_class().claims()).classes
    phrases = own_phrases(FAMILIES[BANDITS].phrasebook, classes)
    read = []
    for more in ([], ["Somebody should pull arm {action} now."]):
        near = Near(classes, {**phrases, "Pull": [*phrases["Pull"], *more]}, load_synonyms(BANDITS))
        read.append(near.read("someone should pull arm 3 now").claim)
    assert read == [None, "Pull"]


@pytest.mark.parametrize(
    ("name", "claim", "text", "turned"),
    [
        (GRID, "Within", "the treasure is within five moves", "the treasure is at least five moves away"),
        (GRID, "Within", "the treasure is within 5 moves", "the treasure is not within 5 moves"),
        (BANDITS, "NoMoreThan", "no arm pays more than 2 on average", "no arm pays less than 2"),
        (BANDITS, "NoMoreThan", "no arm pays more than 2 on average", "every arm pays more than 2"),
        ("parking", "Crashed", "you crashed the car", "you didn't crash the car"),
    ],
)
def test_bounds_and_truths_that_are_turned_round_are_not_read(name, claim, text, turned):
    near = reader(name)._near
    assert near.read(text).claim == claim
    assert near.read(turned).claim is None


@pytest.mark.parametrize(
    "text",
    [
        *("Liars tell you: Go west.", "Forget it: Go west.", "Go west. NOT", "Go west. Just kidding!"),
        *('They say "Go west."', '"Go west." is what they say.', '"Hello. Go west. Bye." Who said that?'),
        *("Go west. Go south. Only joking!", "Opposite day! Go west. Go south.", "Go west... or not.", "'Go west.'"),
    ],
)
def test_a_phrase_that_is_no_sentence_of_its_own_or_is_taken_back_is_not_read(text):
    assert {layer for layer, *_ in read(GRID, text)} == {""}


@pytest.mark.parametrize(
    "text",
    ["Go west. Go south.", "Hmm. Go west. Go south.", "Go west.\n- Well:\nGo south.", '"Hi" again! Go west. Go south.'],
)
def test_phrases_that_are_sentences_are_read(text):
    ways = [(layer, slots["action"]) for layer, claim, slots in read(GRID, text) if claim == "Go"]
    assert ways == [("exact", "west"), ("exact", "south")]


def test_sentences_that_state_nothing_keep_others_from_being_read_as_claims():
    """Of a family's, in all files, fewer are read than by a layer that has not learnt from such ones."""
    classes = Vocabulary(FAMILIES[BANDITS].oracle_class().claims()).classes
    phrases, table = own_phrases(FAMILIES[BANDITS].phrasebook, classes), load_synonyms(BANDITS)
    idle = [each.text for path in FILES for each in labelled(path) if (each.family, each.claim) == (BANDITS, None)]
    layers = (Near(classes, phrases, table._replace(nothing=nothing)) for nothing in (table.nothing, ()))
    learnt, other = (sum(near.read(text).claim is not None for text in idle) for near in layers)
    assert learnt < other


def test_nothing_is_learnt_from_the_files_that_measure():
    for name in FAMILIES:
        nothing = [_bare(text) for text in load_synonyms(name).nothing]
        assert len(nothing) == len({*nothing}) >= len(load_synonyms("none").nothing) > 0  # more with a table of its own
        assert not {*nothing} & {_bare(each.text) for path in FILES for each in labelled(path) if each.family == name}


def _bare(text):
    return " ".join(re.findall(r"\w+", text.lower()))


@settings(max_examples=60)
@given(
    st.text(max_size=200)
    | st.lists(
        st.sampled_from(["not", "arm", "pull", "3", "3.5", "[1]", '"', "`", "best", "-", "from", "to", "one"])
    ).map(" ".join)
)
def test_any_text_is_read_without_an_error(text):
    for each in reader(BANDITS).read(text):
        assert (each.layer == "") == (each.claim is None)


def test_long_texts_take_little_time():
    for text in ("arm 3 " * 5_000, "3 " * 10_000, "a. " * 1_000, '"' * 30_000, "[" * 30_000):
        began = time.perf_counter()
        reader(BANDITS).read(text)
        assert time.perf_counter() - began < 8, text[:10]


def test_sentences_of_people_are_read_right_or_not_at_all():
    """416 of them, a third of which says nothing that can be checked."""
    sentences = list(labelled(FILE))
    assert len(sentences) >= 400
    assert len({each.family for each in sentences}) == 8
    assert sum(each.claim is None for each in sentences) >= len(sentences) / 3
    for each in sentences:
        vocabulary = Vocabulary(FAMILIES[each.family].oracle_class().claims())
        assert each.claim is None or each.claim in vocabulary.classes, each
    found = score(read_sentences(sentences, FAMILIES))
    assert found.precision[1] >= 0.95
    assert found.recall >= 0.5


def test_phrases_that_are_left_out_are_read_right_or_not_at_all():
    """In two families here; `llf dev reading` measures all of them."""
    results = [each for name in ("bandits", "gridworld") for each in read_left_out(FAMILIES[name], turns=60)]
    assert len(results) > 300
    assert {each.what for each in results} == {LEFT_OUT}
    found = score(results)
    assert found.precision[0] >= 0.99
    assert found.recall >= 0.6


def test_a_score_counts_what_is_read_wrong():
    right = Result(SENTENCES, "x", "near", "Go", "Go", True, "")
    wrong, missed, idle = (
        right._replace(read="No", right=False),
        right._replace(layer="", right=False),
        right._replace(stated="", layer="", read="", right=False),
    )
    found = score([right, right, wrong, missed, idle])
    assert (found.stating, found.read, found.right, found.recall) == (4, 3, 2, 0.5)
    assert found.precision[0] == pytest.approx(2 / 3)
    assert found.precision[1] < 0.2


def test_a_bad_line_is_refused(tmp_path):
    (tmp_path / "s.txt").write_text("[bandits]\nPull action | go\n")
    with pytest.raises(ValueError, match=r"line 2 must be `CLAIM slot=value; ... \| sentence`, got 'Pull action"):
        list(labelled(tmp_path / "s.txt"))


def test_a_lead_is_chosen_by_the_phrases_of_other_families():
    """All of y's phrases are right from 0.1 on; the clearest one of x is wrong, so that none of y's is read."""

    def left_out(family, lead, right):
        return Result(LEFT_OUT, family, "near", "Go", "Go", right, "", lead, f"{family} {lead}")

    x = [left_out("x", 0.9, False), left_out("x", 0.5, True), left_out("x", 0.05, True)]
    y = [left_out("y", lead, True) for lead in (0.8, 0.4, 0.1)]
    (row,) = zip(*(column.cells for column in curve([*x, *y], [0.99]).columns), strict=True)
    assert row == ("0.99", "0.100 to inf", "2", "1", "0.500", "0.167")
