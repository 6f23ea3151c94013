"""The server: what it answers, to whom, and what it refuses."""

import contextlib
import io
import json
import sqlite3

import pytest
from PIL import Image
from starlette.testclient import TestClient
from studying import stored

from llf_teacher.studies import Study, load, run
from llf_teacher.theme import kind_mark
from llf_teacher.web import open_lessons
from llf_teacher.web.app import LARGEST, make_app
from llf_teacher.web.guard import COOKIE
from llf_teacher.web.open_lessons import OpenLessons, Terms
from llf_teacher.web.plan import read_plan

GRID = "llf-gridworld-v0"
HTML = {"accept": "text/html"}


def client(*args, **settings):
    return TestClient(make_app(*args, **settings), base_url="http://127.0.0.1:8000", follow_redirects=False)


def begin(visitor, **choices):
    answer = visitor.post("/lessons", json={"id": GRID, "seed": 7, "max_turns": 3, **choices})
    assert answer.status_code == 201, answer.text
    return answer.json()["page"]


def told(answer):
    assert answer.status_code == 200, answer.text
    return answer.json()


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
    student = visitor.get(page).text.partition('data-path="')[2].partition('"')[0]
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


def test_two_people_see_what_is_theirs():
    visitor = client()
    page = begin(visitor, seat="student", two=True)
    address = visitor.get(page).text.partition('data-path="')[2].partition('"')[0]
    other = told(visitor.get(f"{address}/state"))
    assert (other["seat"], other["mine"], other["claims"][0]["kind"]) == ("teacher", True, "fp")
    assert "data-path" not in visitor.get(address).text
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
    student = visitor.get(page).text.partition('data-path="')[2].partition('"')[0]
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
        (None, 400, "turn must be a whole number, the turn of the lesson's state, got None"),
        (True, 400, "turn must be a whole number"),
        (0, 409, "the lesson is at turn 1, and this was sent for turn 0; look at its state first"),
        (2, 409, "the lesson is at turn 1, and this was sent for turn 2"),
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


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "192.168.0.7:8000", "[", ""])
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


def test_a_key_is_asked_for_once():
    """A seat's address is a secret of its own: whoever has it needs no key."""
    visitor = client(names={"lab.example"}, key="open sesame")
    assert visitor.get("/").status_code == 401
    assert visitor.get("/", params={"key": "wrong"}).status_code == 401
    assert visitor.get("/", headers={"cookie": f'{COOKIE}="'}).status_code == 401
    shown = visitor.get("/", params={"key": "open sesame"})
    assert (shown.status_code, shown.headers["location"]) == (303, "/")
    assert "HttpOnly" in shown.headers["set-cookie"]
    assert "SameSite=strict" in shown.headers["set-cookie"]
    page = begin(visitor, seat="watch")
    visitor.cookies.clear()
    assert visitor.get("/").status_code == 401
    assert visitor.get(page).status_code == 200
    assert visitor.get("/", headers={"host": "lab.example"}).status_code == 401
    assert visitor.get("/", headers={"host": "other.example"}).status_code == 421


@pytest.mark.parametrize("seat", ["student", "teacher", "watch"])
def test_an_episode_can_be_taken_along(seat, tmp_path):
    visitor = client()
    page = begin(visitor, seat=seat)
    finish(visitor, page, {"act": "west", "personality": True})
    record = visitor.get(f"{page}/episode.json").json()
    assert (record["seed"], len(record["turns"]), len(record["regrets"])) == (7, 4, 3)
    (chat,) = map(json.loads, visitor.get(f"{page}/episode.jsonl").text.splitlines())
    assert [message["role"] for message in chat["messages"]][:2] == ["system", "user"]
    with Image.open(io.BytesIO(visitor.get(f"{page}/episode.gif").content)) as film:
        assert film.n_frames == 4
    answer = visitor.get(f"{page}/episode.db")
    assert f'filename="llf-{record["key"][:8]}.db"' in answer.headers["content-disposition"]
    (tmp_path / "one.db").write_bytes(answer.content)
    assert load(tmp_path / "one.db").turns(record["key"]) == record["turns"]
    assert (
        visitor.get(f"{page}/episode.exe").json()["error"]
        == "there is no file with the ending 'exe'; allowed: json, jsonl, gif, db"
    )


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
    assert "To take along" not in shown
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


