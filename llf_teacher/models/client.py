"""The client: ask a model, through the cache and within the spending limit."""

import asyncio
import base64
import importlib.util
import json
import math
import os
import re
import threading
import time
import warnings
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from llf_teacher.models import LLMError, NoAnswerError, SpendingLimitError
from llf_teacher.models.cache import Cache, Sent
from llf_teacher.models.forms import FORMS, AnswerForm, broken, trial
from llf_teacher.models.hints import UNREACHED, hint, is_about_form, is_page
from llf_teacher.models.images import images_of
from llf_teacher.models.proxies import check_proxies, is_here, passes_proxies
from llf_teacher.models.refusals import adapted, refused
from llf_teacher.models.replies import FILTERED, Answer, Prices, Usage, read, served
from llf_teacher.models.retries import PassingError, asked_for, may_pass, pause
from llf_teacher.models.settings import BUDGET, RETRIES, TIMEOUT, ClientSettings
from llf_teacher.models.waiting import loop, wait_for
from teachers.schema import storable
from worlds.extras import pip_install

_TOKENS = 1e6  # prices are per million
_EXCERPT = 300
_TEXTS = ("raw", "reasoning", "finish", "model", "call")  # tokens of an answer
_IMAGE = 10_000  # greatest number of tokens of an image of 512 pixels, beside its bytes
_UNSENT = ("ConnectError", "ConnectTimeout")  # errors before a request is sent, in all releases of `httpx`
_SECRET = 8  # minimum length of a key to mask; a shorter one may be in a text by chance
_NAMED = {"&": ("amp",), "<": ("lt",), ">": ("gt",), '"': ("quot",), "'": ("apos",)}  # characters with names in HTML
_SAFE = str.maketrans("+/", "-_")  # the two characters that differ in Base64 for addresses
_WAITS = 300.0  # seconds, more than all pauses between attempts
_OF_ALL = (401, 402, 403, 404, 408, 409, 429)  # statuses about key, address or time, not about the request
_LOOK = 5.0  # seconds to ask an endpoint for its models
_NO_ANSWER = " gave no answer: "
_PAUSE = 0.1  # seconds between two attempts to reserve money


