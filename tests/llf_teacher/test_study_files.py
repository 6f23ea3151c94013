"""The files of a study: their names, and what they never replace."""

import pytest
from commands import llf
from studying import small, stored

from llf_teacher.studies import load
from llf_teacher.studies.archive import write_archive
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.export import write_export
from llf_teacher.studies.report import write_report
from llf_teacher.studies.store import Store
from llf_teacher.suite.card import check_file

STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "silent"]
students = ["{}"]
seeds = 1
max_turns = 2
"""


def run(folder, *arguments):
    return llf("study", *arguments, "--executor", "here", cwd=folder)


def test_store_and_report_are_named_after_the_file_and_belong_to_it(tmp_path):
    (tmp_path / "deep").mkdir()
    files = ("first.toml", "second.toml", "deep/first.toml")
    for file, student in zip(files, ("random", "obedient", "text_only"), strict=True):
        (tmp_path / file).write_text(STUDY.format(student))
    for file in files[:2]:
        done = run(tmp_path, file)
        assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir() if path.is_file()} == {
        *("first.toml", "first.db", "first.html", "second.toml", "second.db", "second.html")
    }
    before = (tmp_path / "first.db").read_bytes(), (tmp_path / "first.html").read_bytes()
    for arguments, said in (
        (
            ["deep/first.toml"],
            "first.db is the store of the study first.toml, not of deep/first.toml, and has 2 episodes",
        ),
        (["second.toml", "--store", "first.db"], "first.db is the store of the study first.toml, not of second.toml"),
        (["second.toml", "--report", "first.html"], "first.html is the report of the study first.toml, not of second"),
    ):
        refused = run(tmp_path, *arguments)
        assert refused.returncode == 2
        assert said in refused.stderr
        assert "--shared" in refused.stderr
    told = llf("study", "report", "--store", "second.db", "--report", "first.html", cwd=tmp_path)
    assert "first.html is the report of the study first.toml, not of second.toml" in told.stderr
    assert before == ((tmp_path / "first.db").read_bytes(), (tmp_path / "first.html").read_bytes())
    (tmp_path / "first.toml").write_text(STUDY.format("obedient"))  # an edited study is the same
    assert run(tmp_path, "first.toml").returncode == 0
    shared = run(tmp_path, "second.toml", "--store", "first.db", "--report", "first.html", "--shared")
    assert shared.returncode == 0, shared.stderr
    again = llf("study", "report", "second.toml", cwd=tmp_path)
    assert "".join(again.stderr.split()).endswith("second.html")
    (tmp_path / "first.html").unlink()
    assert llf("study", "report", "--store", "first.db", cwd=tmp_path).returncode == 0
    assert (tmp_path / "first.html").exists()


@pytest.mark.parametrize("target", ["it.db", "mine.toml", "other.db", "other.sqlite", "link.html"])
def test_a_store_and_a_study_file_are_not_replaced_by_a_report(tmp_path, target):
    (tmp_path / "mine.toml").write_text(STUDY.format("random"))
    stored(tmp_path / "other.db", small(seeds=1))
    (tmp_path / "other.sqlite").write_bytes((tmp_path / "other.db").read_bytes())
    (tmp_path / "link.html").symlink_to("other.db")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    refused = run(tmp_path, "run", "mine.toml", "--store", "it.db", "--report", target)
    assert refused.returncode == 2
    assert f"cannot write the report to {target}: it is " in refused.stderr
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_no_file_of_a_study_is_replaced(tmp_path):
    path = stored(tmp_path / "s.db", small(seeds=1), {"study": small(seeds=1).as_dict()})
    toml = tmp_path / "s.toml"
    toml.write_text("x = 1")
    before = path.read_bytes(), toml.read_bytes()
    with Store(path, read_only=True) as store, load(path) as results:
        for target in (path, toml):
            for write in (
                lambda: write_archive(path, target),  # noqa: B023 (called here)
                lambda: results.archive(target),  # noqa: B023
                lambda: write_report(store, small(seeds=1), target),  # noqa: B023
                lambda: results.report(small(seeds=1)).save(target),  # noqa: B023
                lambda: write_export(results, target, "chat"),  # noqa: B023
            ):
                with pytest.raises(ValueError, match=r"cannot write the .*, which is not replaced; give another file"):
                    write()
        (tmp_path / "s.csv").write_bytes(path.read_bytes())
        with pytest.raises(ValueError, match=r"cannot write the table to .*: it is an SQLite file"):
            results.export(tmp_path / "s.csv")
    (tmp_path / "card.json").write_bytes(path.read_bytes())
    with pytest.raises(ValueError, match=r"cannot write the card to .*: it is an SQLite file"):
        check_file(tmp_path / "card.json")
    program = tmp_path / "moods.py"
    program.write_text("def grudge(claims, view):\n    return claims\n")
    code = program.read_bytes()
    with Store(path, read_only=True) as store:
        for what, write in {
            "report": lambda to: write_report(store, small(seeds=1), to),
            "archive": lambda to: write_archive(path, to),
        }.items():
            with pytest.raises(ValueError, match=rf"cannot write the {what} to .*moods.py: it is a file that is not a"):
                write(program)
        assert program.read_bytes() == code
        for write, name in ((write_report, "r"), (write_archive, "a")):  # what they wrote themselves is replaced
            for _ in range(2):
                write(*((store, small(seeds=1)) if name == "r" else (path,)), tmp_path / name)
    told = llf("study", "diff", "s.db", "s.db", "--html", "s.db", cwd=tmp_path)
    assert "cannot write the comparison to s.db" in told.stderr
    assert before == (path.read_bytes(), toml.read_bytes())


@pytest.mark.parametrize("student", ["bayesian", "bayesian | stubborn(p=0.3)"])
def test_a_student_that_a_family_does_not_suit_is_refused_before_play(student):
    """Where its actions are no choices, each of its episodes would fail, and fail again."""
    ids = ("llf-bandits-BanditTenArmedRandomFixed-v0", "llf-reco-movie-v0")
    fields = {"ids": ids, "teachers": ("oracle", "silent"), "students": ("obedient", student), "seeds": 2}
    mend = r'in the study\'s file:\n\[fewer."llf-reco-movie-v0"\]\nstudents = \["obedient"\]'
    with pytest.raises(ValueError, match=rf"(?s)students: llf-reco-movie-v0: .*weighs discrete actions.*{mend}"):
        Study(**fields)
    Study(**fields, fewer={"llf-reco-movie-v0": {"students": ["obedient"]}})
    Study(**{**fields, "ids": ids[:1]})