def test_people_agree_before_anything_is_kept(tmp_path):
    path = tmp_path / "people.db"
    visitor = client(Terms(consent="We keep what you do.", codes=True, store=path))
    page = begin(visitor, seat="student", two=True, teacher="mistake(eps=0.5)")
    teacher = visitor.get(page).text.partition('data-path="')[2].partition('"')[0]
    state = told(visitor.get(f"{page}/state"))
    assert (state["join"], state["consent"], state["codes"]) == (True, "We keep what you do.", True)
    for sent, why in (
        ({"agreed": "yes", "code": "p1"}, "to take part you must agree"),
        ({"agreed": True, "code": "a b"}, "the code must be 1 to 32 letters"),
        ({"agreed": True}, "the code must be"),
    ):
        assert why in visitor.post(f"{page}/sit", json=sent).json()["error"]
    assert "you have not taken a seat yet" in move(visitor, page, {"act": "west"}).json()["error"]
    told(visitor.post(f"{page}/sit", json={"agreed": True, "code": "p1"}))
    assert told(visitor.get(f"{page}/state"))["waits"] == "teacher"
    assert "the teacher has not taken a seat yet" in move(visitor, page, {"act": "west"}).json()["error"]
    told(visitor.post(f"{teacher}/sit", json={"agreed": True, "code": "p2"}))
    assert not path.exists()
    for _ in range(3):
        told(move(visitor, teacher, {"personality": True}))
        told(move(visitor, page, {"act": "west"}))
    state = told(move(visitor, teacher, {"claims": []}))
    assert (state["over"], state["kept"], state["undo"]) == (True, True, False)
    assert "is in the store already" in undo(visitor, teacher).json()["error"]
    (row,) = load(path).rows()
    assert row["student"] == "llf_teacher.people:PersonLearning(code='p1')"
    assert row["teacher"] == "llf_teacher.people:PersonTeaching(code='p2', offers='mistake(eps=0.5)')"
    text = json.dumps({**dict(row), "turns": load(path).turns(row["key"])}, default=str)
    assert not [word for word in ("127.0.0.1", "testclient", "Mozilla") if word in text]


def test_the_same_world_again_is_another_sample(tmp_path):
    """Lessons in which nobody sits are not kept."""
    path = tmp_path / "people.db"
    visitor = client(Terms(store=path, undo=False))
    for seat in ("student", "student", "watch"):
        page = begin(visitor, seat=seat, max_turns=1)
        finish(visitor, page, {"act": "west"})
        assert told(visitor.get(f"{page}/state"))["undo"] is False
        assert "does not allow to take turns back" in undo(visitor, page).json()["error"]
    assert sorted(row["sample"] for row in load(path).rows()) == [0, 1]
    with contextlib.closing(sqlite3.connect(path)) as db:
        assert db.execute("SELECT count(*) FROM result").fetchone() == (2,)


def test_lessons_are_bounded_in_number_and_age():
    visitor = client(Terms(most=1))
    page = begin(visitor)
    answer = visitor.post("/lessons", json={"id": GRID})
    assert (answer.status_code, answer.json()["error"].split(";")[0]) == (503, "all 1 lessons are in use")
    now = 0.0
    held = OpenLessons(Terms(most=2, idle=60), clock=lambda: now)
    one, two = (held.begin(read_plan({"id": GRID, "seat": "watch"})) for _ in range(2))
    now = 50.0
    (token,) = one.tokens.values()
    held.find(token)
    now = 70.0
    assert held.find(token) == (one, "watcher")
    assert len(held) == 1
    with pytest.raises(LookupError):
        held.find(*two.tokens.values())
    assert told(visitor.get(f"{page}/state"))["turn"] == 0


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
    with pytest.warns(RuntimeWarning, match="PersonLearning.*is a person in the browser"):
        found = run(study, tmp_path / "none.db", workers=1)
    assert not list(found.rows())
