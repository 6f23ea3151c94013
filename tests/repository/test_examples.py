"""The examples run, shortened."""

import importlib
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies.analysis.statistics import Estimate

ROOT = Path(__file__).parents[2]


def printed(name, *arguments):
    """What an example prints."""
    command = [sys.executable, ROOT / "examples" / f"{name}.py", *map(str, arguments)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_a_curriculum_that_is_learned_beats_random_tasks():
    rows = [line.strip("| ").split(" | ") for line in printed("choose_tasks", "--seeds", 12).splitlines()[2:]]
    found = {name: float(share.split()[0]) for name, share, *_ in rows}
    assert found["edge"] > found["random tasks"] > found["the last task alone"]


def test_own_oracle():
    out = printed("own_oracle")
    assert out.splitlines()[-1] == "True"


def test_where_a_turn_goes():
    rows = printed("where_a_turn_goes", "llf-optimization-Booth-v0", "--steps", 20, "--profiles", 1).splitlines()[2:]
    for row in rows:
        shares = [int(cell) for cell in row.strip("| ").split(" | ")[2:]]
        assert len(shares) == 4
        assert min(shares) > 0
        assert sum(shares) <= 102  # each is rounded
    assert len(rows) == 2


def test_teaching_on_a_budget(tmp_path):
    out = printed("teaching_on_a_budget", "--seeds", 2, "--episodes", 5, "--plot", tmp_path / "plot.png")
    assert out.count("| mistake correcting | ") == 2
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.full
def test_late_or_wrong(tmp_path):
    out = printed(
        "known_results/late_or_wrong",
        *("--seeds", 2, "--workers", 1, "--store", tmp_path / "it.db", "--plot", tmp_path / "it.png"),
    )
    table, verdict = out.split("\n\n")
    rows = [line.split(" | ") for line in table.splitlines()[2:]]
    assert len(rows) == 9
    assert rows[0][0] == "| all families"
    assert verdict.startswith("Verdict: open over all families (score ")
    assert verdict.endswith("2 seeds); of families open in 8\n")
    assert (tmp_path / "it.png").stat().st_size > 10_000


def test_the_verdict_on_late_or_wrong_words_is_that_of_the_tests():
    example = runpy.run_path(str(ROOT / "examples" / "known_results" / "late_or_wrong.py"))
    nan = float("nan")

    def found(*lines):
        return [example["Line"]("family", 1.0, 1.0, Estimate(mean, mean, mean, 6), p) for mean, p in lines]

    families = (0.3, 0.001), (-0.3, 0.001), (0.3, 0.2), (0.1, 0.03)
    for whole, said in (
        ((0.2, 0.01), "late words cost more over all families"),
        ((-0.2, 0.01), "wrong words cost more over all families"),
        ((0.2, nan), "open over all families"),
    ):
        verdict = example["verdict"](found(whole, *families), 6)
        assert verdict.startswith(f"Verdict: {said} (score {whole[0]:.2f}")
        assert verdict.endswith(", 6 seeds); of families late in 2, wrong in 1, open in 1")


def test_the_verdict_on_small_models_needs_no_model(tmp_path, monkeypatch):
    """A model that does as it is told, one that is deaf, and one that was not asked."""
    monkeypatch.setenv("LLF_CACHE", str(tmp_path / "none"))
    heard, deaf = (
        f"llm(model='local:{name}')" for name in ("smollm2-135m#b179c9523d0e", "qwen2.5-coder-0.5b#1d9614638d18")
    )
    advice = "only(kinds='fp')"
    controls = ("silent", f"{advice} | placebo", f"{advice} | misaligned")
    rest = {"turns": 8, "parse_failures": 0, "truncated": 0, "advised": 8, "followed": 6, "seconds": 16.0}
    rest |= {"again": 7, "same_action": 2, "same_thought": 1, "pairs": [[1, "north", "north"]]}
    rows = [
        {"id": family, "family": family, "teacher": teacher, "student": student, "seed": seed, **rest}
        | {"regret": seed % 2 if (student, teacher) == (heard, advice) else 7 + seed % 3}
        for family in ("bandits", "gridworld")
        for student in (heard, deaf, "random")
        for teacher in (advice, *controls)
        for seed in range(3000, 3020)
    ]
    path = tmp_path / "rows.jsonl"
    path.write_text("".join(f"{json.dumps(row)}\n" for row in rows), encoding="utf-8")
    out = printed("known_results/small_models", "--from", path, "--plot", tmp_path / "it.png")
    assert "SmolLM2 135M learns from what it is told: yes" in out
    assert "Qwen2.5-Coder 0.5B learns from what it is told: no" in out
    assert "Qwen2.5-Coder 1.5B learns from what it is told: not decided" in out
    assert (tmp_path / "it.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (lambda rows: [*rows, rows[0]], 3),
        (lambda rows: [rows[0], rows[1] | {"regret": np.nan}], 2),
        (lambda rows: [rows[0] | {"seed": 7}], 1),
        (lambda rows: [{"seed": 3000}], 1),
        (lambda rows: [7], 1),
    ],
)
def test_rows_of_small_models_that_are_none_are_refused(tmp_path, monkeypatch, change, line):
    """A row for another's seed would shift all pairs."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "known_results")
    example = importlib.import_module("small_models")
    rows = (ROOT / "docs" / "small-models.jsonl").read_text("utf-8").splitlines()[:2]
    path = tmp_path / "rows.jsonl"
    path.write_text("".join(f"{json.dumps(row)}\n" for row in change([*map(json.loads, rows)])), encoding="utf-8")
    with pytest.raises(SystemExit, match=f"line {line}: must be a row of an episode"):
        example.checked(path, [*map(example.load_study, example.FILES)])


@pytest.mark.full
@pytest.mark.parametrize(
    ("name", "rows", "effects"),
    [("budget", 7, 6), ("asking", 13, 2), ("curriculum", 3, 10), ("rules", 6, 4), ("half", 6, 8)],
)
def test_known_results(tmp_path, name, rows, effects):
    """Two seeds decide nothing."""
    out = printed(f"known_results/{name}", "--seeds", 2, "--plot", tmp_path / "it.png")
    measured, judged, verdict = out.split("\n\n")
    assert len(measured.splitlines()) == 2 + rows
    assert len(judged.splitlines()) == 2 + effects
    assert judged.count("| open |") == effects
    assert verdict == f"Verdict: open (0 of {effects} effects found, 2 seeds)\n"
    assert (tmp_path / "it.png").stat().st_size > 10_000


def test_a_verdict_on_known_results(monkeypatch, capsys):
    """An effect is tested against the smallest that counts, after Holm, and a verdict is the worst of its effects."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "known_results")
    shared = importlib.import_module("_shared")
    beside, noise = np.full(20, 10.0), np.linspace(-0.5, 0.5, 20)
    cases = {5.0: "yes", 9.0: "open", 9.9: "no"}  # a tenth of 10 counts
    for own, verdict in cases.items():
        shared.print_verdict([shared.saving("less", own + noise, beside)])
        assert f"Verdict: {verdict} (" in capsys.readouterr().out
    effects = [shared.saving("less", own + noise, beside) for own in cases]
    for several, verdict in ((effects[:2], "open"), (effects, "no")):
        shared.print_verdict(several)
        assert f"Verdict: {verdict} (1 of {len(several)} effects found, 20 seeds)" in capsys.readouterr().out
    alone = shared.Effect("significant alone, at 0.031", np.arange(1.0, 7.0), np.zeros(6))
    nothing = shared.Effect("nothing", np.array([1.0, -1.0, 2.0, -2.0, 3.0, -3.0]), np.zeros(6))
    shared.print_verdict([alone])
    assert "Verdict: yes " in capsys.readouterr().out
    shared.print_verdict([alone, nothing, nothing])
    assert "Verdict: open (0 of 3 effects found, 6 seeds)" in capsys.readouterr().out


