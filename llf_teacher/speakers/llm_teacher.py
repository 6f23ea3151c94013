"""llm_teacher: a language model in the teacher's seat."""

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.models.model import AsksModel, Model
from llf_teacher.speakers.speaker import Speaker
from teachers.atoms import FN, FP, ParseFailure, Utterance
from teachers.spec import check_range, unknown

KNOWS = ("claims", "nothing")
"""What the model is given of the truth: the oracle's claims of this turn, or nothing."""
_SYSTEM = (
    "You are a teacher, and teach by what you say. A student acts in a world. After each action you are told what it "
    "did and what it sees; then say in one or two sentences what helps it to do better next. You cannot act yourself. "
    "Say nothing that you do not know to be true, and answer with the words for the student and nothing else.\n\n"
    "The student was told:\n{instruction}"
)
_TURN = "Turn {turn}. The student did: {action}\nThe reward was {reward:g}. It sees now:\n{state}"
_CLAIMS = "\n\nWhat is true, as one says who knows: {claims}"


class _Policy:
    """Asks the model in each turn."""

    def __init__(self, spec: "LLMTeacher") -> None:
        self._spec = spec

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode with an empty conversation."""
        self._model = Model(self._spec.settings, rng)
        self._system = ""
        self._past: list[dict[str, str]] = []

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """The model's words; in the first turn the instruction, after a text that is no action the expected form."""
        moment, suggestion = info["moment"], info["suggestion"]
        if not moment.turn:
            instruction = Utterance.of([atom for atom in suggestion.atoms if atom.kind not in (FP, FN)])
            self._system = _SYSTEM.format(instruction=instruction)
            return instruction
        if isinstance(moment.action, ParseFailure):
            return Utterance.of([atom for atom in suggestion.atoms if atom.kind is None])
        question = _TURN.format(turn=moment.turn, reward=moment.reward, **observation)
        if self._spec.knows == "claims" and suggestion:
            question += _CLAIMS.format(claims=suggestion)
        history = self._spec.history
        past = self._past[-2 * history :] if history else []
        asked = {"role": "user", "content": question}
        words = self._model.answer([{"role": "system", "content": self._system}, *past, asked]).text.strip()
        self._past += [asked, {"role": "assistant", "content": words or "(nothing)"}]
        return words


@dataclass(frozen=True)
class LLMTeacher(AsksModel, Speaker):
    """Asks a model what to say; the instruction is the oracle's. See `ModelSettings` for the model's parameters."""

    model: str = ""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | None = 300
    seed: bool = True
    history: int = 20
    """Number of past turns in a request, 0 to 1000."""
    knows: str = "claims"
    """One of `KNOWS`."""
    input_price: float | None = None
    output_price: float | None = None
    cached_price: float | None = None
    endpoint: str = ""
    extra: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        if self.knows not in KNOWS:
            raise ValueError(unknown("value of knows", self.knows, KNOWS))
        check_range("history", self.history, 0, 1000, int)
        super().__post_init__()

    def arguments(self) -> dict[str, Any]:
        """A new policy as the teacher."""
        return {"teacher": _Policy(self)}

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256."""
        prompts = {"system": _SYSTEM, "turn": _TURN + _CLAIMS}
        return {
            "prompts": {
                name: {"sha256": hashlib.sha256(text.encode()).hexdigest(), "text": text}
                for name, text in prompts.items()
            }
        }
