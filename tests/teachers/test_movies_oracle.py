"""The movies' oracle: each title is judged by each wish, and everything said holds, of any list."""

import json

import numpy as np
import pytest
from catalogues import write_catalogue
from design import amount
from hypothesis import given, settings
from hypothesis import strategies as st

import llf_teacher
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.execution.episode import play
from teachers.atoms import FN, FP, HN, HP, Moment
from teachers.oracles.movies import MoviesOracle
from teachers.oracles.movies.claims import (
    AllFit,
    Ambiguous,
    AttributeFits,
    AttributeMisses,
    AvoidTitle,
    AvoidTrait,
    Fits,
    Nothing,
    NotInCatalogue,
    OthersFit,
    OthersMiss,
    Recommend,
    Repeat,
    Seek,
    SpeltLike,
    TakenFor,
    Unrated,
    Wish,
)
from worlds.movies import AGE, GENRE, TYPE, YEAR, Movies, Profile, Truth, draw_profile
from worlds.movies.catalogue import GENRES, load_catalogue

ID = "llf-reco-movie-v0"
COMEDY = GENRES.index("Comedy")
LABELS = [item.label for item in load_catalogue().items]


def judged(profile, titles, number=1, world=None):
    """The oracle, the moment after a list of titles, and its claims, all of which hold."""
    world = world or Movies()
    lab = world.scratch()
    truth = Truth(profile, TYPE, (0, 0), "")
    oracle = MoviesOracle(world.scratch)
    oracle.start(truth)
    world.restore(truth)
    action = world.legal(json.dumps(titles))
    _, reward, _, _, info = world.step(action)
    moment = Moment(truth, action, reward, world.truth, info["success"], number, False)
    claims = oracle.judge(moment)
    assert [claim for claim in claims if not claim.holds(moment, lab)] == []
    return oracle, moment, claims


def hindsight(profile, *titles):
    return [claim for claim in judged(profile, titles)[2] if claim.kind in (HP, HN)]


def test_each_attribute_is_judged():
    said = hindsight(Profile(False, (1,), (COMEDY,), 1), "The Matrix", "Frasier")
    assert said == [
        AttributeFits(item=1, title="The Matrix", attribute=TYPE, found="movie"),
        AttributeFits(item=1, title="The Matrix", attribute=YEAR, found="1999"),
        AttributeFits(item=2, title="Frasier", attribute=YEAR, found="1993 to 2004"),
        AttributeFits(item=2, title="Frasier", attribute=GENRE, found="Comedy"),
        AttributeFits(item=2, title="Frasier", attribute=AGE, found="TV-PG"),
        AttributeMisses(item=1, title="The Matrix", attribute=GENRE, found="Action and Sci-Fi", wanted="Comedy"),
        AttributeMisses(item=1, title="The Matrix", attribute=AGE, found="R", wanted="family-friendly"),
        AttributeMisses(item=2, title="Frasier", attribute=TYPE, found="TV show", wanted="movie"),
    ]


@pytest.mark.parametrize(
    ("titles", "said"),
    [
        (["The Matrix"], [AllFit()]),
        (["the matrix", "Jaws (1975)"], [AllFit()]),
        (["Jurrasic Park"], [AllFit(), TakenFor(item=1, said="Jurrasic Park", title="Jurassic Park")]),
        (
            ["Star Wars"],
            [AllFit(), TakenFor(item=1, said="Star Wars", title="Star Wars: Episode IV - A New Hope")],
        ),
        ([], [Nothing()]),
        (["Jaws", "Gone Badly"], [Fits(item=1, title="Jaws"), NotInCatalogue(item=2, said="Gone Badly")]),
        (["Vertigu"], [SpeltLike(item=1, said="Vertigu", title="Vertigo")]),
        (["Jaws (1990)"], [NotInCatalogue(item=1, said="Jaws (1990)")]),
        (
            ["Aladdin"],
            [Ambiguous(item=1, said="Aladdin", count=2, works=("Aladdin (1992)", "Aladdin (2019)"))],
        ),
    ],
    ids=str,
)  # fmt: skip
def test_existence_is_judged(titles, said):
    assert hindsight(Profile(False), *titles) == said


@pytest.mark.parametrize(
    ("said", "means"),
    [
        ("IF(2024)", TakenFor),
        ("Heat ( 1995 )", TakenFor),
        ("Friends (1994\u20132004)", AttributeMisses),
        ("The Women (20088)", NotInCatalogue),
        ("ZeroZZeroZero", TakenFor),
        ("An Pan (2015)", SpeltLike),
    ],
)
def test_what_is_said_of_unusual_spellings_holds(said, means):
    assert means in {type(claim) for claim in judged(Profile(False), [said])[2]}


