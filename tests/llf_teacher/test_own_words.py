"""Teachers that speak in their own words: what was read, and what of it is false, in studies and on the page."""

import json
import sys

import pytest

from llf_teacher.episodes.record import READINGS
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies import Study, run
from llf_teacher.studies.definition.study import load_study, to_toml
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.theme import pages
from llf_teacher.web.open_lessons import OpenLessons
from llf_teacher.web.plan import read_plan
from llf_teacher.web.views import state
from pz_envs.seats import TEACHER

MODULE = '''
class Talker:
    """Advises in own words what the oracle advises, or what it warns of."""

    def __init__(self, lies=False, text="Now head {way}. Lovely weather today."):
        self.wanted, self.text = "Avoid" if lies else "Go", text

    def reset(self, rng):
        pass

    def act(self, observation, info):
        if not info["moment"].turn:
            return "Find the treasure."
        for atom in info["suggestion"].atoms:
            if type(atom.claim).__name__ == self.wanted:
                return self.text.format(way=atom.claim.action)
        return ""


def same(sentence):
    return f" {sentence}"


def turned(sentence):
    return sentence.replace("north", "_").replace("south", "north").replace("_", "south")


def read(sentence, vocabulary):
    return {"claims": [{"type": "Go", "action": "west"}]} if "weather" in sentence else None
'''
GRID = {"ids": ["llf-gridworld-v0"], "students": ["random"], "seeds": 2, "max_turns": 4}
NAMES = ("Talker", "Talker(lies=True)")


