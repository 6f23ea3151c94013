"""A voice that asks a language model to put each sentence of a teacher into other words."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from llf_teacher.models import settings
from llf_teacher.models.client import check_extra, connect
from llf_teacher.models.endpoints import Address, check_name, place_of
from llf_teacher.models.settings import Settings
from llf_teacher.speakers.speaker import Wording

_SYSTEM = (
    "You are the voice of a teacher. Say the sentence that you are given in other words, as {tone} would. Keep exactly "
    "what it says: every number, name and quotation stays as it is written, nothing is added and nothing is left out. "
    "Answer with the new sentence and nothing else."
)


@dataclass(frozen=True)
class Rewriter(Wording):
    """A voice for `llf_teacher.make(..., voice=Rewriter("a patient coach"))`, by the client of the LLM student.

    A study names it behind a personality, as in `oracle | rewriter(tone='a patient coach')`. Each sentence is asked for
    once and then comes from the cache; the spending limit, the cache and the key are those of the student, see
    docs/bring-your-agent.md. What a model does to numbers and names is reported in the info as `changes`, with
    `privileged_info=True`, and by `Teacher.changes`; studies count it.
    """

    tone: str = "a friendly teacher"
    """Who speaks, to complete "as ... would"."""
    model: str = ""
    """Name of the model; by default `LLF_LLM_MODEL`, else `OPENAI_MODEL`."""
    base_url: str = ""
    """The endpoint; by default `LLF_LLM_BASE_URL`, else `OPENAI_BASE_URL`, else OpenAI's."""
    temperature: float | None = 0.0
    """None: the endpoint's own."""
    max_tokens: int | None = 300
    """Greatest length of an answer; None: the endpoint's own."""
    prices: tuple[float, float] | None = None
    """Of input and of output, in USD per million tokens; None: unknown."""
    endpoint: str = ""
    """The endpoint by a name, in place of its address; by default `LLF_LLM_ENDPOINT`."""

    def __post_init__(self) -> None:
        endpoint = self.endpoint or ("" if self.base_url else settings.default(settings.ENDPOINT))
        if endpoint and self.base_url:
            raise ValueError(f"give base_url or endpoint, not both, got base_url and endpoint={endpoint!r}")
        object.__setattr__(self, "endpoint", endpoint and check_name(endpoint))
        object.__setattr__(self, "model", self.model or settings.default(settings.MODEL))
        if not self.model:
            raise ValueError(f"model must be the name of a model, got {self.model!r}; or set {settings.MODEL}")
        if not endpoint:
            base_url = self.base_url or settings.default(settings.BASE_URL) or settings.OPENAI
            object.__setattr__(self, "base_url", base_url.rstrip("/"))

    def voice(self) -> "Rewriter":
        """It itself."""
        return self

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure that the client is there, and that a spending limit can be kept."""
        check_extra()
        place = self._place(environment)
        if Settings.read(place.base_url, environment, place.key).budget is not None:
            if self.prices is None:
                raise ValueError(f"a spending limit needs prices: add prices=(input, output) to {str(self)!r}")
            if self.max_tokens is None:
                raise ValueError(
                    f"a spending limit needs a longest answer: give a number as max_tokens in {str(self)!r}"
                )

    def _place(self, environment: Mapping[str, str] = os.environ) -> Address:
        return place_of(self.endpoint, environment) if self.endpoint else Address(self.base_url)

    def __call__(self, sentence: str) -> str:
        """The sentence in other words.

        Raises:
            LLMError: the model gave no answer.
        """
        request: dict[str, Any] = {
            "model": self.model,
            "messages": [
                {"role": "system", "content": _SYSTEM.format(tone=self.tone)},
                {"role": "user", "content": sentence},
            ],
        }
        sampling = {"temperature": self.temperature, "max_tokens": self.max_tokens}
        request |= {name: value for name, value in sampling.items() if value is not None}
        place = self._place()
        endpoint = connect(place.base_url, Settings.read(place.base_url, key_in=place.key), self.endpoint)
        return endpoint.ask(request, self.prices).strip()
