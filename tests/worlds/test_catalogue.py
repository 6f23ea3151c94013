"""The catalogue that ships, and titles that are looked up."""

import contextlib
import copy
import pickle
import re
import sqlite3
from functools import reduce
from operator import or_

import numpy as np
import pytest
from catalogues import write_catalogue
from rapidfuzz.distance import OSA

from worlds.movies import LEAST_MATCHES, draw_profile
from worlds.movies.catalogue import CERTIFICATES, GENRES, Catalogue, aliases, load_catalogue, shipped
from worlds.movies.catalogue.titles import Titles, fold

FILMS, SHOWS = CERTIFICATES[:5], CERTIFICATES[5:]


def found(text):
    catalogue = load_catalogue()
    return [catalogue.items[i].label for i in catalogue.find(text)]


def test_the_catalogue_is_large_and_in_order():
    entries = list(shipped())
    assert sum(not entry.series for entry in entries) >= 6500
    assert sum(entry.series for entry in entries) >= 1000
    assert sum({"Film-Noir"} <= set(entry.genres) for entry in entries) >= 40
    assert sum({"Superhero"} <= set(entry.genres) for entry in entries) >= 150
    assert len({(entry.title, entry.series, entry.first) for entry in entries}) == len(entries)
    for entry in entries:
        assert 1900 <= entry.first <= 2025, entry
        assert entry.last is None or entry.first <= entry.last <= 2025, entry
        assert entry.series or entry.last == entry.first, entry
        assert 1 <= len(set(entry.genres) - {"Superhero", "Film-Noir"}) <= 3, entry
        assert set(entry.genres) <= set(GENRES), entry
        assert list(entry.genres) == sorted(set(entry.genres)), entry
        assert entry.certificate in (SHOWS if entry.series else (*FILMS, None)), entry
        assert entry.source.startswith("general knowledge"), entry
        assert entry.title == " ".join(entry.title.split()), entry


def test_every_label_names_its_item():
    catalogue = load_catalogue()
    assert all(item.named for item in catalogue.items)
    assert [catalogue.find(item.label) for item in catalogue.items] == [(i,) for i in range(len(catalogue.items))]


@pytest.mark.parametrize(
    ("title", "type", "first", "last", "genres", "certificate"),
    [
        ("The Godfather", 0, 1972, 1972, {"Crime", "Drama"}, "R"),
        ("Toy Story", 0, 1995, 1995, {"Adventure", "Animation", "Comedy"}, "G"),
        ("Titanic", 0, 1997, 1997, {"Drama", "Romance"}, "PG-13"),
        ("The Sopranos", 1, 1999, 2007, {"Crime", "Drama"}, "TV-MA"),
        ("Frasier", 1, 1993, 2004, {"Comedy"}, "TV-PG"),
        ("The Simpsons", 1, 1989, None, {"Animation", "Comedy"}, "TV-14"),
    ],
)
def test_facts(title, type, first, last, genres, certificate):
    query = load_catalogue().query
    ((id, *facts),) = query("SELECT id, series, first, last, certificate FROM title WHERE title = ?", title)
    assert facts == [type, first, last, certificate]
    assert {genre for (genre,) in query("SELECT genre FROM genre WHERE id = ?", id)} == genres


def test_most_profiles_have_matches():
    """The share of users, as they are drawn, whose wishes at least three titles meet."""
    catalogue, rng = load_catalogue(), np.random.default_rng(0)
    profiles = [draw_profile(rng) for _ in range(4000)]
    share = np.mean([len(catalogue.fitting(profile.wishes.values())) >= LEAST_MATCHES for profile in profiles])
    assert share >= 0.6
    assert share == pytest.approx(0.916, abs=0.02)