LEFT = {"study": ["quickstart-study.png", "quickstart-study.html"], "learning": ["quickstart-learning.png"]}
"""The files that a program of the quickstart leaves in the folder."""


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("study", r"gridworld +oracle +saves .*moves"),
        pytest.param("learning", r"learned .* moves wasted an episode", marks=pytest.mark.full),  # takes ten seconds
        ("agent", r"chat:agent .*\n.* oracle "),
    ],
)
def test_a_notebook_of_the_quickstart(name, says, tmp_path):
    """As a program, shortened; `python docs site` executes it whole. What it shows and writes stays in the folder."""
    shorter = {"LLF_QUICKSTART_SEEDS": "2", "LLF_QUICKSTART_LIVES": "4", "LLF_QUICKSTART_GENERATIONS": "1"}
    command = [sys.executable, ROOT / "docs" / "quickstart" / f"{name}.py"]
    environment = {**os.environ, "MPLBACKEND": "agg", **shorter}
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert re.search(says, result.stdout)
    left = re.findall(r"^(?:Figure|Report): (.+)$", result.stdout, re.MULTILINE)
    assert left == [f"{tmp_path / each}" for each in LEFT.get(name, ())]
    assert sorted(left) == sorted(map(str, tmp_path.iterdir()))


def test_efficiency():
    out = printed("efficiency", "--episodes", 40, "--workers", 1)
    assert "us of a core to play and check an episode" in out
    assert out.count("| processes, 1 workers | ") == 1
    assert "most memory of the parent" in out


