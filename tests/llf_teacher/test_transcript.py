"""Transcripts from elsewhere are played again, and each sentence is checked."""

import itertools
import json
import re

import numpy as np
import pytest
from scipy.stats import binomtest
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.registry import PREFIX, entry
from llf_teacher.tools import transcript
from llf_teacher.tools.transcript import audit_transcript
from pz_envs.checking import READ, READ_RIGHT, share_false
from pz_envs.family import own_families
from teachers.common import Late, Probably
from teachers.session import Session

GRID = {"id": "llf-gridworld-v0", "seed": 0}
FAMILY = entry(GRID["id"]).family
QUICK = ("bandits", "gridworld", "movies", "optimization", "poem")


def lesson(family, teacher, seed=0, turns=4):
    """The lines of a transcript of a lesson."""
    id = PREFIX + family.showcase[0]
    found = entry(id)
    world = family.make_world(**found.options)
    session = Session(world, [family.make_teacher(world, teacher)], max_turns=family.max_turns, instructs=True)
    rng = np.random.default_rng(seed)
    session.open(seed)
    session.speak()
    lines = [{"id": id, "seed": seed, "feedback": session.feedback, "observation": world.describe(session.state)}]
    while not session.over and len(lines) <= turns:
        action = world.legal(world.sample_action(rng))
        session.act(action)
        session.speak()
        lines.append({"action": action, "feedback": session.feedback, "observation": world.describe(session.state)})
    return lines


@pytest.fixture
def written(tmp_path):
    def write(*lines):
        path = tmp_path / "lesson.jsonl"
        path.write_text("\n".join(each if isinstance(each, str) else json.dumps(each) for each in lines))
        return path

    return write


@pytest.mark.parametrize("family", [each for each in own_families() if each.name in QUICK], ids=lambda each: each.name)
def test_honest_teachers_say_nothing_false_and_liars_nothing_true(family, written):
    honest = audit_transcript(written(*lesson(family, "oracle")))
    assert not [each for each in honest.sentences if each.checked.holds is False]
    assert honest.count(holds=True) >= 5
    lied = audit_transcript(written(*lesson(family, "mistake(eps=1)")))
    assert lied.count(holds=False) >= 3
    assert [each for each in lied.sentences if each.checked.holds] == []


