"""The client's way to the network: no request takes longer, and no reply is longer, than it may."""

import asyncio
from typing import Any

import openai

from llf_teacher.models import LLMError

MOST_BYTES = 16_000_000
"""Greatest length of a reply's body."""
_OF_THE_WIRE = ("content-encoding", "content-length", "transfer-encoding")


class BoundedClient(openai.DefaultAsyncHttpxClient):
    """An HTTP client that reads each reply whole before it gives it.

    Args:
        seconds: for a request as a whole, from connecting to the last byte.
        options: those of `httpx.AsyncClient`.
    """

    def __init__(self, seconds: float, **options: Any) -> None:
        super().__init__(**options)
        self._seconds = seconds

    async def send(self, request: Any, **options: Any) -> Any:
        """The reply, decoded.

        Raises:
            TimeoutError: it took too long.
            LLMError: it was too long.
        """
        async with asyncio.timeout(self._seconds):
            reply = await super().send(request, **options | {"stream": True})
            try:
                body = bytearray()
                async for part in reply.aiter_bytes(65_536):
                    body += part
                    if len(body) > MOST_BYTES:
                        raise LLMError(f"the reply has more than {MOST_BYTES} bytes, which is no answer of a model")
            finally:
                await reply.aclose()
        headers = [(name, value) for name, value in reply.headers.multi_items() if name not in _OF_THE_WIRE]
        return type(reply)(reply.status_code, headers=headers, content=bytes(body), request=request)
