"""llm_teacher: a language model in the teacher's seat."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.models.asked import Asked, as_asked
from llf_teacher.models.forms import AUTO, check_answer
from llf_teacher.models.model import AsksModel, Model, ModelSettings, prompt_facts
from llf_teacher.models.replies import LENGTH, Answer, Usage
from llf_teacher.speakers.speaker import CUT, EMPTY, REPEATS, Speaker, TeacherReply
from pz_envs.text.answer_formats import form_fields
from pz_envs.text.json_values import find_message
from pz_envs.text.message_formats import FEW_CLAIMS, longest, message_schema
from teachers.atoms import FN, FP, HN, HP, Atom, Claim, Moment, ParseFailure, R, Utterance
from teachers.common import Paid, Reward, Solved, TryAgain
from teachers.schema import LONGEST_TEXT, MOST_CLAIMS, Message, Vocabulary, may_lack, sentences_of
from teachers.spec import check_range, unknown

KNOWS = ("claims", "nothing")
"""The model's knowledge of the truth: the oracle's claims of this turn, or nothing."""
SAYS = ("claims", "both", "words")
"""The form of the model's answers: claims, which are checked and which the voice words; claims and its own words for
them; or words alone."""
_SYSTEM = (
    "You teach a student that acts in a world. Before each of its actions, {ask}\n\nThe student's task:\n{instruction}"
)
_ASK = {
    "claims": 'answer with JSON: "claims" lists what the student should hear, most helpful first.',
    "both": (
        'answer with JSON: "claims" lists what the student should hear, most helpful first, and "text" says it in your '
        "words."
    ),
    "words": "tell it in one sentence what to do next.",
}
_LISTING = '\n\nEach claim is an object with its "type" and its fields. The types:\n{listing}'
_DID = "It did: {action}\nReward: {reward:g}\n"
_SEES = "It sees:\n{state}"
_TRUE = "\n\nTrue now:\n{claims}"
_ORDER = (FP, FN, HP, HN, R)  # so that advice is not left out where few claims can be said
_SEEN = (Reward, Paid, Solved, TryAgain)  # what a student sees without a teacher
_WORDS = 120  # tokens of an answer in words
_FORM, _MOST = 20, 2000  # tokens around an answer, and of an answer at most
_DIGITS = 4  # of numbers in the claims that the model is shown
_RUN = 5  # successive words of the question that make an answer a repetition


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
        self.reply: TeacherReply | None = None
        """Its last answer; None if the model was not asked in this turn."""
        self.asked: Asked | None = None
        """What it was asked; None if it was not asked in this turn."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str | Message:
        """The model's words or claims, before the first action advice after the instruction.

        Without the model: the instruction, if the student hears no advice or the model says words alone; the notice
        after a text that is no action.
        """
        moment, suggestion, spec, vocabulary = info["moment"], info["suggestion"], self._spec, info["vocabulary"]
        self.withheld, self.usage, self.reply, self.asked = (), None, None, None
        advice = tuple(atom for atom in suggestion.atoms if atom.kind in (FP, FN))
        if not moment.turn:
            self._instruction = Utterance.of([atom for atom in suggestion.atoms if atom not in advice])
            if spec.says == "words" or vocabulary.kinds.isdisjoint((FP, FN)):
                return self._instruction
        if isinstance(moment.action, ParseFailure):
            return Utterance.of([atom for atom in suggestion.atoms if atom.kind is None])
        said_so = suggestion.atoms if moment.turn else advice
        known = _Known(said_so if spec.knows == "claims" else (), vocabulary)
        seen = ((_DID if moment.turn else "") + _SEES).format(reward=moment.reward, **observation)
        asked = seen
        if spec.knows == "claims" and said_so:
            lines = [json.dumps(each, ensure_ascii=False) for each in known.claims]
            asked += _TRUE.format(claims=f"{suggestion}" if spec.says == "words" else "\n".join(lines))
        form = "text" if spec.says == "words" else self._model.form(spec.answer).name
        answer = self._ask(asked, form, moment, vocabulary, known)
        self.usage = answer.usage
        said = self._words(answer) if spec.says == "words" else self._message(answer, moment, vocabulary, known)
        faults = tuple(name for name, has in self._faults(answer, said, seen) if has)
        self.reply = TeacherReply(answer.text[:LONGEST_TEXT], answer.finish, answer.seconds, form, faults)
        if kept := _kept(said, vocabulary):
            self._past += [{"role": "user", "content": asked}, {"role": "assistant", "content": kept}]
        return said

    def _ask(self, question: str, form: str, moment: Moment[Any], vocabulary: Vocabulary, known: "_Known") -> Answer:
        """The model's answer to a question in a form."""
        spec = self._spec
        if not self._system:
            self._system = _SYSTEM.format(ask=_ASK[spec.says], instruction=self._instruction)
            if spec.says != "words" and (form == "text" or spec.knows == "nothing"):
                self._system += _LISTING.format(listing=vocabulary.listing())
        fields, needed = None, _WORDS
        if spec.says != "words":
            own = self._worded(moment)
            schema = message_schema(vocabulary, moment, spec.most_claims, known=known.claims, words=own)
            fields, needed = claims_form(form, schema), min(_FORM + longest(schema), _MOST)
        past = self._past[-2 * spec.history :] if spec.history else []
        system, asked = {"role": "system", "content": self._system}, {"role": "user", "content": question}
        messages = [system, *past, asked]
        self.asked = as_asked(messages, fields)
        return self._model.answer(messages, fields, needed)

    def _worded(self, moment: Moment[Any]) -> bool:
        """Whether a message has its own words; not in the opening, whose advice is told apart by its claims."""
        return self._spec.says == "both" and moment.turn > 0

    def _words(self, answer: Answer) -> str:
        """The words of an answer, without a sentence that was cut."""
        words = answer.text.strip()
        if answer.finish != LENGTH:
            return words
        sentences = sentences_of(words)
        return words if sentences and words.endswith((".", "!", "?")) else " ".join(sentences[:-1])

    def _message(self, answer: Answer, moment: Moment[Any], vocabulary: Vocabulary, known: "_Known") -> Message:
        """The claims of an answer, each once; its own words if wanted. With a filter, without the false claims."""
        words = answer.text.strip()
        found = find_message(words)
        if found is None:  # no claim could be read, so that none could not be made: the answer itself is at fault
            return Message((), "", ())
        message = vocabulary.read(known.read(found), moment)
        claims = tuple(dict.fromkeys(message.claims))
        if not moment.turn and (early := [claim for claim in claims if claim.kind not in (FP, FN)]):
            problems = [
                f"before the first action a claim must be advice (fp, fn), got {claim!r:.60}" for claim in early
            ]
            claims = tuple(claim for claim in claims if claim not in early)
            message = message._replace(problems=(*message.problems, *problems))
        if not self._spec.filter:
            return message._replace(claims=claims, text=message.text if self._worded(moment) else "")
        kept, problems = [], list(message.problems)
        for claim in claims:
            try:
                if vocabulary.holds(claim, moment):
                    kept.append(claim)
                else:
                    self.withheld += (claim,)
            except ValueError as error:
                problems.append(f"{error}")
        return Message(tuple(kept), "", tuple(problems))

    def _faults(self, answer: Answer, said: str | Message, seen: str) -> list[tuple[str, bool]]:
        """The faults that an answer can have, and whether it has them."""
        text, claims = (said, ()) if isinstance(said, str) else (said.text, (*said.claims, *self.withheld))
        problems = isinstance(said, Message) and said.problems
        only_seen = bool(claims) and all(isinstance(claim, _SEEN) for claim in claims)
        return [
            (CUT, answer.finish == LENGTH),
            (EMPTY, not (text or claims or problems)),
            (REPEATS, only_seen or not _runs(text).isdisjoint(_runs(seen))),
        ]


