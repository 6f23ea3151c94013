"""The client's HTTP transport, with limits on the time of a request and the length of a reply."""

import asyncio
from typing import Any

import openai

from llf_teacher.models import LLMError

MOST_BYTES = 16_000_000
"""Maximum length of a reply's body, in bytes."""
_OF_THE_WIRE = ("content-encoding", "content-length", "transfer-encoding")


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
        headers = [(name, value) for name, value in reply.headers.multi_items() if name not in _OF_THE_WIRE]
        return type(reply)(reply.status_code, headers=headers, content=bytes(body), request=request)