class Endpoint:
    """An OpenAI-compatible endpoint. Many threads may use it at once.

    Args:
        base_url: as in `https://api.openai.com/v1`.
        settings: key, cache, spending limit, time limit and retries.
        name: identifies the endpoint in the cache, with the model that it serves; empty: its address does.

    Raises:
        ModuleNotFoundError: the extra is not installed.
        ValueError: the cache or a proxy in the environment cannot be used.
    """

    def __init__(self, base_url: str, settings: ClientSettings, name: str = "") -> None:
        check_extra()
        import openai

        from llf_teacher.models.http import BoundedClient

        self.base_url, self._settings, self._name = base_url, settings, name
        self._secret = _written(settings.key) if len(settings.key) >= _SECRET else None
        self._served: dict[str, str] = {}
        if settings.key and _is_open(base_url):
            warnings.warn(f"the API key goes to {base_url} for everyone to read; use https", UserWarning, stacklevel=2)
        check_proxies(base_url)
        self._cache = Cache(settings.cache)
        self._forming = threading.Lock()
        self._unsent: dict[str, tuple[str, ...]] = {}
        self._client = openai.AsyncOpenAI(
            base_url=base_url,
            api_key=settings.key or "none",
            timeout=None,  # `BoundedClient` limits the time
            max_retries=0,  # see `retries`
            http_client=BoundedClient(settings.timeout, trust_env=not passes_proxies(base_url)),
        )
        weakref.finalize(self, _close, self._client).atexit = False

    def ask(self, request: dict[str, Any], prices: Prices | tuple[float, float] | None = None) -> str:
        """The model's answer without its thoughts; see `answer`."""
        return self.answer(request, prices).text

    def answer(self, request: dict[str, Any], prices: Prices | tuple[float, float] | None = None) -> Answer:
        """The model's answer, from the cache if the same request was answered before.

        Args:
            request: the body of a chat completion: `model`, `messages` and the rest.
            prices: in USD per million tokens, of input and of output; None: unknown.

        Raises:
            LLMError: there is no answer, also after retries.
            NoAnswerError: there is no answer to this request; others may get one.
            SpendingLimitError: the spending limit does not allow the request.
        """
        whole = {**self._identity(request["model"]), **request}
        key = Cache.key(whole)
        answer = self._cache.get(key)
        if answer is None:
            with self._cache.lock(key):
                answer = self._cache.get(key)
                if answer is None:
                    answer = self._pay(key, whole, request, None if prices is None else Prices(*prices))
        if answer.finish == FILTERED:
            raise NoAnswerError(f"the content filter of {self.base_url} withholds what {request['model']} says")
        return answer

    def form(self, request: dict[str, Any], prices: Prices | tuple[float, float] | None = None) -> AnswerForm:
        """The first form of answers that the endpoint keeps for a model; tried once, and stored in the cache.

        Args:
            request: the body without messages and form: `model`, `temperature` and the like.
            prices: as for `answer`.

        Raises:
            LLMError: there is no answer for a reason other than the form.
        """
        key = Cache.key({**self._identity(request["model"]), **request, "form": "auto"})
        with self._forming:
            found = self._cache.form(key)
            if found is None:
                found = self._first_kept(request, prices)
                self._cache.keep_form(key, request["model"], found)
                found = self._cache.form(key) or found  # another process may have been first
        return found

    def _first_kept(self, request: dict[str, Any], prices: Prices | tuple[float, float] | None) -> AnswerForm:
        reasons: list[str] = []
        for form in FORMS[:-1]:
            asked = {**request, **trial(form)}
            self._cache.keep_trial(Cache.key({**self._identity(request["model"]), **asked}))
            try:
                why = broken(form, self.answer(asked, prices))
            except LLMError as error:
                if not (isinstance(error, NoAnswerError) or is_about_form(f"{error}")):
                    raise
                why = f"was refused: {f'{error}'.partition(_NO_ANSWER)[2] or error}"
            if not why:
                return AnswerForm(form, "; ".join(reasons))
            reasons.append(f"{form} {why}")
        return AnswerForm(FORMS[-1], "; ".join(reasons))

    def _identity(self, model: str) -> dict[str, str]:
        """The endpoint's part of a key in the cache: its address, or its name and the model that it serves."""
        if not self._name:
            return {"base_url": self.base_url}
        if model not in self._served:
            self._served[model] = self._cache.served(self._name, model, wait_for(self._serves(model)))
        return {"endpoint": self._name, "served": self._served[model]}

    async def _serves(self, model: str) -> str | None:
        """The model that the endpoint serves under a name, from its list of models; None without such a list."""
        from llf_teacher.models.http import text_of

        try:
            async with asyncio.timeout(_LOOK):
                reply = await self._client.models.with_raw_response.list()
            found = served(text_of(reply.http_response), model)
            return None if found is None else self._clean(found)
        except Exception:  # an endpoint need not have a list
            return None

    def _compare(self, whole: dict[str, Any], model: str) -> None:
        """Check that an endpoint's name stands for one model.

        Raises:
            LLMError: another model answered under this name before.
        """
        if not self._name or not model:
            return
        place = f"{whole['model']} as {whole['served']}"
        known = self._cache.served(self._name, place, None)
        if known and known != model:
            raise LLMError(
                f"the endpoint {self._name!r} answers as {model!r} now, and did so as {known!r} when asked for "
                f"{whole['model']!r} before; give it another name, or use another file as LLF_LLM_CACHE"
            )
        if not known:
            self._cache.served(self._name, place, model)

    def _pay(self, key: str, whole: dict[str, Any], request: dict[str, Any], prices: Prices | None) -> Answer:
        for attempt in range(self._settings.retries + 1):
            try:
                return self._once(key, whole, request, prices)
            except PassingError as error:
                trouble = error
            if attempt < self._settings.retries:
                time.sleep(pause(attempt, trouble.seconds))
        attempts = f"{self._settings.retries + 1} attempts, at last: {trouble}"
        raise LLMError(f"{self.base_url} sent no answer in {attempts}; {RETRIES} sets how many follow the first")

    def _once(self, key: str, whole: dict[str, Any], request: dict[str, Any], prices: Prices | None) -> Answer:
        """The answer in the next reply.

        Raises:
            PassingError: there is no answer, and another attempt may succeed.
        """
        pledge = self._pledge(key, request, prices)
        answer, usage, sent, charged = None, Usage(), Sent(), False
        try:
            started = time.monotonic()
            reply, unsent = self._reply(request, sent)
            charged = not is_page(reply)
            answer, usage = read(reply, prices)
            if answer is not None:
                texts: dict[str, Any] = {name: self._clean(getattr(answer, name)) for name in _TEXTS}
                answer = replace(answer, **texts, seconds=round(time.monotonic() - started, 3), unsent=unsent)
            self._compare(whole, "" if answer is None else answer.model)
        finally:
            if charged or sent.lost:
                self._cache.add(key, whole, answer, usage, pledge, sent)
            else:
                self._cache.release(pledge, request["model"], sent)
        if answer is None:
            raise PassingError(f"{self._clean(reply)[:_EXCERPT]!r}{hint(200, reply)}")
        if self._settings.budget is not None and usage.usd is None:
            raise LLMError(
                f"{self.base_url} gives no number of tokens, so that no spending limit can be kept; ask it without "
                f"{BUDGET} and --llm-budget"
            )
        return answer

    def _reply(self, request: dict[str, Any], sent: Sent) -> tuple[str, tuple[str, ...]]:
        """The body of the endpoint's reply, and the parameters that it refused; `sent` counts the requests."""
        while True:
            unsent = self._unsent.get(request["model"], ())
            body = adapted(request, unsent)
            if self._settings.budget is not None and length_of(body) is None:
                raise LLMError(f"{self.base_url} accepts no max_tokens, so that no spending limit can be kept")
            sent.requests += 1
            try:
                reply, refusal = wait_for(self._post(body))
            except BaseException as error:  # also an interrupt cancels the request
                sent.lost += getattr(error, "lost", True)
                raise
            if not refusal:
                return reply, tuple(name for name in unsent if name in request)
            self._unsent[request["model"]] = (*unsent, refusal)  # one parameter less in each round

    async def _post(self, request: dict[str, Any]) -> tuple[str, str]:
        """The body of the endpoint's reply, or an empty body and the parameter that it refuses. Sends one request."""
        import openai

        from llf_teacher.models.http import text_of

        body = dict(request)
        try:
            # All other fields go as they are, so that an endpoint may accept fields that the client does not know.
            model, messages = body.pop("model"), body.pop("messages")
            raw = self._client.chat.completions.with_raw_response
            reply = await raw.create(model=model, messages=messages, extra_body=body)
            return text_of(reply.http_response), ""
        except LLMError:
            raise
        except Exception as error:  # any error may quote the key
            own = error if isinstance(error, TimeoutError) else error.__cause__  # older clients wrap the error
            refusal = refused(
                status := getattr(error, "status_code", None), getattr(error, "body", None) or f"{error}", body
            )
            problem = self._describe(error)
            headers = error.response.headers if isinstance(error, openai.APIStatusError) else {}
            unreached = isinstance(error, openai.APIConnectionError)
            unsent = _is_unsent(error)
        # Raised outside `except`, since the client's own exception holds the request with the key.
        if isinstance(own, TimeoutError):
            seconds = f"{self._settings.timeout:g} seconds"
            raise PassingError(f"timed out after {seconds}; {TIMEOUT} sets the limit", lost=True)
        if isinstance(own, LLMError):
            raise own
        if refusal is not None:
            return "", refusal
        if unreached or (status is not None and may_pass(status, headers)):
            raise PassingError(problem, asked_for(headers), lost=unreached and not unsent)
        kind = NoAnswerError if status in range(400, 500) and status not in _OF_ALL else LLMError
        raise kind(f"{self.base_url}{_NO_ANSWER}{problem}")

    def _describe(self, error: Exception) -> str:
        status = getattr(error, "status_code", None)
        wait = asked_for(error.response.headers) if status else None  # type: ignore[attr-defined]
        text = " ".join(dict.fromkeys(filter(None, map(str, [error] if status else _causes(error)))))
        body = getattr(error, "body", None)
        if (
            body and text == f"Error code: {status}" and not is_page(f"{body}")
        ):  # in a form that the client does not know
            text += f" - {body}"
        then = f"; it asks to wait {wait:g} seconds" if wait else UNREACHED if _is_unsent(error) else hint(status, text)
        return f"{type(error).__name__}: {self._clean(text)[:_EXCERPT]}{then}"

    def _pledge(self, key: str, request: dict[str, Any], prices: Prices | None) -> int | None:
        """Note a request, and reserve its maximum cost; wait while other requests have reserved too much."""
        budget, length, model = self._settings.budget, length_of(request), request["model"]
        longest = self._settings.timeout * (self._settings.retries + 1) + _WAITS
        if budget is None:
            return self._cache.pledge(None, None, longest, key, model)
        if prices is None:
            raise LLMError(f"a spending limit needs prices for {self.base_url}: input_price and output_price")
        if length is None:
            raise LLMError(f"a spending limit needs a maximum length for {self.base_url}: max_tokens")
        # A token has at least one byte; an image is counted by its size, not by its bytes.
        read = [request[name] for name in ("messages", "tools", "response_format") if name in request]
        asked = len(json.dumps(read, ensure_ascii=False).encode())
        asked += _IMAGE * sum(1 for _ in images_of(request))
        usd = (asked * prices.input + length * prices.output) / _TOKENS
        while True:
            try:
                pledge = self._cache.pledge(usd, budget, longest, key, model)
            except LookupError:
                break
            if pledge is not None:
                return pledge
            time.sleep(_PAUSE)
        raise SpendingLimitError(
            f"the spending limit of {budget:g} USD is reached: {self._settings.cache} has {self._cache.spent():.6g} "
            f"USD on its ledger, and the next answer may cost {usd:.6g} USD; raise it (--llm-budget) to go "
            "on"
        )

    def _clean(self, text: str) -> str:
        """The text without the key, which an endpoint may repeat, and without lone surrogates."""
        return storable(text if self._secret is None else self._secret.sub("***", text))


