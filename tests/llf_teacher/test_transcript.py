"""Transcripts from elsewhere are played again, and each sentence is checked."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.registry import PREFIX, entry
from llf_teacher.tools import transcript
from llf_teacher.tools.transcript import audit_transcript
from pz_envs.checking import share_false
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
        ([GRID, "", {"action": "up"}], "line 3: action must be"),
        ([GRID, {"action": 9}], "line 2: .*action"),
        ([GRID, {"action": 10**400}], "line 2: "),
        ([GRID, {"act": 1}], "line 2: the key 'act' is unknown; allowed: action"),
        ([GRID, {}], "line 2: a turn must have the key 'action'"),
        ([GRID, {"action": 1, "feedback": 3}], "line 2: feedback must be a text"),
        ([GRID, {"action": 1, "observation": "Room: hall"}], "line 2: the observation differs: the world shows 'Room"),
        ([GRID, *[{"action": 2}] * 99], "line [0-9]+: the episode ended with turn"),
        ([GRID, json.dumps({"action": 2, "feedback": "x" * transcript.LONGEST_LINE})], "line 2: a line must have at"),
    ],
)
def test_bad_lines_are_named(lines, message, written):
    with pytest.raises(ValueError, match=message):
        audit_transcript(written(*lines))


def test_too_many_lines(written, monkeypatch):
    monkeypatch.setattr(transcript, "MOST_LINES", 2)
    with pytest.raises(ValueError, match="line 3: a transcript must have at most 2 lines"):
        audit_transcript(written(GRID, {"action": 2}, {"action": 2}))


def test_a_readers_errors_are_inside_the_interval():
    """Without misreadings it is an interval for a share; with them it still has the truth, whatever they are called."""
    assert share_false(0, 50)[0] == 0
    assert share_false(5, 100, right=10**7, known=10**7) == pytest.approx((0.0143, 0.1210), abs=0.002)
    assert share_false(3, 10, right=0, known=5) == (0.0, 1.0)
    for share in (0.0, 0.1, 0.5, 1.0):
        for called in (0.0, 1.0):  # how often a misreading is called false
            low, high = share_false(round(1000 * (0.92 * share + 0.08 * called)), 1000)
            assert low <= share <= high


def test_the_command_prints_a_table_or_json(written):
    path = written(GRID, {"action": "south", "feedback": "You should go south. What a nice day."})
    shown = CliRunner().invoke(app, ["audit", str(path)])
    assert shown.exit_code == 0, shown.output
    assert "line 2, turn 1: You should go south." in shown.output
    data = json.loads(CliRunner().invoke(app, ["audit", str(path), "--json"]).stdout)
    assert [each["holds"] for each in data["sentences"]] == [False, None]
    both = CliRunner().invoke(app, ["audit", str(path), "llf-gridworld-v0"])
    assert both.exit_code