def test_the_turn_that_a_sentence_names_is_the_one_checked(written):
    first = "You should not have gone south in kitchen-2. It did not bring you closer to the treasure."
    late = next(phrase for phrase in FAMILY.phrasebook().templates(Late) if phrase.endswith("{text}"))
    hedged = next(phrase for phrase in FAMILY.phrasebook().templates(Probably) if phrase.endswith("{text}"))
    said = [first, late.format(turn=1, text=first), late.format(turn=7, text=first)]
    said.append(hedged.format(percent=80, text=first))
    lines = GRID, {"action": "south"}, *({"action": 2, "feedback": each} for each in said)
    found = [each.checked for each in audit_transcript(written(*lines)).sentences]
    assert [each.outcome for each in found] == ["false", "true", "unbuilt", "hedged"]
    assert [each.holds for each in found] == [False, True, None, None]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "line 1: a transcript must begin"),
        (["{"], "line 1: each line must be a JSON object"),
        (["[" * 100_000], "line 1: each line must be a JSON object"),
        (["3"], "line 1: each line must be a JSON object"),
        ([{"seed": 0}], "line 1: the first line must have either id or family"),
        ([{"family": "gridwrld", "seed": 0}], "line 1: .*gridworld"),
        ([{"id": 3, "seed": 0}], "line 1: an id must be a string"),
        ([{**GRID, "options": {"rooms_": 3}}], "line 1: .*rooms_"),
        ([{**GRID, "options": 3}], "line 1: options must be an object"),
        ([{"id": GRID["id"]}], "line 1: seed must be an integer"),
        ([{**GRID, "options": {"self": 3}}], "line 1: .*'?self'?"),
        ([{**GRID, "max_turns": 0}], "line 1: max_turns must be an integer of at least 1, got 0"),
        (['{"id": "llf-gridworld-v0", "seed": 0, "seed": 1}'], "line 1: each key must occur once, got id, seed, seed"),
        ([{**GRID, "feedback": 0}], "line 1: feedback must be a text of at most 65536 characters, got 0"),
    ],
)
def test_a_bad_first_line_is_named(lines, message, written):
    with pytest.raises(ValueError, match=message):
        audit_transcript(written(*lines))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["{"], "line 3: each line must be a JSON object"),
        (["[3]"], "line 3: each line must be a JSON object"),
        (['{"action": 1, "action": 2}'], "line 3: each key must occur once, got action, action"),
        ([{"act": 1}], "line 3: the key 'act' is unknown; allowed: action"),
        ([{}], "line 3: a turn must have the key 'action'"),
        *(([{"action": 1, "feedback": each}], "line 3: feedback must be a text") for each in (3, 0, False, [], {})),
        ([{"action": 1, "observation": "Room: hall"}], "line 3: the observation differs: the world shows 'Room"),
        ([*[{"action": 2}] * 99], "line [0-9]+: the episode ended with turn"),
        ([json.dumps({"action": 2, "feedback": "x" * transcript.LONGEST_LINE})], "line 3: a line must have at"),
    ],
)
def test_from_a_bad_line_on_nothing_is_judged(lines, message, written):
    """What was found before is there, and the command shows it before it says what is wrong."""
    last = {"action": 1, "feedback": "Go west."}
    path = written(GRID, {"action": "south", "feedback": "You should go south."}, *lines, last)
    found = audit_transcript(path)
    assert re.search(message, found.problem)
    assert [each.line for each in found.sentences] == [2]
    shown = CliRunner().invoke(app, ["audit", str(path)])
    assert "line 2, turn 1: You should go south." in shown.output
    assert re.search(message, str(shown.exception))
    data = CliRunner().invoke(app, ["audit", str(path), "--json"])
    assert json.loads(data.stdout)["problem"] == found.problem
    assert isinstance(data.exception, ValueError)  # by which `llf` exits with 2


@pytest.mark.parametrize("action", ["up", 9, 10**400, None, True, [1], {"a": 1}, 1.0, "x" * 100_000])
def test_an_action_that_is_none_costs_its_turn(action, written):
    """As in play; the state is what it was, and what is said then is checked."""
    teach = {"feedback": "Go south. Go west."}
    found = audit_transcript(written(GRID, {"action": action, **teach}, {"action": "south"}))
    assert (found.turns, found.failures, found.problem) == (2, (2,), "")
    at_once = audit_transcript(written({**GRID, **teach}))
    assert [each.checked.holds for each in found.sentences] == [each.checked.holds for each in at_once.sentences]


def test_the_first_line_may_say_how_many_turns_there_can_be(written):
    turns = [{"action": "up"}] * 30
    assert audit_transcript(written({**GRID, "max_turns": 30}, *turns)).problem == ""
    assert "line 22: the episode ended with turn 20" in audit_transcript(written(GRID, *turns)).problem


def test_a_mark_of_the_byte_order_is_no_part_of_the_first_line(tmp_path):
    path = tmp_path / "lesson.jsonl"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(GRID).encode())
    assert audit_transcript(path).id == GRID["id"]


def test_too_many_lines(written, monkeypatch):
    monkeypatch.setattr(transcript, "MOST_LINES", 2)
    found = audit_transcript(written(GRID, {"action": 2}, {"action": 2}))
    assert "line 3: a transcript must have at most 2 lines" in found.problem


