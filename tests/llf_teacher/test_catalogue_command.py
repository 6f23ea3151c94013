"""`llf dev movies import`, as a user meets it."""

from commands import llf, llf_apart

import llf_teacher
from worlds.movies.catalogue.importing import BASICS


def test_import_and_use(tmp_path):
    rows = [f"tt{i}\tmovie\tFilm {i}\tFilm\t0\t{1980 + i}\t\\N\t90\tDrama" for i in range(40)]
    (tmp_path / "basics.tsv").write_text("\n".join(["\t".join(BASICS), *rows, rows[0].replace("movie", "short")]))
    result = llf("dev", "movies", "import", "basics.tsv", "big.db", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "big.db: 40 films and series; 1 rows were left out." in " ".join(result.stderr.split())
    env = llf_teacher.make("llf-reco-movie-v0", catalogue=str(tmp_path / "big.db"), text=True)
    env.reset(seed=0)
    assert env.step('["film 7"]')[1] > -1.0


def test_a_mistake_is_one_line_and_status_2(tmp_path):
    (tmp_path / "basics.tsv").write_text("no\tdump\n")
    (tmp_path / "big.db").write_text("as it was")
    result = llf_apart("dev", "movies", "import", "basics.tsv", "big.db", cwd=tmp_path)
    assert result.returncode == 2
    assert "llf: basics.tsv, line 1: got 'no\\tdump'; allowed: the columns of IMDb's title.basics.tsv" in result.stderr
    assert (tmp_path / "big.db").read_text() == "as it was"
    assert "import" in llf("dev", "movies", cwd=tmp_path).stdout
