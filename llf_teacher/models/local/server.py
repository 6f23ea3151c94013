"""The server process of a model, from its users' side: the first starts it, all share it, and it ends with the last.

There is one process for each machine and model. Each user holds a lock together with the others, which the kernel
releases however the user ends; when all have, the server ends. Its folder is `servers/HOST/DIGEST` in the user's cache
folder; `server.log` there is kept.
"""

import contextlib
import importlib.util
import json
import os
import secrets
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.models.local import memory, options
from llf_teacher.models.local.catalogue import LocalModel, folder, write
from llf_teacher.models.local.gguf import read_header
from llf_teacher.models.local.options import ServerOptions
from worlds.extras import pip_install

try:
    import fcntl
except ImportError:  # not POSIX
    fcntl = None  # type: ignore[assignment]

LINGER = 3.0
"""Seconds without users after which a server ends, so that one command can follow another."""
_SERVING = Path(__file__).with_name("serving.py")
_LOOK = 0.05  # seconds between two looks at a server that loads its model
_LOG = 10_000_000  # bytes of a log, after which it begins anew
_EXCERPT = 300  # characters of a log
_CALM = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "0"}
"""Threads that wait give their core away: on 2 cores that others use, too, an answer takes a fiftieth of the time."""


class Running(NamedTuple):
    """A server that answers."""

    url: str
    key: str
    pid: int
    slots: int
    context: int
    threads: int

    def __repr__(self) -> str:
        return f"<server {self.pid} at {self.url}>"  # without the key


def check_engine() -> None:
    """Check that llama.cpp is installed and can be shared.

    Raises:
        ModuleNotFoundError: it is not installed; the message has the pip line.
        ValueError: this system has no locks.
    """
    if fcntl is None:
        raise ValueError("local models need a POSIX system; run a server of your own and give its address as base_url")
    if importlib.util.find_spec("xllamacpp") is None:
        raise ModuleNotFoundError(
            f"local models need 'xllamacpp', which is not installed; run: {pip_install('llm,local')}", name="xllamacpp"
        )


