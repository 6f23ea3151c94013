"""`llf serve`: serve the page in the browser."""

import contextlib
import errno
import socket
from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import draw_off_screen, search_here
from worlds.extras import pip_install

_HOST = "127.0.0.1"
_PATIENCE = 3  # seconds for open answers to end when the server stops


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("serve")(serve)


def serve(
    port: Annotated[int, typer.Option(help="Port to listen on; 0 takes a free one.", min=0, max=65535)] = 8000,
    replay: Annotated[
        list[Path] | None, typer.Option(help="Store of a study whose episodes can be replayed; repeat it for several.")
    ] = None,
    environment: Annotated[
        list[str] | None,
        typer.Option(help="Environment of Gymnasium to offer, too, such as gym:Taxi-v4; repeat it for several."),
    ] = None,
    teacher: Annotated[
        list[str] | None,
        typer.Option(help="Personality of your own to offer, too, as module:Class; repeat it for several."),
    ] = None,
    student: Annotated[
        list[str] | None,
        typer.Option(help="Student of your own to offer, too, as module:factory; repeat it for several."),
    ] = None,
) -> None:
    """Serve a page in the browser, for you alone: play in either seat or both, watch, and replay stored episodes.

    It listens on 127.0.0.1, which no other machine reaches, and stores nothing. Ctrl-C stops it.
    """
    draw_off_screen()
    try:
        import uvicorn

        from llf_teacher.web.app import make_app
    except ModuleNotFoundError as error:
        if error.name not in ("starlette", "uvicorn"):
            raise
        raise ModuleNotFoundError(
            f"the page needs {error.name!r}, which is not installed; run: {pip_install('web')}",
            name=error.name,
        ) from error
    from llf_teacher.students.parsing import parse_student
    from pz_envs.registered import registered
    from teachers.personality import parse_personality

    search_here()
    app = make_app(
        replay or (),
        [registered(id).id for id in environment or ()],
        [str(parse_personality(spec)) for spec in teacher or ()],
        [str(parse_student(spec)) for spec in student or ()],
    )
    try:
        listening = socket.create_server((_HOST, port))
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise ValueError(f"port {port} of {_HOST} is taken; give another --port, or 0 for a free one") from error
        raise
    settings = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=_PATIENCE,
    )
    with listening, contextlib.suppress(KeyboardInterrupt):
        typer.echo(f"http://{_HOST}:{listening.getsockname()[1]}/")
        uvicorn.Server(settings).run(sockets=[listening])
