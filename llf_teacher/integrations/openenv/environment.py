"""An environment with a teacher for OpenEnv's server."""

from typing import Any
from uuid import uuid4

from openenv.core.env_server.interfaces import Environment
from openenv.core.env_server.types import EnvironmentMetadata, State

import llf_teacher
from llf_teacher.gym import StudentEnv
from llf_teacher.integrations.openenv.models import FeedbackAction, FeedbackObservation
from teachers.atoms import ParseFailure
from teachers.personality import parse_personality

SEEDS = 1000
"""Tasks of each environment in a split."""
_FIRST = {"train": 0, "test": 1_000_000}  # seed of each split
_BUTTONS = 12  # greatest number of buttons on the web page
_SETTINGS = ("teacher", "feedback_type", "instruction_type", "max_turns")  # settings that clients may choose


class FeedbackServerEnvironment(Environment[FeedbackAction, FeedbackObservation, State]):
    """The environment of a client's session. A task, named by split and index, is an environment's id and a seed."""

    SUPPORTS_CONCURRENT_SESSIONS = True

    def __init__(self) -> None:
        super().__init__()
        self._state = State(episode_id=None, step_count=0)
        self._env: StudentEnv | None = None
        self._made: tuple[Any, ...] = ()

    def list_splits(self) -> list[str]:
        """The splits, `train` and `test`, which have different seeds."""
        return list(_FIRST)

    def num_tasks(self, split: str) -> int:
        """The number of tasks in a split."""
        _first(split)
        return len(llf_teacher.ids()) * SEEDS

    def get_task(self, split: str, index: int) -> dict[str, Any]:
        """A task; successive tasks have successive environments.

        Raises:
            IndexError: there is no such task.
        """
        first, ids = _first(split), llf_teacher.ids()
        if not 0 <= index < self.num_tasks(split):
            raise IndexError(f"index must be from 0 to {self.num_tasks(split) - 1}, got {index}")
        return {"task": f"{split}-{index}", "id": ids[index % len(ids)], "seed": first + index // len(ids)}

    def list_tasks(self, split: str) -> list[dict[str, Any]]:
        """The first task of each environment."""
        return [self.get_task(split, index) for index in range(len(llf_teacher.ids()))]

    def reset(
        self,
        seed: int | None = None,
        episode_id: str | None = None,
        *,
        split: str = "train",
        index: int | None = None,
        id: str = "",
        **others: Any,
    ) -> FeedbackObservation:
        """Begin an episode of a task, or of an id (by default the first) and a seed.

        Args:
            seed: the seed of the episode, without a task.
            episode_id: name of the episode; None: a new name.
            split, index: the task.
            id: the id of the environment, without a task.
            others: may have the settings `teacher`, `feedback_type`, `instruction_type` and `max_turns`; the rest is
                ignored.

        Raises:
            ValueError: a setting is not allowed.
        """
        settings = {name: others[name] for name in _SETTINGS if name in others}
        teacher = settings.get("teacher", "")
        if index is not None:
            task = self.get_task(split, index)
            id, seed = task["id"], task["seed"]
        id = id or llf_teacher.ids()[0]
        if id.count(":") > 1:
            raise ValueError(f"id must name an environment alone, got {id!r}; a server imports nothing for clients")
        if not isinstance(teacher, str) or ":" in teacher:
            raise ValueError(
                f"teacher must be a spec of `llf list`, got {teacher!r}; a server imports nothing for clients"
            )
        made = (id, settings)
        if self._env is None or made != self._made:
            # Clients name personalities alone: a model as the teacher would cost the server's owner money.
            own = {"teacher": parse_personality(teacher)} if "teacher" in settings else {}
            env = llf_teacher.make(id, text=True, **settings | own)
            self.close()
            self._env, self._made = env, made
        observation, info = self._env.reset(seed=seed)
        self._state = State(episode_id=episode_id or f"{uuid4()}", step_count=0)
        return _observation(observation, info, 0.0, False, None)

    def step(self, action: FeedbackAction, timeout_s: float | None = None, **others: Any) -> FeedbackObservation:
        """Act; then the teacher speaks."""
        if self._env is None:
            raise RuntimeError("there is no episode; call reset before step, in the same session")
        observation, reward, terminated, truncated, info = self._env.step(action.text)
        self._state.step_count += 1
        acted = self._env.session.moment.action
        failure = acted.why if type(acted) is ParseFailure else None
        return _observation(observation, info, reward, terminated or truncated, failure)

    @property
    def state(self) -> State:
        """The name of the episode, and its number of turns."""
        return self._state

    def get_metadata(self) -> EnvironmentMetadata:
        """The server's description."""
        return EnvironmentMetadata(
            name="llf_teacher",
            description="Worlds in which a student learns from what a teacher says: learning from language feedback.",
            version=llf_teacher.__version__,
        )

    def web_actions(self, observation: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
        """A button for each word that names an action, if there are at most 12."""
        words = [] if self._env is None else list(self._env.session.world.action_words)
        return [(word, {"text": word}) for word in words] if len(words) <= _BUTTONS else []

    def close(self) -> None:
        """Close the world."""
        if self._env is not None:
            self._env.close()
            self._env = None


def _first(split: str) -> int:
    if split not in _FIRST:
        raise ValueError(f"split must be one of {', '.join(_FIRST)}, got {split!r}")
    return _FIRST[split]


def _observation(
    observation: dict[str, Any], info: dict[str, Any], reward: float, done: bool, failure: str | None
) -> FeedbackObservation:
    texts = {name: f"{text}" for name, text in observation.items()}
    kinds = [f"{atom.kind}" for atom in info["atoms"] if atom.kind is not None]
    metadata = {"success": bool(info["success"]), "kinds": kinds, "failure": failure}
    return FeedbackObservation(**texts, reward=float(reward), done=bool(done), metadata=metadata)
