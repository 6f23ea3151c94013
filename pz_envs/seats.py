"""The base of the AEC environments with seats for teachers and students."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from pettingzoo import AECEnv
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from pz_envs.global_state import GlobalState, Seated, Shared
from pz_envs.numbers import Field, Flat
from pz_envs.settings import RENDER_MODES
from pz_envs.student_view import StudentView, info_for
from pz_envs.window import FPS, Renderer
from teachers.atoms import Moment
from teachers.schema import Message
from teachers.session import Session
from worlds.pictures.canvas import Frame
from worlds.world import World

TEACHER, STUDENT = "teacher_0", "student_0"
_NUMERIC = ("trimmed",)
_CHECKERS = {"options": 1}  # options of `pettingzoo.test`


def role_of(agent: str) -> str:
    """The role of an agent: `teacher` or `student`."""
    return agent.rpartition("_")[0]


def checked_options(options: dict[str, Any] | None, world: World[Any]) -> dict[str, Any] | None:
    """The options of a reset, without those that PettingZoo's checkers pass to every environment.

    Raises:
        ValueError: the world's `reset` does not take one.
    """
    if options == _CHECKERS:
        return None
    world.check_reset(options)
    return options


class SeatsEnv(AECEnv):
    """An AEC environment that renders as text or as an image.

    Args:
        name: for `metadata`.
        speech: the form of a teacher's action, one of `pz_envs.settings.SPEECHES`.
        render_mode: None, `ansi`, `rgb_array` or `human`, a window.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's convention)
        "render_modes": [*RENDER_MODES],
        "name": "seats_v0",
        "is_parallelizable": False,
        "render_fps": FPS,
    }

    max_turns: int
    """Greatest number of actions of a student in an episode."""

    def __init__(self, name: str, speech: str, render_mode: str | None) -> None:
        self.metadata = {**self.metadata}
        self.label = name
        self.speech, self.render_mode = speech, render_mode
        self._renderer = Renderer(render_mode, self.metadata["name"], self.as_text, self.frame)
        self._flat: dict[str, Flat] = {}  # for each teacher that observes one array
        self.agents: list[str] = []
        self._cumulative_rewards: dict[str, float] = {}
        self.observation_spaces: dict[str, spaces.Space[Any]] = {}
        self.action_spaces: dict[str, spaces.Space[Any]] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.label} speech={self.speech!r} {self._describe_seats()}>"

    @property
    def label(self) -> str:
        """The id of the environment, or the name of its subject, for `repr`; `metadata` has its name."""
        return self._label

    @label.setter
    def label(self, label: str) -> None:
        self._label = label
        name, dash, version = label.removeprefix("llf/").rpartition("-v")
        self.metadata["name"] = f"{name}_v{version}" if dash and version.isdigit() else f"{label}_v0"

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """The agent's observation space, the same object each time."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """The agent's action space, the same object each time."""
        return self.action_spaces[agent]

    def step(self, action: Any) -> None:
        """Let the agent whose turn it is act.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._was_dead_step(action)
            return
        self._act(agent, action)
        self._show_masks()
        if self.render_mode == "human":
            self.render()

    def _pay_all(self, actor: str, rewards: Mapping[str, float]) -> None:
        """Reset the actor's cumulative reward, then add the step's rewards."""
        self._cumulative_rewards[actor] = 0.0
        self.rewards = dict.fromkeys(self.agents, 0.0) | dict(rewards)
        for agent, reward in rewards.items():
            self._cumulative_rewards[agent] += reward

    def check_action(self, agent: str, action: Any) -> None:
        """Raise a ValueError if an agent's action is outside its space."""
        student = next((each.view for each in self.seated if each.student == agent), None)
        if student is not None:
            student.check(action)
        elif not isinstance(action, Mapping | Message) and not self.action_space(agent).contains(action):
            space = self.action_space(agent)
            raise ValueError(f"the action must be in {space}, got {action!r:.80}; the state is unchanged")

    def observe(self, agent: str) -> Any:
        """The agent's present observation."""
        observation = self._observe(agent)
        flat = self._flat.get(agent)
        return observation if flat is None else flat.of(observation)

    @abstractmethod
    def _observe(self, agent: str) -> Any:
        """The agent's present observation, before it becomes one array."""

    def flatten_teachers(self) -> None:
        """Let teachers observe one array; their infos keep only `action_mask` and `trimmed`, as libraries require.

        Raises:
            ValueError: they observe texts.
        """
        for agent in self.possible_agents:
            if role_of(agent) == role_of(TEACHER):
                flat = self._flat[agent] = Flat(self.observation_spaces[agent])
                self.observation_spaces[agent] = flat.space

    def fields_of(self, agent: str) -> tuple[Field, ...]:
        """The fields of an agent's observation if it is one array, else an empty tuple."""
        if agent in self._flat:
            return self._flat[agent].fields
        return next((each.view.fields for each in self.seated if each.student == agent), ())

    def _show_masks(self) -> None:
        """Leave only numbers in the infos of teachers that observe one array: the mask, and `trimmed`."""
        for agent in self._flat.keys() & self.infos.keys():
            left = {name: value for name, value in self.infos[agent].items() if name in _NUMERIC}
            self.infos[agent] = {**left, "action_mask": self._observe(agent)["action_mask"]}

    # The state of all seats.

    @property
    @abstractmethod
    def seated(self) -> Sequence[Seated]:
        """The students with their teachers."""

    def shared(self) -> list[Shared]:
        """Numbers about the whole environment that are part of its state."""
        return []

    @cached_property
    def _global_state(self) -> GlobalState:
        return GlobalState(self.possible_agents, self.seated, self.shared())

    @property
    def state_space(self) -> spaces.Box:
        """The space of `state`, the same object each time."""
        return self._global_state.space

    @property
    def state_fields(self) -> tuple[Field, ...]:
        """The fields of `state`, in their order."""
        return self._global_state.fields

    def state(self) -> npt.NDArray[np.float32]:
        """All seats and the oracle's values as one array, float32: privileged. See `pz_envs.global_state`."""
        return self._global_state.of(self.agent_selection, self.agents, self.shared())

    def render(self) -> str | Frame | None:
        """In mode `ansi` return `as_text()`, in mode `rgb_array` `frame()`; in mode `human` show the frame in a window.

        Raises:
            RuntimeError: in mode `human` there is no display.
        """
        return self._renderer.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._renderer.close()

    @abstractmethod
    def moment_of(self, student: str) -> Moment[Any]:
        """The last moment of a student: privileged."""

    def turns_left(self, student: str = STUDENT) -> int:
        """The student's remaining actions, if nothing else ends its episode."""
        return self.max_turns - self.moment_of(student).turn

    def info_for(self, policy: Any, student: str = STUDENT) -> dict[str, Any]:
        """The info that a policy in a student's seat may see; see `pz_envs.student_view.info_for`."""
        return info_for(policy, self.infos[student], self.turns_left(student), self.moment_of(student))

    @property
    @abstractmethod
    def current_truth(self) -> Any:
        """The current truth of the world, or a tuple with the truth of each world; see `start_next_episode`."""

    @abstractmethod
    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson: the streams go on, and spent budgets stay spent.

        Args:
            start: the truth to begin with, in the form of `current_truth`; None: the world's reset draws it.
            options: the world's.
        """

    @abstractmethod
    def as_text(self) -> str:
        """The last turn as text."""

    @abstractmethod
    def frame(self) -> Frame:
        """The last turn as an image, uint8 (height, width, 3).

        Raises:
            RuntimeError: the environment was made without a render mode.
        """

    @abstractmethod
    def _describe_seats(self) -> str:
        """The teachers and the students, for `repr`."""

    @abstractmethod
    def _act(self, agent: str, action: Any) -> None:
        """The turn of a live agent."""

    def _open(self) -> None:
        """Set PettingZoo's attributes for the beginning of an episode; the subclass sets the infos."""
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {}
        self._skip_agent_selection = None


