"""Movies: requests, answers, and what they earn."""

import json
import pickle
import time
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from catalogues import write_catalogue

from worlds.movies import (
    AGE,
    GENRE,
    LEAST_MATCHES,
    MAX_LENGTH,
    MAX_TITLES,
    TYPE,
    YEAR,
    Movies,
    Profile,
    Truth,
    answers,
    draw_profile,
)
from worlds.movies.catalogue import AGES, GENRES, PERIODS, load_catalogue
from worlds.movies.catalogue.titles import fold

COMEDY, DRAMA, SPORT = (GENRES.index(name) for name in ("Comedy", "Drama", "Sport"))


def world_for(profile, unsaid=TYPE):
    world = Movies()
    world.reset(seed=0)
    world.restore(Truth(profile, unsaid, (0, 0), ""))
    return world


def earned(profile, *titles):
    return world_for(profile).step(json.dumps(titles))[1]


@pytest.mark.parametrize(
    ("profile", "titles", "reward"),
    [
        (Profile(False), ["The Matrix"], 0.0),
        (Profile(True), ["The Matrix"], -1.0),
        (Profile(False), ["The Matrix", "Friends"], 1 / 2 - 1),
        (Profile(False), ["The Matrix", "The Glimmerfoam Heist"], 1 / 2 - 1),
        (Profile(False), ["Aladdin"], -1.0),  # there are two
        (Profile(False), ["Aladdin (2019)"], 0.0),
        (Profile(False), [], -1.0),
        (Profile(False, (1,)), ["The Matrix"], 0.0),
        (Profile(False, (0, 2)), ["The Matrix"], -1.0),
        (Profile(False, (0, 1)), ["The Matrix"], 0.0),
        (Profile(False, (1,), (COMEDY, SPORT), 2), ["The Matrix"], -1.0),
        (Profile(False), ["Friends", "Jaws", "The Matrix", "Jaws", "The Wicher"], 3 / 5 - 1),
        (Profile(True, (2,)), ["Frasier"], 0.0),  # 1993 to 2004
        (Profile(True, (0,)), ["Frasier"], -1.0),
        (Profile(True, (3,)), ["The Simpsons"], 0.0),  # still running
        (Profile(False, age=0), ["Toy Story"], 0.0),
        (Profile(False, age=1), ["Toy Story", "Jumanji"], 0.0),
        (Profile(False, age=0), ["Jumanji"], -1.0),
        (Profile(False, age=2), ["Pulp Fiction"], 0.0),
        (Profile(True, age=2), ["The Sopranos"], 0.0),
    ],
)
def test_reward_is_the_share_of_titles_that_meet_every_wish_less_one(profile, titles, reward):
    assert earned(profile, *titles) == pytest.approx(reward)
    assert world_for(profile).step(json.dumps(titles))[4]["success"] == (reward == 0.0)


def test_rewards_of_2000_lists_agree_with_the_rule_as_stated():
    """The share of the titles named that meet every wish, less 1; judged by the catalogue's rows, for drawn users."""
    world, rng = Movies(), np.random.default_rng(0)
    rows = world.catalogue.query(
        "SELECT title, first, last, series, certificate, group_concat(genre, '|') "
        "FROM title JOIN genre USING (id) GROUP BY id"
    )
    titles = Counter(fold(row[0]) for row in rows)
    between = 0
    for seed in range(2000):
        world.reset(seed=seed)
        profile = world.truth.profile
        chosen = [rows[i] for i in rng.integers(len(rows), size=rng.integers(1, 7)).tolist()]
        fitting = world.catalogue.fitting(profile.wishes.values())
        chosen += [rows[i] for i in rng.choice(fitting, size=2).tolist()]
        named, met = [], 0
        for title, first, last, series, certificate, genres in chosen:
            form = int(rng.integers(3))
            named.append(("Turnip Season", title, f"{title} ({first})")[form])
            if form == 0 or (form == 1 and titles[fold(title)] > 1):
                continue  # unknown or ambiguous
            spans = [PERIODS[period] for period in profile.periods]
            met += (
                series == profile.series
                and (not spans or any(first <= end and (last or 9999) >= begin for begin, end in spans))
                and (not profile.genres or any(GENRES[genre] in genres.split("|") for genre in profile.genres))
                and (profile.age < 0 or certificate in AGES[profile.age])
            )
        between += 0 < met < len(named)
        assert world.step(json.dumps(named))[1] == pytest.approx(float(Fraction(met, len(named)) - 1), abs=1e-12), named
    assert between > 500


