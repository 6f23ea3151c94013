"""A voice that asks a language model to put each sentence of a teacher into other words."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.models import settings
from llf_teacher.models.client import connect
from llf_teacher.models.settings import Settings

_SYSTEM = (
    "You are the voice of a teacher. Say the sentence that you are given in other words, as {tone} would. Keep exactly "
    "what it says: every number, name and quotation stays as it is written, nothing is added and nothing is left out. "
    "Answer with the new sentence and nothing else."
)


@dataclass(frozen=True)
class Rewriter:
    """A voice for `llf_teacher.make(..., voice=Rewriter("a patient coach"))`, by the client of the LLM student.

    Each sentence is asked for once and then comes from the cache; the spending limit, the cache and the key are those
    of the student, see docs/bring-your-agent.md. What a model does to numbers and names is reported in the info as
    `changes`, with `privileged_info=True`, and by `Teacher.changes`.
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", self.model or settings.default(settings.MODEL))
        if not self.model:
            raise ValueError(f"model must be the name of a model, got {self.model!r}; or set {settings.MODEL}")
        base_url = self.base_url or settings.default(settings.BASE_URL) or settings.OPENAI
        object.__setattr__(self, "base_url", base_url.rstrip("/"))

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
        return connect(self.base_url, Settings.read(self.base_url)).ask(request, self.prices).strip()
