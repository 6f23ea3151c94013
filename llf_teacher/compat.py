"""LLF-Bench's surface on our environments: `import llf_teacher.compat as llfbench`.

Observations are texts (None where a family has none), `None` stands for an absent instruction or feedback, actions
may be given natively or as text, and the attributes and methods that LLF-Bench's users rely on are on what
`make` returns, and on every wrapper here. `docs/coming-from-llf-bench.md` says what differs on purpose.
"""

import copy
from collections.abc import Iterable
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
from gymnasium import spaces

import llf_teacher
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import supported_types
from llf_teacher.students.agents import as_text
from teachers.feedback import parse_kinds
from teachers.phrasebook import Paraphrase

__all__ = [
    "FullInformationWrapper",
    "LLFEnv",
    "LLFWrapper",
    "RandomActionOrderWrapper",
    "TerminalFreeWrapper",
    "TextWrapper",
    "make",
    "supported_types",
]


def make(
    env_name: str,
    *,
    instruction_type: str = "b",
    feedback_type: str | Iterable[str] = "a",
    visual: bool = False,
    **options: Any,
) -> "LLFEnv":
    """An environment as LLF-Bench makes it.

    Args:
        env_name: an id `llf-...` or `verbal-...`.
        instruction_type: `b`, `p` or `c`.
        feedback_type: `a`, `n`, `m`, a kind, or a set, list or tuple of kinds.
        visual: ask for images where the family has them.
        options: whatever else `llf_teacher.make` takes, a `teacher` for instance.

    Raises:
        ValueError: an unknown id, or an argument that is not supported.
    """
    env = llf_teacher.make(
        env_name, instruction_type=instruction_type, feedback_type=feedback_type, visual=visual, text=True, **options
    )
    return LLFEnv(env)


class LLFWrapper(gymnasium.Wrapper):
    """Base of the wrappers: what LLF-Bench's users reach through any of them."""

    @property
    def _student(self) -> StudentEnv:
        return self.unwrapped  # type: ignore[return-value]

    @property
    def reward_range(self) -> tuple[float, float]:
        """Least and greatest reward of one step."""
        return self._student.reward_range

    @property
    def INSTRUCTION_TYPES(self) -> tuple[str, ...]:  # noqa: N802
        """The instruction types that the environment supports."""
        return supported_types(self._student.env_id)[0]

    @property
    def FEEDBACK_TYPES(self) -> tuple[str, ...]:  # noqa: N802
        """The kinds of feedback that the environment supports."""
        return supported_types(self._student.env_id)[1]

    @property
    def instruction_type(self) -> str:
        """The type of the instruction that reset gives."""
        return self._student.teacher.instruction_type

    def set_instruction_type(self, instruction_type: str) -> None:
        """Change the instruction type from the next reset on; a ValueError if it is not supported."""
        self._student.teacher.instruction_type = instruction_type

    @property
    def feedback_type(self) -> str | set[str]:
        """The feedback type: `a`, `n`, `m`, or the set of kinds."""
        value = self._student.teacher.feedback_type
        return value if value in ("a", "n", "m") else {kind.value for kind in parse_kinds(value)}

    def set_feedback_type(self, feedback_type: str | Iterable[str]) -> None:
        """Change the feedback type from the next step on; a ValueError if it is not supported."""
        self._student.teacher.feedback_type = feedback_type

    @property
    def paraphrase_method(self) -> Paraphrase:
        """How paraphrases are chosen."""
        return self._student.teacher.paraphrase

    def set_paraphrase_method(self, method: Paraphrase) -> None:
        """Choose paraphrases by `"random"`, an index (modulo their number) or `(templates, **slots) -> str`."""
        self._student.teacher.paraphrase = method

    @property
    def action_count(self) -> int:
        """The number of discrete actions.

        Raises:
            ValueError: the actions are not discrete.
        """
        space = self._student.aec.world.action_space
        if not isinstance(space, spaces.Discrete):
            raise ValueError(
                f"{type(self).__name__} needs discrete actions, got {space}; use it with another environment"
            )
        return int(space.n)


