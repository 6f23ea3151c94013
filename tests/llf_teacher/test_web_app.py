"""The server: what it answers, to whom, and what it refuses."""

import contextlib
import io
import json
import pickle
import sqlite3
from concurrent.futures import Future, ThreadPoolExecutor

import pytest
from PIL import Image
from starlette.testclient import TestClient
from studying import stored

from llf_teacher.episodes.live import WATCHER
from llf_teacher.studies import Study, load, run
from llf_teacher.theme import kind_mark
from llf_teacher.web import films, open_lessons
from llf_teacher.web.app import LARGEST, make_app
from llf_teacher.web.films import Films
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.open_lessons import OpenLessons
from llf_teacher.web.plan import read_plan

GRID = "llf-gridworld-v0"
HTML = {"accept": "text/html"}


def client(**settings):
    return TestClient(make_app(**settings), base_url="http://127.0.0.1:8000", follow_redirects=False)


def begin(visitor, **choices):
    answer = visitor.post("/lessons", json={"id": GRID, "seed": 7, "max_turns": 3, **choices})
    assert answer.status_code == 201, answer.text
    return answer.json()["page"]


def told(answer):
    assert answer.status_code == 200, answer.text
    return answer.json()


def other_seat(visitor, page):
    """The address of the other seat, which the page of the first has."""
    return visitor.get(page).text.partition('id="link" href="')[2].partition('"')[0]


def move(visitor, page, sent, what="move"):
    """What the page sends at the turn that it shows."""
    turn = told(visitor.get(f"{page}/state"))["turn"]
    return visitor.post(f"{page}/{what}", json={**sent, "turn": turn})


def undo(visitor, page, since=""):
    return move(visitor, page, {"since": since}, "undo")


def finish(visitor, page, sent=None):
    state = told(visitor.get(f"{page}/state"))
    while not state["over"]:
        state = told(move(visitor, page, sent or {}))
    return state


def test_how_much_is_said_is_shown_but_for_the_student():
    visitor = client()
    page = begin(visitor, seat="teacher", two=True, bits=True)
    state = told(visitor.get(f"{page}/state"))
    assert all(" bits" in each["html"] for each in state["claims"] if each["kind"])
    state = told(move(visitor, page, {"claims": [0]}))
    assert any(" bits" in each["html"] for each in state["said"])
    assert " bits" in state["turns"][0]
    student = other_seat(visitor, page)
    assert " bits" not in visitor.get(f"{student}/state").text
    for bad, said in (({"seat": "student"}, "a student cannot see how much is said"), ({"bits": 8}, "true or false")):
        answer = visitor.post("/lessons", json={"id": GRID, "seat": "watch", "bits": True, **bad})
        assert (answer.status_code, said in answer.text) == (400, True), answer.text
    page = begin(visitor, seat="watch", id="llf-poem-Haiku-v0", bits=True)
    assert "'poem' has no posterior" in told(visitor.get(f"{page}/state"))["unmeasured"]


def test_a_student_plays_a_lesson():
    visitor = client()
    page = begin(visitor, seat="student")
    assert "You are the student" in visitor.get(page).text
    state = told(visitor.get(f"{page}/state"))
    assert (state["seat"], state["mine"], state["turn"], state["words"][0]) == ("student", True, 0, "north")
    assert [said["kind"] for said in state["said"]] == ["", "", "", "fp", "fn"]
    assert all(kind_mark(said["kind"] or None) in said["html"] for said in state["said"])
    after = told(move(visitor, page, {"act": "west", "since": state["mark"]}))
    assert (after["turn"], after["first"], len(after["turns"])) == (1, 1, 1)
    assert '<code class="action">west</code>' in after["turns"][0]
    assert visitor.get(f"{page}/state", params={"version": after["version"]}).status_code == 204
    back = told(undo(visitor, page, after["mark"]))
    assert (back["turn"], back["first"], back["turns"], back["undo"]) == (0, 0, state["turns"], False)


