"""The command line, as a user meets it."""

import contextlib
import json
import pkgutil
import re
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from commands import llf, llf_apart

import llf_teacher
import llf_teacher.cli.dev
from llf_teacher.cli import app, complete_teacher
from teachers.personalities.mistake import mistake

STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "silent"]
students = ["obedient"]
seeds = 2
"""


def test_list(tmp_path):
    result = llf_apart("list", cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    for id in llf_teacher.ids():
        assert f"  {id}\n" in result.stdout
    assert "mistake(eps=0.1)" in result.stdout
    assert "text_only" in result.stdout


def test_list_what_matches(tmp_path):
    result = llf("list", "mistake", cwd=tmp_path, COLUMNS="160")
    words = " ".join(result.stdout.split())
    assert re.search(r"^mistake\(eps=0.1\) +no ", result.stdout, re.MULTILINE)
    assert re.search(r"^mistake_correcting\(.*\) +yes ", result.stdout, re.MULTILINE)
    assert "counterpart is withheld." in words
    assert "in our seats it has acted" in words
    assert "Environments" not in words
    result = llf("list", "llf-*-Booth-*", cwd=tmp_path)
    assert [line.strip() for line in result.stdout.splitlines() if "llf-" in line] == ["llf-optimization-Booth-v0"]
    result = llf("list", "misstake", cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert "unknown name 'misstake'; did you mean mistake" in result.stderr


def test_a_name_between_colons_stays_as_it_is(tmp_path):
    """Rich would show `:ferry:` as a picture of a ferry."""
    (tmp_path / "ferry.py").write_text("", encoding="utf-8")
    assert "gym:ferry:Fery" in llf("teach", "ferry:Fery", cwd=tmp_path).stderr
    for path in Path(llf_teacher.__file__).parent.rglob("*.py"):
        if "dev" not in path.parts:
            for call in re.findall(r"\bConsole\(.*", path.read_text(encoding="utf-8")):
                assert call.startswith("Console(emoji=False"), path


def test_a_list_that_nobody_reads_to_its_end(tmp_path):
    command = [sys.executable, "-m", "llf_teacher", "list"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait() in (0, 1)


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["play", "llf-gri"], ["llf-gridworld-v0"]),
        (["film", "llf-poem-H"], ["llf-poem-Haiku-v0"]),
        (["play", "llf-gridworld-v0", "--teacher", "mistake_"], ["mistake_correcting"]),
        (["play", "llf-gridworld-v0", "--student", "text"], ["text_only"]),
    ],
)
def test_shells_complete_names(tmp_path, typed, offered):
    asked = {"_LLF_COMPLETE": "complete_bash", "COMP_WORDS": " ".join(["llf", *typed]), "COMP_CWORD": f"{len(typed)}"}
    result = llf(cwd=tmp_path, **asked)
    assert result.stdout.split() == offered, result.stderr


def test_the_last_stage_of_a_spec_is_completed():
    assert complete_teacher("mistake(eps=0.2) | dela") == ["mistake(eps=0.2) | delayed"]


def test_a_file_is_run(tmp_path):
    (tmp_path / "my.toml").write_text(STUDY)
    result = llf("study", "my.toml", "--store", "a.db", "--report", "a.html", "--workers", "1", cwd=tmp_path)
    assert "Played 4 episodes" in result.stderr
    assert (tmp_path / "a.html").exists()


def test_a_study_from_file_to_report(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    command = ("study", "run", "study.toml", "--store", "a.db", "--report", "a.html", "--workers", "1")
    result = llf_apart(*command, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "Played 4 episodes" in result.stderr
    assert "<svg" in (tmp_path / "a.html").read_text(encoding="utf-8")
    again = llf(*command, cwd=tmp_path)
    assert "Played 0 episodes" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("study", "none.toml"), "No such file"),
        (("study", "run", "none.toml"), "none.toml: "),
        (("study", "run", "bad.toml"), "unknown personality 'orakle'; did you mean oracle"),
        (("study", "run", "study.toml", "--store", "notes.db"), "cannot use notes.db as a store"),
        (("study", "run", "study.toml", "--store", "none/s.db"), "cannot use none/s.db as a store"),
        (("study", "run", "study.toml", "--report", "none/r.html"), "none"),
        (("study", "run", "renamed.toml"), "unknown factory in agents_of_mine 'Old'; allowed: New"),
        (("dev", "tables", "missing.md"), "cannot read missing.md: "),
        (("dev", "golden", "notes.db/folder", "llf-gridworld-v0"), "notes.db"),
        (("play", "llf-gridwold-v0"), "did you mean llf-gridworld-v0"),
        (("play", "llf-gridworld-v0", "--feedback-type", "q"), "feedback type 'q'"),
        (("play", "llf-gridworld-v0", "--seat", "janitor"), "seat 'janitor' is unknown; allowed: student, teacher"),
        (("film", "llf-gridworld-v0", "out.avi"), "a film's name must end in one of .gif, .webp, .mp4, got 'out.avi'"),
        (("dev", "golden", "folder", "nothing"), "unknown environment 'nothing'"),
        (("audit", "llf-gridwold-v0"), "did you mean llf-gridworld-v0"),
        (("audit", "--teacher", "orakle"), "did you mean oracle"),
        (("audit", "--voice", "shrill"), "unknown voice 'shrill'; allowed: plain, curt, socratic, warm, the path of"),
        (("audit", "--voice", "shrill:voice"), "cannot load the voice 'shrill:voice': No module named 'shrill'"),
        (("audit", "--voice", "string:digits"), "the voice 'string:digits' must be a function"),
    ],
)
def test_a_mistake_is_one_line_and_status_2(tmp_path, arguments, said):
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "bad.toml").write_text(STUDY.replace("oracle", "orakle"))
    (tmp_path / "renamed.toml").write_text(STUDY.replace("obedient", "agents_of_mine:Old"))
    (tmp_path / "agents_of_mine.py").write_text("class New:\n    pass\n")
    (tmp_path / "notes.db").write_text("not a database " * 100)
    result = llf(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert said in result.stderr
    assert result.stderr.startswith("llf: ")
    assert len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "study.db").exists()


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        ("DROP TABLE story", "its story is missing"),
        ("DROP VIEW episode; ALTER TABLE result DROP COLUMN regret", "its result is defined otherwise"),
        ("DELETE FROM story WHERE number = 1", "an episode is incomplete"),
        ("DELETE FROM result", "an episode is incomplete"),
    ],
)
def test_a_damaged_store_is_one_line_and_stays_as_it_is(tmp_path, harm, said):
    (tmp_path / "study.toml").write_text(STUDY)
    command = ("study", "run", "study.toml", "--executor", "here")
    assert llf(*command, cwd=tmp_path).returncode == 0
    path, report = tmp_path / "study.db", tmp_path / "study.html"
    report.unlink()
    with contextlib.closing(sqlite3.connect(path)) as store, store:
        store.executescript(harm)
    before = path.read_bytes()
    result = llf(*command, cwd=tmp_path)
    assert result.returncode == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert said in result.stderr
    assert "take it by --store" in result.stderr
    assert path.read_bytes() == before
    assert not report.exists()


def test_a_store_is_checked(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    assert llf("study", "run", "study.toml", "--executor", "here", cwd=tmp_path).returncode == 0
    result = llf("study", "check", "study.db", cwd=tmp_path)
    assert result.returncode == 0
    assert result.stdout.endswith(" episodes, all as they were written.\n")
    with contextlib.closing(sqlite3.connect(tmp_path / "study.db")) as store, store:
        store.execute("UPDATE result SET regret = regret + 1e-9 WHERE number = 2")
    result = llf("study", "check", "study.db", cwd=tmp_path)
    assert result.returncode == 1
    assert result.stderr.startswith("study.db, result, row 2: the episode ")


def test_the_short_form_of_a_study_takes_the_options_of_run_in_any_order(tmp_path):
    shown = llf("study", "--help", COLUMNS="200").stdout
    assert shown.index("is short for `llf study run FILE.toml`") < shown.index("--retry-failed")
    (tmp_path / "study.toml").write_text(STUDY + "max_turns = 2\n")
    given = ("--store", "other.db", "--workers", "1", "study.toml", "--fail-fast", "--report", "other.html")
    result = llf("study", *given, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.db", "other.html", "study.toml"]


def test_a_study_without_any_episode_played_has_no_report(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY.replace("obedient", "agents_of_mine:Broken"))
    (tmp_path / "agents_of_mine.py").write_text(
        "class Broken:\n    def act(self, observation):\n        return 1 / 0\n"
    )
    result = llf("study", "run", "study.toml", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 3
    assert "division by zero" in result.stderr
    assert "Played 0 episodes" in result.stderr
    assert not (tmp_path / "study.html").exists()


def test_play(tmp_path):
    result = llf("play", "llf-gridworld-v0", "--seed", "0", "--max-turns", "2", cwd=tmp_path, text="up\nnorth\neast\n")
    assert result.returncode == 0, result.stderr
    text = " ".join(result.stdout.split())
    assert "north (0), east (1), west (2), south (3)" in text
    assert "one of north, east, west, south" in text
    assert "Over after 2 turns" in result.stdout


def test_play_the_teacher(tmp_path):
    command = ("play", "llf-gridworld-v0", "--seat", "teacher", "--seed", "3", "--budget", "20")
    result = llf(*command, cwd=tmp_path, text="fp\npraise+advice\nx\na\n" + "fp\n" * 20)
    assert result.returncode == 0
    assert "Say which kinds, such as praise+advice or hp+fp?" in result.stdout
    assert re.search(r"^  fp advice: Go (north|east|west|south) next\.$", result.stdout, re.MULTILINE)
    assert "Direction" not in result.stdout
    allowed = (
        "Type some of reward (r), praise (hp), blame (hn), advice (fp), warning (fn), a for all of them, or nothing;"
    )
    assert allowed in " ".join(result.stdout.split())
    assert re.search(r"Over after \d turns: solved, total reward 0\.\d+\.", result.stdout)


def test_play_the_teacher_with_a_small_budget(tmp_path):
    command = ("play", "llf-gridworld-v0", "--seat", "teacher", "--seed", "3", "--student", "random", "--budget", "2")
    result = llf(*command, "--max-turns", "4", cwd=tmp_path, text="fp\n\nfp\n\n\n")
    text = " ".join(result.stdout.split())
    assert "(a: all, empty: none; 2 of 2 left)>" in text
    assert text.count("1 of 2 left") == 2
    assert text.count("Your budget of 2 is spent, so that you can say nothing more. Enter to go on>") == 2
    assert "Over after 4 turns" in text


def test_play_a_text_of_several_lines(tmp_path):
    lines = "rain taps on the tin\nnobody answers the bell\none cup on the sill\n\n"
    result = llf("play", "llf-poem-Haiku-v0", "--max-turns", "1", cwd=tmp_path, text=lines)
    assert "Over after 1 turns: solved, total reward 0." in result.stdout


def test_play_commands_of_one_line(tmp_path):
    result = llf("play", "llf-alfworld-v0", "--max-turns", "2", "--seed", "1", cwd=tmp_path, text="look\ninventory\n")
    assert "Over after 2 turns" in result.stdout, result.stderr


def test_leaving(tmp_path):
    result = llf("play", "llf-gridworld-v0", cwd=tmp_path)
    assert result.returncode == 0
    assert "You left the episode" in result.stdout


def test_audit(tmp_path):
    teachers = ("--teacher", "oracle", "--teacher", "mistake(eps=0.5)")
    result = llf("audit", "llf-gridworld-v0", "llf-poem-[HT]*", *teachers, "--turns", "20", cwd=tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr
    assert [line for line in result.stdout.splitlines() if line.startswith("llf-")] == [
        "llf-gridworld-v0",
        "llf-poem-Haiku-v0",
        "llf-poem-Tanka-v0",
    ]
    summary = "By teachers that promise honesty (3 of 6 audits): 0 false claims, 0 contradictions. By all: 0 leaks."
    assert summary in " ".join(result.stdout.split())
    assert max(map(len, result.stdout.splitlines())) <= 80


def test_audit_as_json(tmp_path):
    result = llf("audit", "llf-gridworld-v0", "--turns", "60", "--json", cwd=tmp_path)
    (found,) = json.loads(result.stdout)
    assert (found["id"], found["teacher"], found["turns"]) == ("llf-gridworld-v0", "oracle", 60)
    assert found["held"] == 1
    assert found["claims"]["fp"]["truthful"] >= 60


def test_audit_by_family(tmp_path):
    chosen = [
        "--teacher",
        "oracle",
        "--teacher",
        "vague",
        "--teacher",
        "mistake(eps=1)",
        "llf-bandits-*Low*",
        "llf-gr*",
    ]
    result = llf("audit", "--turns", "20", "--workers", "1", "--by-family", *chosen, cwd=tmp_path)
    names, *rows = (line.split() for line in result.stdout.splitlines())
    assert names[:3] + names[-2:] == [
        "family",
        "environments",
        "turns",
        "contradictions",
        "mistake(eps=1)",
    ]
    assert [row[:3] for row in rows] == [["bandits", "2", "40"], ["gridworld", "1", "20"]]
    for row in rows:
        honest, claims, false, contradictions, wrong, _, all_ = row[9:]
        assert (honest, false, contradictions) == ("2", "0", "0")
        assert int(claims.replace(",", "")) > 0 < int(wrong) == int(all_)


def test_audit_catches_a_liar_who_promises_honesty(tmp_path, monkeypatch):
    monkeypatch.setattr(mistake, "honest", True)
    result = llf("audit", "llf-gridworld-v0", "--turns", "30", "--teacher", "mistake(eps=1)", cwd=tmp_path)
    assert result.returncode == 1
    assert "mistake(eps=1): false" in result.stdout
    assert "seed 0, turn" in " ".join(result.stdout.split())


def test_audit_leaves_out_what_cannot_be_served(tmp_path):
    ids, teachers = ("llf-gridworld-v0", "llf-poem-*"), ("--teacher", "noisy", "--teacher", "skip")
    result = llf("audit", *ids, *teachers, "--turns", "30", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 0
    assert result.stderr.count("left out") == 1
    assert "left out: poem does not support noisy, skip" in result.stderr
    result = llf("audit", "llf-poem-Haiku-v0", "--teacher", "noisy", cwd=tmp_path)
    assert result.returncode == 2
    assert "none of these teachers can teach in these environments" in result.stderr


def test_audit_of_a_shelf(tmp_path):
    """Patterns stand for names of personalities, as they do for ids."""
    teachers = ("--teacher", "oracle", "--teacher", "*_focused", "--teacher", "mistake(eps=1)")
    command = ("audit", "llf-gridworld-v0", *teachers, "--turns", "12", "--workers", "1", "--json")
    result = llf(*command, cwd=tmp_path)
    said = [found["teacher"] for found in json.loads(result.stdout)]
    assert said == ["oracle", "punishment_focused", "reward_focused", "mistake(eps=1)"]
    result = llf("audit", "llf-gridworld-v0", "--teacher", "*_blurred", cwd=tmp_path)
    assert result.returncode == 2
    assert "*_blurred" in result.stderr


def test_audit_of_a_voice(tmp_path):
    """A curt teacher says the same in fewer words; what a rewriting voice changes is counted and shown."""
    words = {}
    for voice in ("plain", "curt"):
        result = llf("audit", "llf-gridworld-v0", "--turns", "30", "--voice", voice, "--json", cwd=tmp_path)
        (found,) = json.loads(result.stdout)
        words[voice] = found["words_per_turn"]
        assert (found["changes"], found["changed"]) == (0, [])
    assert words["curt"] < words["plain"]
    (tmp_path / "muddle.py").write_text("def swap(sentence):\n    return sentence.replace('north', 'south')\n")
    result = llf("audit", "llf-gridworld-v0", "--turns", "60", "--voice", "muddle:swap", cwd=tmp_path)
    assert result.returncode == 0
    assert re.search(r"leaks +dictions +changed", result.stdout)
    assert "llf-gridworld-v0, oracle: changed by the voice" in result.stdout
    assert "vanished: north; appeared: south" in result.stdout
    assert max(map(len, result.stdout.splitlines())) <= 80


def test_tables(tmp_path):
    path = tmp_path / "page.md"
    path.write_text("# Page\n<!-- llf dev tables: matrix -->\nold\n<!-- end -->\nrest\n", encoding="utf-8")
    assert llf("dev", "tables", str(path), cwd=tmp_path).returncode == 0
    (tmp_path / "docs").mkdir()
    printed = llf("dev", "tables", cwd=tmp_path / "docs").stdout
    page = path.read_text(encoding="utf-8")
    table = page.partition("-->\n")[2].partition("<!--")[0]
    assert table in printed
    assert page == f"# Page\n<!-- llf dev tables: matrix -->\n{table}<!-- end -->\nrest\n"
    assert "| `oracle` |  | yes |" in table
    path.write_text(page.replace(table, "old\n"), encoding="utf-8")
    twin = tmp_path / "docs" / "twin.md"
    twin.write_text("<!-- llf dev tables: families -->\n<!-- end -->\n", encoding="utf-8")
    (tmp_path / "docs" / "other.md").write_text("no place", encoding="utf-8")
    assert llf("dev", "tables", cwd=tmp_path).stdout.split() == ["docs/twin.md", "page.md"]
    assert path.read_text(encoding="utf-8") == page
    assert (
        twin.read_text(encoding="utf-8").removeprefix("<!-- llf dev tables: families -->\n").partition("<!--")[0]
        in printed
    )


def test_golden(tmp_path):
    result = llf("dev", "golden", "here", "llf-gridworld-v0", cwd=tmp_path)
    assert result.returncode == 0
    assert sorted(path.name for path in (tmp_path / "here").iterdir()) == ["llf-gridworld-v0.txt", "pictures.toml"]


def test_no_arguments_show_help(tmp_path):
    assert "study" in llf_apart(cwd=tmp_path).stdout


def commands(group, *path):
    """Every command, by the words that call it."""
    yield path
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, *path, name)


COMMANDS = list(commands(typer.main.get_command(app)))


def test_commands_for_users_and_for_developers():
    assert {path[0] for path in COMMANDS if path} == {
        *("list", "play", "teach", "serve", "study", "suite", "audit", "film", "models", "new", "dev")
    }
    developers = {path[1] for path in COMMANDS if path[:1] == ("dev",) and len(path) > 1}
    assert developers == {module.name for module in pkgutil.iter_modules(llf_teacher.cli.dev.__path__)}


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_command_has_help(path):
    """The long and the short option show the same; flags show no type, and every parameter is described."""
    long, short = (llf(*path, option, COLUMNS="120") for option in ("--help", "-h"))
    assert (long.returncode, short.returncode) == (0, 0)
    assert long.stdout == short.stdout
    assert "bool" not in long.stdout.lower()
    rows = [line for line in long.stdout.splitlines() if re.match(r"│ +(\* +)?-", line)]
    assert rows
    for row in rows:
        assert re.search(r"[A-Z0-9][^│]{3,}│$", row), row


def options_in(text):
    return set(re.findall(r"^│ +(?:\* +)?(--[a-z-]+)", text, re.MULTILINE)) - {"--help", "--advanced"}


@pytest.mark.parametrize("path", [each for each in COMMANDS if each and each[0] != "dev"], ids=" ".join)
def test_help_shows_few_options_and_the_rest_with_advanced(path):
    command = typer.main.get_command(app)
    for name in path:
        command = command.commands[name]
    own = {param.opts[0] for param in command.params if param.param_type_name == "option"} - {"--advanced"}
    few = options_in(llf(*path, "--help", COLUMNS="120").stdout.split("is short for")[0])
    assert few <= own
    assert len(few) <= 5
    if few != own:
        assert options_in(llf(*path, "--advanced", COLUMNS="120").stdout) == own


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (("plya",), "unknown command 'plya'; did you mean play? allowed: audit, dev, film, "),
        (("study", "reprot"), "unknown command 'reprot'; did you mean report"),
        (("dev", "comapre"), "unknown command 'comapre'; did you mean compare"),
        (("benchmrk",), "unknown command 'benchmrk'; did you mean dev benchmark?"),
    ],
)
def test_a_mistyped_command_names_the_nearest(tmp_path, typed, said):
    result = llf(*typed, cwd=tmp_path)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith(f"llf: {said}")
    assert len(result.stderr.splitlines()) == 1


def test_audit_of_bits(tmp_path):
    ids = ("llf-gridworld-v0", "llf-poem-Haiku-v0")
    result = llf("audit", *ids, "--turns", "30", "--workers", "1", "--bits", "8", cwd=tmp_path)
    assert result.returncode == 0
    assert "left out: poem: bits cannot be measured there" in result.stderr
    assert re.search(r"dictions +bits +a word +saved +a bit *\n +oracle .* \d\.\d\d +\d\.\d\d\d +", result.stdout)
    result = llf("audit", ids[0], "--turns", "30", "--bits", "8", "--by-claim", cwd=tmp_path)
    assert re.search(r"measured +bits +a word +saved +a bit", result.stdout)
    assert re.search(r"gridworld +Go .* \d\.\d\d +\d\.\d\d\d ", result.stdout)
    result = llf("audit", ids[0], "--by-claim", cwd=tmp_path)
    assert (result.returncode, "give --bits too" in result.stderr) == (2, True)


def test_a_teacher_sees_how_much_its_claims_would_say(tmp_path):
    play = ("play", "llf-bandits-BanditTenArmedGaussian-v0", "--seed", "1", "--bits", "32")
    result = llf(*play, "--seat", "teacher", cwd=tmp_path, text="fp\nundo\nfp\nquit\n")
    offered = re.findall(r"^  fp .*  (\d\.\d\d|at least \d\.\d) bits", result.stdout, re.MULTILINE)
    assert offered[1] == offered[3] == "0.00"  # what was said is known
    assert offered[0] != "0.00" != offered[2]  # what was taken back is not
    result = llf(*play, cwd=tmp_path)
    assert "a student cannot see how much claims say; use --seat teacher" in result.stderr