def test_an_interval_is_wider_the_fewer_texts_there_are():
    assert share_false([]) == share_false([[("Go.", True)]] * 100) == (0.0, 1.0)
    alone = binomtest(10, 100).proportion_ci(0.975, "exact")  # the reader does not err
    read = [(f"{i}", i < 10) for i in range(100)]
    assert share_false([[each] for each in read], 10**7, 10**7) == pytest.approx(alone, abs=0.001)
    assert share_false([read], 10**7, 10**7, here=True) == (0.1, 0.1)
    assert share_false([read], here=True)[0] == 0 < 0.1 < share_false([read], here=True)[1] < 0.4
    assert share_false([[("Go.", True), (" go. ", False)]], right=0, known=5) == (0.0, 1.0)
    widths = [np.ptp(share_false([[(f"{i % texts}", i % 2 == 0)] for i in range(200)])) for texts in (2, 20, 200)]
    assert widths == sorted(widths, reverse=True)


@pytest.mark.parametrize("share", [0.05, 0.5])
@pytest.mark.parametrize("episodes", [1, 5, 20])
def test_sentences_of_an_episode_may_be_all_true_or_all_false(episodes, share, rng):
    """If each sentence counted as an episode, the interval would contain the share too seldom."""
    covered = apart = 0
    for _ in range(100):
        read = [[(f"{i} {j}", bool(lot < share)) for j in range(10)] for i, lot in enumerate(rng.random(episodes))]
        low, high = share_false(read, 10**7, 10**7)
        covered += low <= share <= high
        low, high = share_false([[each] for each in itertools.chain(*read)], 10**7, 10**7)
        apart += low <= share <= high
    assert covered >= 0.95 * 100
    assert apart < covered


@pytest.mark.parametrize("texts", [1, 3, 10, 100])
@pytest.mark.parametrize("called", [False, True, None])
def test_a_readers_errors_are_inside_the_interval(texts, called):
    """It errs on whole texts, as often as its bound says, and calls these sentences false, true, or as it comes.

    What is said in an episode is all true or all false.
    """
    rng = np.random.default_rng(texts)
    rate = binomtest(READ - READ_RIGHT, READ, alternative="less").proportion_ci(0.975, "exact").high
    covered = 0
    for _ in range(200):
        share, often = rng.random(), rng.dirichlet(np.full(texts, 0.5))
        said = rng.choice(texts, 200, p=often)
        false = np.repeat(rng.random(20) < share, 10)
        wrong = (rng.random(texts) < rate)[said]
        read = np.where(wrong, rng.random(200) < 0.5 if called is None else called, false)
        pairs = [*zip(map(str, said), read.tolist(), strict=True)]
        low, high = share_false(pairs[i : i + 10] for i in range(0, 200, 10))
        covered += low <= share <= high
    assert covered >= 0.95 * 200


def test_what_was_not_read_most_often_is_named(written):
    nice = "What a nice day."
    said = [f"What\x1b[1m luck. {nice}", *(f"Day {i} is nice. {nice} Maybe go west." for i in range(12))]
    path = written(*({**GRID, "feedback": nice}, *({"action": "south", "feedback": each} for each in said)))
    unread = audit_transcript(path).unread
    assert (unread[0], len(unread)) == ((nice, "not read", 14), 10)
    assert ("Maybe go west.", "hedged", 12) in unread
    shown = CliRunner().invoke(app, ["audit", str(path)]).output
    assert "not read (14): What a nice day.\nhedged (12): Maybe go west.\nnot read (1): What" in shown
    assert (shown.count("not read (1): "), "\x1b" in shown) == (8, False)


def test_the_command_prints_a_table_or_json(written):
    path = written(GRID, {"action": "south", "feedback": "You should go south. What a nice day."})
    shown = CliRunner().invoke(app, ["audit", str(path)])
    assert shown.exit_code == 0, shown.output
    assert "line 2, turn 1: You should go south." in shown.output
    data = json.loads(CliRunner().invoke(app, ["audit", str(path), "--json"]).stdout)
    assert [each["holds"] for each in data["sentences"]] == [False, None]
    assert data["unread"] == [{"text": "What a nice day.", "outcome": "not read", "number": 1}]
    both = CliRunner().invoke(app, ["audit", str(path), "llf-gridworld-v0"])
    assert both.exit_code
