"""LLF-Bench's `LLFWrapper` and `Feedback`, for users' own environments."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
from gymnasium import spaces

from teachers.atoms import KINDS
from teachers.feedback import ALL, MIXED, draw_kinds, parse_kinds
from teachers.phrasebook import Paraphrase, check_paraphrase
from teachers.teacher_turn import LONGEST
from worlds.spaces import Prose

__all__ = ["Feedback", "LLFWrapper"]

_NAMED = (ALL, "n", MIXED)


@dataclass
class Feedback:
    """The feedback of a turn by kind; None for a kind without feedback."""

    r: str | None = None
    """The reward in words."""
    hp: str | None = None
    """Hindsight positive: what was right."""
    hn: str | None = None
    """Hindsight negative: what was wrong."""
    fp: str | None = None
    """Future positive: what to do next."""
    fn: str | None = None
    """Future negative: what not to do next."""

    def asdict(self) -> dict[str, str | None]:
        """The texts by kind."""
        return asdict(self)

    def __getitem__(self, kind: str) -> str | None:
        return self.asdict()[kind]

    def __setitem__(self, kind: str, text: str | None) -> None:
        self[kind]  # a KeyError if there is no such kind
        setattr(self, kind, text)

    def __delitem__(self, kind: str) -> None:
        self[kind] = None

    def __contains__(self, kind: object) -> bool:
        return kind in self.asdict()


class Forwarding(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A wrapper with the attributes of the wrapped environment, as before Gymnasium 1.0."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.env, name)


class LLFWrapper(Forwarding):
    """An environment with instructions and feedback; a subclass defines `_reset` and `_step`.

    Both return observations that are dicts of `observation`, `instruction` and `feedback`; after a step `feedback` is a
    `Feedback` with only the kinds that `_feedback_type` allows. The info has `success`.

    Args:
        env: the environment that is wrapped.
        instruction_type: one of `INSTRUCTION_TYPES`.
        feedback_type: `a` all, `n` none, `m` a random subset each turn, or kinds of `FEEDBACK_TYPES`.

    Raises:
        ValueError: a type is not supported.
    """

    INSTRUCTION_TYPES: Sequence[str] = ("b", "p", "c")
    """The instruction types that the environment supports."""
    FEEDBACK_TYPES: Sequence[str] = tuple(kind.value for kind in KINDS)
    """The kinds of feedback that the environment supports."""

    def __init__(
        self, env: gymnasium.Env[Any, Any], instruction_type: str = "b", feedback_type: str | Iterable[str] = "a"
    ) -> None:
        super().__init__(env)
        self._rng = np.random.default_rng()
        self._seed: int | None = None
        self.set_instruction_type(instruction_type)
        self.set_feedback_type(feedback_type)
        self.set_paraphrase_method("random")
        self.observation_space = spaces.Dict(
            {"observation": env.observation_space, "instruction": Prose(LONGEST), "feedback": Prose(LONGEST)}
        )

    @property
    def instruction_type(self) -> str:
        """The type of the instruction that reset gives."""
        return self._instruction_type

    def set_instruction_type(self, instruction_type: str) -> None:
        """Change the instruction type from the next reset on."""
        if instruction_type not in self.INSTRUCTION_TYPES:
            allowed = ", ".join(self.INSTRUCTION_TYPES)
            raise ValueError(f"instruction type {instruction_type!r} is not supported; allowed: {allowed}")
        self._instruction_type = instruction_type

    @property
    def feedback_type(self) -> str | set[str]:
        """The feedback type: `a`, `n`, `m`, or the set of kinds."""
        return self._feedback if isinstance(self._feedback, str) else set(self._feedback)

    def set_feedback_type(self, feedback_type: str | Iterable[str]) -> None:
        """Change the feedback type from the next step on."""
        kinds = {kind.value for kind in parse_kinds(feedback_type)}
        named = isinstance(feedback_type, str) and feedback_type in _NAMED
        if not named and not kinds <= set(self.FEEDBACK_TYPES):
            allowed = f"a, n, m, and of {', '.join(self.FEEDBACK_TYPES)}"
            raise ValueError(f"feedback type {feedback_type!r} is not supported; allowed: {allowed}")
        self._feedback: str | set[str] = str(feedback_type) if named else kinds
        self._draw()

    @property
    def _feedback_type(self) -> set[str]:
        """The kinds that are allowed in this turn."""
        return set(self._wanted)

    @property
    def paraphrase_method(self) -> Paraphrase:
        """How paraphrases are chosen."""
        return self._paraphrase

    def set_paraphrase_method(self, method: Paraphrase) -> None:
        """Choose paraphrases by `"random"`, an index (modulo their number) or `(templates, **slots) -> str`."""
        self._paraphrase = check_paraphrase(method)

    def format(self, prompts: Sequence[str], **slots: Any) -> str:
        """One of several paraphrases, formatted."""
        method = self._paraphrase
        if callable(method):
            chosen: Callable[..., str] = method
            return chosen(list(prompts), **slots)
        number = method if isinstance(method, int) else int(self._rng.integers(len(prompts)))
        return prompts[number % len(prompts)].format(**slots)

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Seed the next reset, unless that gets its own seed."""
        self._seed = seed
        return [seed]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the observation has an instruction and no feedback."""
        seed, self._seed = self._seed if seed is None else seed, None
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        self._draw()
        observation, info = self._reset(seed=seed, options=options)
        if observation["instruction"] is None or observation["feedback"] is not None:
            raise ValueError(f"{type(self).__name__}._reset must give an instruction and no feedback: {observation!r}")
        return observation, info

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act; the observation has feedback."""
        self._draw()
        observation, reward, terminated, truncated, info = self._step(action)
        feedback = observation["feedback"]
        if isinstance(feedback, Feedback):
            observation = observation | {"feedback": self._verbalize_feedback(feedback)}
        if "success" not in info:
            raise ValueError(f"{type(self).__name__}._step must give `success` in the info, got {info!r}")
        return observation, reward, terminated, truncated, info

    def _reset(self, *, seed: int | None, options: dict[str, Any] | None) -> tuple[dict[str, Any], dict[str, Any]]:
        raise NotImplementedError(f"{type(self).__name__} must have _reset(*, seed, options)")

    def _step(self, action: Any) -> tuple[dict[str, Any], SupportsFloat, bool, bool, dict[str, Any]]:
        raise NotImplementedError(f"{type(self).__name__} must have _step(action)")

    def _verbalize_feedback(self, feedback: Feedback) -> str:
        """The texts in the order of the kinds."""
        said = [text for kind, text in feedback.asdict().items() if text is not None and kind in self._wanted]
        return "".join(text if text.endswith("\n") else f"{text} " for text in said)[:-1]

    def _draw(self) -> None:
        """Draw the kinds that are allowed in this turn."""
        if self._feedback == MIXED:
            able = frozenset(kind for kind in KINDS if kind.value in self.FEEDBACK_TYPES)
            self._wanted = {kind.value for kind in draw_kinds(able, self._rng)}
        else:
            self._wanted = {kind.value for kind in parse_kinds(self._feedback)} & set(self.FEEDBACK_TYPES)
