"""The client's HTTP transport, with limits on the time of a request and the length of a reply."""

import asyncio
from typing import Any

import openai

from llf_teacher.models import LLMError

MOST_BYTES = 16_000_000
"""Maximum length of a reply's body, in bytes."""
_OF_THE_WIRE = (b"content-encoding", b"content-length", b"transfer-encoding")


class BoundedClient(openai.DefaultAsyncHttpxClient):
    """An HTTP client that reads each reply completely before it returns it.

    Args:
        seconds: time limit of a request, from connecting to the last byte.
        options: options of `httpx.AsyncClient`.
    """

    def __init__(self, seconds: float, **options: Any) -> None:
        super().__init__(**options)
        self._seconds = seconds

    async def send(self, request: Any, **options: Any) -> Any:
        """The reply, decoded.

        Raises:
            TimeoutError: the request took too long.
            LLMError: the reply is too long.
        """
        async with asyncio.timeout(self._seconds):
            reply = await super().send(request, **options | {"stream": True})
            try:
                body = bytearray()
                async for part in reply.aiter_bytes(65_536):
                    body += part
                    if len(body) > MOST_BYTES:
                        error = LLMError(f"the reply is longer than the allowed {MOST_BYTES} bytes")
                        error.lost = reply.is_success
                        raise error
            finally:
                await reply.aclose()
        # As bytes: a header need not be ASCII, and must not cost a paid answer.
        headers = [(name, value) for name, value in reply.headers.raw if name.lower() not in _OF_THE_WIRE]
        return type(reply)(reply.status_code, headers=headers, content=bytes(body), request=request)


def text_of(reply: Any) -> str:
    """The body of a reply: in UTF-8, as JSON is, or in the encoding that its header names where it is not UTF-8."""
    body: bytes = reply.content
    try:
        return body.decode("utf-8-sig")
    except UnicodeDecodeError:
        named = reply.charset_encoding or "utf-8"
    try:
        return body.decode(named, "replace").removeprefix("\ufeff")
    except (LookupError, UnicodeError):  # no such encoding, or none of text
        return body.decode("utf-8-sig", "replace")
