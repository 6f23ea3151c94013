"""llm: asks a language model; it reads and writes words."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import jinja2

from llf_teacher.models import settings
from llf_teacher.models.cache import Cache
from llf_teacher.models.client import check_extra, connect
from llf_teacher.models.settings import Settings
from llf_teacher.students.student import Policy, Student, state_of
from teachers.spec import check_range

PROMPTS = Path(__file__).with_name("prompts")
_OURS = ("model", "messages", "stream", "n")


class _Policy(Policy["LLM"]):
    """Keeps the conversation of an episode."""

    def begin(self) -> None:
        """Have said nothing."""
        spec = self.spec
        self._endpoint = connect(spec.base_url, Settings.read(spec.base_url))
        self._system, self._turn = (_template(name) for name in ("system.j2", "turn.j2"))
        sampling = {
            "temperature": spec.temperature,
            "max_tokens": spec.max_tokens,
            "seed": int(self.rng.integers(2**31)) if spec.seed else None,
        }
        self._sampling = {name: value for name, value in sampling.items() if value is not None}
        self._exchanges: list[dict[str, str]] = []
        self._instruction = ""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """What the model answers; the seat finds the action in it."""
        spec = self.spec
        words = self._turn.render(
            observation=state_of(observation),
            feedback=observation["feedback"],
            turn=len(self._exchanges) // 2 + 1,
        )
        self._instruction = self._instruction or f"{observation['instruction']!s}"
        system = {"role": "system", "content": self._system.render(instruction=self._instruction)}
        asked = {"role": "user", "content": words}
        past = self._exchanges[-2 * spec.history :] if spec.history else []
        request = {"model": spec.model, "messages": [system, *past, asked], **self._sampling, **(spec.extra or {})}
        answer = self._endpoint.ask(request, spec.prices)
        self._exchanges += [asked, {"role": "assistant", "content": answer}]
        return answer


@dataclass(frozen=True)
class LLM(Student):
    """Asks the model of an OpenAI-compatible endpoint. See docs/bring-your-agent.md for costs, cache and key.

    Model and endpoint come from the environment if they are not given, and stand in the spec either way.
    """

    model: str = ""
    """Name of the model; by default `LLF_LLM_MODEL`, else `OPENAI_MODEL`."""
    base_url: str = ""
    """The endpoint; by default `LLF_LLM_BASE_URL`, else `OPENAI_BASE_URL`, else OpenAI's."""
    temperature: float | None = 0.0
    """None: the endpoint's own."""
    max_tokens: int | None = 1000
    """Greatest length of an answer; None: the endpoint's own."""
    seed: bool = True
    """Whether a sampling seed is sent, which depends on the episode's seed only."""
    history: int = 20
    """How many past turns are sent along, the latest ones; the instruction always is."""
    input_price: float | None = None
    """USD per million tokens; None: unknown."""
    output_price: float | None = None
    """USD per million tokens; None: unknown."""
    extra: dict[str, Any] | None = None
    """More of the request's body, such as `{'reasoning_effort': 'low'}`."""

    reads = "words"
    text = True
    policy = _Policy

    def __post_init__(self) -> None:
        base_url = self.base_url or settings.default(settings.BASE_URL) or settings.OPENAI
        object.__setattr__(self, "model", self.model or settings.default(settings.MODEL))
        if not isinstance(self.model, str) or not self.model:
            raise ValueError(f"model must be the name of a model, got {self.model!r}; or set {settings.MODEL}")
        object.__setattr__(self, "base_url", _checked_url(base_url))
        if self.temperature is not None:
            check_range("temperature", self.temperature, 0, 10)
        if self.max_tokens is not None:
            check_range("max_tokens", self.max_tokens, 1, 1_000_000, int)
        check_range("history", self.history, 0, 1000, int)
        if not isinstance(self.seed, bool):
            raise ValueError(f"seed must be True or False, got {self.seed!r}")
        for name in ("input_price", "output_price"):
            if (price := getattr(self, name)) is not None:
                check_range(name, price, 0, 1_000_000)
        if self.extra is not None:
            _check_extra_body(self.extra)

    @property
    def prices(self) -> tuple[float, float] | None:
        """Of input and of output, in USD per million tokens; None unless both are known."""
        if self.input_price is None or self.output_price is None:
            return None
        return self.input_price, self.output_price

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure that the client is there, and that a spending limit can be kept."""
        check_extra()
        found = Settings.read(self.base_url, environment)
        if found.budget is not None and self.prices is None:
            raise ValueError(f"a spending limit needs prices: add input_price=..., output_price=... to {str(self)!r}")
        Cache(found.cache).close()

    def facts(self) -> dict[str, Any]:
        """The prompts, each with the SHA-256 of its file."""
        return {
            "prompts": {
                path.name: {"sha256": hashlib.sha256(path.read_bytes()).hexdigest(), "text": path.read_text("utf-8")}
                for path in sorted(PROMPTS.glob("*.j2"))
            }
        }


def _template(name: str) -> jinja2.Template:
    text = (PROMPTS / name).read_text(encoding="utf-8")
    template: jinja2.Template = jinja2.Template(
        text, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    return template


def _checked_url(url: Any) -> str:
    """An endpoint's address without a slash at its end. The message does not repeat it: it may hold a secret."""
    try:
        parts = urlsplit(url) if isinstance(url, str) else None
    except ValueError:
        parts = None
    if parts is None or parts.scheme not in ("http", "https") or not parts.netloc:
        raise ValueError("base_url must be an address such as http://localhost:8000/v1")
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise ValueError(f"base_url must hold no user, password or query: a key goes into {settings.KEY}")
    return f"{url}".rstrip("/")


def _check_extra_body(extra: Any) -> None:
    try:
        json.dumps(extra, allow_nan=False)
        fits = isinstance(extra, dict) and not set(extra) & set(_OURS)
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise ValueError(f"extra must be a dict of JSON values without the keys {', '.join(_OURS)}, got {extra!r}")
