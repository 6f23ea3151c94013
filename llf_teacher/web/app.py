"""The server: routes and handlers."""

import asyncio
import json
import logging
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, JSONResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from llf_teacher.episodes.live import OutOfTurnError
from llf_teacher.episodes.record import pack_turns, unpack_turns
from llf_teacher.escaping import escape_control_chars
from llf_teacher.registry import entries
from llf_teacher.studies import load
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.theme import pages, prepare_turns, style
from llf_teacher.web.downloads import DOWNLOADS, content
from llf_teacher.web.films import Films
from llf_teacher.web.guard import Guard
from llf_teacher.web.open_lessons import OpenLesson, OpenLessons
from llf_teacher.web.plan import MOST_TURNS, SPEECHES, read_plan, students
from llf_teacher.web.stored import PAGE, search
from llf_teacher.web.views import links, picture, state
from pz_envs.seats import STUDENT, TEACHER
from teachers.personality import PERSONALITIES
from teachers.schema import storable
from teachers.spec import paths_in

__all__ = ["make_app"]

LARGEST = 16_384
"""Greatest length of a request body, in bytes."""
LONGEST = 4_000
"""Greatest length of a person's words in a turn, in characters."""
_STATIC = Path(__file__).parent / "static"
_PHRASES = {
    "Not Found": "there is no such page; begin at /",
    "Method Not Allowed": "this page does not allow the request's method; begin at /",
}
"""Sentences for Starlette's own errors."""
_LOG = logging.getLogger("uvicorn.error")
P = ParamSpec("P")
R = TypeVar("R")


def make_app(
    stores: Sequence[Path] = (),
    ids: Sequence[str] = (),
    teachers: Sequence[str] = (),
    students: Sequence[str] = (),
) -> ASGIApp:
    """The application.

    Args:
        stores: the stores whose episodes the page shows.
        ids: environments of Gymnasium's registry that the page offers beside ours.
        teachers: specs of personalities of the user's own that it offers.
        students: specs of students of the user's own that it offers.

    Raises:
        StoreError: a path is no store.
    """
    for path in stores:
        load(path).close()  # raises StoreError
    return _Pages(stores, ids, teachers, students).app()