def test_what_is_joined_by_a_hyphen_is_no_article():
    assert {each.title for each in judged(Profile(False), ["An-Man"])[2] if type(each) is SpeltLike} == {"Ant-Man"}


def test_every_title_of_a_long_list_is_told_of():
    said = hindsight(Profile(True, (0,), (COMEDY,), 0), *LABELS[:100])
    assert {claim.item for claim in said} == set(range(1, 101))


@pytest.mark.parametrize("most", [0, 1, 2, 5])
def test_titles_behind_max_items_are_counted(most):
    """Of five titles three fit; nothing is left out without a word."""
    titles = ["Jaws", "Friends", "The Matrix", "Turnip Season", "Psycho (1960)"]
    said = judged(Profile(False), titles, world=Movies(max_items=most))[2]
    told = [claim for claim in said if claim.kind in (HP, HN)]
    assert {claim.item for claim in told if hasattr(claim, "item")} == set(range(1, most + 1))
    fit, behind = {0: 3, 1: 2, 2: 2, 5: 0}[most], 5 - most
    counted = [OthersFit(first=most + 1, count=fit, total=behind)] if fit else []
    counted += [OthersMiss(first=most + 1, count=behind - fit, total=behind)] if behind > fit else []
    assert [claim for claim in told if not hasattr(claim, "item")] == counted


def test_advice_replaces_the_first_title_that_does_not_fit():
    profile = Profile(False)
    _, moment, claims = judged(profile, ["Jaws", "Friends", "Frasier"])
    (advice,) = (claim for claim in claims if claim.kind == FP)
    titles = json.loads(advice.action)
    assert type(advice) is Recommend
    assert titles == ["Jaws", advice.title, "Frasier"]
    assert advice.title != "Jaws"
    assert claims[-1] == AvoidTitle(title="Friends")
    lab = Movies()
    assert not AvoidTitle(title="Jaws").holds(moment, lab)
    assert not Recommend(action='["Friends"]', title="Friends").holds(moment, lab)
    assert [claim.holds(moment, lab) for claim in advice.coarser(moment, lab)] == [True]
    assert advice.coarser(moment, lab) == (Seek(attribute=TYPE, wish="movie"),)
    assert not Seek(attribute=TYPE, wish="TV show").holds(moment, lab)


def test_a_list_that_fits_is_to_be_repeated():
    _, moment, claims = judged(Profile(False, (1,), age=1), ["Toy Story"])
    assert claims[-2] == Repeat(action='["Toy Story"]')
    traits = {judged(Profile(False, (1,), age=1), ["Toy Story"], number)[2][-1] for number in range(20)}
    assert AvoidTrait(attribute=TYPE, trait="TV show") in traits
    assert AvoidTrait(attribute=AGE, trait="R") in traits
    assert AvoidTrait(attribute=YEAR, trait="the 80s") in traits
    assert not AvoidTrait(attribute=AGE, trait="PG").holds(moment, Movies())
    assert not AvoidTrait(attribute=YEAR, trait="the 90s").holds(moment, Movies())


def test_an_unknown_rating_is_said_to_be_unknown(tmp_path):
    world = Movies(catalogue=str(write_catalogue(tmp_path / "big.db", genres=())))
    truth = Truth(Profile(False, age=0), TYPE, (0, 0), "")
    world.restore(truth)
    _, reward, _, _, _ = world.step('["Film 3"]')
    moment = Moment(truth, '["Film 3"]', reward, world.truth, False, 1, False)
    oracle = MoviesOracle(world.scratch)
    oracle.start(truth)
    claims = oracle.judge(moment)
    (unrated,) = (claim for claim in claims if type(claim) is Unrated)
    assert unrated == Unrated(item=1, title="Film 3", wanted="child-friendly")
    assert FP not in {claim.kind for claim in claims}  # nothing fits, so that nothing can be recommended
    assert oracle.plan(truth, 2) == ()
    assert all(claim.holds(moment, world.scratch()) for claim in claims)
    assert not [claim for claim in unrated.counterparts(moment, world) if claim.holds(moment, world)]
    plain = judged(Profile(False, (0,)), ["Film 3", "Film 30"], world=world)[2]
    assert AttributeMisses(item=2, title="Film 30", attribute=YEAR, found="2010", wanted="the 80s") in plain


