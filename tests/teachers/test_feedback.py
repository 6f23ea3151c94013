"""Feedback types: what may be asked for, and the random subsets of `m`."""

import pickle
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare

import llf_teacher
from teachers.atoms import FN, FP, HN, HP, KINDS, FeedbackType, R
from teachers.common import MayAsk, Truism
from teachers.feedback import draw_kinds, format_kinds, number_of, of_subset, parse_kinds, subset_of
from teachers.personality import parse_personality, personality

kind_sets = st.sets(st.sampled_from(KINDS))


@pytest.mark.parametrize(
    ("feedback_type", "kinds", "text"),
    [
        ("a", set(KINDS), "a"),
        ("m", set(KINDS), "m"),
        ("n", set(), "n"),
        ("r", {R}, "r"),
        ("hp", {HP}, "hp"),
        ("fn+r", {R, FN}, "r+fn"),
        ("fn+fp+hn+hp+r", set(KINDS), "r+hp+hn+fp+fn"),
        ("hp+hp", {HP}, "hp"),
        (["fp", "hn"], {HN, FP}, "hn+fp"),
        (("r",), {R}, "r"),
        ({"fn", "hp"}, {HP, FN}, "hp+fn"),
        (frozenset((FP, "r")), {R, FP}, "r+fp"),
        ([], set(), "n"),
        (set(), set(), "n"),
        (FN, {FN}, "fn"),
    ],
)
def test_feedback_types_are_understood(feedback_type, kinds, text):
    parsed = parse_kinds(feedback_type)
    assert parsed == kinds
    assert all(type(kind) is FeedbackType for kind in parsed)
    assert format_kinds(feedback_type) == text


@given(kind_sets)
def test_kinds_round_trip(kinds):
    assert parse_kinds(format_kinds(kinds)) == kinds
    assert format_kinds([str(kind) for kind in kinds]) == format_kinds(kinds)
    assert format_kinds(format_kinds(kinds)) == format_kinds(kinds)


@given(kind_sets)
def test_a_subset_keeps_its_kinds_and_all_notices(kinds):
    notice, claims = MayAsk(cost=0.5), [Truism(kind=kind, fact="ice is cold") for kind in KINDS]
    kept = of_subset([notice, *claims], number_of(kinds))
    assert kept == [notice, *(claim for claim in claims if claim.kind in kinds)]
    assert subset_of(kept) == number_of(kinds)


@pytest.mark.parametrize(
    ("feedback_type", "named"),
    [
        ("", "''"),
        ("x", "'x'"),
        ("R", "'R'"),
        ("r+", "''"),
        ("r + hp", "'r '"),
        ("r,hp", "'r,hp'"),
        ("r+a", "'a'"),
        (["a"], "'a'"),
        (["r", None], "None"),
        (["r+hp"], r"'r\+hp'"),
        ([["r"]], r"\['r'\]"),
    ],
)
@pytest.mark.parametrize("function", [parse_kinds, format_kinds])
def test_wrong_names_are_named(function, feedback_type, named):
    with pytest.raises(ValueError, match=rf"names {named}; allowed: 'a' \(all\), .* r, hp, hn, fp, fn"):
        function(feedback_type)


@pytest.mark.parametrize("feedback_type", [None, 5, True, {"r": 1}, b"r", (kind for kind in KINDS)])
def test_other_types_are_refused(feedback_type):
    with pytest.raises(ValueError, match=r"is not supported; allowed: 'a' \(all\)"):
        parse_kinds(feedback_type)


@pytest.mark.parametrize("kinds", [{R}, {HP, FN}, {R, HN, FP}, set(KINDS)], ids=format_kinds)
def test_every_non_empty_subset_is_drawn_equally_often(kinds):
    rng = np.random.default_rng(0)
    subsets = [frozenset(chosen) for size in range(1, 6) for chosen in combinations(sorted(kinds), size)]
    counts = dict.fromkeys(subsets, 0)
    for _ in range(200 * len(subsets)):
        counts[draw_kinds(kinds, rng)] += 1
    assert chisquare(list(counts.values())).pvalue > 1e-3 or len(subsets) == 1


def test_of_nothing_nothing_is_drawn():
    assert draw_kinds(frozenset(), np.random.default_rng(0)) == frozenset()


@given(kinds=st.lists(st.sampled_from(KINDS), min_size=1, unique=True), seed=st.integers(0, 2**32))
def test_draws_depend_on_the_seed_and_not_on_the_order_of_the_set(kinds, seed):
    drawn = [draw_kinds(set(order), np.random.default_rng(seed)) for order in (kinds, kinds[::-1])]
    assert drawn[0] == drawn[1]
    assert drawn[0]
    assert drawn[0] <= set(kinds)


def test_a_kind_is_its_code_and_its_word():
    for kind, word in zip(KINDS, ("reward", "praise", "blame", "advice", "warning"), strict=True):
        assert kind.word == word
        assert kind == word == kind
        assert kind == kind.value
        assert word == kind
        assert kind in ("nothing", word)
        assert FeedbackType(word) is kind
        assert (kind != word) is False
        assert [other for other in KINDS if other == word] == [kind]
        assert (str(kind), f"{kind}", hash(kind)) == (kind.value, kind.value, hash(kind.value))
        assert pickle.loads(pickle.dumps(kind)) is kind
    assert HP != "prais"
    assert HP != 1
    assert format_kinds("praise+warning") == "hp+fn" == format_kinds({"praise", "fn"})


def test_a_personality_may_know_kinds_by_words():
    @personality()
    def blunt(claims, view):
        """Says what was bad."""
        return [claim for claim in claims if claim.kind == "blame"]

    said = []
    for teacher in (blunt(), "only(kinds='blame')", "only(kinds='hn')"):
        env = llf_teacher.make("llf-gridworld-v0", teacher=teacher, feedback_type="a")
        env.reset(seed=7)
        said.append([env.step(action)[0]["feedback"] for action in (3, 2, 0, 1)])
    assert said[0] == said[1] == said[2]
    assert any(said[0])
    assert f"{parse_personality('only(kinds=' + repr('praise+blame') + ')')}" == "only(kinds='hp+hn')"
