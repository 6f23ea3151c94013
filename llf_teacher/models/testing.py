"""A scripted OpenAI-compatible endpoint on this computer, to try students without a model and without costs."""

import json
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, NamedTuple


class Reply(NamedTuple):
    """A reply other than an answer."""

    status: int = 200
    body: str = ""
    headers: tuple[tuple[str, str], ...] = ()
    cut: bool = False
    """Break the connection after half of the body."""


class ScriptedEndpoint:
    """Serves `POST /v1/chat/completions` while its `with` block runs, at `url`.

    Args:
        answer: what to say to a request, the decoded body: a text, or a `Reply`.
    """

    def __init__(self, answer: Callable[[dict[str, Any]], str | Reply]) -> None:
        self.requests: list[dict[str, Any]] = []
        """Every request, in the order of arrival."""
        self.keys: list[str | None] = []
        """The `Authorization` header of each."""
        self._answer = answer
        endpoint = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                endpoint._serve(self)

            def log_message(self, format: str, *arguments: Any) -> None:
                """Say nothing."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._lock = threading.Lock()
        self.url = f"http://127.0.0.1:{self._server.server_port}/v1"

    def _serve(self, handler: BaseHTTPRequestHandler) -> None:
        request = json.loads(handler.rfile.read(int(handler.headers["Content-Length"])))
        with self._lock:
            self.requests.append(request)
            self.keys.append(handler.headers["Authorization"])
        reply = self._answer(request)
        if isinstance(reply, str):
            reply = Reply(body=completion(reply, request))
        body = reply.body.encode("utf-8", "surrogatepass")
        try:
            handler.send_response(reply.status)
            for name, value in (*reply.headers, ("Content-Type", "application/json")):
                handler.send_header(name, value)
            handler.send_header("Content-Length", f"{len(body)}")
            handler.end_headers()
            handler.wfile.write(body[: len(body) // 2] if reply.cut else body)
        except ConnectionError:  # who asked is gone
            pass

    def __enter__(self) -> "ScriptedEndpoint":
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


def completion(text: str | None, request: dict[str, Any] | None = None) -> str:
    """The body of a chat completion; its tokens are words."""
    asked = sum(len(message["content"].split()) for message in (request or {"messages": []})["messages"])
    return json.dumps(
        {
            "object": "chat.completion",
            "choices": [{"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": text}}],
            "usage": {"prompt_tokens": asked, "completion_tokens": len((text or "").split())},
        }
    )