def _written(key: str) -> re.Pattern[str]:
    """The key as JSON (also JSON within JSON), an address or HTML escape it, in Base64, and in hexadecimal digits."""
    encoded = (*_in_base64(key.encode()), f"(?i:{key.encode().hex()})")
    return re.compile("|".join(("".join(map(_escaped, key)), *encoded)))


def _in_base64(key: bytes) -> Iterator[str]:
    """Patterns of a key in Base64, also behind other bytes, as in `Basic` of `user:key`."""
    for before in range(3):
        text = base64.b64encode(bytes(before) + key).decode()
        # The characters that other bytes cannot change: each has 6 bits.
        sure = text[math.ceil(before * 8 / 6) : (before + len(key)) * 8 // 6]
        for each in dict.fromkeys((sure, sure.translate(_SAFE))):
            # Letters and digits are not escaped, and a pattern of plain ones is quick.
            yield "".join(letter if letter.isalnum() else _escaped(letter) for letter in each)


def _escaped(letter: str) -> str:
    """A pattern of a character of ASCII, escaped or not."""
    return rf"\\{{0,8}}(?:{'|'.join(_forms(letter))})"  # bounded, so that the time is linear


def _forms(letter: str) -> tuple[str, ...]:
    """Patterns of a character of ASCII, as it is and escaped."""
    code = f"{ord(letter):02x}"
    return (
        re.escape(letter),
        rf"(?<=\\)u00(?i:{code})",
        f"%(?:25){{0,4}}(?i:{code})",  # escaped again, a percent sign is %25
        f"&#(?:0{{0,4}}{ord(letter)}|(?i:x0{{0,4}}{code}));",
        *(f"&{name};" for name in _NAMED.get(letter, ())),
    )


def length_of(request: Mapping[str, Any]) -> int | None:
    """The maximum length of an answer that a request allows, in tokens; None: no maximum."""
    lengths = [request[name] for name in ("max_tokens", "max_completion_tokens") if name in request]
    return min(lengths) if lengths and all(type(length) is int for length in lengths) else None


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__  # the network's own reason is in the suppressed context


def _is_unsent(error: BaseException) -> bool:
    """Whether an error came before the request was sent."""
    return any(type(cause).__name__ in _UNSENT for cause in _causes(error))


def _close(client: Any) -> None:
    """Close a client's connections, in the loop that opened them."""
    asyncio.run_coroutine_threadsafe(client.close(), loop())


def _is_open(base_url: str) -> bool:
    """Whether requests go unencrypted to another machine."""
    return base_url.startswith("http:") and not is_here(base_url)


def connect(base_url: str, settings: ClientSettings, name: str = "") -> Endpoint:
    """An endpoint, the same for the same settings in the same process."""
    with _connecting:
        return _connect(base_url, settings, name, os.getpid())


_connecting = threading.Lock()


@cache
def _connect(base_url: str, settings: ClientSettings, name: str, process: int) -> Endpoint:
    return Endpoint(base_url, settings, name)


def check_extra() -> None:
    """Check that the client is installed.

    Raises:
        ModuleNotFoundError: it is not; the message has the pip line.
    """
    if importlib.util.find_spec("openai") is None:
        raise ModuleNotFoundError(
            f"asking a language model needs 'openai', which is not installed; run: {pip_install('llm')}",
            name="openai",
        )
