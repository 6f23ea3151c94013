"""The suite taken by models: time, progress and resumption, and cards that say how they answered. All are scripted."""

import collections
import io
import json
import re
import time

import pytest
from commands import llf
from rich.console import Console

from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.studies.execution import worker
from llf_teacher.studies.execution.progress import StudyProgress, in_words
from llf_teacher.suite import Card, all_experiments, take, taking
from llf_teacher.suite.answers import AnswerSummary, copies
from llf_teacher.suite.card import CardError, checksum

pytestmark = pytest.mark.usefixtures("no_settings")


def student(url, more=""):
    return f"llm(model='m', base_url='{url}', max_tokens=50, answer='text'{more})"


def obeys(request):
    """The arm that the teacher named last, in a bandit; else one arm after the other."""
    said = (
        request["messages"][0]["content"],
        *(each["content"] for each in request["messages"] if each["role"] == "user"),
    )
    arms = re.findall(r"(?i)\b(?:arm|next turn is) (\d)\b", " ".join(said))
    return f"Response: {arms[-1] if arms else len(said) % 10}"


class Clock:
    """A time that goes on by each answer alone; the real one goes on meanwhile."""

    def __init__(self):
        self.now, self.pace = 1000.0, 2.0

    def monotonic(self):
        return self.now

    def answer(self, request):
        self.now += self.pace
        return obeys(request)


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(worker, "time", found)
    monkeypatch.setattr(taking, "time", found)
    return found


def asked_twice(server):
    counts = collections.Counter(json.dumps(request, sort_keys=True) for request in server.requests)
    return [request for request, number in counts.items() if number > 1]


class EndedError(Exception):
    """Ends a run."""


def test_the_time_is_said_from_a_few_episodes_of_the_suite_that_are_not_played_again(tmp_path, clock):
    """One lesson of the model in each of two environments is played before, of five turns; the others take as long."""
    announced = []
    with ScriptedEndpoint(clock.answer) as server:

        def announce(outlook):
            announced.append((outlook, len(server.requests)))

        card = take(student(server.url), tmp_path / "it.db", ["advice"], True, workers=1, announce=announce)
        assert asked_twice(server) == []
    ((outlook, asked),) = announced
    assert asked == 2 * 5
    assert outlook.episodes == 48 - 2
    assert outlook.turn_seconds == {id: pytest.approx(2) for id in all_experiments()["advice"].ids}
    assert outlook.seconds == pytest.approx(46 * 5 * 2)
    assert "46 episodes of the student are to be played: about 8 minutes at the measured speed (a turn" in f"{outlook}"
    assert card.cost["episodes"] == 48


def test_an_interrupted_suite_goes_on_and_asks_nothing_twice(tmp_path, clock):
    def interrupt(done, total, left):
        if done > 60:
            raise EndedError

    outlooks = []
    with ScriptedEndpoint(clock.answer) as server:
        spec = student(server.url)
        with pytest.raises(EndedError):
            take(spec, tmp_path / "it.db", ["advice"], True, workers=1, progress=interrupt)
        before = len(server.requests)
        card = take(spec, tmp_path / "it.db", ["advice"], True, workers=1, announce=outlooks.append)
        assert 0 < before < len(server.requests) == card.cost["answers"]
        assert asked_twice(server) == []
        assert outlooks[0].episodes == 48 - before // 5  # the speed is known from the store: none was played before
        take(spec, tmp_path / "it.db", ["advice"], True, workers=1, announce=outlooks.append)
        assert len(server.requests) == card.cost["answers"]
    assert min(outlooks[0].turn_seconds.values()) > 0
    assert (outlooks[1].episodes, outlooks[1].seconds, outlooks[1].turn_seconds) == (0, 0, {})


def test_answers_of_the_cache_do_not_make_a_model_fast(tmp_path, monkeypatch):
    """They are free, but what is not in the cache takes as long as it took then."""

    def slowly(request):
        time.sleep(0.03)
        return obeys(request)

    monkeypatch.setenv("LLF_LLM_CACHE", f"{tmp_path / 'answers.db'}")
    outlooks = []
    with ScriptedEndpoint(slowly) as server:
        for store in ("one.db", "two.db"):
            take(student(server.url), tmp_path / store, ["hints"], True, workers=1, announce=outlooks.append)
            assert asked_twice(server) == []
    assert all(min(each.turn_seconds.values()) >= 0.03 for each in outlooks)


