"""`llf serve`: the command."""

import contextlib
import json
import os
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


def test_a_page_on_this_machine(tmp_path):
    store = tmp_path / "people.db"
    with serving("--store", store) as (_, address):
        assert address.startswith("http://127.0.0.1:")
        with get(address) as page:
            assert b"Learning from language feedback" in page.read()
        sent = json.dumps({"id": "llf-gridworld-v0", "seat": "watch"}).encode()
        request = urllib.request.Request(f"{address}lessons", sent, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            assert json.load(answer)["page"].startswith("/seat/")
        assert store.exists()
        taken = llf("serve", "--port", "0", "--store", store)
        assert (taken.returncode, "another run writes to" in taken.stderr) == (2, True)


def test_bad_requests_are_one_line_of_the_log():
    """And requests that are half there do not keep the server from ending."""
    with serving() as (server, address), contextlib.ExitStack() as held:
        port = int(address.rstrip("/").rpartition(":")[2])
        for data in [b"nonsense\r\n\r\n"] * 20 + [b"GET / HTTP/1.1\r\n"]:
            connection = held.enter_context(socket.create_connection(("127.0.0.1", port), 60))
            connection.sendall(data)
            if data.startswith(b"nonsense"):
                assert connection.recv(1000).startswith(b"HTTP/1.1 400 ")
        server.send_signal(signal.SIGINT)
        _, errors = server.communicate(timeout=60)
    assert errors == "WARNING: Invalid HTTP request received.\n"


def test_beyond_this_machine_there_is_a_key():
    with serving("--host", "0.0.0.0", "--name", "lab.example") as (_, address):
        assert "/?key=" in address
        here = address.replace("0.0.0.0", "127.0.0.1")
        bare = here.partition("?")[0]
        with pytest.raises(urllib.error.HTTPError, match="401"):
            get(bare)
        with pytest.raises(urllib.error.HTTPError, match="421"):
            get(here, Host="evil.example")
        jar = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        with jar.open(here, timeout=60) as page:
            assert page.url == bare
            assert page.status == 200


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("--replay", "none.db"), "there is no file none.db"),
        (
            ("--consent", "none.txt"),
            "--consent: there is no file none.txt; give a text file with what people",
        ),
        (("--consent", os.devnull), f"--consent: {os.devnull} is empty; give a text file"),
        (("--host", "no.such.host.invalid"), "llf: "),
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
    monkeypatch.delitem(sys.modules, "llf_teacher.web.connections", raising=False)
    result = llf("serve")
    assert result.returncode == 2
    assert "the page needs 'uvicorn', which is not installed; run: pip install 'llf-teacher[web]'" in result.stderr