def test_a_student_is_told_the_checks_when_it_is_over():
    """And neither regret nor truth before."""
    visitor = client()
    page = begin(visitor, seat="student", teacher="mistake(eps=1)")
    state = told(move(visitor, page, {"act": "west"}))
    hidden = ("regret", "✗", "✓", 'class="claim"')
    assert not [word for word in hidden if word in json.dumps(state, ensure_ascii=False)]
    assert visitor.get(f"{page}/episode", headers=HTML).status_code == 400
    state = finish(visitor, page, {"act": "west"})
    drawn = "".join(state["turns"])
    assert [word for word in hidden if word in drawn] == list(hidden)
    assert "✗ false" in visitor.get(f"{page}/episode").text
    frames = [visitor.get(f"{page}/frame.png", params={"theme": theme}).content for theme in ("light", "dark")]
    light, dark = (Image.open(io.BytesIO(frame)).convert("L").resize((1, 1)).getpixel((0, 0)) for frame in frames)
    assert light > 2 * dark


def test_actions_by_number_have_a_button_each():
    visitor = client()
    page = begin(visitor, id="llf-bandits-BanditTenArmedGaussian-v0", seat="student")
    state = told(visitor.get(f"{page}/state"))
    assert state["words"] == [f"{arm}" for arm in range(10)]
    after = told(move(visitor, page, {"act": state["words"][9]}))
    assert after["did"].startswith("The student: 9 (reward ")
    page = begin(visitor, id="llf-optimization-Booth-v0", seat="student")
    assert told(visitor.get(f"{page}/state"))["words"] == []


def test_marks_are_for_those_who_see_the_truth():
    """The picture has the world alone, at twice the size of that in a frame."""
    visitor = client()
    for seat, marks in (("student", {""}), ("watch", {"✗ false"})):
        page = begin(visitor, seat=seat, teacher="mistake(eps=1)")
        state = told(move(visitor, page, {"act": "west"}))
        assert {said["mark"] for said in state["said"]} == marks
        with Image.open(io.BytesIO(visitor.get(f"{page}/frame.png").content)) as picture:
            assert picture.size == (768, 884)


def test_each_seat_sees_what_is_its_own():
    visitor = client()
    page = begin(visitor, seat="student", two=True)
    address = other_seat(visitor, page)
    other = told(visitor.get(f"{address}/state"))
    assert (other["seat"], other["mine"], other["claims"][0]["kind"]) == ("teacher", True, "fp")
    assert not other_seat(visitor, address)
    waiting = told(visitor.get(f"{page}/state"))
    assert (waiting["mine"], waiting["waits"]) == (False, "teacher")
    assert "claims" not in waiting
    answer = move(visitor, page, {"act": "west"})
    assert (answer.status_code, answer.json()["error"]) == (
        409,
        "it is the turn of the other seat; wait until it has moved",
    )
    told(move(visitor, address, {"claims": [0]}))
    fresh = told(visitor.get(f"{page}/state", params={"version": waiting["version"], "since": waiting["mark"]}))
    assert (fresh["mine"], [said["kind"] for said in fresh["said"]][-1]) == (True, "fp")


def test_what_a_teacher_ticks_is_what_the_student_hears():
    """Also after it was looked at twice and a turn was taken back, and in the film and the store of the episode."""
    visitor = client()
    page = begin(visitor, seat="teacher", two=True, max_turns=2)
    student = other_seat(visitor, page)
    heard = []
    for turn, chosen in enumerate(([1], [0], [0, 1])):
        for again in (False, True):
            state = told(visitor.get(f"{page}/state"))
            ticked = [state["claims"][i]["text"] for i in chosen]
            told(move(visitor, page, {"claims": chosen}))
            if not again and turn < 2:
                undo(visitor, page)
            elif not again:
                break
        said = [said["text"] for said in told(visitor.get(f"{student}/state"))["said"]]
        assert said[-len(ticked) :] == ticked
        heard.append(ticked)
        if turn < 2:
            told(move(visitor, student, {"act": "south"}))
    turns = visitor.get(f"{page}/episode.json").json()["turns"]
    assert [
        [atom["text"] for atom in turn["atoms"]][-len(said) :] for turn, said in zip(turns, heard, strict=True)
    ] == heard