@pytest.mark.parametrize(
    ("episodes", "least"), [(100, 0.0), pytest.param(3000, 0.6, marks=pytest.mark.full)], ids=["short", "whole"]
)
def test_both_seats_learn(episodes, least):
    out = printed("both_seats_learn", "--episodes", episodes)
    _, rule, first, *_, last = (line.split("|") for line in out.splitlines())
    assert rule[1] == "---"
    assert float(last[2]) >= least
    assert (float(first[2]) < 0.4) or not least


@pytest.mark.full
def test_learn_to_teach(tmp_path):
    """Needs the extra `learn`."""
    few = ("--steps", 2000, "--seeds", 3, "--episodes", 2)
    out = printed("learn_to_teach", *few, "--save", tmp_path / "teacher.zip", "--plot", tmp_path / "plot.png")
    assert "| learned | " in out
    assert "| announced mistake | " in out
    assert (tmp_path / "teacher.zip").stat().st_size > 10_000
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.full
def test_learn_by_budget(tmp_path):
    """Needs the extra `learn`. A second run trains nothing, and prints the same."""
    store = tmp_path / "it.jsonl"
    few = ("--steps", 2000, "--lifetimes", 3, "--budgets", 2, "--trainings", 1, "--without", "way")
    first, again = (printed("learn_by_budget", *few, "--store", store) for _ in range(2))
    assert first == again
    assert "| 2 | last iterate, without way | " in first
    rules, training = map(json.loads, store.read_text().splitlines())
    assert len(rules["announced mistake"]) == len(training["learned"]) == 3


@pytest.mark.full
def test_search_a_teacher(tmp_path):
    """Needs the extra `learn`. A second run trains nothing, and prints the same."""
    store = tmp_path / "it.jsonl"
    few = ("--generations", 2, "--lifetimes", 3, "--cases", "bandits", "without way", "--trainings", 2)
    first, again = (
        printed("search_a_teacher", *few, "--store", store, "--plot", tmp_path / "it.png") for _ in range(2)
    )
    assert first == again
    assert re.search(r"^\| bandits \| .*\(10\).* \| 2 \|$", first, re.MULTILINE)
    lines = [json.loads(line) for line in store.read_text().splitlines()]
    cases = [(case, seed) for case in ("bandits", "without way") for seed in (None, 0, 1)]
    assert [(line["case"], line.get("seed")) for line in lines] == cases
    assert all(len(line["last iterate"]) == 3 for line in lines if "seed" in line)
    assert (tmp_path / "it.png").stat().st_size > 10_000


@pytest.mark.full
def test_learned_teachers_beside_a_rule(tmp_path):
    """Needs `cma`. A second run lives no lifetime, and prints the same."""
    store = tmp_path / "it.jsonl"
    few = ("--lifetimes", 12, "--store", store, "--plot", tmp_path / "it.png")
    first, again = (printed("beside_a_rule", *few) for _ in range(2))
    assert first == again
    assert len(re.findall(r"\| (wins|loses|equal|undecided) \|$", first, re.MULTILINE)) == 5 + 2 * 4
    assert (tmp_path / "it.png").stat().st_size > 10_000


@pytest.mark.full
def test_verdicts_are_those_of_the_rule():
    """Needs `cma`. The tables of the page are what its store comes to."""
    page = (ROOT / "docs" / "internals" / "learn-to-teach.md").read_text(encoding="utf-8")
    tables = printed("beside_a_rule", "--store", ROOT / "docs" / "beside-a-rule.jsonl").split("\n\n")
    assert len(tables) == 2
    assert all(table.strip() in page for table in tables)


@pytest.mark.full
def test_a_choice_of_bits(tmp_path):
    """Needs `cma`."""
    few = ("--generations", 1, "--lessons", 6, "--store", tmp_path / "it.json")
    first, again = (printed("choose_bits", *few) for _ in range(2))
    assert first == again
    assert re.search(r"\| (wins|loses|equal|undecided) \|$", first, re.MULTILINE)


@pytest.mark.full
def test_check_suite(tmp_path):
    """Each known defect takes its ability away, and no other that does not rest on it; chance may spoil one cell."""
    out = printed("check_suite", "--keys", "test", "--store", tmp_path / "it.db", "--plot", tmp_path / "it.png")
    (faults,) = re.findall("Faults with test: (.*)", out)
    assert faults.count(";") == 0, faults
    assert (tmp_path / "it.png").stat().st_size > 10_000


