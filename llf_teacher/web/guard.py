"""Checks of every request, and security headers of every response."""

import ipaddress
import secrets
from collections.abc import Collection
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

KEY, COOKIE = "key", "llf_key"
"""The names of the server's key: a query parameter in the first address, then a cookie."""
OPEN = ("/static/", "/seat/")
"""Paths without a key: static files, and seats, whose addresses are secrets themselves."""
LOCAL = frozenset({"127.0.0.1", "localhost", "::1"})
"""The names of a server that is reached only from its own machine."""
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
    """Refuses requests with a foreign `Host`, from a foreign page, or without the key.

    The check of `Host` stops DNS rebinding, where the name of a foreign page leads to this server.

    Args:
        app: handles the other requests.
        names: the names of this server.
        key: that visitors need; empty: none.
    """

    def __init__(self, app: ASGIApp, names: Collection[str] = LOCAL, key: str = "") -> None:
        self._app, self._names, self._key = app, {name.lower() for name in names}, key

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(_HEADERS)
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        await (self._refusal(scope) or self._app)(scope, receive, send_with_headers)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._is_ours(host):
            return _no(f"{host[:100]!r} is not a name of this server; start it with `llf serve --name`", 421)
        origin = headers.get("origin")
        if scope["method"] not in ("GET", "HEAD") and origin is not None and urlsplit(origin).netloc != host:
            return _no("the request comes from a foreign page; open this server's own page", 403)
        path: str = scope["path"]
        if not self._key or path.startswith(OPEN):
            return None
        given = parse_qs(scope["query_string"].decode("latin-1")).get(KEY, [""])[0]
        if self._fits(given):
            answer = RedirectResponse(path if not path.startswith("//") else "/", 303)
            answer.set_cookie(COOKIE, given, httponly=True, samesite="strict")
            return answer
        if self._fits(_cookie(headers)):
            return None
        return _no("this server needs a key; open the address that `llf serve` shows, which has it", 401)

    def _fits(self, key: str) -> bool:
        return secrets.compare_digest(key.encode(), self._key.encode())

    def _is_ours(self, host: str) -> bool:
        """Whether a `Host` header names this server; with a key any IP address does: only names can be rebound."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._names:
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return bool(self._key)


def _cookie(headers: Headers) -> str:
    jar: SimpleCookie = SimpleCookie()
    try:
        jar.load(headers.get("cookie", ""))
    except CookieError:
        return ""
    return jar[COOKIE].value if COOKIE in jar else ""


def _no(why: str, status: int) -> Response:
    return PlainTextResponse(f"{why}\n", status)