@pytest.mark.parametrize("max_items", [-1, 101, 2.0, True, "3"])
def test_what_max_items_may_be_is_said(max_items):
    with pytest.raises(ValueError, match=r"max_items must be None or a whole number from 0 to 100, got"):
        Movies(max_items=max_items)


@pytest.mark.parametrize(
    ("answer", "canonical"),
    [
        ('["The Matrix"]', '["The Matrix"]'),
        (' [ "The  Matrix" ,\n"Jaws"]\n', '["The Matrix", "Jaws"]'),
        ('[{"title": "The Matrix"}]', '["The Matrix"]'),
        ('[{"title": "Aladdin", "year": 1992, "why": ["good"]}]', '["Aladdin (1992)"]'),
        ('[{"title": "Aladdin (1992)", "year": 1992}, "Jaws"]', '["Aladdin (1992)", "Jaws"]'),
        ('[{"title": "Aladdin", "year": "1992"}]', '["Aladdin"]'),
        ('```json\n["The Matrix"]\n```', '["The Matrix"]'),
        ('```\n\t["The Matrix"]  \n```', '["The Matrix"]'),
        ('["Am\\u00e9lie"]', '["Amélie"]'),
        ("[]", "[]"),
    ],
)
def test_answers_have_a_canonical_form(answer, canonical):
    world = world_for(Profile(False))
    assert world.legal(answer) == world.legal(canonical) == canonical


@pytest.mark.parametrize(
    "answer",
    [
        "The Matrix",
        '"The Matrix"',
        '{"title": "The Matrix"}',
        '["The Matrix"',
        '["The Matrix"] and more',
        '["The Matrix"]]',
        '\ufeff["The Matrix"]',
        '```\n\xa0["The Matrix"]\n```',
        "[1]",
        "[null]",
        "[[]]",
        '[""]',
        '["  "]',
        '[{"name": "The Matrix"}]',
        '[{"title": 1}]',
        '["a\\u0000b"]',
        '["\\ud800"]',
        "[NaN]",
        "[" * 9000,
        "[" + "9" * 5000 + "]",
        '["' + "x" * 201 + '"]',
        json.dumps(["x"] * (MAX_TITLES + 1)),
        '"' * 100_000,
        "",
        None,
        ["The Matrix"],
    ],
    ids=lambda answer: repr(answer)[:30],
)
def test_what_is_no_answer_is_refused(answer):
    world = world_for(Profile(False))
    before = world.save()
    with pytest.raises(ValueError, match="allowed: a JSON list of at most 100 titles"):
        world.step(answer)
    assert world.save() == before


def test_hostile_answers_take_bounded_work():
    """The longest lists of titles that nobody has heard of, and texts that are no answer."""
    world = world_for(Profile(False))
    answers = [json.dumps([f"{letter * 40} {i} {i}" for i in range(MAX_TITLES)]) for letter in "abcdefgh"]
    answers.append(json.dumps(["the shawshank redemptoin" + "x" * 60] * MAX_TITLES))
    assert all(len(answer) <= MAX_LENGTH for answer in answers)
    begin = time.process_time()
    for answer in answers:
        assert world.step(answer)[1] == -1.0
    for text in ('"' * 100_000, "[" * 100_000, json.dumps(["x"] * 5000), json.dumps(["x" * 100_000])):
        with pytest.raises(ValueError, match="allowed"):
            world.step(text)
    assert time.process_time() - begin < 5


