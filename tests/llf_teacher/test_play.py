"""`llf play`: what a person sees in the terminal, in both seats."""

import contextlib
import io
import re

import pytest
from commands import llf

from pz_envs.family import own_families
from teachers import terminal
from teachers.atoms import KINDS
from teachers.terminal import Waiting
from teachers.words import KIND_MEANINGS

GRID = "llf-gridworld-v0"
LEFT = r"(None|\d+) of the \d+ checked sentences (was|were) false\.\n(  .*\n)*You left the episode\.\n\Z"
COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-9][0-9;]*m")


def play(*arguments, text, **environment):
    with pytest.MonkeyPatch.context() as patch:
        for name in ("NO_COLOR", "FORCE_COLOR"):
            patch.delenv(name, raising=False)
        result = llf("play", *arguments, text=text, **environment)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_the_student_sees_turns_rewards_and_a_map():
    out = play(GRID, "--seed", "7", "--max-turns", "2", text="west\nsouth\n")
    assert "Turn 0 of 2, 2 left; reward 0 in all\n" in out
    assert "Turn 1 of 2, 1 left; reward 0 in all\nThe student: west (reward 0)\n" in out
    assert "[cellar-1]" in out
    assert re.search(r"^advice: \w", out, re.MULTILINE)


@pytest.mark.parametrize(
    ("command", "text"),
    [
        ((), "west\nsouth\n"),
        ((), "west\nq\n"),
        (("--seat", "teacher"), "a\n" * 3),
        (("--student", "obedient"), ""),
    ],
)
def test_the_end_tells_which_sentences_were_false(command, text):
    """The same as the episode's record, also if a person leaves."""
    given = (GRID, "--teacher", "mistake(eps=0.5)", "--seed", "7", "--max-turns", "2", *command)
    out = play(*given, text=text)
    turn, end = r"  turn \d, (?:reward|praise|blame|advice|warning): ", out[out.rindex("checked sentences") - 20 :]
    number, checked = map(int, re.search(r"(\d+) of the (\d+) checked sentences were false\.", end).groups())
    assert 0 < number < checked
    assert len(re.findall(f"^{turn}", end, re.MULTILINE)) == number
    if command == ("--student", "obedient"):
        assert out.count("[✗ false]") == number
        assert out.count("[✓ true]") == checked - number


def test_an_honest_teacher_said_nothing_false():
    out = play(GRID, "--seed", "7", "--max-turns", "1", text="west\n")
    assert re.search(r"\nNone of the \d+ checked sentences was false\.\n\Z", out)


def test_what_is_not_checked_is_counted():
    command = (GRID, "--seat", "teacher", "--own-words", "--seed", "7", "--max-turns", "2")
    out = " ".join(play(*command, text="\nNow head south.\nHm.\n").split())
    assert out.endswith(
        "1 of the 6 checked sentences was false. Not checked: 1; words that are not read, and hedges, are neither true "
        "nor false. turn 1, advice: Now head south."
    )


def test_an_empty_line_repeats_nothing():
    quick, slow = (play(GRID, "--seed", "7", "--max-turns", "1", text=text) for text in ("west\n", "\n  \n\nwest\n"))
    assert slow == quick.replace("Turn 1> ", "Turn 1> " * 4)


@pytest.mark.parametrize(
    ("id", "turn"),
    [
        (GRID, "west\n"),
        pytest.param("llf-poem-Haiku-v0", "one\ntwo\n\n", marks=pytest.mark.full),
        pytest.param("llf-alfworld-v0", "look\n", marks=pytest.mark.full),
    ],
)
def test_a_turn_is_taken_back(id, turn):
    """What is seen then is what was seen before it; and what comes of the same turn is the same again."""
    once = play(id, "--seed", "7", "--max-turns", "2", text=turn + turn)
    again = play(id, "--seed", "7", "--max-turns", "2", text=f"{turn}undo\n{turn}{turn}")
    head, _, tail = again.partition("The last turn is taken back.\n\n")
    assert tail
    greeting, _, rest = once.partition("\n\n")
    assert head.startswith(greeting)
    assert rest == tail
    assert "There is no turn to take back" in play(id, "--seed", "7", text="undo\n")


def test_the_teacher_sees_the_truth_and_takes_a_turn_back():
    command = (GRID, "--seat", "teacher", "--seed", "3", "--max-turns", "2", "--student", "q_learning")
    once = play(*command, text="fp\na\na\n")
    again = play(*command, text="fp\nundo\nfp\na\na\n")
    assert re.search(r"\*[a-z]+-\d+\*", once)  # the treasure
    assert "Over after 2 turns" in again
    assert again.partition("The last turn is taken back.\n\n")[2] == once[once.index("Turn 0 of 2") :]