@pytest.mark.parametrize(
    ("pace", "names", "worlds"),
    [
        (3, ["advice", "hints", "silence", "turncoat"], 8),
        (4, ["advice", "silence", "turncoat"], 8),
        (5, ["advice", "silence"], 8),
        (9, ["advice"], 8),
        (12, ["advice"], 6),
        (60, ["advice"], 6),
    ],
)
def test_the_quick_suite_leaves_out_what_does_not_fit_20_minutes(tmp_path, clock, pace, names, worlds):
    """The whole has 360 turns."""

    def stop(outlook):
        outlooks.append(outlook)
        raise EndedError

    outlooks, clock.pace = [], pace
    with ScriptedEndpoint(clock.answer) as server, pytest.raises(EndedError):
        take(student(server.url), tmp_path / "it.db", (), True, workers=1, announce=stop)
    (outlook,) = outlooks
    assert (list(outlook.names), outlook.worlds) == (names, worlds)
    assert {*outlook.left_out} == {"advice", "hints", "silence", "turncoat"} - {*names}
    assert all(f"at {pace} s a turn it does not fit 20 minutes" in why for why in outlook.left_out.values())
    assert (outlook.seconds <= 1200) == (pace < 60)


def test_what_was_left_out_is_said_and_the_next_run_goes_on_with_it(tmp_path, clock):
    clock.pace = 5
    with ScriptedEndpoint(clock.answer) as server:
        first, second = (take(student(server.url), tmp_path / "it.db", (), True, workers=1) for _ in range(2))
        assert asked_twice(server) == []
    assert [each.name for each in first.lines] == ["advice", "silence"]
    (hints,) = (each for each in first.sentences() if each.startswith("Left out: combines hints"))
    assert "at 5 s a turn it does not fit 20 minutes" in hints
    assert first.sentences()[-1].startswith("Only the whole suite asks whether it heeds")
    assert (len(second.lines), second.left_out) == (4, {})


def test_a_model_that_becomes_slow_ends_the_quick_suite_in_time(tmp_path, clock):
    """It was fast when it was measured: all would fit. An experiment that was begun is played whole."""
    outlooks = []

    def slower(request):
        clock.pace = 3 if len(server.requests) <= 40 else 8
        return clock.answer(request)

    with ScriptedEndpoint(slower) as server:
        card = take(student(server.url), tmp_path / "it.db", (), True, workers=1, announce=outlooks.append)
    assert outlooks[0].left_out == {}
    assert [each.name for each in card.lines] == ["advice"]
    assert {*card.left_out} == {"hints", "silence", "turncoat"}
    assert clock.now - 1000 < 1200
    assert card.lines[0].seeds == 8


def test_progress_has_the_time_that_is_left_and_it_ends_at_0(tmp_path, clock):
    """It is corrected by what was measured since."""
    shown = []

    def slower(request):
        clock.pace = 2 if len(server.requests) <= 100 else 6
        return clock.answer(request)

    with ScriptedEndpoint(slower) as server:
        take(student(server.url), tmp_path / "it.db", ["hints"], True, workers=1, progress=lambda *of: shown.append(of))
    left = {total - done: left for done, total, left in shown}
    assert 0.5 < left[40] / (40 * 5 * 2) <= 1  # some answers are in the cache already
    assert 0.7 < left[8] / (8 * 5 * 6) <= 1
    assert shown[-1] == (shown[-1][1], shown[-1][1], 0)


def test_the_bar_has_the_time_that_is_left():
    file = io.StringIO()
    with StudyProgress(Console(file=file, force_terminal=True, width=120), measured=True) as progress:
        progress(1, 20, 754.0)
    assert "13 minutes left" in file.getvalue()
    assert [in_words(seconds) for seconds in (42.4, 130, 7980)] == ["42 seconds", "2 minutes", "2 h 13 min"]


