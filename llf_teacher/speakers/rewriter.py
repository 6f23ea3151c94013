"""A voice that asks a language model to put each sentence of a teacher into other words."""

from dataclasses import dataclass, replace
from typing import Any

from llf_teacher.models.model import AsksModel, Model, ModelSettings
from llf_teacher.speakers.speaker import Wording

_SYSTEM = (
    "You are the voice of a teacher. Say the sentence that you are given in other words, as {tone} would. Keep exactly "
    "what it says: every number, name and quotation stays as it is written, nothing is added and nothing is left out. "
    "Answer with the new sentence and nothing else."
)


@dataclass(frozen=True)
class Rewriter(AsksModel, Wording):
    """A voice for `llf_teacher.make(..., voice=Rewriter("a patient coach"))`; see `ModelSettings` for its model.

    A study names it behind a personality, as in `oracle | rewriter(tone='a patient coach')`. It asks once per sentence;
    repetitions come from the cache. Changes of numbers and names are in `Teacher.changes` and, with
    `privileged_info=True`, in the info as `changes`; studies count them.
    """

    tone: str = "a friendly teacher"
    """The speaker, to complete "as ... would"."""
    model: str = ""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | None = 300
    prices: tuple[float, ...] | None = None
    """USD per million tokens, of input, of output and, optionally, of cached input; None: unknown."""
    endpoint: str = ""

    price_fields = "prices=(input, output)"

    def __post_init__(self) -> None:
        if not isinstance(self.tone, str):
            raise ValueError(f"tone must be a text, got {self.tone!r}")
        prices: Any = self.prices
        if prices is not None and not (isinstance(prices, tuple | list) and len(prices) in (2, 3)):
            raise ValueError(f"prices must be None, (input, output) or (input, output, cached), got {prices!r}")
        super().__post_init__()

    @property
    def settings(self) -> ModelSettings:
        """The settings among the fields; requests have no sampling seed."""
        prices = (*(self.prices or (None, None)), None)
        return replace(
            super().settings, seed=False, input_price=prices[0], output_price=prices[1], cached_price=prices[2]
        )

    def voice(self) -> "Rewriter":
        """The rewriter itself."""
        return self

    def __call__(self, sentence: str) -> str:
        """The sentence in other words.

        Raises:
            LLMError: the model gave no answer.
        """
        system = {"role": "system", "content": _SYSTEM.format(tone=self.tone)}
        return Model(self.settings).answer([system, {"role": "user", "content": sentence}]).text.strip()