def test_one_wish_stays_unsaid():
    seen = set()
    for seed in range(200):
        world = Movies()
        observation, _ = world.reset(seed=seed)
        profile, unsaid, *_ = world.truth
        seen.add(unsaid)
        said = {
            TYPE: int(observation["type"]) == profile.series + 1,
            YEAR: bool(profile.periods) and np.flatnonzero(observation["periods"]).tolist() == list(profile.periods),
            GENRE: bool(profile.genres) and np.flatnonzero(observation["genres"]).tolist() == list(profile.genres),
            AGE: profile.age >= 0 and int(observation["age"]) == profile.age + 1,
        }
        assert {attribute for attribute, told in said.items() if told} == set(profile.wishes) - {unsaid}
        request = world.describe(observation)
        for attribute in (YEAR, GENRE, AGE):
            words = profile.words(attribute)
            assert (bool(words) and words in request) == (bool(words) and attribute != unsaid)
    assert seen == {TYPE, YEAR, GENRE, AGE}


def test_requests_are_put_in_fifty_ways():
    world = Movies()
    said = set()
    for seed in range(1000):
        observation, _ = world.reset(seed=seed)
        world.restore(world.truth._replace(profile=Profile(False, (0,), (COMEDY,), 1), unsaid=YEAR))
        said.add(world.describe({**world.step("[]")[0], "manner": observation["manner"]}))
    assert len(said) == 50
    assert all("family-friendly movies of the genre Comedy" in request for request in said)


def test_users_can_be_pleased():
    world = Movies()
    for seed in range(200):
        world.reset(seed=seed)
        fitting = world.catalogue.fitting(world.truth.profile.wishes.values())
        assert len(fitting) >= LEAST_MATCHES
        labels = [world.catalogue.items[i].label for i in fitting.tolist()][:MAX_TITLES]
        assert world.step(json.dumps(labels))[1] == 0.0


def test_wishes_are_drawn_as_they_should_be():
    rng = np.random.default_rng(0)
    profiles = [draw_profile(rng) for _ in range(5000)]
    assert np.mean([profile.series for profile in profiles]) == pytest.approx(0.5, abs=0.03)
    for name in ("periods", "genres"):
        counts = np.bincount([len(getattr(profile, name)) for profile in profiles]) / 5000
        assert counts == pytest.approx([1 / 3] * 3, abs=0.03)
        assert all(list(getattr(profile, name)) == sorted(set(getattr(profile, name))) for profile in profiles)
    plain = [profile.age for profile in profiles if profile.genres == ()]
    assert np.mean([age == -1 for age in plain]) == pytest.approx(0.4, abs=0.04)
    assert not [p for p in profiles if p.age == 0 and GENRES.index("Horror") in p.genres]
    assert not [p for p in profiles if p.age == 2 and GENRES.index("Family") in p.genres]


def test_a_catalogue_without_age_ratings(tmp_path):
    """Unknown ratings meet no wish, so that no user wishes for one."""
    target = write_catalogue(tmp_path / "big.db")
    world = Movies(catalogue=str(target))
    for seed in range(100):
        world.reset(seed=seed)
        assert not world.truth.profile.series
        assert world.truth.profile.age == -1
    world.restore(Truth(Profile(False, age=0), TYPE, (0, 0), ""))
    assert world.step('["Film 3"]')[1] == -1.0
    assert world.scratch().catalogue is pickle.loads(pickle.dumps(world)).catalogue is load_catalogue(str(target))


def test_a_catalogue_that_is_too_small_is_refused(tmp_path):
    with pytest.raises(ValueError, match="has fewer than 3 titles of each type"):
        Movies(catalogue=str(write_catalogue(tmp_path / "small.db", 1)))
    with pytest.raises(ValueError, match="cannot read the catalogue"):
        Movies(catalogue=str(tmp_path / "missing.db"))


def test_an_answer_is_parsed_once(monkeypatch):
    read = []
    monkeypatch.setattr(answers, "_parsed", lambda text, parsed=answers._parsed: read.append(text) or parsed(text))
    earned(Profile(False), "Twelve Names of the Same River", "The Glimmerfoam Heist")
    assert len(read) == 1