class _Pages:
    """The handlers of the routes.

    One thread handles all lessons and stores: some simulators can draw only in the thread in which they began, and two
    requests never change a lesson at the same time. The event loop stays free for short work, and films, which may take
    minutes, are made in another process.
    """

    def __init__(
        self, stores: Sequence[Path], ids: Sequence[str], teachers: Sequence[str], students: Sequence[str]
    ) -> None:
        self.lessons, self._ids, self._films = OpenLessons(), ids, Films()
        self._teachers, self._students = teachers, students
        self._own = frozenset(path for spec in (*teachers, *students) for path in paths_in(spec))
        self._stores = [Store(path, read_only=True) for path in stores]
        self._thread = ThreadPoolExecutor(1, "lessons")
        self._pages = pages("llf_teacher.web", "templates")
        self._style = style()

    def app(self) -> ASGIApp:
        """The application."""
        seat = "/seat/{token}"
        routes = [
            Route("/", self.start),
            Route("/lessons", self.begin, methods=["POST"]),
            Route(seat, self.seat),
            Route(f"{seat}/state", self.state),
            Route(f"{seat}/move", self.move, methods=["POST"]),
            Route(f"{seat}/undo", self.undo, methods=["POST"]),
            Route(f"{seat}/frame.png", self.frame),
            Route(f"{seat}/episode", self.episode),
            Route(f"{seat}/film", self.film, methods=["POST"]),
            Route(f"{seat}/episode.gif", self.made_film),
            Route(f"{seat}/episode.{{ending}}", self.download),
            Route("/stored/{store:int}", self.listing),
            Route("/stored/{store:int}/{key}", self.replay),
            Route("/static/theme.css", self.theme),
            Mount("/static", StaticFiles(directory=_STATIC)),
        ]
        handlers: Any = {ValueError: _refused, HTTPException: _refused, StoreError: _damaged, Exception: _broken}
        return Guard(Starlette(routes=routes, exception_handlers=handlers, lifespan=self._lifespan))

    @asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        """Close the stores, and end the thread and the process of films, when the server stops."""
        with ExitStack() as held:
            for store in self._stores:
                held.callback(store.close)
            held.callback(self._thread.shutdown)
            held.callback(self._films.close)
            yield

    async def _do(self, what: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Call a function in the thread of lessons."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, lambda: what(*args, **kwargs))

    def _page(self, name: str, **values: Any) -> Response:
        text = self._pages.get_template(name).render(stores=self._stores, **values)
        return HTMLResponse(escape_control_chars(text))

    async def theme(self, request: Request) -> Response:
        """The style sheet, which reports share."""
        return Response(self._style, media_type="text/css", headers={"Cache-Control": "max-age=3600"})

    # Lessons.

    async def start(self, request: Request) -> Response:
        """The page with the form for a lesson."""
        families: dict[str, list[str]] = {}
        for id, each in entries().items():
            if not each.family.missing():
                families.setdefault(each.family.name, []).append(id)
        if self._ids:
            families["Gymnasium"] = list(self._ids)
        return self._page(
            "start.html.j2",
            families=families,
            personalities=[*self._teachers, *PERSONALITIES.names],
            students=[*self._students, *students()],
            speeches=list(SPEECHES),
            most_turns=MOST_TURNS,
        )

    async def begin(self, request: Request) -> Response:
        """Begin a lesson; returns the address of its maker's seat."""
        given = await _body(request)
        opened = await self._do(lambda: self.lessons.begin(read_plan(given, self._ids, self._own)))
        return JSONResponse({"page": f"/seat/{opened.tokens[opened.lesson.plan.seat]}"}, 201)

    async def seat(self, request: Request) -> Response:
        """The page of a seat."""
        opened, seat = await self._found(request)
        plan = opened.lesson.plan
        return self._page(
            "seat.html.j2",
            plan=plan,
            seat=seat,
            teaches=seat == TEACHER,
            learns=seat == STUDENT,
            links=links(opened, seat),
        )

    async def state(self, request: Request) -> Response:
        """The state of the lesson; 204 if the page has this `version`."""
        opened, seat = await self._found(request)
        if request.query_params.get("version") == f"{opened.version}":
            return Response(status_code=204)
        return await self._state(opened, seat, request.query_params.get("since", ""))

    async def move(self, request: Request) -> Response:
        """Play turn number `turn`: `act`, `claims`, `say` or `personality`; a watcher gives only the number."""
        opened, seat = await self._found(request)
        given = await _body(request)
        await self._do(self.lessons.move, opened, seat, _parse_turn(given, seat), given.get("turn"))
        return await self._state(opened, seat, _since(given))

    async def undo(self, request: Request) -> Response:
        """Take back the last turn, which has the number `turn`."""
        opened, seat = await self._found(request)
        given = await _body(request)
        await self._do(self.lessons.undo, opened, seat, given.get("turn"))
        return await self._state(opened, seat, _since(given))

    async def frame(self, request: Request) -> Response:
        """The frame as a PNG."""
        opened, seat = await self._found(request)
        theme = request.query_params.get("theme", "light")
        return Response(await self._do(picture, opened.lesson, seat, theme), media_type="image/png")

    async def episode(self, request: Request) -> Response:
        """The whole episode with the label of each claim, after its end."""
        opened, _ = await self._found(request)
        record = await self._do(opened.lesson.record)
        turns = prepare_turns(unpack_turns(pack_turns(record.turns)), record.episode.family)
        values = {**record.spec._asdict(), **record.episode._asdict()}
        asked = opened.film is not None
        return self._page("episode.html.j2", episode=values, turns=turns, downloads=DOWNLOADS, asked=asked)

    async def film(self, request: Request) -> Response:
        """Begin the film of the episode, after its end and if there is none; the answer tells whether it is made."""
        opened, _ = await self._found(request)
        opened.lesson.check_over()
        if opened.film is None:
            opened.film = self._films.begin(opened.lesson.plan, opened.lesson.inputs)
        return JSONResponse({"made": self._film(opened) is not None})

    async def made_film(self, request: Request) -> Response:
        """The film of the episode as a file, once it is made."""
        opened, _ = await self._found(request)
        film = self._film(opened)
        if film is None:
            raise HTTPException(409, "the film is not made; ask for it on the page of the whole episode")
        return _file(opened.lesson.plan.spec().key, "gif", "image/gif", film)

    @staticmethod
    def _film(opened: OpenLesson) -> bytes | None:
        """The film; None while it is not made. Raises a failure once; the next request begins anew."""
        film = opened.film
        if film is None or not film.done():
            return None
        if film.cancelled() or film.exception() is not None:
            opened.film = None
        return film.result()

    async def download(self, request: Request) -> Response:
        """The episode as a file, after its end."""
        opened, _ = await self._found(request)
        ending = request.path_params["ending"]
        if ending not in DOWNLOADS:
            raise HTTPException(
                404, f"there is no file with the ending {ending!r:.20}; allowed: {', '.join(DOWNLOADS)}, gif"
            )
        record = await self._do(opened.lesson.record)
        made = await self._do(content, ending, record)
        return _file(record.spec.key, ending, DOWNLOADS[ending].media_type, made)

    async def _found(self, request: Request) -> tuple[OpenLesson, str]:
        try:
            return await self._do(self.lessons.find, request.path_params["token"])
        except LookupError:
            raise HTTPException(
                404, "there is no such episode, or it was closed after many newer ones; begin a new one"
            ) from None

    async def _state(self, opened: OpenLesson, seat: str, since: str) -> Response:
        return JSONResponse(await self._do(state, opened, seat, self._pages, since))

    # Stored episodes.

    async def listing(self, request: Request) -> Response:
        """The episodes of a store."""
        number, store = self._store(request)
        words = request.query_params.get("q", "")[:200]
        rows, more = await self._do(search, store, words)
        return self._page("listing.html.j2", number=number, store=store, rows=rows, more=more, words=words, most=PAGE)

    async def replay(self, request: Request) -> Response:
        """A stored episode, turn by turn."""
        number, store = self._store(request)
        key = request.path_params["key"]
        if not await self._do(_has, store, key):
            raise HTTPException(404, f"{store.path.name} has no episode {key!r:.40}; begin at /stored/{number}")
        row = dict(await self._do(store.episode, key))
        turns = prepare_turns(await self._do(store.turns, key), row["family"])
        return self._page("episode.html.j2", episode=row, turns=turns, downloads={}, asked=False)

    def _store(self, request: Request) -> tuple[int, Store]:
        number = request.path_params["store"]
        if number >= len(self._stores):
            raise HTTPException(404, "there is no such store; give stores to `llf serve` by --replay")
        return number, self._stores[number]


def _file(key: str, ending: str, media_type: str, made: bytes) -> Response:
    """A file of an episode, to be saved."""
    headers = {"Content-Disposition": f'attachment; filename="llf-{key[:8]}.{ending}"'}
    return Response(made, media_type=media_type, headers=headers)


def _has(store: Store, key: str) -> bool:
    try:
        return store.has(key)
    except ValueError:  # not a hexadecimal number
        return False


async def _body(request: Request) -> dict[str, Any]:
    """The request body as a JSON object.

    Raises:
        ValueError: it is something else.
        HTTPException: it is too long, incomplete, or has another content type.
    """
    if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
        raise HTTPException(415, "the content type must be application/json; send JSON")
    body = b""
    try:
        async for part in request.stream():
            body += part
            if len(body) > LARGEST:
                raise HTTPException(413, f"the request body is too long; allowed: at most {LARGEST} bytes")
    except ClientDisconnect:  # the answer does not reach the client
        raise HTTPException(400, "the request body is incomplete; send it again") from None
    try:
        given = json.loads(body or b"{}")
    except (ValueError, RecursionError):
        raise ValueError("the request body is not valid JSON; send an object") from None
    if not isinstance(given, dict):
        raise ValueError("the request body is JSON, but not an object; send an object")
    return given


def _since(given: Mapping[str, Any]) -> str:
    return f"{given.get('since', '')}"


def _parse_turn(given: Mapping[str, Any], seat: str) -> Any:
    """The move in a request body, for `LiveLesson.move`.

    Raises:
        ValueError: the body has no move.
    """
    if seat == STUDENT:
        return _text(given, "act")
    if seat != TEACHER:
        return None
    if "claims" in given:
        numbers = given["claims"]
        if not isinstance(numbers, list) or not all(type(number) is int for number in numbers):
            raise ValueError(f"claims must be a list of numbers, got {numbers!r:.60}")
        return tuple(numbers)
    return None if given.get("personality") is True else _text(given, "say")


def _text(given: Mapping[str, Any], name: str) -> str:
    text = given.get(name)
    if not isinstance(text, str) or len(text) > LONGEST:
        raise ValueError(f"{name} must be a text of at most {LONGEST} characters, got {text!r:.60}")
    return storable(text)


async def _refused(request: Request, error: Exception) -> Response:
    """An error of the request, as a sentence."""
    status, why = 400, f"{error}"
    if isinstance(error, HTTPException):
        status, why = error.status_code, _PHRASES.get(error.detail, error.detail)
    elif isinstance(error, OutOfTurnError):
        status = 409
    return _sentence(request, escape_control_chars(why), status)


async def _damaged(request: Request, error: Exception) -> Response:
    """An error of a store, whose message names a file of the server."""
    _LOG.error("%s", error)
    return _sentence(request, "a store of this server cannot be used; its terminal shows why", 500)


async def _broken(request: Request, error: Exception) -> Response:
    """An error of the server, as a sentence."""
    why = "the server has an internal error, which its terminal shows; try again, or begin a new episode"
    return _sentence(request, why, 500)


def _sentence(request: Request, why: str, status: int) -> Response:
    if "text/html" in request.headers.get("accept", ""):
        text = pages("llf_teacher.web", "templates").get_template("refused.html.j2").render(why=why)
        return HTMLResponse(text, status)
    return JSONResponse({"error": why}, status)