def test_what_people_say_is_text():
    visitor = client()
    page = begin(visitor, seat="teacher", speech="own words")
    evil = "<script>alert(1)</script>\u202e {{ 7 * 7 }}"
    state = told(move(visitor, page, {"say": evil}))
    assert "&lt;script&gt;" in state["turns"][0]
    assert "\\u202e {{ 7 * 7 }}" in state["turns"][0]
    finish(visitor, page, {"say": evil})
    whole = visitor.get(f"{page}/episode").text
    assert "<script>alert" not in whole
    assert "\u202e" not in whole


@pytest.mark.parametrize(
    ("sent", "status", "why"),
    [
        ({"content": b"{", "headers": {"content-type": "application/json"}}, 400, "the request body is not valid JSON"),
        (
            {"content": b"[" * 9000, "headers": {"content-type": "application/json"}},
            400,
            "the request body is not valid JSON",
        ),
        ({"json": [1]}, 400, "the request body is JSON, but not an object"),
        ({"data": {"id": GRID}}, 415, "the content type must be application/json; send JSON"),
        ({"json": {"id": "x" * LARGEST}}, 413, "the request body is too long; allowed: at most 16384 bytes"),
        ({"json": {"id": GRID, "teacher": "antigravity:fly"}}, 400, "antigravity:fly"),
    ],
)
def test_a_bad_request_is_answered_by_a_sentence(sent, status, why):
    answer = client().post("/lessons", **sent)
    assert answer.status_code == status
    assert why in answer.json()["error"]
    assert "Traceback" not in answer.text


@pytest.mark.parametrize(
    ("seat", "sent", "why"),
    [
        ("student", {}, "act must be a text of at most 4000 characters, got None"),
        ("student", {"act": "x" * 4001}, "act must be a text of at most 4000 characters"),
        ("student", {"act": 1}, "act must be a text"),
        ("teacher", {"claims": "all"}, "claims must be a list of numbers, got 'all'"),
        ("teacher", {"claims": [True]}, "claims must be a list of numbers"),
        ("teacher", {"claims": [-1]}, "there is no claim -1"),
        ("teacher", {"say": "hm"}, "chooses among claims"),
    ],
)
def test_a_bad_turn_changes_nothing(seat, sent, why):
    visitor = client()
    page = begin(visitor, seat=seat)
    before = told(visitor.get(f"{page}/state"))
    answer = move(visitor, page, sent)
    assert answer.status_code == 400
    assert why in answer.json()["error"]
    assert told(visitor.get(f"{page}/state")) == before


@pytest.mark.parametrize(
    ("turn", "status", "why"),
    [
        (None, 400, "turn must be a whole number, the turn of the episode's state, got None"),
        (True, 400, "turn must be a whole number"),
        (0, 409, "the episode is at turn 1, and this was sent for turn 0; look at its state first"),
        (2, 409, "the episode is at turn 1, and this was sent for turn 2"),
    ],
)
def test_a_move_is_for_its_turn_only(turn, status, why):
    visitor = client()
    page = begin(visitor, seat="student")
    before = told(move(visitor, page, {"act": "west"}))
    for what in ("move", "undo"):
        answer = visitor.post(f"{page}/{what}", json={"act": "west", "turn": turn})
        assert answer.status_code == status
        assert why in answer.json()["error"]
    assert told(visitor.get(f"{page}/state"))["version"] == before["version"]


def test_nothing_moves_when_it_is_over():
    visitor = client()
    page = begin(visitor, seat="student", max_turns=1)
    finish(visitor, page, {"act": "west"})
    answer = move(visitor, page, {"act": "west"})
    assert (answer.status_code, answer.json()["error"][:19]) == (409, "the episode is over")