def test_spellings_that_share_letters_are_compared_with_all_titles():
    """Forms that differ in too many letters are passed over; here nothing is."""
    titles = load_catalogue()._titles
    rng = np.random.default_rng(2)
    near = 0
    for form in rng.choice([form for form in titles._by_form if len(form) >= 6], 100).tolist():
        at = int(rng.integers(1, len(form) - 1))
        for said in (form, form[:at] + form[at + 1 :], form[:at] + "x" + form[at:], f"{form[:at]}2{form[at + 1 :]}s"):
            most = 2 if len(said) >= 12 else 1
            all_forms = [form for form in titles._by_form if form[0] == said[0] and len(form) >= 6]
            close = (
                {(d, form) for form in all_forms if (d := OSA.distance(said, form)) <= most}
                if len(said) >= 6
                else set()
            )
            assert set(titles._close(said)) == close
            near += len(close)
    assert near > 300


def test_what_fits_is_found_as_item_by_item():
    """Sets of items, as numbers, against each item's bits."""
    catalogue, rng = load_catalogue(), np.random.default_rng(1)
    assert catalogue.bits == reduce(or_, (item.bits for item in catalogue.items))
    for _ in range(50):
        wishes = draw_profile(rng).wishes.values()
        fitting = [i for i, item in enumerate(catalogue.items) if item.named and item.meets(wishes)]
        assert catalogue.fitting(wishes).tolist() == fitting
        assert catalogue.count(wishes) == len(fitting)
        assert catalogue.bits_of(wishes) == reduce(or_, (catalogue.items[i].bits for i in fitting), 0)


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("The Matrix", ["The Matrix"]),
        ("the MATRIX", ["The Matrix"]),
        ("Incredibles", []),  # with a single word, the article tells works apart
        ("Matrix", ["The Matrix"]),  # but for what stands in the list of other names
        ("Matrix (1999)", ["The Matrix"]),
        ("Matrix (1993)", []),  # a series
        ("Star Wars", ["Star Wars: Episode IV - A New Hope"]),
        ("Star Wars (1977)", ["Star Wars: Episode IV - A New Hope"]),
        ("Star Wars (2015)", []),
        ("The Empire Strikes Back", ["Star Wars: Episode V - The Empire Strikes Back"]),
        ("Empire Strikes Back", ["Star Wars: Episode V - The Empire Strikes Back"]),
        ("The Empire Strikes", []),
        ("Birdman", ["Birdman or (The Unexpected Virtue of Ignorance)"]),
        ("Birdmen", []),  # other names forgive no slip
        ("The Return of the King", []),  # may be that of 1980
        ("Pirates of the Caribbean", []),  # may be any of five
        ("Heat", ["Heat"]),
        ("The Heat", ["The Heat"]),
        ("Dark Knight", ["The Dark Knight"]),
        ("Matrix, The", ["The Matrix"]),
        ("The Matrix (1999)", ["The Matrix"]),
        ("The Matrix (1998)", ["The Matrix"]),
        ("The Matrix (1995)", []),
        ("  Jurrasic   Park", ["Jurassic Park"]),
        ("shawshank redemtion", ["The Shawshank Redemption"]),
        ("Spiderman", ["Spider-Man"]),
        ("Wall-E", ["WALL·E"]),
        ("MASH", ["M*A*S*H (1970)", "M*A*S*H (1972)"]),
        ("la confidential", ["L.A. Confidential"]),
        ("Amelie", ["Amélie"]),
        ("Butch Cassidy & the Sundance Kid", ["Butch Cassidy and the Sundance Kid"]),
        ("Friends (1994-2004)", ["Friends"]),
        ("The Simpsons (1989\u2013)", ["The Simpsons"]),
        ("The Lion King", ["The Lion King (1994)", "The Lion King (2019)"]),
        ("Lion King (2019)", ["The Lion King (2019)"]),
        ("The Lion Kng", []),  # a short word may be another one
        ("The Lion Queen", []),
        ("Toy Story 5", []),  # another number is another work
        ("Rocky VII", []),
        ("Gladiators", []),  # and so is a plural
        ("Hea", []),  # too short for typos
        ("The Glimmerfoam Heist", []),
        ("The", []),
        ("", []),
        ("(1999)", []),
        ("?!", []),
    ],
)
def test_titles_are_matched_forgivingly_but_not_guessed(text, labels):
    assert found(text) == labels