class OneSessionEnv(SeatsEnv):
    """An AEC environment over one session, with the view of its student; for the other arguments see `SeatsEnv`."""

    def __init__(
        self, session: Session, student_view: StudentView, name: str, speech: str, render_mode: str | None
    ) -> None:
        super().__init__(name, speech, render_mode)
        self.session, self.student_view, self.max_turns = session, student_view, session.max_turns

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the world's."""
        self.session.open(seed, checked_options(options, self.session.world))
        self._enter()
        self._show_masks()

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson; see `SeatsEnv`."""
        self.session.start_next_episode(start, checked_options(options, self.session.world))
        self._enter()
        self._show_masks()

    @property
    def current_truth(self) -> Any:
        """The current truth of the world."""
        return self.session.moment.after

    def moment_of(self, student: str) -> Moment[Any]:
        """The student's last moment: privileged."""
        return self.session.moment

    def as_text(self) -> str:
        """The world and the teacher's last words; with a render mode the turn and the student's action, too."""
        return self.student_view.as_text()

    def frame(self) -> Frame:
        """The frame of the last turn, where each sentence of several teachers has its speaker, uint8 (480, 640, 3)."""
        return self.student_view.frame()

    def close(self) -> None:
        """Close the window and the world."""
        super().close()
        self.session.world.close()

    def _enter(self) -> None:
        """Seat the agents at the opening; the teachers are the next to act."""
        self._open()
        self.infos[STUDENT] = self.student_view.info()

    def _select_student(self) -> None:
        """Select the student, with the teachers' words in its info; a finished episode ends."""
        session = self.session
        if session.over:
            self.terminations = dict.fromkeys(self.agents, session.terminated)
            self.truncations = dict.fromkeys(self.agents, session.truncated)
        self.agent_selection = STUDENT


class OrderEnforcing(OrderEnforcingWrapper):
    """PettingZoo's check of the calling order, with the `repr` of the wrapped environment."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.env!r}>"
