"""Many conversations at once, for training the policy that answers: `llf_teacher.rollout`."""

import copy
import inspect
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from llf_teacher.episodes.regret import turn_regret
from llf_teacher.gym import StudentEnv, make
from llf_teacher.models import LLMError, NoAnswerError
from llf_teacher.models.waiting import WaitsForItselfError, all_awaited, awaited
from llf_teacher.students.chat import ChatStudent, takes_messages
from llf_teacher.students.conversation import Conversation, Message, as_prompt
from pz_envs.subject import Subject
from pz_envs.text.actions import failure as unread
from pz_envs.text.answer_formats import THOUGHT
from teachers.atoms import ParseFailure
from teachers.schema import storable
from teachers.seeds import Seeds
from teachers.spec import check_range

_LONG = 1000  # past turns in a prompt: practically all; a `ChatStudent` may set fewer
_ONE = ("prompt", "messages")  # name of the parameter of a function of one conversation


class RolloutTurn(NamedTuple):
    """One turn of a conversation."""

    prompt: list[Message]
    """The messages that were sent: instruction, past turns of the history, and the question."""
    answer: str
    """The unchanged answer of the policy; empty if that is no text."""
    reward: float
    regret: float
    """The action's loss of value, in the family's unit; the negated reward if the oracle has no values."""
    success: bool
    failure: str | None
    """Why the answer is not an action; None for an action."""
    feedback: str
    """The teacher's feedback on it."""


class Rollout(NamedTuple):
    """A complete conversation."""

    id: str
    """The environment's id."""
    seed: int
    turns: tuple[RolloutTurn, ...]

    @property
    def messages(self) -> list[Message]:
        """The last prompt with its answer; if nothing was cut, the whole conversation."""
        return _answered(self.turns[-1])

    @property
    def whole(self) -> bool:
        """Whether `messages` has all prompts and answers, so that it can serve as one training text.

        It is False if history was cut, a thought was removed from it, or an answer was empty; then each turn is a
        separate text.
        """
        following = zip(self.turns, self.turns[1:], strict=False)
        return all(later.prompt[: len(turn.prompt) + 1] == _answered(turn) for turn, later in following)

    @property
    def answers(self) -> tuple[int, ...]:
        """The index in `messages` of each turn's answer.

        Raises:
            ValueError: the conversation is not whole.
        """
        if not self.whole:
            raise ValueError(
                f"the conversation of {self.id} with seed {self.seed} is not whole: history, a thought or an empty "
                "answer was left out of later prompts; train on each of `turns` instead"
            )
        return tuple(len(turn.prompt) for turn in self.turns)

    def spans(self, render: Callable[..., str]) -> tuple[str, list[tuple[int, int]]]:
        """The conversation as one text, and the spans of the policy's characters, one pair of start and end per turn.

        Together with a tokenizer's offsets they give a mask of tokens.

        Args:
            render: gives the text of messages, with `add_generation_prompt=True` up to the next answer:
                `functools.partial(tokenizer.apply_chat_template, tokenize=False)`. The text between an answer and the
                next message belongs to the span, so that a model learns to stop.

        Raises:
            ValueError: the conversation is not whole, or the text of its beginning is not the beginning of its text.
        """
        text = render(self.messages)
        spans: list[tuple[int, int]] = []
        for place in self.answers:
            before = render(self.messages[:place], add_generation_prompt=True)
            after = render(self.messages[: place + 1])
            if not (text.startswith(after) and after.startswith(before)):
                raise ValueError(
                    "render must give the beginning of a conversation the same text as in the whole, got another text "
                    f"for the answer of turn {len(spans) + 1}; train on each of `turns` instead"
                )
            spans.append((len(before), len(after)))
        return text, spans

    @property
    def rewards(self) -> tuple[float, ...]:
        """The reward of each turn."""
        return tuple(turn.reward for turn in self.turns)

    @property
    def regrets(self) -> tuple[float, ...]:
        """The regret of each turn."""
        return tuple(turn.regret for turn in self.turns)

    @property
    def success(self) -> bool:
        """Whether the last turn succeeded."""
        return self.turns[-1].success

    @property
    def failures(self) -> int:
        """Number of answers that were not actions."""
        return sum(turn.failure is not None for turn in self.turns)


