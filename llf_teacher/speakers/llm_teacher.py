"""llm_teacher: a language model in the teacher's seat, by the client of the student `llm`."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.speakers.speaker import Speaker
from llf_teacher.students.builtin.llm import LLM
from teachers.atoms import FN, FP, ParseFailure, Utterance
from teachers.spec import check_range, unknown

KNOWS = ("claims", "nothing")
"""What a model may know of the truth: what the oracle would say in this turn, or nothing."""
_SYSTEM = (
    "You are a teacher, and teach by what you say. A student acts in a world. After each action you are told what it "
    "did and what it sees; then say in one or two sentences what helps it to do better next. You cannot act yourself. "
    "Say nothing that you do not know to be true, and answer with the words for the student and nothing else.\n\n"
    "The student was told:\n{instruction}"
)
_TURN = "Turn {turn}. The student did: {action}\nThe reward was {reward:g}. It sees now:\n{state}"
_TOLD = "\n\nWhat is true, as one says who knows: {claims}"


class _Policy:
    """Asks the model in each turn."""

    def __init__(self, spec: "LLMTeacher") -> None:
        self._spec = spec

    def reset(self, rng: np.random.Generator) -> None:
        """Forget what was said."""
        spec = self._spec
        self._endpoint, self._sampling = spec.asks.connected(), spec.asks.sampling(rng)
        self._system = ""
        self._said: list[dict[str, str]] = []

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """The instruction as it is, and what a text has to look like that was no action; else the model's words."""
        moment, suggestion = info["moment"], info["suggestion"]
        known = Utterance.of([atom for atom in suggestion.atoms if atom.kind not in (FP, FN)])
        if not moment.turn:
            self._system = _SYSTEM.format(instruction=known)
            return known
        if isinstance(moment.action, ParseFailure):
            return Utterance.of([atom for atom in suggestion.atoms if atom.kind is None])
        asked = _TURN.format(turn=moment.turn, reward=moment.reward, **observation)
        if self._spec.knows == "claims" and suggestion:
            asked += _TOLD.format(claims=suggestion)
        said = self._ask(asked)
        self._said += [{"role": "user", "content": asked}, {"role": "assistant", "content": said or "(nothing)"}]
        return said

    def _ask(self, asked: str) -> str:
        spec, past = self._spec, self._said[-2 * self._spec.history :] if self._spec.history else []
        messages = [{"role": "system", "content": self._system}, *past, {"role": "user", "content": asked}]
        request = {"model": spec.model, "messages": messages, **self._sampling, **(spec.extra or {})}
        return self._endpoint.answer(request, spec.asks.prices).text.strip()


@dataclass(frozen=True)
class LLMTeacher(Speaker):
    """Asks the model of an OpenAI-compatible endpoint what to say; the instruction is the oracle's."""

    model: str = ""
    """As of the student `llm`, as are all but `knows`."""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | None = 300
    seed: bool = True
    history: int = 20
    """How many past turns are sent along."""
    knows: str = "claims"
    """One of `KNOWS`."""
    input_price: float | None = None
    output_price: float | None = None
    cached_price: float | None = None
    endpoint: str = ""
    extra: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        if self.knows not in KNOWS:
            raise ValueError(unknown("knowledge", self.knows, KNOWS))
        check_range("history", self.history, 0, 1000, int)
        for name in ("model", "base_url", "endpoint"):
            object.__setattr__(self, name, getattr(self.asks, name))

    @property
    def asks(self) -> LLM:
        """The student that would ask the same model in the same way."""
        shared = {name: value for name, value in vars(self).items() if name not in ("knows", "history")}
        return LLM(**shared)

    def arguments(self) -> dict[str, Any]:
        """A new policy."""
        return {"teacher": _Policy(self)}

    def check(self, environment: Mapping[str, str]) -> None:
        """As of the student."""
        try:
            self.asks.check(environment)
        except ValueError as error:
            raise ValueError(f"{self}: {error}") from None

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256."""
        prompts = {"system": _SYSTEM, "turn": _TURN + _TOLD}
        return {
            "prompts": {
                name: {"sha256": hashlib.sha256(text.encode()).hexdigest(), "text": text}
                for name, text in prompts.items()
            }
        }
