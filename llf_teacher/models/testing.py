"""A scripted OpenAI-compatible endpoint on this computer, for tests without a model and without costs."""

import itertools
import json
import threading
import time
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, NamedTuple


class Reply(NamedTuple):
    """A reply that is not a normal answer."""

    status: int = 200
    body: str | bytes = ""
    """Text is sent in UTF-8."""
    headers: tuple[tuple[str, str], ...] = ()
    cut: bool = False
    """Break the connection after half of the body."""
    repeat: int = 1
    """How often the body is sent."""
    pause: float = 0.0
    """Seconds between two bytes of the body; 0: all at once."""


class ScriptedEndpoint:
    """Serves `POST /v1/chat/completions` and `GET /v1/models` while its `with` block runs, at `url`.

    The answer to a request with `stream` comes word by word.

    Args:
        answer: returns the answer to a request, given its decoded body: a text, or a `Reply`.
        models: entries of `GET /v1/models`.
    """

    def __init__(
        self, answer: Callable[[dict[str, Any]], str | Reply], models: tuple[dict[str, Any], ...] = ()
    ) -> None:
        self.requests: list[dict[str, Any]] = []
        """Every request, in the order of arrival."""
        self.keys: list[str | None] = []
        """The `Authorization` header of each."""
        self._answer, self._models = answer, models
        endpoint = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                endpoint._send(self, Reply(body=json.dumps({"object": "list", "data": endpoint._models})))

            def do_POST(self) -> None:
                endpoint._serve(self)

            def log_message(self, format: str, *arguments: Any) -> None:
                """Say nothing."""

        self._server = _Server(("127.0.0.1", 0), Handler)
        self._lock = threading.Lock()
        # Its own path: a port comes again, and answers may be kept by address.
        self.url = f"http://127.0.0.1:{self._server.server_port}/{next(_NUMBERS)}/v1"

    def _serve(self, handler: BaseHTTPRequestHandler) -> None:
        request = json.loads(handler.rfile.read(int(handler.headers["Content-Length"])))
        with self._lock:
            self.requests.append(request)
            self.keys.append(handler.headers["Authorization"])
        reply = self._answer(request)
        if isinstance(reply, str):
            body = "".join(_events(reply, request)) if request.get("stream") else completion(reply, request)
            reply = Reply(body=body, headers=_STREAM if request.get("stream") else ())
        self._send(handler, reply)

    def _send(self, handler: BaseHTTPRequestHandler, reply: Reply) -> None:
        body = reply.body if isinstance(reply.body, bytes) else reply.body.encode("utf-8", "surrogatepass")
        try:
            handler.send_response(reply.status)
            for name, value in dict([("Content-Type", "application/json"), *reply.headers]).items():
                handler.send_header(name, value)
            handler.send_header("Content-Length", f"{len(body) * reply.repeat}")
            handler.end_headers()
            for part in _parts(body[: len(body) // 2] if reply.cut else body, reply):
                handler.wfile.write(part)
                time.sleep(reply.pause)
        except ConnectionError:  # the client has closed the connection
            pass

    def __enter__(self) -> "ScriptedEndpoint":
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 1024  # connections that may wait at once


_NUMBERS = itertools.count(1)
_STREAM = (("Content-Type", "text/event-stream"),)


def _parts(body: bytes, reply: Reply) -> Iterator[bytes]:
    for _ in range(reply.repeat):
        if reply.pause:
            yield from (bytes([byte]) for byte in body)
        else:
            yield body


def _events(text: str, request: dict[str, Any]) -> Iterator[str]:
    """A streamed completion, a word at a time, with its usage at the end if requested."""
    begun = _begun("chat.completion.chunk", request)
    for word in text.split(" "):
        yield _event(begun, {"role": "assistant", "content": f"{word} "}, None)
    yield _event(begun, {}, "stop")
    if (request.get("stream_options") or {}).get("include_usage"):
        yield f"data: {json.dumps({**begun, 'choices': [], 'usage': _usage(request, text)})}\n\n"
    yield "data: [DONE]\n\n"


def _event(begun: dict[str, Any], delta: dict[str, str], finish: str | None) -> str:
    choice = {"index": 0, "delta": delta, "finish_reason": finish}
    return f"data: {json.dumps({**begun, 'choices': [choice]})}\n\n"


def completion(text: str | None, request: dict[str, Any] | None = None, *, finish: str = "stop", **message: Any) -> str:
    """The body of a chat completion; a token is a word.

    Args:
        text: the content.
        request: the request that it answers.
        finish: why the answer ended.
        message: further fields of the message, such as `reasoning_content` or `tool_calls`.
    """
    said = {"role": "assistant", "content": text, **message}
    return json.dumps(
        {
            **_begun("chat.completion", request),
            "choices": [{"index": 0, "finish_reason": finish, "message": said}],
            "usage": _usage(request, text),
        }
    )


def _begun(kind: str, request: dict[str, Any] | None) -> dict[str, Any]:
    return {"id": "scripted", "object": kind, "created": 0, "model": (request or {}).get("model", "")}


def _usage(request: dict[str, Any] | None, text: str | None) -> dict[str, int]:
    asked = sum(_words(message["content"]) for message in (request or {"messages": []})["messages"])
    said = _words(text)
    return {"prompt_tokens": asked, "completion_tokens": said, "total_tokens": asked + said}


def refusal(parameter: str, status: int = 400) -> Reply:
    """The reply of an endpoint that does not accept a parameter."""
    instead = " Use 'max_completion_tokens' instead." if parameter == "max_tokens" else ""
    message = f"Unsupported parameter: '{parameter}' is not supported with this model.{instead}"
    error = {"message": message, "type": "invalid_request_error", "param": parameter, "code": "unsupported_parameter"}
    return Reply(status, json.dumps({"error": error}))


def too_long(request: dict[str, Any], words: int) -> Reply | None:
    """The reply to a prompt of more words than the context has; None if the prompt fits."""
    asked = sum(_words(message["content"]) for message in request["messages"])
    if asked <= words:
        return None
    error = {
        "message": f"This model's maximum context length is {words} tokens. However, your messages resulted in {asked} "
        "tokens.",
        "param": "messages",
        "code": "context_length_exceeded",
    }
    return Reply(400, json.dumps({"error": error}))


def _words(content: Any) -> int:
    """The number of words in a message's content, a text or parts."""
    if isinstance(content, list):
        return sum(_words(part.get("text")) for part in content)
    return len((content or "").split())