def test_a_slip_within_a_longer_word_still_finds_its_title():
    title = "The Shawshank Redemption"
    assert found("The Shawhsank Redemption") == found("The Shawshank Redemptionn") == found("The Shawwshank Redemption")
    for i in [*range(6, 12), *range(15, 23)]:  # within the words
        for wrong in (title[:i] + title[i + 1 :], title[:i] + "q" + title[i:]):
            assert found(wrong) == [title], wrong
        assert found(title[:i] + "q" + title[i + 1 :]) == []  # another letter


def test_works_of_one_spelling_are_ambiguous():
    titles = Titles([("Green Street", 1990), ("Green-Street", 1991), ("Same Name", 2000), ("Same Name", 2000)])
    assert titles.find("Green Street") == (0, 1)
    assert titles.find("Green Street (1991)") == (1,)
    assert titles.label(0) == ("Green Street (1990)", True)
    assert titles.label(2) == ("Same Name (2000)", False)


OTHER_WORKS = """
The Witches/The Witcher; Man on Wire/Man on Fire; The Hustler/Hustle; Crooklyn/Brooklyn; The Hustle/Hustle
The Heat/Heat; Mask/The Mask; Ring/The Ring; The Hunt/Hunt; The Hunter/The Hunted; Alien/Aliens; Predators/Predator
Rocky II/Rocky III; Toy Story 2/Toy Story 3; Twisters/Twister; Cure/Cube; Cars/Care; Dune/June; Duel/Fuel; Emma/Emmy
The Fly/Fly; Gone Girl/Gone Girls; House/The House; Insomnia/Insomniac; Klute/Flute; Lion/Loin; Loving/Living
Looper/Looker; Lucy/Lucky; Manhunter/Manhunt; Master/Faster; Moonlight/Moonfall; Mother/Brother; Passengers/Passenger
The Passenger/The Messenger; Platoon/Cartoon; The Prisoner/Prisoners; Psych/Psycho; Ran/Rain; Room/The Room; Rush/Brush
Scanners/Scanner; Shame/Shane; Shine/Shrine; Sisters/Sister; Sleeper/Sleepers; Slacker/Slackers; Solaris/Polaris
The Killer/The Killers; The Birds/The Bird; The Boxer/The Boxers; The Gambler/The Gamblers; The Game/Game
The Man/The Mad; The Others/The Other; The Rover/The Lover; The Sting/The String; The Thing/The Ring
Warrior/The Warriors; Witness/Fitness; A Single Man/A Simple Man; A Simple Plan/A Simple Man; Bad Boys/Bad Toys
Blood Work/Blood Word; Dark City/Dark Pity; Easy Rider/Easy Riders; Fair Game/Fair Games; Ice Age/Ice Ages
Iron Man/Iron Men; Lost Highway/Last Highway; Night Moves/Night Wolves; Open Water/Open Waters; Red Dragon/Bad Dragon
The Last Stand/The Lost Stand; Stealing Beauty/Sleeping Beauty; Singles/Single; Chained/Changed; Candyman/Handyman
The Interview/Interview; The Island/Island; Taken/Token; The Craft/The Draft; Saved!/Shaved; Notting Hill/Nothing Hill
The Untouchables/The Intouchables; Marnie/Marni; Carol/Carole; Coraline/Caroline; Zombieland/Zombielands
"""
"""Titles, each with one that is spelt much like it and may be another work."""


@pytest.mark.parametrize("pair", re.split(r"; |\n", OTHER_WORKS.strip()))
def test_a_title_that_may_be_another_work_is_not_taken_for_one(pair):
    one, other = pair.split("/")
    assert Titles([(one, 2000)]).find(other) == Titles([(other, 2000)]).find(one) == ()
    for title in (one, other):  # nor is one of the catalogue
        assert {fold(load_catalogue().items[i].title) for i in load_catalogue().find(title)} <= {fold(title)}


