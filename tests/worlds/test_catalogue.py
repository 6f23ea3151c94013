"""The catalogue that ships, titles that are looked up, and imports of IMDb's and MovieLens's files."""

import copy
import gzip
import pickle
import re
import sqlite3
from collections import Counter
from functools import reduce
from operator import or_

import numpy as np
import pytest
from rapidfuzz.distance import OSA

from worlds.movies import LEAST_MATCHES, draw_profile
from worlds.movies.catalogue import CERTIFICATES, GENRES, Catalogue, aliases, load_catalogue, shipped
from worlds.movies.catalogue.importing import BASICS, Imported, import_catalogue
from worlds.movies.catalogue.titles import Titles, fold

FILMS, SHOWS = CERTIFICATES[:5], CERTIFICATES[5:]


def found(text, catalogue=None):
    catalogue = catalogue or load_catalogue()
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


# --- imports

HEADER = "\t".join(BASICS)
ROWS = [
    "tt0133093\tmovie\tThe Matrix\tThe Matrix\t0\t1999\t\\N\t136\tAction,Sci-Fi",
    'tt0000002\ttvSeries\tA "quoted" show\tA\t0\t1990\t2001\t\\N\tComedy,Reality-TV',
    "tt0000003\ttvMiniSeries\tStill running\tA\t0\t2020\t\\N\t\\N\tDrama",
    "tt0000004\tshort\tA short one\tA\t0\t1999\t\\N\t5\tComedy",
    "tt0000005\tmovie\tNot for children\tA\t1\t1999\t\\N\t90\tDrama",
    "tt0000006\ttvMovie\tNo year\tA\t0\t\\N\t\\N\t90\tDrama",
    "tt0000007\ttvMovie\tNo genres\tA\t0\t1985\t\\N\t90\t\\N",
    "tt0000008\tmovie\tThe Matrix\tThe Matrix\t0\t2029\t\\N\t136\tDrama",
]
RATINGS = "tconst\taverageRating\tnumVotes\ntt0133093\t8.7\t2000000\ntt0000002\t5.0\t10\ntt0000003\t5.0\t100\n"
LENS = """movieId,title,genres
1,Toy Story (1995),Adventure|Animation|Children|Comedy|Fantasy
2,"American President, The (1995)",Comedy|Drama|Romance
3,"Amelie (Fabuleux destin d'Amélie, Le) (2001)",Comedy
4,No year at all,Drama
5,Nothing (1990),(no genres listed)
"""


def entries_of(path):
    items = load_catalogue(path).items
    return [(item.title, item.series, item.first, item.last, item.genres, item.certificate) for item in items]


@pytest.mark.parametrize("packed", [False, True])
def test_import_of_imdb(tmp_path, packed):
    source, target, seen = tmp_path / "title.basics.tsv", tmp_path / "big.db", []
    data = "\n".join([HEADER, *ROWS, ""]).encode()
    source.write_bytes(gzip.compress(data) if packed else data)
    assert import_catalogue(source, target, progress=lambda *each: seen.append(each)) == Imported(5, 3)
    assert entries_of(target) == [
        ("The Matrix", False, 1999, 1999, ("Action", "Sci-Fi"), None),
        ('A "quoted" show', True, 1990, 2001, ("Comedy",), None),
        ("Still running", True, 2020, None, ("Drama",), None),
        ("No genres", False, 1985, 1985, (), None),
        ("The Matrix", False, 2029, 2029, ("Drama",), None),
    ]
    size = source.stat().st_size
    assert seen[-1] == (size, size)
    (sources,) = zip(*load_catalogue(target).query("SELECT source FROM title"), strict=True)
    assert sources[0] == "IMDb title.basics tt0133093"
    assert found("the matrix", load_catalogue(target)) == ["The Matrix (1999)", "The Matrix (2029)"]


def test_import_leaves_out_what_few_have_rated(tmp_path):
    source, ratings, target = (tmp_path / name for name in ("b.tsv", "r.tsv.gz", "big.db"))
    source.write_text("\n".join([HEADER, *ROWS]))
    ratings.write_bytes(gzip.compress(RATINGS.encode()))
    assert import_catalogue(source, target, ratings, 100) == Imported(2, 6)


def test_import_of_movielens(tmp_path):
    source, target = tmp_path / "films.csv", tmp_path / "big.db"
    source.write_text(LENS, encoding="utf-8")
    assert import_catalogue(source, target) == Imported(4, 1)
    assert entries_of(target)[:2] == [
        ("Toy Story", False, 1995, 1995, ("Adventure", "Animation", "Comedy", "Family", "Fantasy"), None),
        ("The American President", False, 1995, 1995, ("Comedy", "Drama", "Romance"), None),
    ]
    assert entries_of(target)[3] == ("Nothing", False, 1990, 1990, (), None)


