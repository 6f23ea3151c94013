"""Sentences that are word for word a phrase are read, and no others."""

import time
from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pz_envs.family import own_families
from pz_envs.text.claim_building import make_reader
from pz_envs.text.phrases import read_sentences
from teachers.common import Probably
from teachers.oracles.bandits import Pull
from teachers.oracles.gridworld import Go
from teachers.templates import Template
from worlds.gridworld import Direction

FAMILIES = {each.name: each for each in own_families()}
BANDITS, GRID, POEM = "bandits", "gridworld", "poem"


@cache
def reader(name):
    return make_reader(FAMILIES[name])


def read(name, text):
    return [(each.claim and each.claim.__name__, each.slots) for each in read_sentences(reader(name).anew(), text)]


@pytest.mark.parametrize(
    ("name", "text", "claim", "slots"),
    [
        (BANDITS, "Pull arm 3 next.", "Pull", {"action": "3"}),
        (POEM, "Give 7 syllables to line 2.", "Count", {"amount": "7 syllables", "line": "2"}),
        *((BANDITS, text, None, {}) for text in ("go for arm three", "keep your hands off arm 2", "pull arm 3 next")),
        *((GRID, text, None, {}) for text in ("Head south now.", "go esat now", "go west, probably")),
    ],
)
def test_only_phrases_are_read(name, text, claim, slots):
    assert read(name, text) == [(claim, slots)]


def test_a_text_is_read_sentence_by_sentence():
    found = read(GRID, "Hello there. Go north next. What a day! You should not head west now. Which way is it?")
    assert found == [(None, {}), ("Go", {"action": "north"}), (None, {}), (None, {}), (None, {})]


def test_a_word_that_turns_the_sense_is_never_overlooked():
    """Advice that is denied is not read as advice."""
    for phrase in FAMILIES[BANDITS].phrasebook("plain").templates(Pull):
        for denied in ("Never: {}", "It would be wrong: {}", "{} Not!"):
            text = denied.format(Template(phrase).format(Pull(action=3)))
            assert "Pull" not in [claim for claim, _ in read(BANDITS, text)], text


def test_what_is_hedged_by_a_phrase_is_read_as_hedged():
    hedged = next(phrase for phrase in FAMILIES[GRID].phrasebook().templates(Probably) if phrase.endswith("{text}"))
    (found,) = read_sentences(reader(GRID).anew(), hedged.format(percent=80, text="Go west."))
    assert (found.claim, found.hedged) == (Go, True)


def test_what_leads_to_a_phrase_may_take_it_back():
    (phrase, *_) = FAMILIES[GRID].phrasebook("plain").templates(Go)
    text = Template(phrase).format(Go(action=Direction.WEST))
    for before in ("Never listen when I say: ", "Do not do this: ", "Wrong: "):
        assert "Go" not in [claim for claim, _ in read(GRID, before + text)]
    assert read(GRID, f"Look. {text}")[1:] == [("Go", {"action": "west"})]


@pytest.mark.parametrize(
    "text",
    [
        *("Liars tell you: Go west.", "Forget it: Go west.", "Go west. NOT", "Go west. Just kidding!"),
        *('They say "Go west."', '"Go west." is what they say.', '"Hello. Go west. Bye." Who said that?'),
        *("Go west. Go south. Only joking!", "Opposite day! Go west. Go south.", "Go west... or not.", "'Go west.'"),
        *("Go west. I didn't mean that.", "Go west. That is not true.", "Go west. On second thought, wait."),
    ],
)
def test_a_phrase_that_is_no_sentence_of_its_own_or_is_taken_back_is_not_read(text):
    assert {claim for claim, _ in read(GRID, text)} == {None}


@pytest.mark.parametrize(
    "text",
    ["Go west. Go south.", "Hmm. Go west. Go south.", "Go west.\n- Well:\nGo south.", '"Hi" again! Go west. Go south.'],
)
def test_phrases_that_are_sentences_are_read(text):
    assert [slots["action"] for claim, slots in read(GRID, text) if claim == "Go"] == ["west", "south"]


@settings(max_examples=60)
@given(
    st.text(max_size=200)
    | st.lists(
        st.sampled_from(["not", "Pull arm", "3", "3.5", "[1]", '"', "`", "next.", "-", "from", "to", "one"])
    ).map(" ".join)
)
def test_any_text_is_read_without_an_error(text):
    for each in read_sentences(reader(BANDITS).anew(), text):
        assert each.claim is not None or not each.slots


def test_long_texts_take_little_time():
    for text in ("arm 3 " * 5_000, "Pull arm 3. " * 1_000, "3 " * 10_000, "a. " * 1_000, '"' * 30_000, "[" * 30_000):
        began = time.process_time()
        read(BANDITS, text)
        assert time.process_time() - began < 8, text[:10]
