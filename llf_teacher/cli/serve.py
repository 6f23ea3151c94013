"""`llf serve`: serve the page in the browser."""

import contextlib
import errno
import secrets
import socket
from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import draw_off_screen, search_here
from worlds.extras import pip_install


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("serve")(serve)


def serve(
    host: Annotated[
        str, typer.Option(help="Address to listen on; other machines need the key that is printed.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0 takes a free one.", min=0, max=65535)] = 8000,
    name: Annotated[
        list[str] | None,
        typer.Option(help="Another name of this machine that requests may use; repeat it for several."),
    ] = None,
    replay: Annotated[
        list[Path] | None, typer.Option(help="Store of a study whose episodes can be replayed; repeat it for several.")
    ] = None,
    store: Annotated[Path | None, typer.Option(help="Store to which episodes with people are written.")] = None,
    consent: Annotated[Path | None, typer.Option(help="Text file to which people must agree before they play.")] = None,
    codes: Annotated[bool, typer.Option("--codes", help="Ask people for a participant code.")] = False,
    no_undo: Annotated[bool, typer.Option("--no-undo", help="Do not allow people to take turns back.")] = False,
    sessions: Annotated[int, typer.Option(help="Most lessons at a time.", min=1)] = 100,
    idle: Annotated[
        float, typer.Option(help="Minutes without a request after which a lesson is dropped.", min=0.1)
    ] = 60.0,
    environment: Annotated[
        list[str] | None,
        typer.Option(help="Environment of Gymnasium to offer, too, such as gym:Taxi-v4; repeat it for several."),
    ] = None,
    connections: Annotated[
        int | None,
        typer.Option(
            help="Most connections at a time, of which one address has at most half; by default half of the files that "
            "the process may open, at most 512.",
            min=2,
        ),
    ] = None,
) -> None:
    """Serve a page in the browser for both seats: play, watch, and replay stored episodes. Ctrl-C stops it.

    Only episodes are stored, and only with --store.
    """
    draw_off_screen()
    try:
        from llf_teacher.web.app import make_app
        from llf_teacher.web.connections import ConnectionLimits, LimitedServer, default_connections
        from llf_teacher.web.guard import LOCAL
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn"):
            raise
        raise ModuleNotFoundError(
            f"the page needs {error.name!r}, which is not installed; run: {pip_install('web')}",
            name=error.name,
        ) from error
    from llf_teacher.studies.store import Store
    from llf_teacher.studies.store.store_lock import lock_store
    from llf_teacher.web.open_lessons import Terms
    from pz_envs.registered import registered

    search_here()
    key = "" if host in LOCAL else secrets.token_urlsafe(16)
    names = {*LOCAL, *(name or ())} | ({host} if key else set())
    text = _agreement(consent) if consent else ""
    with contextlib.ExitStack() as held:
        if store is not None:
            held.enter_context(lock_store(store))
            Store(store).close()  # makes the file, or fails before the first lesson
        ids = tuple(registered(id).id for id in environment or ())
        terms = Terms(text, codes, not no_undo, store, sessions, 60 * idle, ids)
        app = make_app(terms, replay or (), names, key)
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            listening = held.enter_context(socket.create_server((host, port), family=family))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise ValueError(f"port {port} of {host} is taken; give another --port, or 0 for a free one") from error
            raise
        shown = f"[{host}]" if ":" in host else host
        address = f"http://{shown}:{listening.getsockname()[1]}/"
        typer.echo(f"{address}?key={key}" if key else address)
        limits = ConnectionLimits(connections or default_connections())
        with contextlib.suppress(KeyboardInterrupt):
            LimitedServer(app, limits).run(sockets=[listening])


def _agreement(path: Path) -> str:
    """The text of a file to which people must agree."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    if not text.strip():
        why = f"{path} is empty" if path.exists() else f"there is no file {path}"
        raise ValueError(f"--consent: {why}; give a text file with what people must agree to before they play")
    return text
