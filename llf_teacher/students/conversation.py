"""A conversation with a chat model: the instruction, past turns as far as they fit, and what there is to answer."""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import jinja2
import numpy as np

from llf_teacher.models.images import data_url
from llf_teacher.students.answers import ANSWERS, action_in, asking, example, written
from llf_teacher.students.student import state_of
from pz_envs.answers import split_thought
from teachers.spec import check_range
from worlds.world import World

PROMPTS = Path(__file__).with_name("prompts")
SYSTEM, TURN = "system.j2", "turn.j2"
Message = dict[str, Any]
_TOKENS_PER_BYTE = 1 / 3  # until an endpoint has counted
_SPAN = (1 / 16, 1.0)  # of what a count can be


class Question(NamedTuple):
    """What is asked in a turn."""

    text: str
    image: str = ""
    """Its data URL; empty if there is none."""

    def then(self, later: "Question", shown: bool) -> "Question":
        """A later question together with this one, with the later image if that is shown."""
        text = "\n\n".join(filter(None, (self.text, later.text)))
        return Question(text, (later.image if shown else "") or self.image)


class Exchange(NamedTuple):
    """A past turn."""

    asked: Question
    answered: str
    """Without what was thought before it; empty if there was nothing else."""
    call: str = ""
    """Id of the tool's call that the answer is; empty if it is none."""


class Conversation:
    """What a chat model is told and asked, turn by turn.

    `ask` gives the messages to send, `answer` takes what the model said and gives the action for the environment.
    Thoughts between marks such as `<think>` are not sent back, and neither are empty answers. Where an observation has
    an `image`, the question is a list of parts, the text and a PNG of it in a data URL.

    Args:
        env: the environment, as `llf_teacher.make(..., text=True)` gives it, or a world; for an example of an answer
            and the number of turns. None: without either.
        history: how many past turns are sent along at most, the latest ones; the instruction always is.
        max_prompt_tokens: cut the history to half of this when it would be more, so that the beginning of the prompt
            stays the same for many turns and an endpoint can keep it; never the instruction. None: no limit.
        images: how many of the latest turns are sent with their images; those before are text alone.
        answer: `text`, `json` or `tool`; `options` has what requests need for the last two.
        prompts: folder of templates `system.j2` and `turn.j2`; what it lacks is as by default.
        rng: draws the action of the example.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(
        self,
        env: gymnasium.Env[Any, Any] | None = None,
        *,
        history: int = 20,
        max_prompt_tokens: int | None = None,
        images: int = 1,
        answer: str = "text",
        prompts: Path | str | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        check_manner(history, max_prompt_tokens, answer, images)
        self._view = None if env is None else getattr(env.unwrapped, "student_view", None)
        world: World[Any] | None = env if self._view is None else self._view.session.world  # type: ignore[assignment]
        self.history, self.max_prompt_tokens, self.form, self.images = history, max_prompt_tokens, answer, images
        self._system, self._turn = (_template(text) for text in texts_of(prompts))
        rng = np.random.default_rng(0) if rng is None else rng
        self._example = "" if world is None else example(answer, written(world.scratch(), rng))
        self.options = asking(answer, world)
        """More of a request's body."""
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self.instruction = ""
        self.thought = ""
        """What was thought before the last answer, if that was marked."""
        self._turns: list[Exchange] = []
        self._start = 0  # the first turn that is sent along
        self._asked = Question("")
        self._number = 0  # of the turn within the episode
        self._words = ""  # the last feedback of an episode that is over
        self._new = False
        self._per_byte, self._bytes = _TOKENS_PER_BYTE, 1

    def next_episode(self, feedback: str = "") -> None:
        """Another episode of the same student begins, which remembers this one.

        Args:
            feedback: the last words of the teacher, which came after the last action.
        """
        self._number, self._words, self._new = 0, feedback, True

    def ask(self, observation: dict[str, Any], turns_left: int | None = None) -> list[Message]:
        """The messages to send for an observation: of the student's seat, or of the environment.

        Args:
            observation: of this turn.
            turns_left: turns until the episode ends, this one included; None: as the environment has it, if any.
        """
        if turns_left is None and self._view is not None:
            turns_left = self._view.turns_left
        if told := f"{observation['instruction']!s}":
            self._begin(told)
        self._number += 1
        words = filter(None, (self._words, f"{observation['feedback']!s}"))
        text = self._turn.render(
            observation=f"{state_of(observation)!s}",
            feedback=" ".join(words),
            turn=self._number,
            turns_left=turns_left,
            begins_anew=self._new,
        )
        self._asked = Question(text, data_url(observation["image"]) if self.images and "image" in observation else "")
        self._words, self._new = "", False
        messages = self._cut()
        self._bytes = _size(messages)
        return messages

    def answer(self, text: str, *, call: str = "", input_tokens: int | None = None) -> str:
        """The action in what the model said, for the environment's `step`.

        Args:
            text: the answer, or the arguments of the tool's call.
            call: the call's id.
            input_tokens: what the endpoint counted of the messages.
        """
        parted = split_thought(text)
        self._turns.append(Exchange(self._asked, parted.answer, call))
        if input_tokens:
            self._per_byte = min(max(input_tokens / self._bytes, _SPAN[0]), _SPAN[1])
        action, thought = action_in(self.form, parted.answer)
        self.thought = "\n\n".join(filter(None, (parted.thought, thought)))
        return action

    def _begin(self, instruction: str) -> None:
        """Take in an instruction: of a first episode, or of one more."""
        if not self._new:
            self.clear()
        self.instruction = instruction

    def _cut(self) -> list[Message]:
        """The messages of a window that fits; where it does not, it begins so much later that half of it is free."""
        self._start = max(self._start, len(self._turns) - self.history)
        messages = self._messages()
        most = self.max_prompt_tokens
        if most is not None and _size(messages) * self._per_byte > most:
            while self._start < len(self._turns) and _size(messages) * self._per_byte > most / 2:
                self._start += 1
                messages = self._messages()
        return messages

    def _messages(self) -> list[Message]:
        rendered = self._system.render(instruction=self.instruction, example=self._example, answer=self.form)
        messages: list[Message] = [{"role": "system", "content": rendered}]
        asked = Question("")  # what was not answered is asked together with the next
        result = ""  # the call that the next question is the result of
        shown = len(self._turns) + 1 - self.images  # the first turn whose image is sent along
        for number, turn in enumerate(self._turns[self._start :], self._start):
            asked = asked.then(turn.asked, number >= shown)
            if turn.answered:
                messages += [*_questions(asked, result), _reply(turn)]
                asked, result = Question(""), turn.call
        return messages + _questions(asked.then(self._asked, True), result)