def rollout(
    policy: Callable[..., Any] | ChatStudent,
    ids: str | Subject | Iterable[str | Subject],
    seeds: int | Iterable[int],
    batch: int = 64,
    thought: int = THOUGHT,
    **settings: Any,
) -> list[Rollout]:
    """Play many conversations side by side. Each ends at success, unless its task is asked repeatedly.

    Args:
        policy: `f(conversations) -> texts`, which takes a list of conversations, each a list of messages, and returns
            an answer for each; or a function of one conversation, whose parameter is `prompt` or `messages`, or what
            `chat_student` returns. Both may be coroutine functions; those of one conversation run concurrently.
        ids: one or several of `ids()`, or a `Lesson`.
        seeds: the seeds of the episodes of each id; a number n means 0 to n - 1. A repeated seed makes a group: several
            conversations about the same world.
        batch: number of conversations at once; when one ends the next begins.
        thought: greatest number of characters of a thought before an action; with 0 the prompt asks for no thought.
        settings: keyword arguments of `make`: `teacher`, `feedback_type`, `max_turns`, ...

    Returns:
        One conversation per id and seed, in this order. An answer that is no text, or an error that a function of one
        conversation raises, is a turn without an action; `failure` says why, and a warning counts them.

    Raises:
        ValueError: an argument is not allowed.
        TypeError: the policy does not return a list with an answer for each conversation.
    """
    check_range("batch", batch, 1, 1_000_000, int)
    if "text" in settings:
        raise ValueError(f"rollout always plays in text mode; leave out text={settings['text']!r}")
    if isinstance(seeds, int):
        check_range("seeds", seeds, 0, 1_000_000, int)
    answer = _answering(policy)
    subjects = [ids] if isinstance(ids, str | Subject) else list(ids)
    numbers = list(range(seeds) if isinstance(seeds, int) else seeds)
    waiting = deque(_Lane(subject, seed, place) for place, (subject, seed) in enumerate(_cross(subjects, numbers)))
    played: list[Rollout | None] = [None] * len(waiting)
    kept: dict[Any, list[StudentEnv]] = {subject: [] for subject in subjects}  # for reuse
    going: list[_Lane] = []
    odd: list[str] = []
    try:
        while waiting or going:
            while waiting and len(going) < batch:
                lane = waiting.popleft()
                free = kept[lane.subject]
                lane.env = free.pop() if free else _environment(lane.subject, settings)
                going.append(lane)
                lane.begin(policy, thought)
            for lane, said in zip(going, answer([lane.prompt for lane in going]), strict=True):
                odd += lane.step(said)
            for lane in going:
                if lane.over:
                    played[lane.place] = Rollout(lane.env.env_id, lane.seed, tuple(lane.turns))
                    kept[lane.subject].append(lane.env)
            going = [lane for lane in going if not lane.over]
    finally:
        for env in [lane.env for lane in going] + [env for free in kept.values() for env in free]:
            env.close()
    if odd:
        warnings.warn(f"{len(odd)} answers were no texts, the first: {odd[0]}", RuntimeWarning, stacklevel=2)
    return [each for each in played if each is not None]


