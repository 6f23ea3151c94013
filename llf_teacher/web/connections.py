"""Limits of connections: how many there are, and how long they take for a request.

uvicorn ends a connection that is idle between two requests. It has no limit for half a request, and its
`limit_concurrency` answers whole requests only.
"""

import asyncio
import ipaddress
import itertools
import json
import socket
from collections import Counter
from functools import partial
from http import HTTPStatus
from typing import Any, NamedTuple

import h11
import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from llf_teacher.web.seldom import LOGGING

__all__ = ["ConnectionLimits", "Connections", "LimitedServer", "default_connections", "network_of"]

_MOST = 512
_ACCEPTED_AT_ONCE = 20  # before they are counted: that many descriptors must be free beside the limit
_QUEUE = 4096  # connections that the system keeps until they are accepted
_HALF, _NEW, _IDLE = range(3)  # what waits for its client: half a request, no request yet, none since the last answer


def default_connections() -> int:
    """Half of the files that this process may open, at most 512."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return _MOST
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return _MOST if most == resource.RLIM_INFINITY else min(_MOST, most // 2)


class ConnectionLimits(NamedTuple):
    """Limits of connections."""

    connections: int = _MOST
    """Greatest number of connections; one address has at most half of them."""
    headers: float = 10.0
    """Seconds in which the headers of a request must arrive."""
    body: float = 10.0
    """Seconds in which the rest of it must arrive."""
    answer: float = 60.0
    """Seconds in which the client must have taken the answer."""


class Connections:
    """The open connections of a server.

    Where there is no room for a new one, one that waits for its client is closed: if possible one with half a request,
    else one without any request yet, else one that is idle since its last answer; of these the one that has waited
    longest. Browsers connect again by themselves.

    Args:
        limits: the limits.
    """

    def __init__(self, limits: ConnectionLimits) -> None:
        self.limits = limits
        self._most_of_address = max(1, limits.connections // 2)
        self._open: dict[LimitedProtocol, str] = {}  # with their addresses
        self._of_address: Counter[str] = Counter()
        self._waiting: list[dict[LimitedProtocol, None]] = [{}, {}, {}]  # by what they wait for, the longest first

    def __len__(self) -> int:
        return len(self._open)

    def admit(self, new: "LimitedProtocol") -> bool:
        """Count a new connection, if there is room or an old one can go."""
        address = network_of(new.client[0]) if new.client else ""
        alone = self._of_address[address] >= self._most_of_address
        if alone or len(self._open) >= self.limits.connections:
            waiting = itertools.chain.from_iterable(self._waiting)
            old = next((each for each in waiting if not alone or self._open[each] == address), None)
            if old is None:
                return False
            self.leave(old)
            old.transport.abort()
        self._open[new] = address
        self._of_address[address] += 1
        return True

    def wait(self, connection: "LimitedProtocol", what: int | None) -> None:
        """Note what a connection waits for; None: it does not wait for its client."""
        for each in self._waiting:
            each.pop(connection, None)
        if what is not None and connection in self._open:
            self._waiting[what][connection] = None

    def leave(self, connection: "LimitedProtocol") -> None:
        """Forget a connection."""
        self.wait(connection, None)
        address = self._open.pop(connection, None)
        if address is not None:
            self._of_address[address] -= 1
            if not self._of_address[address]:
                del self._of_address[address]


def network_of(address: str) -> str:
    """What counts as one address: of IPv6 the first 64 bits, since a machine may have all others."""
    ip = ipaddress.ip_address(address)
    return f"{ip}" if ip.version == 4 else f"{int(ip) >> 64:x}"


class LimitedProtocol(H11Protocol):
    """A connection that keeps the limits.

    Args:
        connections: all connections of the server.
        *args, **kwargs: uvicorn's.
    """

    def __init__(self, *args: Any, connections: Connections, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._all = connections
        self._awaited: tuple[Any, int | None] = (
            None,
            None,
        )  # h11's state of the client, and what the connection waits for
        self._deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Take the connection, or say that there are too many."""
        super().connection_made(transport)
        if self._all.admit(self):
            self._watch(_NEW)
        else:
            self._refuse(503, "the server has too many connections; try again later")

    def data_received(self, data: bytes) -> None:
        """Read a part of a request."""
        super().data_received(data)
        self._watch(_HALF)

    def on_response_complete(self) -> None:
        """Go on after an answer."""
        super().on_response_complete()
        self._watch(_IDLE)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        super().connection_lost(exc)
        self._all.leave(self)
        self._set_deadline(None)

    def _watch(self, what: int) -> None:
        """Set the deadline of what the client has to do next; more of the same half does not set it anew."""
        state, limits = self.conn.their_state, self._all.limits
        seconds = {h11.IDLE: limits.headers, h11.SEND_BODY: limits.body}.get(state)
        awaited = state, None if seconds is None else what
        if awaited == self._awaited and what is not _IDLE:
            return
        self._awaited = awaited
        self._all.wait(self, awaited[1])
        self._set_deadline(limits.answer if self.transport.get_write_buffer_size() else seconds)

    def _set_deadline(self, seconds: float | None) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        self._deadline = None if seconds is None else self.loop.call_later(seconds, self._expire)

    def _expire(self) -> None:
        answered = self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE)
        if answered or self.transport.is_closing() or self.transport.get_write_buffer_size():
            self.transport.abort()
        else:
            self._refuse(408, "the request did not arrive in time; send it again")

    def _refuse(self, status: int, why: str) -> None:
        """Answer with an error, in the form of the others, and close."""
        body = json.dumps({"error": why}).encode()
        head = f"HTTP/1.1 {status} {HTTPStatus(status).phrase}\r\nContent-Type: application/json\r\n"
        self.transport.write(f"{head}Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode() + body)
        self.transport.close()


class LimitedServer(uvicorn.Server):
    """A server that keeps the limits, has no log of visits, for privacy, and repeats no line of its log in a minute.

    Args:
        app: the application.
        limits: the limits.
    """

    def __init__(self, app: ASGIApp, limits: ConnectionLimits) -> None:
        protocol: Any = partial(LimitedProtocol, connections=Connections(limits))
        super().__init__(
            uvicorn.Config(
                app,
                http=protocol,
                ws="none",  # its protocol would take connections over
                log_config=LOGGING,
                log_level="warning",
                access_log=False,
                server_header=False,
                proxy_headers=False,
                backlog=_ACCEPTED_AT_ONCE,
            )
        )

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen, with a longer queue than `backlog`, which is also how many connections asyncio accepts in a row."""
        await super().startup(sockets)
        for each in sockets or ():
            each.listen(_QUEUE)