def test_the_teacher_may_speak_in_its_own_words_and_sees_what_is_understood():
    command = (GRID, "--seat", "teacher", "--own-words", "--seed", "3", "--max-turns", "2", "--student", "obedient")
    said = "\n?\nNow head north. \x1b[31mLovely day.\nundo\nHm.\nThat was right.\n"
    out = " ".join(play(*command, text=said).split())
    assert out.count("Your task is to enter its room.") == 3, "suggested, said, and explained"
    assert re.search(r"(true|false): Now head north\. Go\(action=", out)
    assert re.search(r"unchecked: .{0,10}Lovely day\. not read ", out)
    assert "\x1b" not in out
    assert out.count("Your first words are the instruction, not checked. What do you say? (empty: the text") == 1
    assert "What do you say? (empty: nothing)>" in out
    assert "unchecked: Hm." in out
    assert "The last turn is taken back." in out
    assert re.search(r"(true|false): That was right\.", out)
    long = " ".join(play(*command, text=f"\n{'x' * 70_000}\nHm.\nHm.\n").split())
    assert long.count("Nothing is said: at most 65536 characters are allowed, got 70000.") == 1
    assert "Over after 2 turns" in long
    refused = llf("play", GRID, "--own-words", text="")
    assert "a student says nothing; use --seat teacher" in refused.stderr


def test_with_and_without_colours():
    plain = play(GRID, "--seed", "7", "--max-turns", "1", text="west\n")
    assert "\x1b" not in plain
    coloured = play(GRID, "--seed", "7", "--max-turns", "1", text="west\n", FORCE_COLOR="1", TERM="xterm-256color")
    assert COLOUR.search(coloured)
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plain
    without = play(
        GRID, "--seed", "7", "--max-turns", "1", text="west\n", FORCE_COLOR="1", NO_COLOR="1", TERM="xterm-256color"
    )
    assert not COLOUR.search(without)


def test_a_seed_that_is_drawn_is_told():
    first = play(GRID, "--max-turns", "1", text="west\n")
    seed = re.match(r"Seed (\d+)\. ", first)[1]
    assert play(GRID, "--max-turns", "1", "--seed", seed, text="west\n") == first


@pytest.mark.parametrize("word", ["help", "?", "norht", "west or east", "Help", "q", "Quit", "exit", ":q"])
def test_what_is_no_action_costs_no_turn(word):
    out = play(GRID, "--seed", "7", "--max-turns", "2", text=f"{word}\nwest\nsouth\n")
    assert "not understood" not in out
    assert " q or Ctrl-D to leave.\n" in out
    if word.strip(":").lower() in ("q", "quit", "exit"):
        assert re.search(r"Turn 1> \n" + LEFT, out)
        return
    assert out.count("Turn 1> ") == 2
    assert "Over after 2 turns" in out
    said = out.partition("Turn 1> ")[2].partition("Turn 1> ")[0]
    assert ("treasure" in said) == (word.lower() in ("help", "?"))
    assert ("No turn is lost: it " in said and "Expected: " in said) == (word in ("norht", "west or east"))


def test_what_a_world_does_not_list_costs_no_turn():
    """ALFWorld's engine takes any text for a command; it has a `help` of its own, which says what the rules say."""
    out = play("llf-alfworld-v0", "--seed", "7", "--max-turns", "9", text="help\ngo to frige 1\nlook\nquit\n")
    assert out.count("Turn 1> ") == 3
    assert "No turn is lost: unknown action 'go to frige 1'; did you mean go to fridge 1 or " in out
    assert re.search(r"Turn 2> \n" + LEFT, out)
    assert "Nothing happens" not in out
    assert "Available commands" not in out


def test_a_seed_is_at_least_0():
    refused = llf("play", GRID, "--seed", "-1")
    assert refused.returncode == 2
    assert "Traceback" not in refused.stderr
    assert "'--seed'" in refused.stderr


def test_kinds_are_explained_to_both_seats():
    for seat, answers in (("student", "?\nquit\n"), ("teacher", "what\n?\nall\nquit\n")):
        out = play(GRID, "--seed", "7", "--seat", seat, text=answers)
        for kind in KINDS:
            assert re.search(rf"^{kind:2} {re.escape(KIND_MEANINGS[kind])}$", out, re.MULTILINE)
        assert ("or nothing; ? explains them." in out) == (seat == "teacher")