def test_half_a_character_is_a_text_that_is_no_action():
    visitor = client()
    page = begin(visitor, seat="student")
    body = b'{"act": "\\ud800", "turn": 0}'
    state = told(visitor.post(f"{page}/move", content=body, headers={"content-type": "application/json"}))
    assert "No action could be read from" in state["turns"][-1]


@pytest.mark.parametrize(
    ("path", "status"),
    [("/nowhere", 404), ("/seat/guess", 404), ("/seat/guess/frame.png", 404), ("/stored/0", 404), ("/static/no", 404)],
)
def test_what_is_not_there_is_said(path, status):
    visitor = client()
    assert visitor.get(path).status_code == status
    assert visitor.get(path).json()["error"].startswith("there is no ")
    assert '<p role="alert">there is no ' in visitor.get(path, headers=HTML).text
    assert visitor.delete("/").json()["error"] == "this page does not allow the request's method; begin at /"


def test_a_mistake_of_ours_is_no_traceback(monkeypatch):
    def broken(*_):
        raise RuntimeError("secret")

    monkeypatch.setattr(open_lessons, "PlannedLesson", broken)
    visitor = TestClient(make_app(), base_url="http://127.0.0.1", raise_server_exceptions=False)
    answer = visitor.post("/lessons", json={"id": GRID})
    assert answer.status_code == 500
    assert answer.json()["error"].startswith("the server has an internal error")
    assert "secret" not in answer.text
    assert answer.headers["content-security-policy"]


def test_pages_load_nothing_from_elsewhere():
    visitor = client()
    page = begin(visitor, seat="watch")
    finish(visitor, page)
    for path in ("/", page, f"{page}/episode"):
        answer = visitor.get(path)
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self'; ")
        assert "unsafe" not in policy
        assert "//" not in answer.text.replace("<!DOCTYPE html>", "")
        assert " style=" not in answer.text
        assert "<script>" not in answer.text
        assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in answer.text
        assert answer.headers["cache-control"] == "no-store"
    assert visitor.get("/static/theme.css").headers["content-type"].startswith("text/css")
    assert "ol.turns" in visitor.get("/static/theme.css").text


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "192.168.0.7:8000", "0.0.0.0:8000", "[", ""]
)
def test_only_those_who_call_it_by_its_name_are_answered(host):
    answer = client().get("/", headers={"host": host})
    assert answer.status_code == 421
    assert "is not a name of this server" in answer.text


def test_a_foreign_page_cannot_play():
    visitor = client()
    for origin in ("http://evil.example", "null"):
        answer = visitor.post("/lessons", json={"id": GRID}, headers={"origin": origin})
        assert (answer.status_code, answer.text) == (
            403,
            "the request comes from a foreign page; open this server's own page\n",
        )
    own = visitor.post("/lessons", json={"id": GRID}, headers={"origin": "http://127.0.0.1:8000"})
    assert own.status_code == 201
    assert "access-control-allow-origin" not in own.headers


@pytest.mark.parametrize("seat", ["student", "teacher", "watch"])
def test_an_episode_can_be_taken_along(seat, tmp_path):
    visitor = client()
    page = begin(visitor, seat=seat)
    finish(visitor, page, {"act": "west", "personality": True})
    record = visitor.get(f"{page}/episode.json").json()
    assert (record["seed"], len(record["turns"]), len(record["regrets"])) == (7, 4, 3)
    (chat,) = map(json.loads, visitor.get(f"{page}/episode.jsonl").text.splitlines())
    assert [message["role"] for message in chat["messages"]][:2] == ["system", "user"]
    answer = visitor.get(f"{page}/episode.db")
    assert f'filename="llf-{record["key"][:8]}.db"' in answer.headers["content-disposition"]
    (tmp_path / "one.db").write_bytes(answer.content)
    assert load(tmp_path / "one.db").turns(record["key"]) == record["turns"]
    assert (
        visitor.get(f"{page}/episode.exe").json()["error"]
        == "there is no file with the ending 'exe'; allowed: json, jsonl, db, gif"
    )


