"""The client: ask a model, through the cache and within the spending limit."""

import importlib.util
import ipaddress
import json
import math
import time
import warnings
from functools import cache
from typing import Any
from urllib.parse import urlsplit

from llf_teacher.models import LLMError, SpendingLimitError
from llf_teacher.models.cache import Cache, Usage
from llf_teacher.models.settings import Settings

_TOKENS = 1e6  # prices are per million
_EXCERPT = 300
_SECRET = 8  # a shorter key is no secret, and may stand in a text by chance


class Endpoint:
    """An OpenAI-compatible endpoint.

    Args:
        base_url: as in `https://api.openai.com/v1`.
        settings: how to ask.

    Raises:
        ModuleNotFoundError: the extra is not installed.
        ValueError: the cache cannot be used.
    """

    def __init__(self, base_url: str, settings: Settings) -> None:
        check_extra()
        import openai

        self.base_url, self._settings = base_url, settings
        if settings.key and _is_open(base_url):
            warnings.warn(f"the API key goes to {base_url} for everyone to read; use https", UserWarning, stacklevel=2)
        self._cache = Cache(settings.cache)
        # It retries connection errors, timeouts, 408, 409, 429 and 5xx, with backoff and jitter or as Retry-After says.
        self._client = openai.OpenAI(
            base_url=base_url, api_key=settings.key or "none", timeout=settings.timeout, max_retries=settings.retries
        )

    def ask(self, request: dict[str, Any], prices: tuple[float, float] | None = None) -> str:
        """The model's answer, from the cache if it has been given before.

        Args:
            request: the body of a chat completion: `model`, `messages` and the rest.
            prices: USD per million tokens of input and of output; None: unknown.

        Raises:
            LLMError: there is none, and trying again has not helped.
            SpendingLimitError: there is no money left for asking.
        """
        whole = {"base_url": self.base_url, **request}
        key = Cache.key(whole)
        answer = self._cache.get(key)
        if answer is None:
            with self._cache.alone(key):
                answer = self._cache.get(key)
                if answer is None:
                    answer = self._pay(key, whole, request, prices)
        return answer

    def _pay(self, key: str, whole: dict[str, Any], request: dict[str, Any], prices: tuple[float, float] | None) -> str:
        problem = ""
        for attempt in range(self._settings.retries + 1):
            if attempt:  # an answer came, but a broken one: the client takes no notice of these
                time.sleep(min(2.0 ** (attempt - 2), 8.0))
            self._check_budget(prices)
            reply = self._post(request)
            text, usage = _read(reply, prices)
            if text is not None or usage.input_tokens is not None:
                text = None if text is None else self._clean(text)
                self._cache.add(key, whole, text, usage)
            if self._settings.budget is not None and usage.usd is None and text is not None:
                raise LLMError(
                    f"{self.base_url} does not tell the tokens it used, so that no spending limit can be kept"
                )
            if text is not None:
                return text
            problem = self._clean(reply)[:_EXCERPT]
        raise LLMError(f"{self.base_url} sent no answer in {self._settings.retries + 1} attempts, at last: {problem!r}")

    def _post(self, request: dict[str, Any]) -> str:
        """The body of the endpoint's reply."""
        completions = self._client.chat.completions.with_raw_response
        body = dict(request)
        try:
            # All but these two goes as it is, so that an endpoint may take what the client does not know.
            reply = completions.create(model=body.pop("model"), messages=body.pop("messages"), extra_body=body)
            return reply.content.decode("utf-8", "replace")
        except Exception as error:  # not only its own errors: any may quote the key
            problem = self._describe(error)
        # Raised outside of `except`: the client's own exception holds the request, and with it the key.
        raise LLMError(problem)

    def _describe(self, error: Exception) -> str:
        status = getattr(error, "status_code", None)
        wait = error.response.headers.get("retry-after") if status else None  # type: ignore[attr-defined]
        hint = "; set LLF_LLM_API_KEY" if status == 401 else f"; it asks to wait {wait} seconds" if wait else ""
        text = " ".join(f"{each}" for each in (error, error.__cause__) if each)
        return f"{self.base_url} gave no answer: {type(error).__name__}: {self._clean(text)[:_EXCERPT]}{hint}"

    def _check_budget(self, prices: tuple[float, float] | None) -> None:
        budget = self._settings.budget
        if budget is not None and prices is None:
            raise LLMError(f"a spending limit needs prices for {self.base_url}: input_price and output_price")
        if budget is not None and (spent := self._cache.spent()) >= budget:
            raise SpendingLimitError(
                f"the spending limit of {budget:g} USD is reached: {self._settings.cache} has {spent:.6g} USD on its "
                "ledger; raise --llm-budget to go on"
            )

    def _clean(self, text: str) -> str:
        """The text without the key, should an endpoint repeat it, and without half characters."""
        key = self._settings.key
        if len(key) >= _SECRET:
            text = text.replace(key, "***")
        return text.encode("utf-8", "replace").decode()


def _is_open(base_url: str) -> bool:
    """Whether what is sent goes unencrypted to another machine."""
    address = urlsplit(base_url)
    host = address.hostname or ""
    try:
        own = ipaddress.ip_address(host).is_loopback
    except ValueError:
        own = host == "localhost" or host.endswith(".localhost")
    return address.scheme == "http" and not own


@cache
def connect(base_url: str, settings: Settings) -> Endpoint:
    """An endpoint, the same for the same settings."""
    return Endpoint(base_url, settings)


def check_extra() -> None:
    """Make sure that the client is installed.

    Raises:
        ModuleNotFoundError: it is not; the message has the pip line.
    """
    if importlib.util.find_spec("openai") is None:
        raise ModuleNotFoundError(
            "students that ask a language model need 'openai', which is not installed; "
            "run: pip install 'llf-teacher[llm]'",
            name="openai",
        )


def _read(reply: str, prices: tuple[float, float] | None) -> tuple[str | None, Usage]:
    """The answer in a reply and what it cost; None if there is no answer in it."""
    try:
        data = json.loads(reply)
    except (ValueError, RecursionError):
        return None, Usage(None, None, None)
    text: str | None = None
    try:
        content = data["choices"][0]["message"]["content"]
        if content is None or isinstance(content, str):  # none: all tokens went into thoughts
            text = content or ""
    except (LookupError, TypeError):
        pass
    try:
        tokens = int(data["usage"]["prompt_tokens"]), int(data["usage"]["completion_tokens"])
    except (LookupError, TypeError, ValueError):
        return text, Usage(None, None, None)
    usd = None if prices is None else math.fsum(n * price for n, price in zip(tokens, prices, strict=True)) / _TOKENS
    return text, Usage(*tokens, usd)
