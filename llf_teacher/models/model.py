"""Language models by their settings: one checked value says which model to ask, where and how."""

import contextlib
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from llf_teacher.models import settings
from llf_teacher.models.cache import Cache
from llf_teacher.models.client import Endpoint, check_extra, connect
from llf_teacher.models.endpoints import Address, check_name, checked_url, place_of
from llf_teacher.models.forms import AUTO, AnswerForm
from llf_teacher.models.local.catalogue import find, is_local, resolved
from llf_teacher.models.local.endpoint import asked_as, check_local, connect_local, local_settings
from llf_teacher.models.proxies import reach_proxy
from llf_teacher.models.replies import Answer, Prices
from llf_teacher.models.settings import ClientSettings
from teachers.spec import Spec, check_range

_RESERVED = ("model", "messages", "stream", "n", "tools", "tool_choice", "response_format")
_TRIAL = 100  # tokens of an answer to a trial, at least
_LIMIT = 1000  # tokens of an answer that may be thoughts
_RESOLVED = ("model", "base_url", "endpoint")


@dataclass(frozen=True, kw_only=True)
class ModelSettings:
    """The parameters of every spec that asks a model of an OpenAI-compatible endpoint.

    Model and endpoint come from the environment if they are not given. See docs/language-models.md for costs, cache
    and key.

    Raises:
        ValueError: a value is not allowed.
    """

    model: str = ""
    """Name of the model; by default `LLF_LLM_MODEL`, else `OPENAI_MODEL`. `local:NAME` is a model of this machine, see
    `llf models`; it has neither `base_url` nor `endpoint`, and its digest is added."""
    base_url: str = ""
    """Its endpoint's address, without `endpoint`; by default `LLF_LLM_BASE_URL`, `OPENAI_BASE_URL` or OpenAI's."""
    temperature: float | None = 0.0
    """Sampling temperature, 0 to 10; None: the endpoint's default."""
    max_tokens: int | str | None = AUTO
    """Maximum length of an answer, in tokens; None: the endpoint's default. `auto`: what the longest action needs, but
    at least 1,000 where the model is not of this machine, since it may think before it answers."""
    seed: bool = True
    """Whether requests have a sampling seed, which depends only on the episode's seed."""
    input_price: float | None = None
    """USD per million tokens of input; None: unknown."""
    output_price: float | None = None
    """USD per million tokens of output; None: unknown."""
    cached_price: float | None = None
    """USD per million tokens of input from the endpoint's cache; None: as other input."""
    endpoint: str = ""
    """Name of an endpoint, see `llf_teacher.models.endpoints`, without `base_url`; by default `LLF_LLM_ENDPOINT`."""
    extra: dict[str, Any] | None = None
    """Further fields of the request's body, such as `{'reasoning_effort': 'low'}`."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", self.model or settings.default(settings.MODEL))
        if not isinstance(self.model, str) or not self.model:
            raise ValueError(f"model must be the name of a model, got {self.model!r}; or set {settings.MODEL}")
        if is_local(self.model):
            if self.endpoint or self.base_url:
                raise ValueError(f"leave out base_url and endpoint: the model {self.model!r} is served on this machine")
            object.__setattr__(self, "model", resolved(self.model))
        else:
            self._resolve_address()
        if self.temperature is not None:
            check_range("temperature", self.temperature, 0, 10)
        if self.max_tokens is not None and self.max_tokens != AUTO:
            check_range("max_tokens", self.max_tokens, 1, 1_000_000, int)
        if not isinstance(self.seed, bool):
            raise ValueError(f"seed must be True or False, got {self.seed!r}")
        for name in ("input_price", "output_price", "cached_price"):
            if (price := getattr(self, name)) is not None:
                check_range(name, price, 0, 1_000_000)
        if self.extra is not None:
            _check_extra_body(self.extra)

    def _resolve_address(self) -> None:
        """Fill in the endpoint's name or address."""
        endpoint = self.endpoint or ("" if self.base_url else os.environ.get(settings.ENDPOINT, ""))
        if endpoint and self.base_url:
            raise ValueError(f"give base_url or endpoint, not both, got base_url and endpoint={endpoint!r}")
        object.__setattr__(self, "endpoint", endpoint and check_name(endpoint))
        if not endpoint:
            base_url = self.base_url or settings.default(settings.BASE_URL) or settings.OPENAI
            object.__setattr__(self, "base_url", checked_url(base_url))

    @property
    def prices(self) -> Prices | None:
        """USD per million tokens, 0 on this machine; None unless the prices of input and of output are known."""
        if is_local(self.model) and self.input_price is None and self.output_price is None:
            return Prices(0.0, 0.0, None)
        if self.input_price is None or self.output_price is None:
            return None
        return Prices(self.input_price, self.output_price, self.cached_price)

    def address(self, environment: Mapping[str, str] = os.environ) -> Address:
        """The address of the endpoint.

        Raises:
            ValueError: the endpoint's name has no address, or its address is not allowed.
        """
        return place_of(self.endpoint, environment) if self.endpoint else Address(self.base_url)

    def limit(self, needed: int | None = None) -> int | None:
        """Maximum length of an answer, in tokens; None: the endpoint's default.

        Args:
            needed: what the longest action needs; None: unknown.
        """
        if not isinstance(self.max_tokens, str):
            return self.max_tokens
        return needed if needed is not None and is_local(self.model) else max(needed or 0, _LIMIT)

    def sampling(self, rng: np.random.Generator | None, needed: int | None = None) -> dict[str, Any]:
        """The sampling part of a request's body.

        Args:
            rng: draws the seed, if the settings want one.
            needed: what the longest action needs, in tokens; None: unknown.
        """
        sampling = {
            "temperature": self.temperature,
            "max_tokens": self.limit(needed),
            "seed": int(rng.integers(2**31)) if self.seed and rng is not None else None,
        }
        return {name: value for name, value in sampling.items() if value is not None}


