"""llm: asks a language model; it reads and writes words."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from llf_teacher.models import settings
from llf_teacher.models.cache import Cache
from llf_teacher.models.client import Endpoint, check_extra, connect
from llf_teacher.models.endpoints import Address, check_name, checked_url, place_of
from llf_teacher.models.replies import Answer, Prices
from llf_teacher.models.settings import Settings
from llf_teacher.students.conversation import SYSTEM, TURN, Conversation, Message, check_manner, digest_of, texts_of
from llf_teacher.students.student import Student, Telling
from llf_teacher.students.talking import TalkingPolicy
from teachers.spec import check_range

_OURS = ("model", "messages", "stream", "n", "tools", "tool_choice", "response_format")
_APART = "#"  # between a folder of prompts and what tells them from others


class _Policy(TalkingPolicy["LLM"]):
    """Asks the endpoint."""

    def begin(self) -> None:
        """Have said nothing, unless the episode before was the same student's."""
        self._endpoint, self._sampling = self.spec.connected(), self.spec.sampling(self.rng)
        self._last: Answer | None = None
        super().begin()

    def converse(self) -> Conversation:
        """As the spec says."""
        spec = self.spec
        return Conversation(
            self.world,
            history=spec.history,
            max_prompt_tokens=spec.max_prompt_tokens,
            images=spec.images,
            answer=spec.answer,
            prompts=spec.folder,
            rng=self.rng,
        )

    def reply(self, messages: list[Message]) -> str:
        """The action in what the model answers."""
        spec = self.spec
        form, more = self.talk.options, spec.extra or {}
        request = {"model": spec.model, "messages": messages, **form, **self._sampling, **more}
        self._last = answer = self._endpoint.answer(request, spec.prices)
        return self.talk.answer(answer.raw, call=answer.call, input_tokens=answer.usage.input_tokens)

    def record(self) -> Telling:
        """The last answer and its cost."""
        answer = self._last
        if answer is None:
            return {}
        usage = answer.usage
        thought = "\n\n".join(dict.fromkeys(filter(None, (answer.thought, self.talk.thought))))
        said = Telling(answer=answer.text, thought=thought, finish=answer.finish, seconds=answer.seconds)
        known = {"input_tokens": usage.input_tokens, "output_tokens": usage.output_tokens, "usd": usage.usd}
        return cast(Telling, {**said, **known})