def test_a_large_file_is_streamed(tmp_path):
    source, target, seen = tmp_path / "b.tsv.gz", tmp_path / "big.db", []
    rows = (f"tt{i}\tmovie\tFilm number {i}\tx\t0\t{1980 + i % 40}\t\\N\t90\tDrama" for i in range(20_000))
    source.write_bytes(gzip.compress("\n".join([HEADER, *rows]).encode()))
    assert import_catalogue(source, target, progress=lambda *each: seen.append(each[0])).taken == 20_000
    assert len(seen) > 10
    assert seen == sorted(seen)
    assert Counter(entry[2] for entry in entries_of(target))[1980] == 500


DAMAGED = {
    "columns": ("\n".join([HEADER, *ROWS, "tt9\tmovie\tCut o"]), "line 10: has 3 columns, not 9"),
    "year": ("\n".join([HEADER, ROWS[0].replace("1999", "199x")]), "line 2: a year was expected, got '199x'"),
    "id": ("\n".join([HEADER, ROWS[0][2:]]), "line 2: an id such as tt0133093 was expected, got '0133093'"),
    "header": ("id\tname\n1\tA", "line 1: got 'id\\tname'; allowed: the columns of IMDb's"),
    "empty": ("", "line 1: got ''"),
    "nothing to take": ("\n".join([HEADER, ROWS[3]]), "not one of 1 rows is a film or a series"),
    "encoding": (HEADER.encode() + b"\n\xff\xfe\xff", "is damaged after line"),
    "cut gzip": (gzip.compress("\n".join([HEADER, *ROWS * 2000]).encode())[:-200], "is damaged after line"),
    "bad gzip": (b"\x1f\x8bno gzip at all", "is damaged after line 0"),
    "lens columns": (LENS + "6,Too,many,columns\n", "line 7: has 4 columns, not 3"),
    "lens id": (LENS + "x,A (1999),Drama\n", "a number was expected as movieId, got 'x'"),
    "lens quotes": (LENS + '6,"Never closed (1999),Drama\n', "is damaged: unexpected end of data"),
}


@pytest.mark.parametrize(("data", "said"), DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_file_is_refused_and_the_old_catalogue_stays(tmp_path, data, said):
    good, source, target = tmp_path / "good.tsv", tmp_path / "source", tmp_path / "big.db"
    good.write_text("\n".join([HEADER, *ROWS]))
    import_catalogue(good, target)
    before = target.read_bytes()
    source.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(ValueError, match=re.escape(said)) as error:
        import_catalogue(source, target)
    assert str(source) in str(error.value)
    assert target.read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["big.db", "good.tsv", "source"]


def test_what_cannot_be_imported_is_said(tmp_path):
    source, ratings = tmp_path / "source", tmp_path / "ratings"
    source.write_text("\n".join([HEADER, *ROWS]))
    ratings.write_text(RATINGS + "tt1\t5.0\tmany\n")
    with pytest.raises(ValueError, match=r"cannot import .*missing"):
        import_catalogue(tmp_path / "missing", tmp_path / "big.db")
    with pytest.raises(ValueError, match=r"cannot import .*none"):
        import_catalogue(source, tmp_path / "none" / "big.db")
    with pytest.raises(ValueError, match=r"title.ratings.tsv is needed"):
        import_catalogue(source, tmp_path / "big.db", least_votes=3)
    with pytest.raises(ValueError, match="least_votes must be at least 0, got -1"):
        import_catalogue(source, tmp_path / "big.db", least_votes=-1)
    with pytest.raises(ValueError, match="line 5: an id, a rating and a number of votes were expected"):
        import_catalogue(source, tmp_path / "big.db", ratings)
    with pytest.raises(ValueError, match=r"allowed: the columns of title.ratings.tsv"):
        import_catalogue(source, tmp_path / "big.db", source)
    source.write_text(LENS)
    ratings.write_text(RATINGS)
    with pytest.raises(ValueError, match="tell nothing of MovieLens's titles"):
        import_catalogue(source, tmp_path / "big.db", ratings)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ratings", "source"]


def test_what_is_no_catalogue_is_refused(tmp_path):
    other = tmp_path / "other.db"
    database = sqlite3.connect(other)
    database.execute("CREATE TABLE title (id)")
    database.close()
    text = tmp_path / "text.db"
    text.write_text("no database " * 100)
    for path in (other, text):
        with pytest.raises(ValueError, match=r"is no catalogue .*import_catalogue` makes one"):
            load_catalogue(path)
    for path in (tmp_path / "missing.db", 3.5):
        with pytest.raises(ValueError, match="cannot read the catalogue"):
            load_catalogue(path)


def test_a_changed_file_is_read_again(tmp_path):
    source, target = tmp_path / "source", tmp_path / "big.db"
    for count in (4, 5):
        source.write_text("\n".join([HEADER, *(row for row in ROWS * 2)][: count + 1]))
        import_catalogue(source, target)
        first = load_catalogue(str(target))
        assert load_catalogue(str(target)) is first
        assert isinstance(first, Catalogue)
    assert len(first.items) == 3


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