@pytest.mark.parametrize("family", own_families(), ids=lambda family: family.name)
def test_nothing_is_wider_than_the_terminal_and_no_word_is_cut(family):
    """In both seats of each family, at 80 columns and at 40."""
    if why := family.missing():
        pytest.skip(why)
    id = f"llf-{family.showcase[0]}"
    for seat, text in (("student", "?\n"), ("teacher", "a\na\n")):
        settings = (id, "--seat", seat, "--seed", "4", "--max-turns", "3")
        wide, *others = (  # a person's Enter ends the line of a question
            play(*settings, text=text, COLUMNS=columns).replace("> ", ">\n") for columns in ("2000", "80", "40")
        )
        for columns, out in zip((80, 40), others, strict=True):
            assert max(map(len, out.splitlines())) <= columns
            there = re.sub(r"A\s+part\s+of\s+the\s+map,\s+which\s+is\s+\d+\s+columns\s+wide\.", "", out)
            words = [word for word in there.split() if len(word) < columns // 2]
            assert not {*words} - {*wide.split(), "…"}


def test_a_map_shows_the_treasure_at_100_columns_or_says_that_it_is_cut():
    """Seven rooms side by side."""
    settings = (GRID, "--seat", "teacher", "--seed", "1061429465")
    whole, cut = (play(*settings, text="q\n", COLUMNS=columns) for columns in ("100", "60"))
    assert re.search(r"\*[a-z]+-\d\*", whole)
    assert "A part of the map" not in whole
    assert re.search(r"^A part of the map, which is \d\d columns wide\.$", cut, re.MULTILINE)


@pytest.mark.parametrize("last", ["quit\n", "a first line\n:q\n"])
def test_a_poem_may_be_left_and_explained(last):
    out = play("llf-poem-Haiku-v0", "--seed", "7", text=f"?\n{last}")
    assert out.count("Turn 1 (an empty line ends it)> ") == 2
    assert "Where q may be an answer, :q leaves." in " ".join(out.split())
    assert out.endswith("\nYou left the episode.\n")


@pytest.mark.parametrize("word", ["q", "quit", "exit", ":q"])
@pytest.mark.parametrize("before", ["", "fp\n"])
def test_the_teacher_leaves_at_each_question(word, before):
    """Also when the budget is spent, where an empty line goes on."""
    command = (GRID, "--seat", "teacher", "--seed", "3", "--budget", "1")
    out = play(*command, text=f"{before}{word}\n")
    assert re.search(r"> \n" + (LEFT if before else r"You left the episode\.\n\Z"), out)
    assert ("budget of 1 is spent" in out) == bool(before)


def test_a_word_that_is_an_action_is_taken(tmp_path, monkeypatch):
    """What stands behind a colon leaves."""
    (tmp_path / "hall.py").write_text(HALL)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    out = play("gym:hall:Hall", "--seed", "1", text="quit\n:q\n")
    assert "The student: quit (reward 0)" in out
    assert re.search(r"Turn 2> \n" + LEFT, out)


HALL = """
import gymnasium
from gymnasium.spaces import Discrete


class Hall(gymnasium.Env):
    observation_space, action_space = Discrete(9), Discrete(2)

    def get_action_meanings(self):
        return ["quit", "enter"]

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place = 4
        return self.place, {}

    def step(self, action):
        self.place += 1 if action else -1
        over = self.place in (0, 8)
        return self.place, float(self.place == 8), over, False, {}
"""


def test_a_terminal_shows_that_the_first_lesson_is_prepared(monkeypatch):
    """On standard error, until it is there; what else takes long has its bar meanwhile."""
    said = io.StringIO()
    said.isatty = lambda: True
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    with contextlib.redirect_stderr(said), Waiting("Preparing :cat: [b]") as waiting:
        bar = terminal.error_console().status("another")
        terminal.show(bar)
        terminal.hide(bar)
        waiting.say("Nearly :cat:")
    shown = said.getvalue()
    assert shown.index("Preparing :cat: [b]") < shown.index("another") < shown.rindex(":cat:")
    assert "Nearly :cat:" in shown
    assert shown.endswith("\x1b[2K")  # nothing of it stays
    with contextlib.redirect_stderr(io.StringIO()) as silent, Waiting("Preparing"):
        pass
    assert silent.getvalue() == ""


def test_a_wide_map_fits_the_terminal():
    """It shows the rooms around where the student is."""
    settings = (GRID, "--seat", "teacher", "--seed", "4", "--max-turns", "1")
    wide, narrow = (play(*settings, text="a\n", COLUMNS=columns) for columns in ("200", "50"))

    def rows(out):
        shown = out.partition("left; reward 0 in all\n")[2].partition("Room: ")[0].splitlines()
        return [row for row in shown if not row.startswith("A part of the map")]

    assert max(map(len, rows(wide))) > 50
    assert max(map(len, rows(narrow))) <= 50
    assert len(rows(narrow)) == len(rows(wide))
    assert any("[" in row and "]" in row for row in rows(narrow))
    for row, line in zip(rows(narrow), rows(wide), strict=True):
        assert row.replace("…", " ").strip() in line
