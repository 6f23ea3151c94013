"""Limits of connections, at a real server: half requests, too many of them, moves that come twice."""

import asyncio
import contextlib
import http.client
import json
import logging
import socket
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from starlette.responses import PlainTextResponse

from llf_teacher.web.app import make_app
from llf_teacher.web.connections import ConnectionLimits, LimitedServer, default_connections, network_of
from llf_teacher.web.seldom import Seldom

HALF_HEADERS = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Half: "
HALF_BODY = (
    b"POST /lessons HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 99\r\n\r\n{"
)
SECONDS = 60


@contextlib.contextmanager
def serving(app=None, **limits):
    """A server in a thread; gives its port."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        server = LimitedServer(app or make_app(), ConnectionLimits(**limits))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            yield listening.getsockname()[1]
        finally:
            server.should_exit = True
            thread.join(SECONDS)
            assert not thread.is_alive()


def sends(port, data, source="127.0.0.1"):
    connection = socket.create_connection(("127.0.0.1", port), SECONDS, (source, 0))
    connection.sendall(data)
    return connection


def heard(connection):
    """All that the server sends until it closes the connection."""
    with contextlib.suppress(ConnectionResetError), connection.makefile("rb") as file:
        return file.read()
    return b""


def is_open(connection):
    connection.setblocking(False)
    try:
        return connection.recv(1) != b""
    except BlockingIOError:
        return True
    except ConnectionResetError:
        return False


def ask(port, method="GET", path="/", sent=None):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=SECONDS)
    with contextlib.closing(connection):
        headers = {} if sent is None else {"Content-Type": "application/json"}
        connection.request(method, path, None if sent is None else json.dumps(sent), headers)
        answer = connection.getresponse()
        return answer.status, answer.read()


@pytest.mark.parametrize(
    "data", [b"", HALF_HEADERS, HALF_BODY, HALF_BODY.replace(b"POST", b"GET", 1)], ids=["none", "head", "body", "get"]
)
def test_half_a_request_has_its_time(data):
    with serving(headers=0.3, body=0.3) as port, sends(port, data) as connection:
        answer = heard(connection)
        if data.startswith(b"GET /lessons"):  # which is refused before the body is there
            assert answer.startswith(b"HTTP/1.1 405 ")
        else:
            assert answer.startswith(b"HTTP/1.1 408 Request Timeout\r\n")
            body = json.loads(answer.partition(b"\r\n\r\n")[2])
            assert body == {"error": "the request did not arrive in time; send it again"}
        assert ask(port)[0] == 200


def test_one_byte_after_the_other_is_half_a_request():
    """It neither begins the time anew, nor does it after an answer."""
    whole = b"GET /static/icon.svg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    for first in (b"", whole):
        with serving(headers=0.5) as port, sends(port, first + b"G") as connection:
            connection.settimeout(0.1)
            answer = b""
            while not answer.endswith(b"}"):
                with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # it has closed: its answer waits
                    connection.sendall(b"E")
                with contextlib.suppress(TimeoutError):
                    part = connection.recv(1 << 16)
                    assert part, f"closed after {answer!r}"
                    answer += part
            assert b"HTTP/1.1 408 " in answer


def test_those_that_wait_make_room():
    """The oldest half request of the same address goes first; another address has room of its own."""
    with serving(connections=8) as port, contextlib.ExitStack() as held:
        other = held.enter_context(sends(port, HALF_BODY, "127.0.0.2"))
        kept = held.enter_context(contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=SECONDS)))
        kept.request("GET", "/static/icon.svg")
        kept.getresponse().read()
        sock = kept.sock
        halves = []
        for data in [HALF_HEADERS, HALF_BODY] * 3:
            halves.append(held.enter_context(sends(port, data)))
            assert ask(port)[0] == 200
        assert [heard(each) for each in halves[:4]] == [b""] * 4
        assert all(map(is_open, (*halves[4:], other)))
        kept.request("GET", "/static/icon.svg")
        assert kept.getresponse().status == 200
        assert kept.sock is sock


def test_when_all_are_answered_others_come_later():
    """Nobody that is being answered is closed."""
    go, begun = threading.Event(), threading.Semaphore(0)

    async def app(scope, receive, send):
        if scope["type"] == "http":
            begun.release()
            await asyncio.to_thread(go.wait, SECONDS)
            await PlainTextResponse("done")(scope, receive, send)

    with ThreadPoolExecutor(2) as visitors, serving(app, connections=4) as port:
        asked = [visitors.submit(ask, port) for _ in range(2)]
        for _ in asked:
            begun.acquire()
        with sends(port, b"") as connection:
            answer = heard(connection)
        go.set()
        assert [each.result() for each in asked] == [(200, b"done")] * 2
    assert answer.startswith(b"HTTP/1.1 503 Service Unavailable\r\n")
    assert b'{"error": "the server has too many connections; try again later"}' in answer


def test_a_machine_has_one_address():
    assert network_of("10.0.0.1") != network_of("10.0.0.2")
    assert network_of("2001:db8::1") == network_of("2001:db8::ffff:1") != network_of("2001:db8:0:1::1")


def test_connections_leave_files_for_others():
    assert 2 <= default_connections() <= 512
    if sys.platform != "win32":
        import resource

        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (600, limits[1]))
        try:
            assert default_connections() == 300
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@pytest.mark.parametrize(("seat", "move"), [("student", {"act": "west"}), ("teacher", {"claims": []}), ("watch", {})])
def test_ten_moves_at_once_are_one_move(seat, move):
    with serving() as port, ThreadPoolExecutor(10) as hands:
        page = json.loads(ask(port, "POST", "/lessons", {"id": "llf-gridworld-v0", "seed": 7, "seat": seat})[1])["page"]

        def post(what, turn):
            sent = {**move, "turn": turn}
            return sorted(hands.map(lambda _: ask(port, "POST", f"{page}/{what}", sent), range(10)))

        (status, state), *others = post("move", 0)
        assert (status, json.loads(state)["turn"]) == (200, 1)
        why = "the lesson is at turn 1, and this was sent for turn 0; look at its state first"
        assert [(status, json.loads(answer)) for status, answer in others] == [(409, {"error": why})] * 9
        assert ask(port, "POST", f"{page}/move", {**move, "turn": 1})[0] == 200
        (status, state), *others = post("undo", 2)
        assert (status, json.loads(state)["turn"], {status for status, _ in others}) == (200, 1, {409})


def record(line, text="", error=None):
    info = None if error is None else (type(error), error, error.__traceback__)
    return logging.LogRecord("llf", logging.ERROR, "some.py", line, "%s", (text,), info)


def test_what_repeats_is_logged_once_a_minute():
    now = 0.0
    seldom = Seldom(clock=lambda: now)
    assert [seldom.filter(record(1, f"text {number}")) for number in range(3)] == [True, False, False]
    assert seldom.filter(record(2))
    errors = []
    for raised in (ValueError("a"), ValueError("b"), TypeError("c")):
        try:
            raise raised
        except (ValueError, TypeError) as error:
            errors.append(error)
    assert [seldom.filter(record(2, error=error)) for error in errors] == [True, False, True]
    now = 60.0
    later = record(1, "100 % new")
    assert seldom.filter(later)
    assert later.getMessage() == "100 % new (2 more like this one were not logged)"
    now = 120.0
    last = record(1, "last")
    assert seldom.filter(last)
    assert last.getMessage() == "last"
