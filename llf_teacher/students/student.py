"""Students: policies for the student's seat, named by spec strings such as `q_learning(alpha=0.5)`.

A student is a frozen dataclass in a module of its name under `llf_teacher/students/builtin/`; a `Policy` beside it
plays. A policy knows the rules of the world (spaces, words), never its state, and reads what it says it reads.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypedDict, TypeVar

import numpy as np
from gymnasium import spaces

from llf_teacher.students import builtin
from pz_envs.learning import Learning
from pz_envs.subject import Subject
from teachers.spec import Spec
from worlds.world import World

READS = ("nothing", "reward", "words", "atoms", "atoms and reward", "truth")
TAUGHT = ("words", "atoms", "atoms and reward")
"""What a student reads whom a teacher can reach."""


class Telling(TypedDict, total=False):
    """What a model said in a turn and what that cost, as a record keeps it; all of it may be lacking."""

    answer: str
    """Its words, without thoughts."""
    thought: str
    """What it thought before, where that was marked or given apart."""
    finish: str
    """Why it ended: `length` if it had not come to its end."""
    input_tokens: int
    output_tokens: int
    usd: float
    seconds: float
    """From asking to having the answer."""


S_co = TypeVar("S_co", bound="Student", covariant=True)


class Policy(ABC, Generic[S_co]):
    """Plays in the student's seat: `reset(rng)`, then `act` once a turn.

    Args:
        spec: the student, for its parameters.
        family: the family of the environment.
        world: a scratch world of the environment's class and options, for its rules; it knows no episode.
    """

    def __init__(self, spec: S_co, family: Subject, world: World[Any]) -> None:
        self.spec, self.family, self.world = spec, family, world
        self.reads = spec.reads

    def __repr__(self) -> str:
        return f"<policy of {self.spec} in {self.family.name}>"

    @property
    def action_count(self) -> int:
        """How many actions there are.

        Raises:
            ValueError: they are not finitely many.
        """
        space = self.world.action_space
        if not isinstance(space, spaces.Discrete):
            raise ValueError(f"the student {self.spec} needs discrete actions; those of {self.family.name} are {space}")
        return int(space.n)

    @property
    def action_box(self) -> spaces.Box:
        """The box of the actions.

        Raises:
            ValueError: they are no points of a box.
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
        """Set up what is to be remembered within the episode."""

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Take the end of an episode to heart, before the next one; arguments as in `act`.

        It is called where a student has more than one episode.
        """

    def record(self) -> Telling:
        """What the last action cost, of a student that asks a model; of others nothing."""
        return {}

    @abstractmethod
    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The next action.

        Args:
            observation: what the student's seat observes: `state` (or `observation`), `instruction`, `feedback`.
            info: what `entitled` gives.
        """


class Student(Spec, ABC):
    """Base of all students: a frozen value that makes a `Policy` for a seat."""

    shelf: ClassVar[str] = builtin.__name__
    policy: ClassVar[type[Policy[Any]]]
    """What it is in a seat."""
    suits: ClassVar[type[Learning] | None] = None
    """What it can learn from rewards alone; the fields of that are parameters of the student."""
    batch: ClassVar[str] = ""
    """Its seats in arrays: a class of the module of its name in `llf_teacher.students.batches`; empty: it has none."""

    # A subclass sets these, as in `reads = "words"`, or works them out of its parameters, as a property.

    @property
    @abstractmethod
    def reads(self) -> str:
        """What it learns from, one of `READS`; reports show it."""

    @property
    def text(self) -> bool:
        """Whether it plays in text mode: text in, text out."""
        return False

    @property
    def remembers(self) -> bool:
        """Whether its policy may know in an episode what it learnt in those before."""
        return False

    def seat(self, family: Subject, world: World[Any]) -> Policy[Any]:
        """A policy for environments like `world`; it gets a scratch copy."""
        return self.policy(self, family, world.scratch())

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure, before a study begins, that it can play here; a student that needs nothing always can.

        Raises:
            ValueError: a setting is missing or not allowed.
            ModuleNotFoundError: an extra is not installed; the message has the pip line.
        """

    def facts(self) -> dict[str, Any]:
        """What a study's manifest has to say of it beside its spec, as JSON values."""
        return {}


def state_of(observation: dict[str, Any]) -> Any:
    """The world's part of an observation, whichever adapter it came through."""
    return observation["state"] if "state" in observation else observation["observation"]


def frozen(value: Any) -> Any:
    """A hashable stand-in that is equal for equal observations or actions."""
    if isinstance(value, dict):
        return tuple((key, frozen(item)) for key, item in value.items())
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    return tuple(map(frozen, value)) if isinstance(value, list | tuple) else value