class _Lane:
    """A conversation that is running or waits to begin."""

    env: StudentEnv
    prompt: list[Message]
    """The prompt that waits for an answer."""

    def __init__(self, subject: str | Subject, seed: int, place: int) -> None:
        self.subject, self.seed, self.place = subject, seed, place
        self.turns: list[RolloutTurn] = []
        self.over = False

    def begin(self, policy: Any, thought: int) -> None:
        """Reset the environment, and ask."""
        observation, _ = self.env.reset(seed=self.seed)
        cut = isinstance(policy, ChatStudent)
        self._talk = Conversation(
            self.env,
            history=policy.history if cut else _LONG,
            max_prompt_tokens=policy.max_prompt_tokens if cut else None,
            thought=thought,
            rng=Seeds(self.seed).stream("student"),
        )
        self.prompt = self._talk.ask(observation)

    def step(self, said: Any) -> list[str]:
        """Process an answer, and ask again unless it was the last; the reason why it is no text, if it is none."""
        env, session = self.env, self.env.session
        odd = "" if isinstance(said, str) else f"the policy must answer with a text, got {_shown(said)}"
        text = "" if odd else storable(said)
        action: str | ParseFailure = self._talk.answer(text)
        if odd:
            action = unread("", session.world, odd)
        observation, reward, _, _, _ = env.step(action)
        moment = session.moment
        failed = moment.action if type(moment.action) is ParseFailure else None
        self.turns.append(
            RolloutTurn(
                prompt=self.prompt,
                answer=text,
                reward=reward,
                regret=turn_regret(session.teacher.oracle, moment),
                success=moment.success,
                failure=failed and failed.why,
                feedback=f"{observation['feedback']}",
            )
        )
        self.over = session.done
        if not self.over:
            self.prompt = self._talk.ask(observation)
        return [odd] if odd else []


def _cross(subjects: Sequence[str | Subject], seeds: Sequence[int]) -> Iterator[tuple[str | Subject, int]]:
    return ((subject, seed) for subject in subjects for seed in seeds)


def _environment(subject: str | Subject, settings: dict[str, Any]) -> StudentEnv:
    door: Callable[..., StudentEnv] = make if isinstance(subject, str) else StudentEnv
    return door(subject, text=True, **copy.deepcopy(settings))  # a custom teacher holds the state of one episode


def _answered(turn: RolloutTurn) -> list[Message]:
    return [*turn.prompt, {"role": "assistant", "content": turn.answer}]


def _answering(policy: Callable[..., Any] | ChatStudent) -> Callable[[list[list[Message]]], list[Any]]:
    """A policy as a function of a batch; an error of one conversation is its answer."""
    if not callable(policy) and not isinstance(policy, ChatStudent):
        raise ValueError(f"policy must be a function of conversations or come from chat_student, got {policy!r}")
    function: Any = policy.function if isinstance(policy, ChatStudent) else policy
    alone = isinstance(policy, ChatStudent) or next(iter(inspect.signature(function).parameters), "") in _ONE

    def answer(conversations: list[list[Message]]) -> list[Any]:
        # The policy gets its own: one that adds its answer to the messages would change the record.
        conversations = [[{**message} for message in messages] for messages in conversations]
        if alone:
            listed = takes_messages(function)
            prompts = [messages if listed else as_prompt(messages) for messages in conversations]
            said = all_awaited([_call(function, prompt) for prompt in prompts])
            for each in said:
                if isinstance(each, BaseException) and not _is_of_one_turn(each):
                    raise each
            return said
        number = len(conversations)
        said = awaited(function(conversations))
        if not isinstance(said, list | tuple) or len(said) != number:
            raise TypeError(
                f"policy must return a list of {number} texts, one per conversation, got {said!r:.80}; "
                "for a function of one conversation call its parameter `prompt` or `messages`, or use chat_student"
            )
        return list(said)

    return answer


def _call(function: Callable[..., Any], prompt: Any) -> Any:
    """The function's answer, or its error."""
    try:
        return function(prompt)
    except Exception as error:  # a policy may raise anything
        return error


def _is_of_one_turn(error: BaseException) -> bool:
    """Whether other turns may go on: the endpoint answers others, and the policy does not wait for itself."""
    everywhere = isinstance(error, LLMError) and not isinstance(error, NoAnswerError)
    return isinstance(error, Exception) and not everywhere and not isinstance(error, WaitsForItselfError)


def _shown(said: Any) -> str:
    """An odd answer, for a message."""
    try:
        return f"{type(said).__name__}: {said!r:.200}"
    except Exception:  # its own `__repr__` may raise
        return type(said).__name__
