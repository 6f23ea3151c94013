"""Imports of IMDb's and MovieLens's files."""

import contextlib
import gzip
import re
import sqlite3
from collections import Counter

import pytest

from worlds.movies.catalogue import Catalogue, load_catalogue
from worlds.movies.catalogue.importing import BASICS, Imported, import_catalogue

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
    made = load_catalogue(target)
    assert [made.items[i].label for i in made.find("the matrix")] == ["The Matrix (1999)", "The Matrix (2029)"]


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
    "nothing to take": ("\n".join([HEADER, ROWS[3]]), "none of 1 rows is a film or a series"),
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
    with pytest.raises(ValueError, match=r"least_votes=3 requires ratings, .*title\.ratings\.tsv, got None"):
        import_catalogue(source, tmp_path / "big.db", least_votes=3)
    with pytest.raises(ValueError, match="least_votes must be at least 0, got -1"):
        import_catalogue(source, tmp_path / "big.db", least_votes=-1)
    with pytest.raises(ValueError, match="line 5: an id, a rating and a number of votes were expected"):
        import_catalogue(source, tmp_path / "big.db", ratings)
    with pytest.raises(ValueError, match=r"allowed: the columns of title.ratings.tsv"):
        import_catalogue(source, tmp_path / "big.db", source)
    source.write_text(LENS)
    ratings.write_text(RATINGS)
    with pytest.raises(ValueError, match="ratings apply to IMDb's titles only, got MovieLens's"):
        import_catalogue(source, tmp_path / "big.db", ratings)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ratings", "source"]


def test_what_is_no_catalogue_is_refused(tmp_path):
    other = tmp_path / "other.db"
    with contextlib.closing(sqlite3.connect(other)) as database:
        database.execute("CREATE TABLE title (id)")
    text = tmp_path / "text.db"
    text.write_text("no database " * 100)
    for path in (other, text):
        with pytest.raises(ValueError, match=r"is not a catalogue .*make one with `.*import_catalogue`"):
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
