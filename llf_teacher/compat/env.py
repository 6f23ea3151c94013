"""Environments as LLF-Bench makes them."""

import pkgutil
import warnings
from collections.abc import Iterable
from importlib import import_module
from typing import Any, ClassVar, SupportsFloat

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from llf_teacher.compat import families
from llf_teacher.compat.llf_env import Forwarding, LLFWrapper
from llf_teacher.gym import StudentEnv
from llf_teacher.gym.make import make as make_student_env
from llf_teacher.registry import entry, supported_types
from llf_teacher.students.agents import as_answer
from teachers.feedback import parse_kinds
from teachers.phrasebook import Paraphrase

__all__ = ["LLFEnv", "make"]


def make(
    env_name: str,
    *,
    instruction_type: str = "b",
    feedback_type: str | Iterable[str] = "a",
    visual: bool = False,
    seed: int | None = None,
    warning: bool = True,
    **options: Any,
) -> "LLFEnv":
    """An environment as LLF-Bench makes it.

    Args:
        env_name: an id `llf-...` or `verbal-...`.
        instruction_type: `b`, `p` or `c`.
        feedback_type: `a`, `n`, `m`, a kind, or a set, list or tuple of kinds.
        visual: ask for images, in families with images.
        seed: the seed of the first reset, unless that gets its own.
        warning: whether an alias gives a warning.
        options: other keywords of `llf_teacher.make`, such as `teacher`.

    Raises:
        ValueError: the id is unknown, or an argument is not allowed.
    """
    with warnings.catch_warnings():
        if not warning:
            warnings.simplefilter("ignore")
        found = entry(env_name)
    if visual and not found.family.visual:
        raise ValueError(f"visual=True is not supported by {env_name}: its world has no images; allowed: False")
    env = make_student_env(
        found.id, instruction_type=instruction_type, feedback_type=feedback_type, visual=visual, text=True, **options
    )
    made = _surface(found.family.name)(env)
    made.seed(seed)
    return made


class LLFEnv(LLFWrapper):
    """The environment that `make` returns: actions are native or texts, and absent texts are `None`.

    A family with LLF-Bench's own observations, spaces or words has a subclass `Surface` in the module of its name in
    `llf_teacher.compat.families`.
    """

    failure_reward: ClassVar[float] = 0.0
    """LLF-Bench's reward for a text that is not an action, unless `make` sets another `failure_reward`."""

    def __init__(self, env: StudentEnv) -> None:
        Forwarding.__init__(self, env)
        self._student: StudentEnv = env.unwrapped  # type: ignore[assignment]  # below Gymnasium's wrappers
        self._seed = None
        self.INSTRUCTION_TYPES, self.FEEDBACK_TYPES = supported_types(
            self._student.env_id, **self._student.settings.options
        )
        self.action_space = self._actions()
        words = self._student.student_view.words_space
        self.observation_space = spaces.Dict(
            {"observation": self._observations(), "instruction": words["instruction"], "feedback": words["feedback"]}
        )

    @property
    def _world(self) -> Any:
        return self._student.session.world

    def _actions(self) -> spaces.Space[Any]:
        """The space of native actions."""
        space: spaces.Space[Any] = self._world.action_space
        return space

    def _observations(self) -> spaces.Space[Any]:
        """The space of observations."""
        return self._student.student_view.words_space["state"]

    def _observe(self, text: str) -> Any:
        """The observation: by default the text, or None if it is empty."""
        return text or None

    def _instruct(self, instruction: str) -> str:
        """The instruction in LLF-Bench's form."""
        return instruction

    @property
    def reward_range(self) -> tuple[float, float]:
        """Least and greatest reward of one step."""
        return self._student.reward_range

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
    def expert_action(self) -> Any:
        """The next action of an optimal policy, natively, or None.

        Raises:
            ResetNeeded: before the first reset.
        """
        session = self._student.session
        if not hasattr(session, "moment"):
            raise ResetNeeded("there is no expert action before the first episode; call reset() first")
        plan = session.teacher.oracle.plan(session.moment.after, 1)
        if not plan:
            return None
        if isinstance(self.action_space, spaces.Box):
            return np.array(plan[0])
        return int(plan[0]) if isinstance(plan[0], int) else plan[0]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the observation has an instruction and no feedback."""
        seed, self._seed = self._seed if seed is None else seed, None
        observation, info = self.env.reset(seed=seed, options=options)
        seen, instruction = self._observe(observation["observation"]), self._instruct(observation["instruction"])
        return {"observation": seen, "instruction": instruction, "feedback": None}, self._informed(info)

    def step(self, action: Any) -> tuple[dict[str, Any], SupportsFloat, bool, bool, dict[str, Any]]:
        """Act, natively or in words; the observation has feedback and no instruction.

        A text that is not an action costs a turn, and the feedback says what was expected.
        """
        observation, reward, terminated, truncated, info = self.env.step(as_answer(action, self._student.session.world))
        if "parse_failure" in info and self._student.session.failure_reward is None:
            reward = self.failure_reward
        seen = self._observe(observation["observation"])
        observed = {"observation": seen, "instruction": None, "feedback": observation["feedback"]}
        return observed, reward, terminated, truncated, self._informed(info)

    def _informed(self, info: dict[str, Any]) -> dict[str, Any]:
        """The info with `expert_action`, which LLF-Bench has in some families."""
        return info | {"expert_action": self.expert_action}


def _surface(family: str) -> type[LLFEnv]:
    """The class of a family's environments."""
    if family not in {module.name for module in pkgutil.iter_modules(families.__path__)}:
        return LLFEnv
    surface: type[LLFEnv] = import_module(f"{families.__name__}.{family}").Surface
    return surface