class SlowPool:
    """A pool of processes whose films are made when the test says so."""

    def __init__(self, *_, **__):
        self.futures, self.tasks = [], []

    def schedule(self, function, args):
        self.futures.append(Future())
        self.tasks.append((function, args))
        return self.futures[-1]

    def stop(self):
        """As a pool has it."""

    join = stop


@pytest.fixture
def slow(monkeypatch):
    pool = SlowPool()
    monkeypatch.setattr(films, "ProcessPool", lambda *_, **__: pool)
    return pool


def test_the_page_answers_while_a_film_is_made(slow):
    """The film is made in another process, of which the page only asks whether it is done."""
    visitor = client()
    page = begin(visitor, seat="watch", max_turns=2)
    assert "is not over" in visitor.post(f"{page}/film", json={}).json()["error"]
    finish(visitor, page)
    assert "data-asked" not in visitor.get(f"{page}/episode").text
    for _ in range(2):
        assert told(visitor.post(f"{page}/film", json={})) == {"made": False}
    assert len(slow.futures) == 1
    assert "data-asked" in visitor.get(f"{page}/episode").text
    answer = visitor.get(f"{page}/episode.gif")
    assert (answer.status_code, answer.json()["error"].partition(";")[0]) == (409, "the film is not made")
    other = begin(visitor, seat="student")  # all else goes on
    assert told(move(visitor, other, {"act": "west"}))["turn"] == 1
    assert visitor.get(f"{other}/frame.png").status_code == visitor.get(f"{page}/episode.json").status_code == 200
    slow.futures[0].set_result(b"a film")
    assert told(visitor.post(f"{page}/film", json={})) == {"made": True}
    answer = visitor.get(f"{page}/episode.gif")
    assert (answer.content, answer.headers["content-type"]) == (b"a film", "image/gif")
    undo(visitor, page)
    assert visitor.get(f"{page}/episode.gif").status_code == 409


def test_a_film_that_fails_can_be_asked_for_again(slow):
    visitor = TestClient(make_app(), base_url="http://127.0.0.1", raise_server_exceptions=False)
    page = begin(visitor, seat="watch", max_turns=1)
    finish(visitor, page)
    visitor.post(f"{page}/film", json={})
    slow.futures[0].set_exception(RuntimeError("secret"))
    answer = visitor.post(f"{page}/film", json={})
    assert (answer.status_code, "secret" in answer.text) == (500, False)
    assert told(visitor.post(f"{page}/film", json={})) == {"made": False}
    function, args = pickle.loads(pickle.dumps(slow.tasks[1]))  # as another process gets it
    slow.futures[1].set_result(function(*args))
    with Image.open(io.BytesIO(visitor.get(f"{page}/episode.gif").content)) as film:
        assert film.n_frames == 2


def test_a_film_is_made_in_another_process():
    live = PlannedLesson(read_plan({"id": GRID, "seat": "watch", "seed": 7, "max_turns": 1}))
    live.move(WATCHER, None)
    pool = Films()
    try:
        made = pool.begin(live.plan, live.inputs).result(timeout=120)
    finally:
        pool.close()
    with Image.open(io.BytesIO(made)) as film:
        assert film.n_frames == 2


@pytest.mark.parametrize(("seat", "sent"), [("student", {"act": "west"}), ("teacher", {"claims": []}), ("watch", {})])
def test_ten_moves_at_once_are_one_move(seat, sent):
    with client() as visitor, ThreadPoolExecutor(10) as hands:
        page = begin(visitor, seat=seat, max_turns=20)

        def post(what, turn):
            def once(_):
                answer = visitor.post(f"{page}/{what}", json={**sent, "turn": turn})
                return answer.status_code, answer.json()

            return sorted(hands.map(once, range(10)), key=lambda answer: answer[0])

        (status, state), *others = post("move", 0)
        assert (status, state["turn"]) == (200, 1)
        why = "the episode is at turn 1, and this was sent for turn 0; look at its state first"
        assert others == [(409, {"error": why})] * 9
        assert move(visitor, page, sent).status_code == 200
        (status, state), *others = post("undo", 2)
        assert (status, state["turn"], {status for status, _ in others}) == (200, 1, {409})


