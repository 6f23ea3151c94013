"""The examples run, shortened."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_teaching_on_a_budget(tmp_path):
    command = [sys.executable, ROOT / "examples" / "teaching_on_a_budget.py", "--seeds", "2", "--episodes", "5"]
    result = subprocess.run(
        [*command, "--plot", tmp_path / "plot.png"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("| mistake correcting | ") == 2
    assert (tmp_path / "plot.png").stat().st_size > 10_000


def test_efficiency():
    command = [sys.executable, ROOT / "examples" / "efficiency.py", "--episodes", "40", "--workers", "1"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "us of a core to play and check an episode" in result.stdout
    assert result.stdout.count("| processes, 1 workers | ") == 1
    assert "most memory of the parent" in result.stdout


def test_many_sessions():
    command = [sys.executable, ROOT / "examples" / "many_sessions.py", "--sessions", "6", "--turns", "2"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "6 lessons of llf-gridworld-v0 at once: " in result.stdout
    assert result.stdout.count(" ms | ") == 3
    assert "Its memory: " in result.stdout


@pytest.mark.parametrize(
    ("episodes", "least"), [(100, 0.0), pytest.param(3000, 0.6, marks=pytest.mark.full)], ids=["short", "whole"]
)
def test_both_seats_learn(episodes, least):
    command = [sys.executable, ROOT / "examples" / "both_seats_learn.py", "--episodes", str(episodes)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    _, rule, first, *_, last = (line.split("|") for line in result.stdout.splitlines())
    assert rule[1] == "---"
    assert float(last[2]) >= least
    assert (float(first[2]) < 0.4) or not least


@pytest.mark.full
def test_learn_to_teach(tmp_path):
    """Needs the extra `learn`."""
    command = [sys.executable, ROOT / "examples" / "learn_to_teach.py", "--steps", "2000", "--seeds", "3"]
    result = subprocess.run(
        [*command, "--episodes", "2", "--save", tmp_path / "teacher.zip", "--plot", tmp_path / "plot.png"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "| learned | " in result.stdout
    assert "| announced mistake | " in result.stdout
    assert (tmp_path / "teacher.zip").stat().st_size > 10_000
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.full
def test_learn_by_budget(tmp_path):
    """Needs the extra `learn`. A second run trains nothing, and prints the same."""
    store = tmp_path / "it.jsonl"
    command = [sys.executable, ROOT / "examples" / "learn_by_budget.py", "--steps", "2000", "--lifetimes", "3"]
    command += ["--budgets", "2", "--trainings", "1", "--without", "way", "--store", store]
    first, again = (subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False) for _ in range(2))
    assert first.returncode == 0, first.stderr
    assert first.stdout == again.stdout
    assert "| 2 | last iterate, without way | " in first.stdout
    rules, training = map(json.loads, store.read_text().splitlines())
    assert len(rules["announced mistake"]) == len(training["learned"]) == 3


@pytest.mark.full
def test_search_a_teacher(tmp_path):
    """Needs the extra `learn`. A second run trains nothing, and prints the same."""
    store = tmp_path / "it.jsonl"
    command = [sys.executable, ROOT / "examples" / "search_a_teacher.py", "--generations", "2", "--lifetimes", "3"]
    command += ["--cases", "bandits", "without way", "--trainings", "2"]
    command += ["--store", store, "--plot", tmp_path / "it.png"]
    first, again = (subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False) for _ in range(2))
    assert first.returncode == 0, first.stderr
    assert first.stdout == again.stdout
    assert re.search(r"^\| bandits \| .*\(10\).* \| 2 \|$", first.stdout, re.MULTILINE)
    lines = [json.loads(line) for line in store.read_text().splitlines()]
    assert [(line["case"], line.get("seed")) for line in lines] == [
        ("bandits", None),
        ("bandits", 0),
        ("bandits", 1),
        ("without way", None),
        ("without way", 0),
        ("without way", 1),
    ]
    assert all(len(line["last iterate"]) == 3 for line in lines if "seed" in line)
    assert (tmp_path / "it.png").stat().st_size > 10_000


def test_checking_the_catalogue(tmp_path):
    """The films of other data are counted that are found, and that agree; those that are not found are named."""
    keys = ("Title", "Release Date", "MPAA Rating", "IMDB Votes")
    films = [
        ("Star Wars", "May 25 1977", "PG", 9),
        ("Psycho", "Jun 16 2060", "R", 8),
        ("The Matrix", "Mar 31 1989", "PG", 7),
        ("Turnip Season", "Jan 01 1990", None, None),
    ]
    vega, ggplot2 = tmp_path / "movies.json", tmp_path / "movies.csv"
    vega.write_text(json.dumps([dict(zip(keys, film, strict=True)) for film in films]))
    ggplot2.write_text('title,year,votes,mpaa\n"Matrix, The",1999,7,R\nAladdin,1992,6,G\nAladdin,1950,6,\n')
    command = [sys.executable, ROOT / "examples" / "check_catalogue.py", "--vega", vega, "--ggplot2", ggplot2]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in result.stdout.splitlines()]
    assert ["vega-datasets", "100", "3", "2", "2 of 3"] in rows
    assert ["ggplot2movies", "100", "2", "2", "2 of 2"] in rows
    assert "vega-datasets, not found: Turnip Season (1990)" in result.stdout
    assert "ggplot2movies, not found: Aladdin (1950)" in result.stdout


def test_a_model_learns_what_the_teachers_words_mean(tmp_path):
    command = [sys.executable, ROOT / "examples" / "train_a_model.py", "--plot", tmp_path / "plot.png"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    curve = [float(share) for share in result.stdout.split()[1:]]
    assert len(curve) == 20
    assert curve[0] < 0.2 < 0.8 < curve[-1]
    assert (tmp_path / "plot.png").stat().st_size > 10_000