class Model:
    """A model behind its endpoint, for one episode.

    Args:
        settings: which model, where and how.
        rng: draws the sampling seed, if the settings want one.
    """

    def __init__(self, settings: ModelSettings, rng: np.random.Generator | None = None) -> None:
        self._settings, self._name = settings, settings.model
        self._endpoint: Endpoint
        if is_local(settings.model):
            self._name, self._endpoint = asked_as(settings.model), connect_local(settings.model)
        else:
            address = settings.address()
            client = ClientSettings.read(address.base_url, key_in=address.key)
            self._endpoint = connect(address.base_url, client, settings.endpoint)
        self._sampling = settings.sampling(rng)

    def form(self, answer: str) -> AnswerForm:
        """The form of answers for the option `answer`; `auto` is tried once for each model and endpoint.

        Raises:
            LLMError: the endpoint gives no answer, for a reason other than the form.
        """
        if answer != AUTO:
            return AnswerForm(answer)
        asked = self._settings
        sampling = asked.sampling(None)
        if "max_tokens" in sampling:
            sampling["max_tokens"] = max(sampling["max_tokens"], _TRIAL)
        body = {"model": self._name, **sampling, **(asked.extra or {})}
        return self._endpoint.form(body, asked.prices)

    def answer(
        self, messages: list[dict[str, Any]], form: Mapping[str, Any] | None = None, needed: int | None = None
    ) -> Answer:
        """The model's answer to messages; see `Endpoint.answer` for the errors.

        Args:
            messages: of a chat completion.
            form: the part of the request's body for the form of the answer; None: a text.
            needed: what the longest answer needs, in tokens; None: unknown.
        """
        asked = self._settings
        sampling = self._sampling | ({} if asked.max_tokens is None else {"max_tokens": asked.limit(needed)})
        body = {**(form or {}), **sampling, **(asked.extra or {})}
        return self._endpoint.answer({"model": self._name, "messages": messages, **body}, asked.prices)


class AsksModel(Spec):
    """Base of specs that ask a model; their fields have the names and meanings of fields of `ModelSettings`."""

    price_fields: ClassVar[str] = "input_price=..., output_price=..."
    """How a spec states prices, for a message."""

    @property
    def settings(self) -> ModelSettings:
        """The settings among the fields."""
        names = {field.name for field in fields(ModelSettings)}
        return ModelSettings(**{name: value for name, value in vars(self).items() if name in names})

    def __post_init__(self) -> None:
        super().__post_init__()
        checked = self.settings
        for name in _RESOLVED:
            object.__setattr__(self, name, getattr(checked, name))

    def model_facts(self) -> dict[str, Any]:
        """What identifies a model of this machine, for a manifest; empty if it is not at hand, or is elsewhere."""
        with contextlib.suppress(ValueError):
            return {"model": find(self.settings.model).facts()} if is_local(self.settings.model) else {}
        return {}

    def check(self, environment: Mapping[str, str]) -> None:
        """Check that the client is installed, that its settings are allowed and that a spending limit can be kept.

        Raises:
            ValueError: a setting is missing or not allowed.
            ModuleNotFoundError: the client is not installed.
        """
        check_extra()
        asked = self.settings
        if is_local(asked.model):
            check_local(asked.model, environment)
            client = local_settings(environment)
        else:
            address = asked.address(environment)
            client = ClientSettings.read(address.base_url, environment, address.key)
            reach_proxy(address.base_url)
        if client.budget is not None and asked.prices is None:
            raise ValueError(f"a spending limit needs prices: add {self.price_fields} to {str(self)!r}")
        if client.budget is not None and asked.max_tokens is None:
            raise ValueError(f"a spending limit needs a maximum length: give a number as max_tokens in {str(self)!r}")
        Cache(client.cache).close()


def prompt_facts(texts: Mapping[str, str]) -> dict[str, Any]:
    """Prompts by name as facts of a manifest, each with its SHA-256."""
    return {
        "prompts": {
            name: {"sha256": hashlib.sha256(text.encode()).hexdigest(), "text": text} for name, text in texts.items()
        }
    }


def _check_extra_body(extra: Any) -> None:
    try:
        json.dumps(extra, allow_nan=False)
        fits = isinstance(extra, dict) and not set(extra) & set(_RESERVED)
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise ValueError(f"extra must be a dict of JSON values without the keys {', '.join(_RESERVED)}, got {extra!r}")