class LLFEnv(LLFWrapper):
    """What `make` returns: texts out, native actions or texts in, `None` for what is absent."""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the observation has an instruction and no feedback."""
        observation, info = self.env.reset(seed=seed, options=options)
        return self._absent(observation) | {"feedback": None}, self._expert(info)

    def step(self, action: Any) -> tuple[dict[str, Any], SupportsFloat, bool, bool, dict[str, Any]]:
        """Act, natively or in words; the observation has feedback and no instruction.

        An action that is none costs a turn, and the feedback says what was expected.
        """
        observation, reward, terminated, truncated, info = self.env.step(as_text(action))
        return self._absent(observation) | {"instruction": None}, reward, terminated, truncated, self._expert(info)

    def _absent(self, observation: dict[str, Any]) -> dict[str, Any]:
        return observation | {"observation": observation["observation"] or None}

    def _expert(self, info: dict[str, Any]) -> dict[str, Any]:
        """Add `expert_action`, which LLF-Bench has in some families: the next of an optimal policy, or None."""
        aec = self._student.aec
        plan = aec.teacher.oracle.plan(aec.moment.after, 1)
        expert = plan[0] if plan else None
        return info | {"expert_action": int(expert) if isinstance(expert, int) else expert}


class TextWrapper(LLFWrapper):
    """Text in; observations are texts already. It stands where LLF-Bench's users have it."""

    def step(self, action: str) -> tuple[dict[str, Any], SupportsFloat, bool, bool, dict[str, Any]]:
        """Act in words."""
        return self.env.step(str(action))


class TerminalFreeWrapper(LLFWrapper):
    """Episodes never end: success and the end of the horizon are told in the info only.

    The info has `terminated` and `truncated`, which the environment would have given. After its end it is asked no
    more: the last observation comes again, with reward 0.
    """

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode."""
        self._last: tuple[Any, dict[str, Any]] | None = None
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act; nothing ends."""
        if self._last is not None:
            observation, info = self._last
            return observation, 0.0, False, False, dict(info)
        observation, reward, terminated, truncated, info = self.env.step(action)
        info = info | {"terminated": terminated, "truncated": truncated}
        if terminated or truncated:
            self._last = observation, info
        return observation, reward, False, False, info


class RandomActionOrderWrapper(LLFWrapper):
    """The numbers of discrete actions change their meaning at each reset; names of actions keep theirs.

    Raises:
        ValueError: the actions are not discrete.
    """

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self._order = list(range(self.action_count))
        self._rng: np.random.Generator | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode with an order of its own."""
        if seed is not None or self._rng is None:
            self._rng = np.random.default_rng(seed)
        self._order = self._rng.permutation(self.action_count).tolist()
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._renumber(info)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act by the shuffled number."""
        text = as_text(action).strip()
        known = text.isascii() and text.isdigit() and int(text) < self.action_count
        observation, reward, terminated, truncated, info = self.env.step(self._order[int(text)] if known else action)
        return observation, reward, terminated, truncated, self._renumber(info)

    def _renumber(self, info: dict[str, Any]) -> dict[str, Any]:
        expert = info.get("expert_action")
        return info if expert is None else info | {"expert_action": self._order.index(expert)}


class FullInformationWrapper(LLFWrapper):
    """Adds to the info of each step what every discrete action would have given in its place.

    `full_information` is a list by action of dicts with `observation`, `reward`, `terminated`, `truncated` and `info`.

    Raises:
        ValueError: the actions are not discrete.
    """

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self._keys = ("observation", "reward", "terminated", "truncated", "info")
        self._count = self.action_count

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act, and see what else could have been."""
        outcomes = [
            dict(zip(self._keys, copy.deepcopy(self.env).step(other), strict=True)) for other in range(self._count)
        ]
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, info | {"full_information": outcomes}