def test_other_names_stand_for_one_work_that_is_there():
    """None is the title of a work of the catalogue, or the title of another without its article."""
    catalogue, entries = load_catalogue(), list(shipped())
    keys = {fold(entry.title) for entry in entries}
    names = [fold(alias) for alias, _, _ in aliases()]
    assert len(set(names)) == len(names) >= 50
    assert not keys.intersection(names)
    for alias, title, year in aliases():
        (found,) = catalogue.find(alias)
        assert (catalogue.items[found].title, catalogue.items[found].first) == (title, year)


def test_another_name_of_what_may_be_two_works_is_ambiguous_and_a_title_goes_before_it():
    other = [("Matrix", "The Matrix", 1999), ("Heat", "The Heat", 2013)]
    titles = Titles([("The Matrix", 1999), ("The Matrix", 2029), ("The Heat", 2014), ("Heat", 1995)], other)
    assert titles.find("Matrix") == (0, 1)
    assert titles.find("Matrix (2029)") == (1,)
    assert titles.find("Heat") == (3,)
    assert Titles([("The Heat", 2014)], other).find("Heat") == ()  # not the work that is meant


def test_what_a_title_is_spelt_like_can_be_asked_for():
    titles = Titles([("The Witcher", 2019), ("The Witch", 2015), ("Heat", 1995), ("The Matrix", 1999)])
    assert [titles.near(text) for text in ("The Witches", "The Heat", "Matrix", "Vertigo")] == [(0,), (2,), (3,), ()]
    assert titles.near("The Witches (2019)") == (0,)
    assert titles.near("The Witches (1990)") == ()


@pytest.mark.parametrize("text", ["é" * 200, "the " * 50, "\u0301" * 200, "a, the, the", "ß" * 200, "(" * 200])
def test_odd_titles_fold_to_something(text):
    assert fold(text) == fold(text.upper().lower()) or fold(text)
    assert isinstance(load_catalogue().find(text), tuple)


def test_a_title_folds_the_same_beside_other_alphabets():
    """Texts of ASCII are folded by a table, others by an expression."""
    for title in (f"Up{chr(i)}on" for i in range(128)):
        assert fold(f"{title} \u0436") == f"{fold(title)} \u0436"


def test_copies_share_the_catalogue():
    catalogue = load_catalogue()
    assert copy.deepcopy(catalogue) is pickle.loads(pickle.dumps(catalogue)) is load_catalogue() is catalogue


def test_labels_are_looked_up_without_reading_them(monkeypatch):
    catalogue = Catalogue()
    read = [catalogue.find(item.label) for item in catalogue.items]
    monkeypatch.setattr(catalogue, "find", lambda title: pytest.fail(f"{title} was read"))
    found = [(i, catalogue.item(item.label)) for i, item in enumerate(catalogue.items) if item.named]
    assert all(item is catalogue.items[i] and read[i] == (i,) for i, item in found)
    assert len(found) > 1000


def test_equal_facts_of_items_are_one_object():
    """Thousands of strings for a few genres would have to be fetched from memory one by one."""
    items = Catalogue().items
    for facts in (
        [item.genres for item in items],
        [item.certificate for item in items],
        [item.first for item in items],
    ):
        assert len(set(map(id, facts))) == len(set(facts)) < 600


def test_what_is_no_catalogue_is_refused(tmp_path):
    other = tmp_path / "other.db"
    with contextlib.closing(sqlite3.connect(other)) as database:
        database.execute("CREATE TABLE title (id)")
    text = tmp_path / "text.db"
    text.write_text("no database " * 100)
    for path in (other, text):
        with pytest.raises(ValueError, match=r"is not a catalogue .*make one with `worlds.movies.catalogue.write`"):
            load_catalogue(path)
    for path in (tmp_path / "missing.db", 3.5):
        with pytest.raises(ValueError, match="cannot read the catalogue"):
            load_catalogue(path)


def test_a_changed_file_is_read_again(tmp_path):
    target = tmp_path / "big.db"
    for count in (2, 3):
        target.unlink(missing_ok=True)
        write_catalogue(target, count)
        first = load_catalogue(str(target))
        assert load_catalogue(str(target)) is first
        assert isinstance(first, Catalogue)
    assert len(first.items) == 3
