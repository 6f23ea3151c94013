"""llm_teacher: a language model in the teacher's seat."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.models.forms import AUTO, check_answer
from llf_teacher.models.model import AsksModel, Model, ModelSettings, prompt_facts
from llf_teacher.models.replies import Usage
from llf_teacher.speakers.speaker import Speaker
from pz_envs.text.answer_formats import form_fields
from pz_envs.text.json_values import find_message
from teachers.atoms import FN, FP, Atom, Claim, Moment, ParseFailure, Utterance
from teachers.schema import LONGEST_TEXT, Message, Vocabulary
from teachers.spec import check_range, unknown

KNOWS = ("claims", "nothing")
"""The model's knowledge of the truth: the oracle's claims of this turn, or nothing."""
SAYS = ("words", "claims")
"""The form of the model's answers: words for the student, or claims, which are checked."""
_BEGIN = (
    "You are a teacher, and teach by what you say. A student acts in a world. After each action you are told what it "
    "did and what it sees; then say in one or two sentences what helps it to do better next. You cannot act yourself. "
    "Say nothing that you do not know to be true, and answer with "
)
_END = "\n\nThe student was told:\n{instruction}"
_SYSTEM = _BEGIN + "the words for the student and nothing else." + _END
_COMPOSE = (
    _BEGIN + "a JSON object and nothing else. Its list `claims` has what you say, each claim an object with its `type` "
    "and its fields; its `text`, which may be left out, says the same in your own words, a sentence for each claim. An "
    'empty list says nothing. An example: {{"claims": [{{"type": "Reward", "reward": 0.5}}], "text": "You earned '
    '0.5."}}\n\nThese are the claims, with their fields:\n{listing}' + _END
)
_TURN = "Turn {turn}. The student did: {action}\nThe reward was {reward:g}. It sees now:\n{state}"
_CLAIMS = "\n\nWhat is true, as one says who knows: {claims}"
_DATA = "\nThe same as claims: {data}"


class ModelPolicy:
    """Asks the model in each turn; `make_model` makes one of settings and a random stream."""

    def __init__(
        self, spec: "LLMTeacher", make_model: Callable[[ModelSettings, np.random.Generator], Model] = Model
    ) -> None:
        self._spec, self._make_model = spec, make_model

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode with an empty conversation."""
        self._model = self._make_model(self._spec.settings, rng)
        self._system = ""
        self._past: list[dict[str, str]] = []
        self.withheld: tuple[Claim, ...] = ()
        """The false claims of its last answer, if they are withheld."""
        self.usage: Usage | None = None
        """The cost of its last answer; None if the model was not asked in this turn."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str | Message:
        """The model's words or claims; in the first turn the instruction, after a text without an action the notice."""
        moment, suggestion, spec, vocabulary = info["moment"], info["suggestion"], self._spec, info["vocabulary"]
        self.withheld, self.usage = (), None
        if not moment.turn:
            instruction = Utterance.of([atom for atom in suggestion.atoms if atom.kind not in (FP, FN)])
            prompt = _COMPOSE if spec.says == "claims" else _SYSTEM
            self._system = prompt.format(instruction=instruction, listing=vocabulary.listing())
            return instruction
        if isinstance(moment.action, ParseFailure):
            return Utterance.of([atom for atom in suggestion.atoms if atom.kind is None])
        question = _TURN.format(turn=moment.turn, reward=moment.reward, **observation)
        if spec.knows == "claims" and suggestion:
            question += _CLAIMS.format(claims=suggestion)
            if spec.says == "claims":
                question += _DATA.format(data=json.dumps(_data(suggestion.atoms, vocabulary), ensure_ascii=False))
        past = self._past[-2 * spec.history :] if spec.history else []
        asked = {"role": "user", "content": question}
        form = claims_form(self._model.form(spec.answer).name, vocabulary) if spec.says == "claims" else None
        answer = self._model.answer([{"role": "system", "content": self._system}, *past, asked], form)
        words, self.usage = answer.text.strip(), answer.usage
        self._past += [asked, {"role": "assistant", "content": words[:LONGEST_TEXT] or "(nothing)"}]
        return self._message(words, moment, vocabulary) if spec.says == "claims" else words

    def _message(self, words: str, moment: Moment[Any], vocabulary: Vocabulary) -> Message:
        """The claims of an answer; with a filter, without the false ones and its own words."""
        found = find_message(words)
        message = vocabulary.read(words if found is None else found, moment)
        if not self._spec.filter:
            return message
        kept, problems = [], list(message.problems)
        for claim in message.claims:
            try:
                if vocabulary.holds(claim, moment):
                    kept.append(claim)
                else:
                    self.withheld += (claim,)
            except ValueError as error:
                problems.append(f"{error}")
        return Message(tuple(kept), "", tuple(problems))


def claims_form(form: str, vocabulary: Vocabulary) -> dict[str, Any] | None:
    """The part of a request that asks for a message in a form; None: as text."""
    return None if form == "text" else form_fields(form, "message", "Say these claims.", vocabulary.schema())


def _data(atoms: tuple[Atom, ...], vocabulary: Vocabulary) -> list[dict[str, Any]]:
    """The claims among atoms that can be said."""
    return [vocabulary.data_of(atom.claim) for atom in atoms if type(atom.claim) in vocabulary.classes.values()]


@dataclass(frozen=True)
class LLMTeacher(AsksModel, Speaker):
    """Asks a model what to say; the instruction is the oracle's. See `ModelSettings` for the model's parameters."""

    model: str = ""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | None = 300
    seed: bool = True
    history: int = 20
    """Number of past turns in a request, 0 to 1,000."""
    knows: str = "claims"
    """One of `KNOWS`."""
    says: str = "words"
    """One of `SAYS`. With claims, sentences of an answer's text that the voice would not make of its claims are
    unchecked.
    """
    answer: str = AUTO
    """The form of an answer with claims: `json` of a schema, a call of a `tool`, `text`, only by the prompt, or `auto`,
    the first of these that the endpoint keeps."""
    filter: bool = False
    """Whether it says only checked claims, with `says="claims"`: true claims in the words of the voice."""
    input_price: float | None = None
    output_price: float | None = None
    cached_price: float | None = None
    endpoint: str = ""
    extra: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        check_answer(self.answer)
        for name, allowed in (("knows", KNOWS), ("says", SAYS)):
            if (value := getattr(self, name)) not in allowed:
                raise ValueError(unknown(f"value of {name}", value, allowed))
        if not isinstance(self.filter, bool) or (self.filter and self.says != "claims"):
            raise ValueError(f"filter must be False, or True with says='claims', got {self.filter!r}")
        check_range("history", self.history, 0, 1000, int)
        super().__post_init__()

    def arguments(self) -> dict[str, Any]:
        """A new policy as the teacher."""
        return {"teacher": ModelPolicy(self)}

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256, and what identifies a model of this machine."""
        prompts = {"system": _SYSTEM, "turn": _TURN + _CLAIMS}
        if self.says == "claims":
            prompts = {"system": _COMPOSE, "turn": _TURN + _CLAIMS + _DATA}
        return prompt_facts(prompts) | self.model_facts()
