"""Checks of every request, and security headers of every response."""

import asyncio
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

NAMES = frozenset({"127.0.0.1", "localhost"})
"""The names of the server, which only its own machine reaches."""
_POLICY = "; ".join(
    (
        "default-src 'none'",
        *(f"{what}-src 'self'" for what in ("script", "style", "img", "connect")),
        "form-action 'self'",
        *(f"{what} 'none'" for what in ("base-uri", "frame-ancestors")),
    )
)
_HEADERS = {
    "Content-Security-Policy": _POLICY,
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


class Guard:
    """Refuses requests with a foreign `Host`, or from a foreign page, and ends those that are open when it stops.

    The check of `Host` stops DNS rebinding, in which a foreign page's name leads to this server.

    Args:
        app: handles the other requests.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        begun = False

        async def send_with_headers(message: Message) -> None:
            nonlocal begun
            begun = True
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(_HEADERS)
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        try:
            await (_refusal(scope) or self._app)(scope, receive, send_with_headers)
        except asyncio.CancelledError:  # the server stops, and waits no longer for this request
            if not begun:
                await _no("the server stops; begin it again with `llf serve`", 503)(scope, receive, send_with_headers)


def _refusal(scope: Scope) -> Response | None:
    """The answer to a refused request."""
    headers = Headers(scope=scope)
    host = headers.get("host", "")
    if _name(host) not in NAMES:
        return _no(f"{host[:100]!r} is not a name of this server; allowed: {', '.join(sorted(NAMES))}", 421)
    origin = headers.get("origin")
    if scope["method"] not in ("GET", "HEAD") and origin is not None and urlsplit(origin).netloc != host:
        return _no("the request comes from a foreign page; open this server's own page", 403)
    return None


def _name(host: str) -> str:
    """The name in a `Host` header; empty if there is none."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _no(why: str, status: int) -> Response:
    return PlainTextResponse(f"{why}\n", status)