def test_stored_episodes_can_be_looked_at(tmp_path):
    study = Study(ids=[GRID], teachers=["oracle", "mistake(eps=1)"], students=["obedient"], seeds=1)
    visitor = client(stores=[stored(tmp_path / "study.db", study)])
    assert '<a href="/stored/0">study.db</a>: 2 episodes' in visitor.get("/").text
    assert visitor.get("/stored/0").text.count("<tr><th") == 3
    listing = visitor.get("/stored/0", params={"q": "MISTAKE gridworld"}).text
    assert listing.count('<a href="/stored/0/') == 1
    address = listing.partition('<a href="')[2].partition("/stored/0/")[2].partition('"')[0]
    shown = visitor.get(f"/stored/0/{address}").text
    assert "✗ false" in shown
    assert "Downloads" not in shown
    assert "There is none." in visitor.get("/stored/0", params={"q": "<b>"}).text
    for key in ("00", "zz"):
        answer = visitor.get(f"/stored/0/{key}")
        why = f"study.db has no episode '{key}'; begin at /stored/0"
        assert (answer.status_code, answer.json()) == (404, {"error": why})
        assert "has no episode &#39;" in visitor.get(f"/stored/0/{key}", headers=HTML).text
    with pytest.raises(ValueError, match="there is no file"):
        client(stores=[tmp_path / "none.db"])


def test_a_damaged_store_does_not_show_where_it_is(tmp_path, caplog):
    path = stored(tmp_path / "study.db", Study(ids=[GRID], teachers=["oracle"], students=["obedient"], seeds=1))
    visitor = client(stores=[path])
    (row,) = load(path).rows()
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute("UPDATE story SET packed = x'00'")
    answer = visitor.get(f"/stored/0/{row['key']}")
    why = "a store of this server cannot be used; its terminal shows why"
    assert (answer.status_code, answer.json()) == (500, {"error": why})
    assert f"{path} is incomplete or damaged" in caplog.text


def test_beyond_the_most_the_lesson_that_waits_longest_is_closed(monkeypatch):
    visitor = client()
    page = begin(visitor)
    assert told(visitor.get(f"{page}/state"))["turn"] == 0
    monkeypatch.setattr(open_lessons, "MOST", 2)
    held, plan = OpenLessons(), read_plan({"id": GRID, "seat": "watch"})
    one, two = held.begin(plan), held.begin(plan)
    (token,) = one.tokens.values()
    held.find(token)
    closed, made = [], Future()
    monkeypatch.setattr(two.lesson, "close", lambda: closed.append(two))
    two.film = made
    held.begin(plan)
    assert (held.find(token), len(held), closed, made.cancelled()) == ((one, "watcher"), 2, [two], True)
    with pytest.raises(LookupError):
        held.find(*two.tokens.values())


def test_a_page_that_comes_back_finds_all_as_it_was():
    visitor = client()
    page = begin(visitor, seat="student")
    state = told(move(visitor, page, {"act": "west"}))
    again = told(visitor.get(f"{page}/state"))
    assert {**again, "first": 0, "turns": []} == {**state, "first": 0, "turns": []}
    assert len(again["turns"]) == 2
    for since in ("0p.99", "nonsense", "0c.1", "0p.-1", "0p.²"):
        odd = told(visitor.get(f"{page}/state", params={"since": since}))
        assert odd["first"] == (2 if since == "0p.99" else 0)


def test_a_study_that_runs_has_no_people(tmp_path):
    study = Study(ids=[GRID], teachers=["oracle"], students=["llf_teacher.people:PersonLearning"], seeds=1)
    with pytest.warns(RuntimeWarning, match="PersonLearning.*is a person, whom no program can play"):
        found = run(study, tmp_path / "none.db", workers=1)
    assert not list(found.rows())