@pytest.mark.full
def test_suite_gallery(tmp_path):
    """Other worlds order students alike."""
    students = ("random", "obedient", "text_only", "bayesian", "obedient | mishears(p=0.3)", "obedient(forget=False)")
    files = ("--store", tmp_path / "it.db", "--plot", tmp_path / "it.png", "--cards", tmp_path / "cards")
    out = printed("suite_gallery", "--keys", "one", "two", "--only", *students, *files)
    (found,) = re.findall(r"Rank correlation of 'one' and 'two', all scores: ([\d.]+)", out)
    assert float(found) > 0.9
    assert len(list((tmp_path / "cards").glob("*.json"))) == len(students)
    assert (tmp_path / "it.png").stat().st_size > 10_000


def test_families_order_students_alike_or_not(monkeypatch):
    """Pairs count that differ in both families; a student that played like another is no other."""
    monkeypatch.syspath_prepend(ROOT / "examples")
    check = importlib.import_module("check_suite")
    order = check.order
    noise = np.random.default_rng(0).normal(0, 0.1, (4, 2, 20))
    means = np.array([[0, 0], [1, 2], [2, 3], [3, 3]])  # by student and family; the last two differ in one only
    costs = list(means[:, :, np.newaxis] + noise)
    assert order(costs).tolist() == [5, 0, 1]
    assert order([*costs, costs[0], costs[3]]).tolist() == [5, 0, 1]
    assert order([each * [[1], [-1]] for each in costs]).tolist() == [0, 5, 1]
    assert order(costs[:1]).tolist() == order([]).tolist() == [0, 0, 0]
    table = check.families({"alike": [5, 0, 1], "opposite": [1, 5, 0], "few": [4, 0, 9]})
    assert re.findall("[^|]+(?= \\|$)", table, re.MULTILINE)[2:] == [" 1.00", " -0.67: not alike", " too few pairs"]


@pytest.mark.full
def test_suite_endpoint(tmp_path):
    out = printed("suite_endpoint", "--card", tmp_path / "card.html")
    assert "at most 72 episodes, 360 turns" in out
    assert "The student takes advice" in out
    assert re.search(r"360 answers, \d+ tokens in, \d+ out, 0\.03\d+ USD", out)
    assert (tmp_path / "card.html").stat().st_size > 10_000


def test_ways_to_ask(tmp_path, monkeypatch):
    """A model that copies the prompt, and one that answers for itself and obeys, as the table has them."""

    def model(request):
        way = re.findall(r"Go (north|east|west|south) next|$", request["messages"][-1]["content"])[0] or "north"
        thought = "says in a few words what you" if "thought" in json.dumps(request["response_format"]) else "I go"
        return json.dumps({"thought": thought, "action": way})

    with ScriptedEndpoint(model) as server:
        monkeypatch.setenv("LLF_LLM_BASE_URL", server.url)
        common = ("--ids", "llf-gridworld-v0", "--seeds", 1, "--turns", 2, "--workers", 1)
        lines = printed("ways_to_ask", tmp_path, "m", "--ways", "why", "why-", *common).splitlines()
    copied, own = map(json.loads, lines)
    assert (copied["way"], copied["answers"], copied["actions"], copied["copies"]) == ("why", 4, 4, 4)
    assert (own["way"], own["copies"]) == ("why-", 0)
    assert own["regret oracle"] <= own["regret silent"]
    assert len((tmp_path / "table.jsonl").read_text().splitlines()) == 2


def test_model_teachers(tmp_path, monkeypatch):
    """A model that says all that it is shown, and repeats what the student sees if it is shown nothing."""

    def model(request):
        lines = request["messages"][-1]["content"].partition("True now:\n")[2].splitlines()
        return json.dumps({"claims": [*map(json.loads, lines)] or [{"type": "TryAgain"}, {"type": "Fly"}]})

    with ScriptedEndpoint(model) as server:
        monkeypatch.setenv("LLF_LLM_BASE_URL", server.url)
        common = ("--ids", "llf-gridworld-v0", "--seeds", 1, "--turns", 3, "--options", ", answer='json'")
        lines = printed("model_teachers", tmp_path, "m", *common).splitlines()
    knowing, blind = map(json.loads, lines)
    assert knowing["claims"] == sum(true for true, _ in knowing["kinds"].values()) > 3
    assert (knowing["advises"], knowing["repeats"], knowing["unbuilt"]) == (3, 0, 0)
    assert knowing["regret"]["model"] == knowing["regret"]["oracle"] < knowing["regret"]["silent"]
    assert (blind["answers"], blind["repeats"], blind["nothing"], blind["unbuilt"]) == (4, 3, 1, 5)
    assert blind["regret"]["model"] == blind["regret"]["silent"]
    assert len((tmp_path / "table.jsonl").read_text().splitlines()) == 2
