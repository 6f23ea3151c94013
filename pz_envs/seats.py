"""What all environments with seats for teachers and students have in common."""

from abc import abstractmethod
from typing import Any

from gymnasium import spaces
from pettingzoo import AECEnv
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from pz_envs.settings import RENDER_MODES
from pz_envs.student_view import info_for
from pz_envs.window import FPS, Renderer
from teachers.atoms import Moment
from worlds.pictures.canvas import Frame
from worlds.world import World

TEACHER, STUDENT = "teacher_0", "student_0"


def role_of(agent: str) -> str:
    """What an agent is, `teacher` or `student`."""
    return agent.rpartition("_")[0]


def known_options(options: dict[str, Any] | None, world: World[Any]) -> dict[str, Any] | None:
    """The options of a reset that a world has. PettingZoo's own checkers give others, which are ignored."""
    if options is None or world.reset_options is None:
        return options
    return {name: value for name, value in options.items() if name in world.reset_options}


class SeatsEnv(AECEnv):
    """An AEC environment that can be shown, as text or as a picture.

    Args:
        name: for `metadata`.
        speech: what a teacher's action is, one of `pz_envs.settings.SPEECHES`.
        render_mode: None, `ansi`, `rgb_array` or `human`, a window.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's convention)
        "render_modes": [*RENDER_MODES],
        "name": "seats_v0",
        "is_parallelizable": False,
        "render_fps": FPS,
    }

    max_turns: int
    """Actions that a student has in an episode."""
    label: str
    """The id by which it was made, or what is taught."""

    def __init__(self, name: str, speech: str, render_mode: str | None) -> None:
        self.metadata = {**self.metadata, "name": f"{name}_v0"}
        self.label = name
        self.speech, self.render_mode = speech, render_mode
        self._renderer = Renderer(render_mode, self.metadata["name"], self.as_text, self.frame)
        self.agents: list[str] = []
        self.observation_spaces: dict[str, spaces.Space[Any]] = {}
        self.action_spaces: dict[str, spaces.Space[Any]] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.label} speech={self.speech!r} {self._parties()}>"

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
        if self.render_mode == "human":
            self.render()

    def render(self) -> str | Frame | None:
        """In mode `ansi` what `as_text` says, in mode `rgb_array` the `frame`; in mode `human` it is shown in a window.

        Raises:
            RuntimeError: in mode `human` there is no display.
        """
        return self._renderer.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._renderer.close()

    @abstractmethod
    def moment_of(self, student: str) -> Moment[Any]:
        """A student's last turn, as its teacher sees it: privileged."""

    def turns_left(self, student: str = STUDENT) -> int:
        """How many actions a student has yet, if nothing else ends its episode."""
        return self.max_turns - self.moment_of(student).turn

    @property
    @abstractmethod
    def truth_now(self) -> Any:
        """The truth of the world as it is, or that of each world: with it `start_next_episode` can begin."""

    @abstractmethod
    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson: the streams go on, and what was spent of a budget stays spent.

        Args:
            start: the truth to begin with, as of `truth_now`; None: as a reset of the world draws it.
            options: the world's.
        """

    @abstractmethod
    def as_text(self) -> str:
        """The state of affairs for human eyes, in words."""

    @abstractmethod
    def frame(self) -> Frame:
        """The state of affairs for human eyes, uint8 (height, width, 3).

        Raises:
            RuntimeError: the environment was made without a render mode.
        """

    @abstractmethod
    def _parties(self) -> str:
        """The teachers and the students, for `repr`."""

    @abstractmethod
    def _act(self, agent: str, action: Any) -> None:
        """The turn of an agent that has not ended."""

    def _open(self) -> None:
        """Enter all agents at the beginning of an episode; infos are up to the environment."""
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {}
        self._skip_agent_selection = None


class OrderEnforcing(OrderEnforcingWrapper):
    """PettingZoo's check of the calling order, with a `repr` of what it wraps."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.env!r}>"


def entitled(policy: Any, env: SeatsEnv, student: str = STUDENT) -> dict[str, Any]:
    """The info that a policy in a student's seat of an environment may see; see `info_for`."""
    return info_for(policy, env.infos[student], env.turns_left(student), env.moment_of(student))