def claims_form(form: str, schema: dict[str, Any]) -> dict[str, Any] | None:
    """The part of a request that asks for a message of a schema in a form; None: as text."""
    return None if form == "text" else form_fields(form, "message", "Say these claims.", schema)


class _Known:
    """The claims that the model is shown, advice first, with numbers of few digits."""

    def __init__(self, atoms: tuple[Atom, ...], vocabulary: Vocabulary) -> None:
        said = [atom.claim for atom in atoms if type(atom.claim) in vocabulary.classes.values()]
        self._exact: dict[tuple[str, float], float] = {}
        self.claims = [
            {
                field: self._shown(field, value)
                for field, value in vocabulary.data_of(claim).items()
                if not may_lack(type(claim), field)
            }
            for claim in sorted(said, key=lambda claim: _ORDER.index(claim.kind))
        ]
        """The claims as JSON values, verdicts without the action, which the moment gives."""

    def _shown(self, field: str, value: Any) -> Any:
        if isinstance(value, list):
            return [self._shown(field, each) for each in value]
        if not isinstance(value, float):
            return value
        short = float(f"{value:.{_DIGITS}g}")
        return value if self._exact.setdefault((field, short), value) != value else short

    def read(self, data: Any) -> Any:
        """JSON values of a model, with the exact numbers for those that it was shown."""
        if not (isinstance(data, dict) and isinstance(claims := data.get("claims"), list)):
            return data
        exact = [
            {field: self._meant(field, value) for field, value in claim.items()} if isinstance(claim, dict) else claim
            for claim in claims
        ]
        return data | {"claims": exact}

    def _meant(self, field: str, value: Any) -> Any:
        if isinstance(value, list):
            return [self._meant(field, each) for each in value]
        if not isinstance(value, int | float) or isinstance(value, bool):
            return value
        anywhere = (exact for (_, short), exact in self._exact.items() if short == value)
        return self._exact.get((field, value), next(anywhere, value))


