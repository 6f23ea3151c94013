"""A conversation with a chat model: the instruction, the past turns that fit, and the current question."""

import hashlib
import json
from collections.abc import Iterable, Sequence
from functools import cache
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import jinja2
import numpy as np

from llf_teacher.models.images import data_url
from llf_teacher.students.student import state_of
from pz_envs.text.actions import first_answer, parse_action
from pz_envs.text.answer_formats import (
    ANSWERS,
    THOUGHT,
    action_in,
    answer_of,
    example,
    longest_answer,
    request_fields,
    worded,
    written,
)
from pz_envs.text.json_values import unique_keys
from pz_envs.text.thoughts import SplitReply, split_thought
from teachers.atoms import ParseFailure
from teachers.spec import check_range
from worlds.world import World

PROMPTS = Path(__file__).with_name("prompts")
SYSTEM, TURN, EXAMPLES = "system.j2", "turn.j2", "examples.jsonl"
PRESETS = ("neutral",)
"""Prompts that come with the package, beside the default."""
STOPS = ("\n\nTeacher:", "\nYour action?", "\nUser:")
"""Texts that end an answer in words, where the model begins to speak for others; the first two are of `turn.j2`."""
_REVIEW = (
    "The episode is over. The teacher said at its end: {words}\n\nWrite down what helps you to do better in the next "
    "episodes of this task, in at most {most} words and nothing else. All else is forgotten; so are earlier notes."
)
_NOTES = "\n\nYour notes of earlier episodes:\n{notes}"
_LONGEST = 20_000  # characters of an answer that are sent back
_LETTERS = 10  # greatest mean length of a word of the notes
Message = dict[str, Any]
_TOKENS_PER_BYTE = 1 / 3  # tokens per byte, until an endpoint gives a count
_SPAN = (1 / 16, 1.0)  # range of plausible tokens per byte


class Question(NamedTuple):
    """The question of a turn."""

    text: str
    image: str = ""
    """Its data URL; empty if there is none."""

    def then(self, later: "Question", shown: bool) -> "Question":
        """A question with a later question appended, and the later image if it is shown."""
        text = "\n\n".join(filter(None, (self.text, later.text)))
        return Question(text, (later.image if shown else "") or self.image)


class Exchange(NamedTuple):
    """A past turn."""

    asked: Question
    answered: str
    """The answer without thoughts; may be empty."""
    call: str = ""
    """Id of the tool call; empty if the answer is not a tool call."""