titles = st.one_of(
    st.sampled_from(LABELS),
    st.sampled_from(LABELS).map(lambda label: label[1:] or "x"),
    st.sampled_from(["Aladdin", "Footloose", "the lion king", "The Lion Kng", "Jaws (1976)", "Jaws (1990)", "The"]),
    st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1, max_size=30),
    st.sampled_from(['a "quoted" one', "%s {0}", "(1999)", "x (20", "'", "\u0301", "; ", " or "]),
)


@given(seed=st.integers(0, 10_000), said=st.lists(titles, max_size=8), number=st.integers(1, 40))
@settings(deadline=None, max_examples=150)
def test_what_is_said_of_any_list_holds_and_its_advice_helps(seed, said, number):
    rng = np.random.default_rng(seed)
    catalogue = load_catalogue()
    profile = next(p for p in iter(lambda: draw_profile(rng), None) if len(catalogue.fitting(p.wishes.values())) >= 3)
    oracle, moment, claims = judged(profile, [title for title in said if title.strip()], number)
    (advice,) = (claim for claim in claims if claim.kind == FP)
    (warning,) = (claim for claim in claims if claim.kind == FN)
    assert isinstance(warning, AvoidTitle | AvoidTrait)
    world = Movies()
    world.restore(moment.after)
    assert world.step(advice.action)[1] > moment.reward or moment.success
    for claim in claims:
        false = oracle.distort(claim, moment, rng)
        assert false is None or not false.holds(moment, world)


@pytest.mark.parametrize("student", ["obedient", "text_only"])
def test_students_who_listen_succeed_within_ten_turns(student):
    """In at least 95 % of many episodes."""
    specs = [EpisodeSpec(ID, "oracle", student, "b", "a", 10, seed, "") for seed in range(amount(40, full=80))]
    firsts = [play(spec).episode.first_success for spec in specs]
    assert sum(first is not None for first in firsts) >= 0.95 * len(firsts)


def test_advice_leads_to_a_list_that_fits():
    """Even if a student keeps all that it has not been told to replace."""
    oracle, moment, _ = judged(Profile(False, (0,), (COMEDY,)), ["Friends", "Nothing of Note", "Aladdin", "1917"])
    world = Movies()
    for _ in range(4):
        (advice,) = oracle.judge(moment, frozenset((FP,)))
        world.restore(moment.after)
        _, reward, _, _, info = world.step(advice.action)
        moment = Moment(moment.after, advice.action, reward, world.truth, info["success"], moment.turn + 1, False)
    assert moment.success
    assert len(json.loads(moment.action)) == 4


@pytest.mark.parametrize("answer", ['["Jaws"]', '[{"title": "jaws", "year": 1975}]', "Jaws, of course", '["Jaws"'])
def test_text_mode_and_plain_steps_take_the_same_text(answer):
    plain, text = llf_teacher.make(ID), llf_teacher.make(ID, text=True)
    assert plain.reset(seed=3)[0]["feedback"] == text.reset(seed=3)[0]["feedback"]
    for _ in range(2):
        one, other = plain.step(answer), text.step(answer)
        assert one[0]["feedback"] == other[0]["feedback"] != ""
        assert plain.session.world.describe(one[0]["observation"]) == other[0]["observation"]
        assert one[1:4] == other[1:4]
        assert ("parse_failure" in one[4]) == ("parse_failure" in other[4]) == (answer[0] != "[" or answer[-1] != "]")
    assert text.step(f"Thought: a classic.\nResponse: {answer}")[0]["feedback"]


def test_a_turn_looks_a_list_up_once(monkeypatch):
    """World, hindsight and advice share what its titles stand for."""
    env = llf_teacher.make(ID)
    env.reset(seed=0)
    catalogue = env.session.world.catalogue
    asked = []
    monkeypatch.setattr(catalogue, "item", lambda title, item=catalogue.item: asked.append(title) or item(title))
    env.step('["Jaws", "The Names of Nine Rivers"]')
    assert asked == ["Jaws", "The Names of Nine Rivers"]


def test_a_wish_in_other_words_than_the_worlds_does_not_hold():
    world = Movies()
    for seed in range(20):
        world.reset(seed=seed)
        moment, lab = Moment.opening(world.truth), world.scratch()
        for attribute in (TYPE, YEAR, GENRE, AGE):
            words = world.truth.profile.words(attribute)
            assert Wish(attribute=attribute, wish=words).holds(moment, lab) == bool(words)
            assert not Wish(attribute=attribute, wish=f"{words} or so").holds(moment, lab)