def _kept(said: str | Message, vocabulary: Vocabulary) -> str:
    """What is sent back of an answer: what was read in it; empty if there is nothing."""
    if isinstance(said, str):
        return said[:LONGEST_TEXT]
    if not said.claims:
        return ""
    data = {"claims": [*map(vocabulary.data_of, said.claims)]} | ({"text": said.text} if said.text else {})
    return json.dumps(data, ensure_ascii=False)


def _runs(text: str) -> set[tuple[str, ...]]:
    """All successive words of a text, five at a time."""
    words = re.findall(r"\w+", text.lower())
    return {tuple(words[at : at + _RUN]) for at in range(len(words) - _RUN + 1)}


@dataclass(frozen=True)
class LLMTeacher(AsksModel, Speaker):
    """Asks a model what to say; the instruction is the oracle's. See `ModelSettings` for the model's parameters."""

    model: str = ""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | str | None = AUTO
    seed: bool = True
    history: int = 0
    """Number of past turns in a request, 0 to 1,000. A small model says again what was true then."""
    knows: str = "claims"
    """One of `KNOWS`."""
    says: str = "claims"
    """One of `SAYS`. With `both`, sentences that the voice would not make of the claims are unchecked."""
    most_claims: int = FEW_CLAIMS
    """Greatest number of claims that it is asked for, 1 to 32."""
    answer: str = AUTO
    """The form of an answer with claims: `json` of a schema, a call of a `tool`, `text`, only by the prompt, or `auto`,
    the first of these that the endpoint keeps."""
    filter: bool = False
    """Whether it says only true claims, with `says="claims"`."""
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
        check_range("most_claims", self.most_claims, 1, MOST_CLAIMS, int)
        super().__post_init__()

    def arguments(self) -> dict[str, Any]:
        """A new policy as the teacher."""
        return {"teacher": ModelPolicy(self)}

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256, and what identifies a model of this machine."""
        prompts = {"system": _SYSTEM.replace("{ask}", _ASK[self.says]), "turn": _DID + _SEES + _TRUE}
        return prompt_facts(prompts | ({} if self.says == "words" else {"types": _LISTING})) | self.model_facts()