FAULTS = {
    "no_action": lambda request: "I would rather not.",
    "cut": lambda request: Reply(body=completion("Response: 3, since this is the arm that", request, finish="length")),
    "copied": lambda request: f"{' '.join(request['messages'][0]['content'].split()[:12])}\nResponse: 3",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_answers_that_fail_are_counted_and_the_score_is_said_to_show_them(tmp_path, fault):
    with ScriptedEndpoint(FAULTS[fault]) as server:
        card = take(student(server.url), tmp_path / "it.db", ["hints"], True, workers=1)
    (line,) = card.lines
    assert line.answers.turns == 240
    assert getattr(line.answers, fault) == 240
    text = " ".join(card.sentences())
    assert "Less than half" not in text
    counted = line.score is not None  # else the reason of the missing score has the number
    what = "repeat the prompt" if fault == "copied" else "failed"
    assert (f"Many answers {what}, so that scores also show how the student answers" in text) == counted
    assert repr(line.answers.answered) in text
    for form in (card.as_markdown(), card.as_html()):
        assert "of its 240 answers 240 " in form.lower()


def test_an_agent_that_answers_a_bandit_with_a_direction_sees_what_was_asked(tmp_path):
    with ScriptedEndpoint(lambda request: "north") as server:
        card = take(student(server.url), tmp_path / "it.db", (), True, workers=1)
    first, second, *_ = card.sentences()
    assert first == "Nothing was measured."
    assert "There are 10 arms to pull." in second
    assert "answered 'north', which is no action here" in second
    assert all("100% of the answers were no actions" in each.did for each in card.lines)
    assert {row[1] for row in card.table()[1:]} == {"not measured"}


def test_the_card_of_a_model_that_obeys(tmp_path):
    with ScriptedEndpoint(obeys) as server:
        card = take(student(server.url), tmp_path / "it.db", (), True, workers=1)
    by_name = {each.name: each for each in card.lines}
    assert re.match(r"It did: the teacher spared it (\d+% of the|more) loss", by_name["advice"].did)
    assert by_name["turncoat"].did.startswith("It lost by this, 1")
    assert by_name["advice"].answers.followed == by_name["advice"].answers.advised == 40
    assert by_name["advice"].answers.words.startswith("All of its 120 answers were actions.")
    assert "Only the whole suite asks whether it heeds warnings;" in card.sentences()[-1]


@pytest.mark.parametrize(
    ("spec", "name", "did"),
    [
        ("obedient", "advice", r"It did: the teacher spared it 100% of the loss that it spares a scripted student "),
        ("random", "advice", r"(It did not|This is not decided): the teacher spared it"),
        ("random", "turncoat", r"This could not be measured: .*no gain to lose"),
        ("obedient | mishears(p=0.3)", "advice", r"It did in part: the teacher spared it \d\d% of"),
        ("obedient", "turncoat", r"It lost by this, 100% of what it costs a scripted student that obeys\."),
        ("obedient", "hints", r"It did not: the teacher spared it nothing, no more than chance explains\. In each"),
        ("reasoner(worlds=64)", "hints", r"It did: the teacher spared it 100% of the loss .* that reasons"),
    ],
)
def test_students_with_known_defects_are_described(scripted, spec, name, did):
    (line,) = (each for each in take(spec, scripted, (), True, workers=1).lines if each.name == name)
    assert re.match(did, line.did), line.did
    assert line.asked
    assert line.answers.transcript.count("student: ") == 5
    assert "8 worlds" in line.measured or line.score is None


@pytest.fixture(scope="module")
def scripted(tmp_path_factory):
    return tmp_path_factory.mktemp("suite") / "it.db"


def test_a_lesson_can_be_opened(scripted, tmp_path):
    """In pages, and by the command that is printed."""
    files = [tmp_path / f"card{suffix}" for suffix in (".md", ".html", ".json")]
    options = [each for file in files for each in ("--card", file)]
    done = llf("suite", "--student", "obedient", "--quick", "--only", "advice", "--workers", 1, *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "a turn takes" in " ".join(done.stderr.split())
    assert "Ctrl-C ends it; the same command goes on: llf suite --student obedient" in done.stderr
    (command,) = re.findall(r"an episode: llf (study transcript llf-suite\.db [0-9a-f]{12})\n", done.stdout)
    assert "If your code has changed" not in done.stderr
    opened = llf(*command.split(), cwd=tmp_path).stdout
    assert "[5] student: " in opened
    for file in files[:2]:
        assert "<details><summary>An episode, turn by turn</summary>" in file.read_text()
        assert "[5] student: " in file.read_text()
    assert Card.load(files[2]).lines[0].answers.transcript.strip() == opened.strip()


def test_cards_of_earlier_releases_are_read(scripted, tmp_path):
    values = json.loads(take("obedient", scripted, ["advice"], True, workers=1).as_json())
    del values["checksum"], values["left_out"], values["lines"][0]["answers"], values["lines"][0]["readable"]
    path = tmp_path / "old.json"
    path.write_text(json.dumps(values | {"checksum": checksum(values)}))
    assert Card.load(path).lines[0].answers == AnswerSummary()
    values["lines"][0]["answers"] = {"turns": -1}
    path.write_text(json.dumps(values | {"checksum": checksum(values)}))
    with pytest.raises(CardError, match=r"answers: missing or unknown: advised"):
        Card.load(path)


def test_a_copy_has_six_words_in_a_row():
    form = 'Answer with {"thought": "I want to see what it does", "action": 3}.'
    assert copies("i want to see what it did", form)
    assert not copies("I want to see what I can do", form)
    assert not copies("3", form)
    assert not copies("", "")