class Conversation:
    """The messages to a chat model, turn by turn.

    `ask` returns the messages to send; `answer` takes the model's answer and returns the action for the environment.
    It does not send back thoughts between marks such as `<think>`, answers that are no action, or turns of others that
    the model invented; of an answer that was cut, it sends back the action alone. If an observation has an `image`, the
    question is a list of parts: the text and the image as a PNG in a data URL.

    Args:
        env: an environment from `llf_teacher.make(..., text=True)`, or a world; for the form of actions and the number
            of turns. None: actions of any form, no number of turns.
        history: maximum number of past turns in a prompt, the latest; the instruction is always in it.
        max_prompt_tokens: when a prompt would be longer, cut the history until the prompt has half this length, so that
            the beginning of the prompt stays the same for many turns and an endpoint can cache it. The instruction is
            never cut. None: no limit.
        images: number of the latest turns that are sent with their images; earlier turns are sent as text.
        answer: `text`, `json` or `tool`; `options` has the fields that a request needs for the last two.
        thought: greatest number of characters of a thought before the action; 0: no thought.
        prompts: folder of templates `system.j2` and `turn.j2`, or one of `PRESETS`; a missing template is the default.
            Its `examples.jsonl`, if there is one, has an example of a turn per line, an object with `question` and
            `answer`; they stand before the conversation.
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
        thought: int = THOUGHT,
        prompts: Path | str | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        check_options(history, max_prompt_tokens, answer, images, thought)
        self._view = None if env is None else getattr(env.unwrapped, "student_view", None)
        world: World[Any] | None = env if self._view is None else self._view.session.world  # type: ignore[assignment]
        self.history, self.max_prompt_tokens, self.form, self.images = history, max_prompt_tokens, answer, images
        texts = texts_of(prompts)
        self._system, self._turn = _template(texts[SYSTEM]), _template(texts[TURN])
        called = "example" if answer == "tool" else ""
        self._examples = [Exchange(Question(question), said, called) for question, said in _examples(texts)]
        rng = np.random.default_rng(0) if rng is None else rng
        self._example = "" if world is None else example(answer, written(world.scratch(), rng))
        self._world, self._thought = world, thought
        self.options = request_fields(answer, world, (), thought)
        """Further fields of the next request's body."""
        self.most_tokens = None if world is None else longest_answer(world, answer, thought)
        """Number of tokens that leaves room for any answer; None without a world."""
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self.instruction = ""
        self.thought = ""
        """The thoughts of the last answer, if they were marked."""
        self.said = ""
        """The last answer without thoughts, up to the point where it begins to speak for others."""
        self.invented = ""
        """The rest of the last answer, which is not sent back."""
        self.notes = ""
        """The model's notes about earlier episodes."""
        self._turns: list[Exchange] = []
        self._start = 0  # the first sent turn
        self._asked = Question("")
        self._number = 0  # the turn within the episode
        self._words = ""  # the last feedback of the previous episode
        self._new = False
        self._per_byte, self._bytes = _TOKENS_PER_BYTE, 1

    def next_episode(self, feedback: str = "") -> None:
        """Begin another episode of the same student, which remembers the past ones.

        Args:
            feedback: the teacher's feedback to the last action.
        """
        self._number, self._words, self._new = 0, feedback, True

    def review(self, most: int) -> list[Message]:
        """The messages that request notes of at most `words` words, between two episodes."""
        self._asked = Question(_REVIEW.format(words=self._words or "-", most=most))
        return self._cut()

    def note(self, text: str, most: int) -> None:
        """Replace the turns so far by notes of at most `words` words."""
        self.notes, self._turns, self._start, self._words = text.strip()[: most * _LETTERS], [], 0, ""

    def ask(
        self, observation: dict[str, Any], turns_left: int | None = None, listed: Sequence[str] = ()
    ) -> list[Message]:
        """The messages to send for an observation of the student's seat, or of the environment.

        Args:
            observation: this turn's observation.
            turns_left: turns until the episode ends, including this one; None: the environment's number, if any.
            listed: the commands that the world lists in this turn; empty: those of the environment, if any.
        """
        if self._view is not None:
            turns_left = self._view.turns_left if turns_left is None else turns_left
            session = self._view.session
            listed = listed or session.info.get(session.world.actions_key) or ()
        if listed and self._world is not None:
            self.options = request_fields(self.form, self._world, listed, self._thought)
        if instruction := f"{observation['instruction']!s}":
            self._begin(instruction)
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

    def answer(
        self, text: str | SplitReply, *, call: str = "", input_tokens: int | None = None, cut: bool = False
    ) -> str:
        """The action in the model's answer, for the environment's `step`.

        Args:
            text: the answer, or the arguments of a tool call; whole, or with its thoughts split off.
            call: id of the tool call.
            input_tokens: the endpoint's count of tokens in the messages.
            cut: whether the answer was cut at its greatest length.
        """
        split = split_thought(text)
        self.said, self.invented = first_answer(split.answer, self._world)
        action, thought = action_in(self.form, self.said, self._world)
        self._turns.append(Exchange(self._asked, self._kept(action, cut), call))
        if input_tokens:
            self._per_byte = min(max(input_tokens / self._bytes, _SPAN[0]), _SPAN[1])
        self.thought = "\n\n".join(filter(None, (split.thought, thought)))
        return action

    def _kept(self, action: str, cut: bool) -> str:
        """What is sent back of the last answer: nothing if it is no action, and only the action if it was cut."""
        if self._world is None:
            return self.said[:_LONGEST]
        if action in self._world.answer_words:
            words = action
        elif isinstance(taken := parse_action(action, self._world), ParseFailure):
            return ""
        else:
            words = worded(self._world, taken)
        if not cut:
            return self.said[:_LONGEST]
        return f"Response: {words}" if self.form == "text" else answer_of(self.form, words)

    def did(self, action: str) -> None:
        """Record this action as taken, in place of the last answer."""
        self._turns[-1] = self._turns[-1]._replace(answered=answer_of(self.form, action))

    def _begin(self, instruction: str) -> None:
        """Set the instruction of the first or of a further episode."""
        if not self._new:
            self.clear()
        self.instruction = instruction

    def _cut(self) -> list[Message]:
        """The messages that fit; if too many, the window's start moves until the messages have half the limit."""
        self._start = max(self._start, len(self._turns) - self.history)
        messages = self._messages()
        most = self.max_prompt_tokens
        if most is not None and _size(messages) * self._per_byte > most:
            while self._start < len(self._turns) and _size(messages) * self._per_byte > most / 2:
                self._start += 1
                messages = self._messages()
        return messages

    def _messages(self) -> list[Message]:
        rendered = self._system.render(
            instruction=self.instruction, example=self._example, answer=self.form, thought=self._thought
        )
        noted = _NOTES.format(notes=self.notes) if self.notes else ""
        messages: list[Message] = [{"role": "system", "content": rendered + noted}]
        asked = Question("")  # a question without an answer is sent together with the next
        result = ""  # the tool call whose result the next question is
        shown = len(self._turns) + 1 - self.images  # the first turn with a sent image
        sent = [*self._examples, *self._turns[self._start :]]
        for number, turn in enumerate(sent, self._start - len(self._examples)):
            asked = asked.then(turn.asked, number >= shown)
            if turn.answered:
                messages += [*_questions(asked, result), reply_of(turn.answered, turn.call)]
                asked, result = Question(""), turn.call
        return messages + _questions(asked.then(self._asked, True), result)


