"""`llf serve`: a page in the browser."""

import contextlib
import secrets
import socket
from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import draw_off_screen


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("serve")(serve)


def serve(
    host: Annotated[str, typer.Option(help="Where to listen; beyond this machine visitors need a key.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="0: any that is free.", min=0, max=65535)] = 8000,
    name: Annotated[list[str] | None, typer.Option(help="A name under which visitors know this machine.")] = None,
    replay: Annotated[list[Path] | None, typer.Option(help="A study's store, to look at its episodes.")] = None,
    store: Annotated[Path | None, typer.Option(help="Where episodes with people are written.")] = None,
    consent: Annotated[Path | None, typer.Option(help="A text to which people have to agree.")] = None,
    codes: Annotated[bool, typer.Option("--codes", help="Ask people for a participant's code.")] = False,
    no_undo: Annotated[bool, typer.Option("--no-undo", help="Take no turn back.")] = False,
    sessions: Annotated[int, typer.Option(help="Lessons at a time.", min=1)] = 100,
    idle: Annotated[float, typer.Option(help="Minutes after which a lesson is dropped.", min=0.1)] = 60.0,
) -> None:
    """Serve a page on which people sit in the seats, watch, and look at stored episodes. Ctrl-C ends it.

    Nothing is kept but the episodes that go into --store.
    """
    draw_off_screen()
    try:
        import uvicorn

        from llf_teacher.web.app import make_app
        from llf_teacher.web.guard import LOCAL
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn"):
            raise
        raise ModuleNotFoundError(
            f"the page needs {error.name!r}, which is not installed; run: pip install 'llf-teacher[web]'",
            name=error.name,
        ) from error
    from llf_teacher.studies.store import Store
    from llf_teacher.studies.store.store_lock import lock_store
    from llf_teacher.web.sessions import Terms

    key = "" if host in LOCAL else secrets.token_urlsafe(16)
    names = {*LOCAL, *(name or ())} | ({host} if key else set())
    text = "" if consent is None else consent.read_text(encoding="utf-8")
    with contextlib.ExitStack() as held:
        if store is not None:
            held.enter_context(lock_store(store))
            Store(store).close()  # so that it is made, or refused, before anybody has played
        terms = Terms(text, codes, not no_undo, store, sessions, 60 * idle)
        app = make_app(terms, replay or (), names, key)
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listening = held.enter_context(socket.create_server((host, port), family=family))
        shown = f"[{host}]" if ":" in host else host
        address = f"http://{shown}:{listening.getsockname()[1]}/"
        typer.echo(f"{address}?key={key}" if key else address)
        # No line a visit: who came when is nobody's business.
        settings = uvicorn.Config(app, access_log=False, log_level="warning", server_header=False, proxy_headers=False)
        with contextlib.suppress(KeyboardInterrupt):
            uvicorn.Server(settings).run(sockets=[listening])