@dataclass(frozen=True)
class LLM(Student):
    """Asks the model of an OpenAI-compatible endpoint. See docs/bring-your-agent.md for costs, cache and key.

    Model and endpoint come from the environment if they are not given, and stand in the spec either way.
    """

    model: str = ""
    """Name of the model; by default `LLF_LLM_MODEL`, else `OPENAI_MODEL`."""
    base_url: str = ""
    """The endpoint; by default `LLF_LLM_BASE_URL`, else `OPENAI_BASE_URL`, else OpenAI's; none beside `endpoint`."""
    temperature: float | None = 0.0
    """None: the endpoint's own."""
    max_tokens: int | None = 1000
    """Greatest length of an answer; None: the endpoint's own."""
    seed: bool = True
    """Whether a sampling seed is sent, which depends on the episode's seed only."""
    history: int = 20
    """How many past turns are sent along, the latest ones; the instruction always is."""
    max_prompt_tokens: int | None = None
    """Greatest length of a prompt, about: history beyond is cut in blocks, never the instruction. None: any."""
    answer: str = "text"
    """What the model answers with: `text`, a `json` object, or a call of a `tool`."""
    prompts: str | None = None
    """Folder of templates `system.j2` and `turn.j2` in place of ours; the spec adds what tells them from others."""
    input_price: float | None = None
    """USD per million tokens; None: unknown."""
    output_price: float | None = None
    """USD per million tokens; None: unknown."""
    cached_price: float | None = None
    """Of input that the endpoint had in its cache; None: as other input."""
    endpoint: str = ""
    """The endpoint by a name, which is said elsewhere where it is; by default `LLF_LLM_ENDPOINT`."""
    images: int = 1
    """How many of the latest turns are sent with their images, where there are any."""
    extra: dict[str, Any] | None = None
    """More of the request's body, such as `{'reasoning_effort': 'low'}`."""

    reads = "words"
    text = True
    remembers = True
    policy = _Policy

    def __post_init__(self) -> None:
        endpoint = self.endpoint or ("" if self.base_url else os.environ.get(settings.ENDPOINT, ""))
        if endpoint and self.base_url:
            raise ValueError(f"give base_url or endpoint, not both, got base_url and endpoint={endpoint!r}")
        object.__setattr__(self, "endpoint", endpoint and check_name(endpoint))
        object.__setattr__(self, "model", self.model or settings.default(settings.MODEL))
        if not isinstance(self.model, str) or not self.model:
            raise ValueError(f"model must be the name of a model, got {self.model!r}; or set {settings.MODEL}")
        if not endpoint:
            base_url = self.base_url or settings.default(settings.BASE_URL) or settings.OPENAI
            object.__setattr__(self, "base_url", checked_url(base_url))
        if self.temperature is not None:
            check_range("temperature", self.temperature, 0, 10)
        if self.max_tokens is not None:
            check_range("max_tokens", self.max_tokens, 1, 1_000_000, int)
        check_manner(self.history, self.max_prompt_tokens, self.answer, self.images)
        if self.prompts is not None:
            object.__setattr__(self, "prompts", _told_apart(self.prompts))
        if not isinstance(self.seed, bool):
            raise ValueError(f"seed must be True or False, got {self.seed!r}")
        for name in ("input_price", "output_price", "cached_price"):
            if (price := getattr(self, name)) is not None:
                check_range(name, price, 0, 1_000_000)
        if self.extra is not None:
            _check_extra_body(self.extra)

    @property
    def prices(self) -> Prices | None:
        """In USD per million tokens; None unless those of input and of output are known."""
        if self.input_price is None or self.output_price is None:
            return None
        return Prices(self.input_price, self.output_price, self.cached_price)

    @property
    def folder(self) -> str | None:
        """Where its templates are; None: where ours are."""
        return None if self.prompts is None else self.prompts.rpartition(_APART)[0]

    def place(self, environment: Mapping[str, str] = os.environ) -> Address:
        """Where its endpoint is.

        Raises:
            ValueError: nobody says so.
        """
        return place_of(self.endpoint, environment) if self.endpoint else Address(self.base_url)

    def connected(self) -> Endpoint:
        """Its endpoint."""
        place = self.place()
        return connect(place.base_url, Settings.read(place.base_url, key_in=place.key), self.endpoint)

    def sampling(self, rng: np.random.Generator) -> dict[str, Any]:
        """How an episode's answers are sampled, as requests say it."""
        sampling = {
            "temperature": self.temperature,
            "max_tokens": self.max_tokens,
            "seed": int(rng.integers(2**31)) if self.seed else None,
        }
        return {name: value for name, value in sampling.items() if value is not None}

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure that the client is there, and that a spending limit can be kept."""
        check_extra()
        place = self.place(environment)
        found = Settings.read(place.base_url, environment, place.key)
        if found.budget is not None and self.prices is None:
            raise ValueError(f"a spending limit needs prices: add input_price=..., output_price=... to {str(self)!r}")
        if found.budget is not None and self.max_tokens is None:
            raise ValueError(f"a spending limit needs a longest answer: give a number as max_tokens in {str(self)!r}")
        Cache(found.cache).close()

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256."""
        texts = zip((SYSTEM, TURN), texts_of(self.folder), strict=True)
        return {
            "prompts": {
                name: {"sha256": hashlib.sha256(text.encode()).hexdigest(), "text": text} for name, text in texts
            }
        }


def _told_apart(prompts: Any) -> str:
    """A folder of prompts with the digest of what is in it, as it stands in a spec.

    Raises:
        ValueError: there are no prompts, or they are not what they were.
    """
    folder, _, was = f"{prompts}".rpartition(_APART) if _APART in f"{prompts}" else (f"{prompts}", "", "")
    now = digest_of(folder)
    if was and was != now:
        raise ValueError(
            f"the prompts in {folder} are not those of {prompts!r}; leave out {_APART + was!r} to use them"
        )
    return f"{folder}{_APART}{now}"


def _check_extra_body(extra: Any) -> None:
    try:
        json.dumps(extra, allow_nan=False)
        fits = isinstance(extra, dict) and not set(extra) & set(_OURS)
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise ValueError(f"extra must be a dict of JSON values without the keys {', '.join(_OURS)}, got {extra!r}")