def as_prompt(messages: Iterable[Message]) -> str:
    """The same as one text, for who takes no messages; without images."""
    return "\n\n".join(
        f"Your answer: {message['content']}" if message["role"] == "assistant" else text_of(message).strip()
        for message in messages
    )


def text_of(message: Message) -> str:
    """The text of a message, whose content may be parts."""
    content = message["content"]
    return "".join(part.get("text", "") for part in content) if isinstance(content, list) else f"{content or ''}"


def check_manner(history: int, max_prompt_tokens: int | None, answer: str, images: int = 1) -> None:
    """Check the options of a conversation.

    Raises:
        ValueError: one is not allowed.
    """
    check_range("history", history, 0, 1000, int)
    check_range("images", images, 0, 1000, int)
    if max_prompt_tokens is not None:
        check_range("max_prompt_tokens", max_prompt_tokens, 1, 1_000_000_000, int)
    if answer not in ANSWERS:
        raise ValueError(f"answer must be one of {', '.join(ANSWERS)}, got {answer!r}")


def texts_of(prompts: Path | str | None) -> tuple[str, str]:
    """The templates of a folder, system and turn.

    Raises:
        ValueError: there is no such folder, it has neither, or one is no template.
    """
    names = (SYSTEM, TURN)
    folder = PROMPTS if prompts is None else Path(prompts)
    if not any((folder / name).is_file() for name in names):
        raise ValueError(f"prompts must be a folder with {SYSTEM} or {TURN} or both, got {f'{prompts}'!r}")
    texts = [(folder if (folder / name).is_file() else PROMPTS).joinpath(name).read_text("utf-8") for name in names]
    seen: tuple[dict[str, Any], ...] = ({"instruction": "", "example": "", "answer": "text"}, _NO_TURN)
    for name, text, values in zip(names, texts, seen, strict=True):
        try:
            _template(text).render(values)
        except jinja2.TemplateError as error:
            raise ValueError(f"{folder / name} is no template: {error}; it may use {', '.join(values)}") from None
    return texts[0], texts[1]


def digest_of(prompts: Path | str | None) -> str:
    """What tells prompts from others."""
    return hashlib.sha256("\0".join(texts_of(prompts)).encode()).hexdigest()[:12]


_NO_TURN = {"observation": "", "feedback": "", "turn": 1, "turns_left": None, "begins_anew": False}


@cache
def _template(text: str) -> jinja2.Template:
    template: jinja2.Template = jinja2.Template(
        text, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    return template


def _questions(asked: Question, result: str) -> list[Message]:
    """A question, or the result of a call; a result is text, so that an image comes behind it on its own."""
    text, image = asked
    shown = {"type": "image_url", "image_url": {"url": image}}
    if result:
        told = {"role": "tool", "tool_call_id": result, "content": text}
        return [told, {"role": "user", "content": [shown]}] if image else [told]
    return [{"role": "user", "content": [{"type": "text", "text": text}, shown] if image else text}]


def _reply(turn: Exchange) -> Message:
    if not turn.call:
        return {"role": "assistant", "content": turn.answered}
    called = {"name": "act", "arguments": turn.answered}
    return {
        "role": "assistant",
        "content": None,
        "tool_calls": [{"id": turn.call, "type": "function", "function": called}],
    }


def _size(messages: Iterable[Message]) -> int:
    """Bytes of the messages' texts."""
    return sum(len((text_of(message) or f"{message.get('tool_calls')}").encode()) for message in messages)