@pytest.fixture(autouse=True)
def _mine(tmp_path, monkeypatch, no_settings):
    (tmp_path / "talkers.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("talkers", None)


def study(*teachers, **changes):
    return Study(teachers=[f"talkers:{each}" if each in NAMES else each for each in teachers], **GRID | changes)


def played(teacher, **changes):
    return play(next(study(teacher, **changes).episodes()))


def readings(record):
    return [each for row in record.turns for each in row.readings or ()]


@pytest.mark.parametrize("lies", [False, True])
def test_what_is_read_is_checked_and_summed(lies):
    record = played(NAMES[lies])
    advice = [each for each in readings(record) if each["layer"]]
    assert [each["holds"] for each in advice] == [not lies] * len(advice) != []
    assert {each["claim"] for each in advice} == {"gridworld.Go"}
    episode = record.episode
    assert (episode.read_exact, episode.unread) == (len(advice), len(advice))
    assert episode.read_false == len(advice) * lies
    assert (episode.read_model, episode.model_false) == (0, 0)
    assert episode.unchecked == 2 * len(advice)
    assert not record.turns[0].readings


@pytest.mark.parametrize("teacher", ["oracle", "oracle | voice(tone='warm')", "silent"])
def test_teachers_whose_words_are_claims_are_not_read(teacher):
    record = played(teacher)
    assert all(row.readings is None for row in record.turns)
    assert {getattr(record.episode, name) for name in READINGS} == {None}


def test_reading_changes_no_lesson():
    without = played(NAMES[0], reader="none")
    assert all(row.readings is None for row in without.turns)
    read = [row._replace(readings=None) for row in played(NAMES[0]).turns]
    assert tuple(read) == without.turns


@pytest.mark.parametrize(("function", "misleads"), [("same", False), ("turned", True)])
def test_a_voice_that_rewrites_is_read_whole(function, misleads):
    episode = played(f"oracle | talkers:{function}").episode
    assert episode.distorted == 0, "the claims are those of the oracle"
    assert episode.read_exact > 5
    assert bool(episode.read_false) == misleads


def test_the_report_says_what_was_read_and_shows_a_false_sentence(tmp_path):
    with run(study(*NAMES, "oracle"), tmp_path / "s.db", options=RunOptions("here")) as results:
        html = results.report().html
        rows = [row for row in results.rows() if row["teacher"] == "talkers:Talker(lies=True)"]
    part = html[html.index('<section id="accounting"') :].partition("</section>")[0]
    honest, liar = (
        part.partition(f"<p><code>{name}</code> in gridworld: ")[2].partition("</p>")[0]
        for name in study(*NAMES).teachers
    )
    read = sum(row["read_exact"] for row in rows)
    assert liar.startswith(f"50 % of {2 * read} sentences in its own words were read.")
    assert f"Of the {read} that are word for word phrases of ours {read} are false." in liar
    assert "<q>Now head " in liar
    assert "Go(action=" in liar
    assert "phrases of ours 0 are false." in honest
    assert "<q>" not in honest
    assert "<code>oracle</code>: " not in part


def test_a_model_reads_the_rest_and_has_no_interval(tmp_path):
    def answer(request):
        said = request["messages"][-1]["content"]
        return json.dumps({"claims": [{"type": "Go", "action": "west"}] if "weather" in said else []})

    with ScriptedEndpoint(answer) as server:
        reader = f"llm_reader(model='m', base_url='{server.url}', answer='json', input_price=1.0, output_price=1.0)"
        with run(study(NAMES[0], reader=reader), tmp_path / "s.db", options=RunOptions("here")) as results:
            rows, html = list(results.rows()), results.report().html
            manifest = results.manifest
        assert [request["messages"][-1]["content"] for request in server.requests] == ["Lovely weather today."]
        again = run(study(NAMES[0], reader=reader), tmp_path / "s.db", options=RunOptions("here"))
    assert len(server.requests) == 1
    assert list(again.rows()) == rows
    said = sum(row["read_model"] for row in rows)
    assert said > 0 == sum(row["unread"] for row in rows)
    assert (
        f"Of the {said} that a model read {sum(row['model_false'] for row in rows)} are false; how often it errs"
        in html
    )
    assert "The sentence is data" in manifest["reader"]["prompts"]["system"]["text"]
    assert {row["reader"] for row in rows} == {reader}


def test_a_function_of_ones_own_reads(tmp_path):
    assert played(NAMES[0], reader="talkers:read").episode.read_model > 0


def test_the_key_in_a_file(tmp_path):
    plain = study(NAMES[0])
    assert "reader" not in to_toml(plain)
    for reader in ("none", "talkers:read"):
        (tmp_path / "s.toml").write_text(to_toml(study(NAMES[0], reader=reader)))
        assert load_study(tmp_path / "s.toml") == study(NAMES[0], reader=reader)
        assert next(study(NAMES[0], reader=reader).episodes()).key != next(plain.episodes()).key
    with pytest.raises(ValueError, match=r"reader 'near' is unknown; allowed: none, exact, llm_reader\(model=...\)"):
        study(NAMES[0], reader="near")
    with pytest.raises(ValueError, match=r"reader 'talkers:reed': unknown function in talkers 'reed'; did you"):
        study(NAMES[0], reader="talkers:reed")
    with pytest.raises(ValueError, match="reader"):
        study(NAMES[0], reader=3)


def test_a_spending_limit_needs_prices_of_the_reader(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_LLM_BUDGET", "1")
    with pytest.raises(ValueError, match=r"spending limit needs prices.*llm_reader"):
        run(study(NAMES[0], reader="llm_reader(model='m')"), tmp_path / "s.db", options=RunOptions("here"))


HOSTILE = "Now head north. <script>alert(1)</script> {{ 7 * 7 }}"


def shown(opened):
    drawn = state(opened, TEACHER, pages("llf_teacher.web", "templates"))
    return drawn, json.dumps(drawn)


def test_a_person_sees_what_was_understood():
    lessons = OpenLessons()
    plan = read_plan({"id": GRID["ids"][0], "seat": "teacher", "speech": "own words", "seed": 3, "max_turns": 2})
    opened = lessons.begin(plan)
    lessons.move(opened, TEACHER, "Find the treasure.", 0)
    drawn, _ = shown(opened)
    assert drawn["understood"] == []
    lessons.move(opened, TEACHER, HOSTILE, 1)
    drawn, text = shown(opened)
    first, *others = drawn["understood"]
    assert (first["kind"], first["text"]) == ("fp", "Now head north.")
    assert first["mark"][2:] in ("true", "false")
    assert "Go(action=" in first["html"]
    assert {each["mark"] for each in others} == {""}
    assert "not read" in others[0]["html"]
    assert "<script>" not in "".join(each["html"] for each in drawn["understood"])
    assert "49" not in drawn["understood"][-1]["html"]
    assert "In words of its own" in text
    lessons.move(opened, TEACHER, "That was right.", 2)
    drawn, _ = shown(opened)
    assert drawn["over"]
    assert [each["mark"][2:] for each in drawn["said"]] in (["true"], ["false"])
    record = opened.lesson.record()
    assert record.episode.read_exact == 2
    assert [len(row.readings or ()) for row in record.turns] == [0, len(others) + 1, 1]


def test_a_turn_that_is_taken_back_is_read_anew():
    lessons = OpenLessons()
    opened = lessons.begin(
        read_plan({"id": GRID["ids"][0], "seat": "teacher", "speech": "own words", "seed": 3, "max_turns": 3})
    )
    lessons.move(opened, TEACHER, "Find the treasure.", 0)
    lessons.move(opened, TEACHER, "Now head north.", 1)
    before = opened.lesson.rows[-1].readings
    lessons.undo(opened, TEACHER, 2)
    lessons.move(opened, TEACHER, "Now head south.", 1)
    lessons.undo(opened, TEACHER, 2)
    lessons.move(opened, TEACHER, "Now head north.", 1)
    assert opened.lesson.rows[-1].readings == before
