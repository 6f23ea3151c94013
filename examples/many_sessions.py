"""How long a step takes when many lessons are played at once at one server, and what memory they take.

    pip install -e ".[all,web]" -c constraints.txt
    python examples/many_sessions.py
    python examples/many_sessions.py --sessions 100 --turns 10 --id llf-gridworld-v0

Starts `llf serve`, opens as many lessons as it is told, a third of them in each seat, and plays all at once, by a
thread a visitor. A visitor does not stop to think, and asks for the picture after each turn as the page does. Prints a
table in Markdown. What the server has used is read from /proc, which only Linux has.
"""

import argparse
import http.client
import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median, quantiles
from typing import Any, NamedTuple

SEATS = {"student": {"act": "0"}, "teacher": {"personality": True}, "watch": {}}
local = threading.local()


def ask(port: int, method: str, path: str, sent: dict[str, Any] | None = None) -> tuple[bytes, float]:
    """An answer of the server, whose connection each thread keeps, and the seconds that it took."""
    if not hasattr(local, "connection"):
        local.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
    body = None if sent is None else json.dumps(sent)
    begun = time.perf_counter()
    local.connection.request(method, path, body, {} if sent is None else {"Content-Type": "application/json"})
    answer = local.connection.getresponse()
    content = answer.read()
    taken = time.perf_counter() - begun
    if answer.status >= 400:
        raise RuntimeError(f"{path}: {content.decode()}")
    return content, taken


class Used(NamedTuple):
    """What a process has used."""

    megabytes: float
    seconds: float
    """Of processor time."""


def used(process: subprocess.Popen[str]) -> Used:
    """What the kernel says of a process."""
    folder = Path(f"/proc/{process.pid}")
    pages = int((folder / "statm").read_text().split()[1])
    ticks = (folder / "stat").read_text().rpartition(")")[2].split()[11:13]
    return Used(pages * os.sysconf("SC_PAGE_SIZE") / 2**20, sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK"))


def main() -> None:
    """Play, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=100)
    parser.add_argument("--turns", type=int, default=10)
    parser.add_argument("--id", default="llf-gridworld-v0")
    settings = parser.parse_args()
    command = [sys.executable, "-m", "llf_teacher", "serve", "--port", "0", "--sessions", str(settings.sessions + 1)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:  # noqa: S603 (of our own words)
        try:
            play(server, settings)
        finally:
            server.send_signal(signal.SIGINT)


def play(server: subprocess.Popen[str], settings: argparse.Namespace) -> None:
    """Play as many lessons at once."""
    assert server.stdout is not None  # noqa: S101 (it was asked for)
    port = int(server.stdout.readline().strip().rstrip("/").rpartition(":")[2])

    def begin(number: int, seat: str) -> tuple[str, float]:
        chosen = {"id": settings.id, "seat": seat, "seed": number, "student": "random", "max_turns": settings.turns}
        answer, taken = ask(port, "POST", "/lessons", chosen)
        return json.loads(answer)["page"], taken

    def sit(number: int, seat: str) -> tuple[list[float], list[float], float]:
        """One visitor: the seconds of each step, of each picture, and of the beginning."""
        page, beginning = begin(number, seat)
        steps, pictures = [], []
        over, mark, turn = False, "", 0
        while not over:
            answer, taken = ask(port, "POST", f"{page}/move", {**SEATS[seat], "since": mark, "turn": turn})
            steps.append(taken)
            told = json.loads(answer)
            over, mark, turn = told["over"], told["mark"], told["turn"]
            pictures.append(ask(port, "GET", f"{page}/frame.png")[1])
        return steps, pictures, beginning

    page, _ = begin(0, "watch")  # which loads what all of them need
    ask(port, "GET", f"{page}/frame.png")
    before = used(server)
    begun = time.perf_counter()
    with ThreadPoolExecutor(settings.sessions) as visitors:
        played = list(visitors.map(sit, range(settings.sessions), itertools.cycle(SEATS)))
    seconds = time.perf_counter() - begun
    after = used(server)
    steps, pictures = ([each for visitor in played for each in visitor[i]] for i in (0, 1))
    print(f"{settings.sessions} lessons of {settings.id} at once: {len(steps)} steps and pictures in {seconds:.1f} s\n")
    print("| what | median | 95 of 100 within |\n|---|---|---|")
    for what, each in {"a step": steps, "a picture": pictures, "a beginning": [v[2] for v in played]}.items():
        print(f"| {what} | {1000 * median(each):.0f} ms | {1000 * quantiles(each, n=20)[-1]:.0f} ms |")
    each = (after.megabytes - before.megabytes) / settings.sessions
    busy = after.seconds - before.seconds
    print(f"\nProcessor time of the server: {busy:.1f} s, {1000 * busy / len(steps):.0f} ms a step with its picture")
    print(
        f"Its memory: {before.megabytes:.0f} MB before, {after.megabytes:.0f} MB with all of them, {each:.2f} MB each"
    )


if __name__ == "__main__":
    main()