class ServerLease:
    """The share of this process in the server of a model. Many threads may use it.

    Args:
        model: the model.
    """

    def __init__(self, model: LocalModel) -> None:
        self._model = model
        self._one = threading.Lock()
        self._lock: int | None = None
        self._running: Running | None = None

    @property
    def folder(self) -> Path:
        """The folder of the server."""
        return folder_of(self._model.digest)

    @property
    def log(self) -> Path:
        """What the server writes."""
        return self.folder / "server.log"

    def running(self) -> Running:
        """The server, which is started unless it runs.

        Raises:
            ValueError, OSError: it does not start, or runs with other options; the message has the remedy.
            ModuleNotFoundError: llama.cpp is not installed.
        """
        with self._one:
            if self._running is None:
                self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
                with _locked(self.folder.parent / "start.lock"):  # one at a time: the next sees what memory is left
                    self._hold()
                    self._running = self._join() or self._start()
            return self._running

    def lives(self) -> bool:
        """Whether the server that this process uses runs; another may have begun in its place."""
        return self._running is not None and is_alive(self.folder) and read_running(self.folder) == self._running

    def last_words(self) -> str:
        """The end of the server's log."""
        with contextlib.suppress(OSError):
            lines = self.log.read_text("utf-8", "replace").rstrip()[-4 * _EXCERPT :].splitlines()
            errors = [line for line in lines if " E " in line or "rror" in line]
            return (errors or lines or [""])[-1].strip()[:_EXCERPT]
        return ""

    def close(self) -> None:
        """Leave the server to its other users."""
        with self._one:
            if self._lock is not None:
                os.close(self._lock)
            self._lock = self._running = None

    def _hold(self) -> None:
        """Become a user. This waits for a server that is ending."""
        if self._lock is None:
            self._lock = os.open(self.folder / "users.lock", os.O_RDWR | os.O_CREAT, 0o600)
            fcntl.flock(self._lock, fcntl.LOCK_SH)

    def _join(self) -> Running | None:
        """The server that runs already; None if there is none."""
        while is_alive(self.folder):
            if found := read_running(self.folder):
                self._compare(found)
                return found
            time.sleep(_LOOK)  # the process that started it has ended while it loads
        return None

    def _compare(self, found: Running) -> None:
        wanted = ServerOptions.read(read_header(Path(self._model.path)).context)
        for field, name in options.given().items():
            if (now := getattr(found, field)) != (want := getattr(wanted, field)):
                raise ValueError(
                    f"the server of the model {self._model.name!r} (process {found.pid}) runs with {name}={now}, got "
                    f"{want}; unset {name}, or end the programs that use the model first"
                )

    def _start(self) -> Running:
        check_engine()
        header = read_header(Path(self._model.path))
        wanted = ServerOptions.read(header.context)
        self._check_memory(memory.needed(header, wanted.context, wanted.slots), wanted)
        settings = {
            "path": self._model.path,
            "alias": self._model.digest,
            "template": self._model.template,
            "key": secrets.token_urlsafe(32),
            "prompts": memory.PROMPTS,
            "linger": LINGER,
            **wanted._asdict(),
        }
        (self.folder / "server.json").unlink(missing_ok=True)
        write(self.folder / "settings.json", settings)
        process = self._spawn()
        while process.poll() is None:
            if found := read_running(self.folder):
                threading.Thread(target=process.wait, name="llf-local-server", daemon=True).start()  # no zombie stays
                return found
            time.sleep(_LOOK)
        raise ValueError(
            f"the server of the model {self._model.name!r} ended while it began: {self.last_words()}; its log is "
            f"{self.log}"
        )

    def _spawn(self) -> "subprocess.Popen[bytes]":
        begins_anew = self.log.exists() and self.log.stat().st_size > _LOG
        with self.log.open("wb" if begins_anew else "ab") as log:
            log.write(f"\n== {time.strftime('%Y-%m-%d %H:%M:%S')} {self._model.spec} {self._model.path}\n".encode())
            log.flush()
            return subprocess.Popen(  # noqa: S603 (our own words)
                [sys.executable, "-P", f"{_SERVING}", f"{self.folder}"],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env={**_CALM, **os.environ},
                start_new_session=True,  # an interrupt at the terminal is for its users
            )

    def _check_memory(self, need: int, wanted: ServerOptions) -> None:
        there = memory.available()
        if there is None or need <= there:
            return
        others = [name for name, _ in servers() if name != self._model.digest]
        also = f"; {len(others)} other local models run: end the programs that use them" if others else ""
        raise ValueError(
            f"the model {self._model.name!r} needs about {memory.shown(need)} of memory with {wanted.slots} slots of "
            f"{wanted.context} tokens, and {memory.shown(there)} are available; set {options.CONTEXT} or "
            f"{options.SLOTS} to a smaller number, or take a smaller model{also}"
        )


def folder_of(digest: str) -> Path:
    """The folder of a model's server on this machine."""
    return folder() / "servers" / socket.gethostname() / digest


def servers() -> list[tuple[str, Running]]:
    """The servers that run on this machine, each with its model's digest."""
    folders = [path for path in folder_of("").glob("*") if path.is_dir() and is_alive(path)]
    return [(path.name, found) for path in sorted(folders) if (found := read_running(path))]


def read_running(path: Path) -> Running | None:
    """The server of a folder, if it has said that it answers."""
    try:
        settings: dict[str, Any] = json.loads((path / "server.json").read_text("utf-8"))
        return Running(**settings)
    except (OSError, ValueError, TypeError):
        return None


def is_alive(path: Path) -> bool:
    """Whether the server of a folder lives: it holds its lock."""
    if fcntl is None:
        return False
    try:
        lock = os.open(path / "server.lock", os.O_RDWR)
    except OSError:
        return False
    try:
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(lock)
    return False


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)
