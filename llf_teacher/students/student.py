"""Students: policies for the student's seat, named by spec strings such as `q_learning(alpha=0.5)`.

A student is a frozen dataclass in a module of its name under `llf_teacher/students/builtin/`; a `Policy` beside it
plays. A policy has the rules of the world (spaces, words), never its state, and gets the information in `reads`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypedDict, TypeVar

import numpy as np
from gymnasium import spaces

from llf_teacher.models.asked import Asked
from llf_teacher.students import builtin
from pz_envs.learning import Learning
from pz_envs.subject import Subject
from teachers.spec import Spec
from worlds.world import World

READS = ("nothing", "reward", "words", "atoms", "atoms and reward", "truth")
TAUGHT = ("words", "atoms", "atoms and reward")
"""Values of `reads` of students that feedback can change."""


class ModelReply(TypedDict, total=False):
    """A model's answer in a turn and its cost, as a record keeps them; every key is optional."""

    answer: str
    """The answer, without thoughts."""
    invented: str
    """The turns of others that the model invented, cut from the answer."""
    thought: str
    """The thoughts before it, if they were marked or in a separate field."""
    finish: str
    """Why the answer ended: `length` if it is incomplete."""
    form: str
    """The form that was asked for: `json`, `tool` or `text`."""
    asked: Asked
    """The messages that were sent, and the fields for the form; see `llf_teacher.models.asked`."""
    input_tokens: int
    output_tokens: int
    usd: float
    seconds: float
    """Time from the request to the reply."""


S_co = TypeVar("S_co", bound="Student", covariant=True)


class Policy(ABC, Generic[S_co]):
    """Plays in the student's seat: `reset(rng)`, then `act` once a turn.

    Args:
        spec: the student, for its parameters.
        family: the family of the environment.
        world: a scratch world with the environment's class and options, for its rules; it has no episode.
    """

    def __init__(self, spec: S_co, family: Subject, world: World[Any]) -> None:
        self.spec, self.family, self.world = spec, family, world
        self.reads, self.draws_worlds = spec.reads, spec.draws_worlds

    def __repr__(self) -> str:
        return f"<policy of {self.spec} in {self.family.name}>"

    @property
    def action_count(self) -> int:
        """The number of actions.

        Raises:
            ValueError: the action space is not discrete.
        """
        space = self.world.action_space
        if not isinstance(space, spaces.Discrete):
            raise ValueError(f"the student {self.spec} needs discrete actions; those of {self.family.name} are {space}")
        return int(space.n)

    @property
    def action_box(self) -> spaces.Box:
        """The box of the actions.

        Raises:
            ValueError: the action space is not a box.
        """
        space = self.world.action_space
        if not isinstance(space, spaces.Box):
            raise ValueError(f"the student {self.spec} needs actions in a box; those of {self.family.name} are {space}")
        return space

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""
        self.rng = rng
        self.begin()

    def begin(self) -> None:
        """Set up the memory of an episode."""

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the end of an episode; arguments as in `act`.

        It is called before the next episode, if a student has several.
        """

    def did(self, action: Any) -> None:
        """Note that a trait has replaced the last action of `act` by this one.

        Policies that remember their actions override it.
        """

    def succeed(self, past: "Policy[Any]") -> None:
        """Take over what the same student's old policy could not forget; by default nothing."""

    def record(self) -> ModelReply:
        """The answer and the cost of the last action, for students that ask a model; empty for others."""
        return {}

    @abstractmethod
    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The next action.

        Args:
            observation: of the student's seat: `state` (or `observation`), `instruction`, `feedback`.
            info: the info from `SeatsEnv.info_for`.
        """


class Student(Spec, ABC):
    """Base of all students: a frozen value that makes a `Policy` for a seat."""

    package: ClassVar[str] = builtin.__name__
    policy: ClassVar[type[Policy[Any]]]
    """The class of its policy."""
    suits: ClassVar[type[Learning] | None] = None
    """The kind of learning from rewards that suits it; the fields of this class are parameters of the student."""
    searches: ClassVar[bool] = False
    """Whether its method needs the reward of each proposed action, so that no trait may change its actions."""
    batch: ClassVar[str] = ""
    """Its policy in arrays: a class of the module of its name in `llf_teacher.students.batches`; empty: none."""

    # A subclass sets these, as in `reads = "words"`, or computes them from its parameters, as a property.

    @property
    @abstractmethod
    def reads(self) -> str:
        """The information that it uses, one of `READS`; reports show it."""

    @property
    def draws_worlds(self) -> bool:
        """Whether it draws worlds that it cannot distinguish from its own, which needs a family with a posterior."""
        return False

    @property
    def needs_discrete(self) -> bool:
        """Whether it needs discrete actions, which not all families have."""
        return False

    @property
    def text(self) -> bool:
        """Whether it plays in text mode: text in, text out."""
        return False

    @property
    def remembers(self) -> bool:
        """Whether its policy can use what it learned in earlier episodes; by default if `forget` is False."""
        return not getattr(self, "forget", True)

    def seat(self, family: Subject, world: World[Any]) -> Policy[Any]:
        """A policy for environments like `world`; it gets a scratch copy."""
        return self.policy(self, family, world.scratch())

    def check(self, environment: Mapping[str, str]) -> None:
        """Check, before a study begins, that it can play here. By default it always can.

        Raises:
            ValueError: a setting is missing or not allowed.
            ModuleNotFoundError: an extra is not installed; the message has the pip line.
        """

    def facts(self) -> dict[str, Any]:
        """Entries for a study's manifest, as JSON values."""
        return {}


def state_of(observation: dict[str, Any]) -> Any:
    """The world's part of an observation, of the seat or of an adapter."""
    return observation["state"] if "state" in observation else observation["observation"]


def frozen(value: Any) -> Any:
    """A hashable value that is equal for equal observations or actions."""
    if isinstance(value, dict):
        return tuple((key, frozen(item)) for key, item in value.items())
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    return tuple(map(frozen, value)) if isinstance(value, list | tuple) else value
