"""llm: asks a language model; it reads and writes words."""

from dataclasses import dataclass
from typing import Any, cast

import gymnasium
import numpy as np

from llf_teacher.models import NoAnswerError
from llf_teacher.models.asked import as_asked
from llf_teacher.models.forms import AUTO, FORMS, check_answer
from llf_teacher.models.model import AsksModel, Model, prompt_facts
from llf_teacher.models.replies import LENGTH, Answer
from llf_teacher.students.conversation import STOPS, Conversation, Message, check_options, digest_of, texts_of
from llf_teacher.students.student import ModelReply, Student
from llf_teacher.students.talking import TalkingPolicy
from pz_envs.text.answer_formats import THOUGHT
from teachers.spec import check_range

_DIGEST = "#"  # separates a folder of prompts from the digest of its files


class _Policy(TalkingPolicy["LLM"]):
    """Asks the model in each turn."""

    def begin(self) -> None:
        """Begin an episode, with an empty conversation unless the same student goes on."""
        self._model = Model(self.spec.settings, self.rng)
        self._last: Answer | None = None
        if self._goes_on and (most := self.spec.memory):
            try:
                self.talk.note(self._model.answer(self.talk.review(most)).text, most)
            except NoAnswerError:  # the filter withheld them: go on without notes
                self.talk.note("", most)
        super().begin()

    def converse(self) -> Conversation:
        """A conversation with the options of the spec."""
        self.form = self._model.form(self.spec.answer)
        """The form in which it is asked, once it was asked."""
        return self.spec.conversation(self.world, self.rng, self.form.name)

    def reply(self, messages: list[Message]) -> str:
        """The action in the model's answer."""
        fields = ({"stop": list(STOPS)} if self.talk.form == "text" else {}) | self.talk.options
        self._asked = as_asked(messages, fields)
        self._last = answer = self._model.answer(messages, fields, self.talk.most_tokens)
        cut = answer.finish == LENGTH
        return self.talk.answer(answer.split, call=answer.call, input_tokens=answer.usage.input_tokens, cut=cut)

    def record(self) -> ModelReply:
        """The last answer and its cost."""
        answer = self._last
        if answer is None:
            return {}
        usage = answer.usage
        thought = "\n\n".join(dict.fromkeys(filter(None, (answer.thought, self.talk.thought))))
        said = ModelReply(answer=self.talk.said, thought=thought, finish=answer.finish, seconds=answer.seconds)
        said |= {"form": self.form.name, "asked": self._asked}
        if self.talk.invented:
            said["invented"] = self.talk.invented
        known = {"input_tokens": usage.input_tokens, "output_tokens": usage.output_tokens, "usd": usage.usd}
        return cast(ModelReply, {**said, **known})


@dataclass(frozen=True)
class LLM(AsksModel, Student):
    """Asks a model for each action. See `ModelSettings` for the model's parameters; they are part of the spec."""

    model: str = ""
    base_url: str = ""
    temperature: float | None = 0.0
    max_tokens: int | str | None = AUTO
    seed: bool = True
    history: int = 20
    """Number of past turns in a prompt, the latest; the instruction is always in it."""
    max_prompt_tokens: int | None = None
    """Approximate maximum length of a prompt; older history is cut in blocks, never the instruction. None: no limit."""
    answer: str = AUTO
    """Form of the model's answer: a `json` object of a schema, a call of a `tool`, `text`, or `auto`, the first of
    these that the endpoint keeps."""
    thought: int = THOUGHT
    """Greatest number of characters of a thought before the action; 0: no thought. A text is not held to it."""
    prompts: str | None = None
    """Folder of templates and examples that replace the default, or `neutral`; the spec adds the digest of its files.
    """
    input_price: float | None = None
    output_price: float | None = None
    cached_price: float | None = None
    endpoint: str = ""
    images: int = 1
    """Number of latest turns that are sent with images, if there are images."""
    extra: dict[str, Any] | None = None
    memory: int = 0
    """Greatest number of words of its notes after an episode, which replace the conversation in the next one; 0: no
    notes. If the model gives no answer, for instance because of a filter, there are no notes."""

    reads = "words"
    text = True
    remembers = True
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        check_answer(self.answer)
        check_options(self.history, self.max_prompt_tokens, "json", self.images, self.thought)
        check_range("memory", self.memory, 0, 100_000, int)
        if self.prompts is not None:
            object.__setattr__(self, "prompts", _with_digest(self.prompts))

    @property
    def folder(self) -> str | None:
        """Folder of its templates; None: the default."""
        return None if self.prompts is None else self.prompts.rpartition(_DIGEST)[0]

    def conversation(
        self, env: gymnasium.Env[Any, Any], rng: np.random.Generator, answer: str = FORMS[0]
    ) -> Conversation:
        """A new conversation with its options; see `Conversation`.

        Args:
            env: the environment, or a world.
            rng: draws the action of an example, if the prompts have one.
            answer: the form of answers if its own is `auto`.
        """
        return Conversation(
            env,
            history=self.history,
            max_prompt_tokens=self.max_prompt_tokens,
            images=self.images,
            answer=answer if self.answer == AUTO else self.answer,
            thought=self.thought,
            prompts=self.folder,
            rng=rng,
        )

    def facts(self) -> dict[str, Any]:
        """The prompts, each with its SHA-256, and what identifies a model of this machine."""
        return prompt_facts(texts_of(self.folder)) | self.model_facts()


def _with_digest(prompts: Any) -> str:
    """A folder of prompts with the digest of its files, as in a spec.

    Raises:
        ValueError: the folder has no prompts, or its prompts do not match the digest.
    """
    folder, _, was = f"{prompts}".rpartition(_DIGEST) if _DIGEST in f"{prompts}" else (f"{prompts}", "", "")
    now = digest_of(folder)
    if was and was != now:
        raise ValueError(
            f"the prompts in {folder} have changed since {prompts!r}; leave out {_DIGEST + was!r} to use them"
        )
    return f"{folder}{_DIGEST}{now}"