def as_prompt(messages: Iterable[Message]) -> str:
    """Messages as one text, without images."""
    return "\n\n".join(
        f"Your answer: {message['content']}" if message["role"] == "assistant" else text_of(message).strip()
        for message in messages
    )


def text_of(message: Message) -> str:
    """The text of a message, whose content may be parts."""
    content = message["content"]
    return "".join(part.get("text", "") for part in content) if isinstance(content, list) else f"{content or ''}"


def check_options(
    history: int, max_prompt_tokens: int | None, answer: str, images: int = 1, thought: int = THOUGHT
) -> None:
    """Check the options of a conversation.

    Raises:
        ValueError: an option is not allowed.
    """
    check_range("history", history, 0, 1000, int)
    check_range("images", images, 0, 1000, int)
    check_range("thought", thought, 0, 1000, int)
    if max_prompt_tokens is not None:
        check_range("max_prompt_tokens", max_prompt_tokens, 1, 1_000_000_000, int)
    if answer not in ANSWERS:
        raise ValueError(f"answer must be one of {', '.join(ANSWERS)}, got {answer!r}")


def texts_of(prompts: Path | str | None) -> dict[str, str]:
    """The templates of a folder or a preset, system and turn, and its examples, if any, by the names of their files.

    Raises:
        ValueError: there is no such folder, it has none of them, or one is not valid.
    """
    names = (SYSTEM, TURN, EXAMPLES)
    folder = PROMPTS if prompts is None else PROMPTS / prompts if prompts in PRESETS else Path(prompts)
    if not any((folder / name).is_file() for name in names):
        raise ValueError(
            f"prompts must be {', '.join(PRESETS)}, or a folder with any of {', '.join(names)}, got {f'{prompts}'!r}"
        )
    paths = {name: (folder if (folder / name).is_file() else PROMPTS) / name for name in names}
    texts = {name: path.read_text("utf-8-sig") for name, path in paths.items() if path.is_file()}
    seen: dict[str, dict[str, Any]] = {SYSTEM: _SYSTEM_VALUES, TURN: _NO_TURN}
    for name, values in seen.items():
        try:
            _template(texts[name]).render(values)
        except jinja2.TemplateError as error:
            raise ValueError(
                f"{folder / name} is not a valid template: {error}; allowed: {', '.join(values)}"
            ) from None
    _examples(texts)
    return texts


def _examples(texts: dict[str, str]) -> list[tuple[str, str]]:
    """Questions and answers of the examples.

    Raises:
        ValueError: a line lacks a question or an answer.
    """
    found = []
    for number, line in enumerate(texts.get(EXAMPLES, "").splitlines(), 1):
        try:
            question, answer = itemgetter("question", "answer")(json.loads(line, object_pairs_hook=unique_keys))
            answer = answer if isinstance(answer, str) else json.dumps(answer, ensure_ascii=False)
            (question + answer).encode()
        except (ValueError, LookupError, TypeError, RecursionError):
            raise ValueError(
                f"{EXAMPLES}:{number} must be an object with question, a text, and answer, got {line:.60}"
            ) from None
        found.append((question, answer))
    return found


def digest_of(prompts: Path | str | None) -> str:
    """The first 12 digits of the SHA-256 of the templates of a folder."""
    return hashlib.sha256("\0".join(texts_of(prompts).values()).encode()).hexdigest()[:12]


_SYSTEM_VALUES = {"instruction": "", "example": "", "answer": "text", "thought": THOUGHT}
_NO_TURN = {"observation": "", "feedback": "", "turn": 1, "turns_left": None, "begins_anew": False}


@cache
def _template(text: str) -> jinja2.Template:
    template: jinja2.Template = jinja2.Template(
        text, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    return template


def _questions(asked: Question, result: str) -> list[Message]:
    """A question, or the result of a tool call; a result must be text, so its image is a message of its own."""
    text, image = asked
    shown = {"type": "image_url", "image_url": {"url": image}}
    if result:
        message = {"role": "tool", "tool_call_id": result, "content": text}
        return [message, {"role": "user", "content": [shown]}] if image else [message]
    return [{"role": "user", "content": [{"type": "text", "text": text}, shown] if image else text}]


def reply_of(answer: str, call: str = "") -> Message:
    """An answer as a message; with the id of a call, the arguments of a call of the tool."""
    if not call:
        return {"role": "assistant", "content": answer}
    called = {"name": "act", "arguments": answer}
    return {"role": "assistant", "content": None, "tool_calls": [{"id": call, "type": "function", "function": called}]}


def _size(messages: Iterable[Message]) -> int:
    """Bytes of the messages' texts."""
    return sum(
        len((text_of(message) or f"{message.get('tool_calls')}").encode(errors="replace")) for message in messages
    )
