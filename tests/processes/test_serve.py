"""`llf serve`: the command."""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request

import pytest
from commands import llf


@contextlib.contextmanager
def serving(*arguments):
    """The command at a free port; gives the process and its first line. Ctrl-C has to end it."""
    command = [sys.executable, "-m", "llf_teacher", "serve", "--port", "0", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        yield server, server.stdout.readline().strip()
        errors = ""
        if server.poll() is None:
            server.send_signal(signal.SIGINT)
            _, errors = server.communicate(timeout=60)
    assert "Traceback" not in errors
    assert server.returncode == 0, errors


def get(address, **headers):
    return urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=60)


def test_a_page_on_this_machine():
    with serving() as (_, address):
        assert address.startswith("http://127.0.0.1:")
        with get(address) as page:
            assert b"Learning from language feedback" in page.read()
        sent = json.dumps({"id": "llf-gridworld-v0", "seat": "watch"}).encode()
        request = urllib.request.Request(f"{address}lessons", sent, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            assert json.load(answer)["page"].startswith("/seat/")


def test_a_bad_request_is_a_line_of_the_log():
    """And requests that are half there do not keep the server from ending."""
    with serving() as (server, address), contextlib.ExitStack() as held:
        port = int(address.rstrip("/").rpartition(":")[2])
        for data in [b"nonsense\r\n\r\n", b"GET / HTTP/1.1\r\n"]:
            connection = held.enter_context(socket.create_connection(("127.0.0.1", port), 60))
            connection.sendall(data)
            if data.startswith(b"nonsense"):
                assert connection.recv(1000).startswith(b"HTTP/1.1 400 ")
        server.send_signal(signal.SIGINT)
        _, errors = server.communicate(timeout=60)
    assert re.fullmatch(r"WARNING: +Invalid HTTP request received\.\n", errors), errors


def test_a_request_whose_body_never_ends_is_ended_by_ctrl_c():
    head = "POST /lessons HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: 99\r\n\r\n{{"
    with serving() as (server, address):
        host = address.removeprefix("http://").rstrip("/")
        with socket.create_connection(host.split(":"), 60) as connection:
            connection.sendall(head.format(host).encode())
            get(address).close()  # the server has the other request by now
            server.send_signal(signal.SIGINT)
            assert connection.recv(1000).startswith(b"HTTP/1.1 503 ")
            _, errors = server.communicate(timeout=60)
    assert re.fullmatch(r"ERROR: +Cancel 1 running task\(s\), timeout graceful shutdown exceeded\n", errors), errors


def test_teachers_and_students_of_ones_own_are_offered(tmp_path, monkeypatch):
    module = "from teachers.personality import personality\n\n\n@personality()\ndef shy(claims, view):\n"
    (tmp_path / "moods.py").write_text(f'{module}    """Says one thing."""\n    return claims[:1]\n')
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    with serving("--teacher", "moods:shy") as (_, address):
        with get(address) as page:
            assert b'<option value="moods:shy">' in page.read()
        given = {"id": "llf-gridworld-v0", "seat": "watch", "teacher": "vague | moods:shy"}
        request = urllib.request.Request(
            f"{address}lessons", json.dumps(given).encode(), {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=60) as answer:
            assert json.load(answer)["page"].startswith("/seat/")


def test_only_this_machine_is_answered():
    with serving() as (_, address):
        assert address.startswith("http://127.0.0.1:")
        with pytest.raises(urllib.error.HTTPError, match="421"):
            get(address, Host="evil.example")


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("--replay", "none.db"), "there is no file none.db"),
        (("--environment", "gym:NoSuch-v0"), "NoSuch"),
        (("--host", "0.0.0.0"), "No such option"),
        (("--teacher", "nowhere:Shy"), "cannot import the module 'nowhere'"),
        (("--student", "nowhere:Shy"), "cannot import the module 'nowhere'"),
    ],
)
def test_what_does_not_work_is_one_line(arguments, why):
    result = llf("serve", "--port", "0", *arguments)
    assert result.returncode == 2
    assert why in result.stderr
    assert "Traceback" not in result.stderr


def test_a_port_that_is_taken_is_named():
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        result = llf("serve", "--port", port)
    assert result.returncode == 2
    assert f"llf: port {port} of 127.0.0.1 is taken; give another --port, or 0 for a free one" in result.stderr


def test_what_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    result = llf("serve")
    assert result.returncode == 2
    assert "the page needs 'uvicorn', which is not installed; run: pip install 'llf-teacher[web]'" in result.stderr
