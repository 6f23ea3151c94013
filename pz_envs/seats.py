"""What all environments with seats for teachers and students have in common."""

from abc import abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import logger, spaces
from pettingzoo import AECEnv
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from teachers.atoms import Moment
from worlds.world import World

if TYPE_CHECKING:
    from pz_envs.window import Window
    from worlds.pictures.canvas import Frame

TEACHER, STUDENT = "teacher_0", "student_0"
SPEECHES = ("message", "kinds", "claims")
"""What a teacher's action can be: its own words, kinds of feedback to voice, or one claim after the other."""


def role_of(agent: str) -> str:
    """What an agent is, `teacher` or `student`."""
    return agent.rpartition("_")[0]


def check_flags(**flags: Any) -> None:
    """Check switches.

    Raises:
        ValueError: one is no truth value.
    """
    for name, value in flags.items():
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"{name} must be True or False, got {value!r}")


def known_options(options: dict[str, Any] | None, world: World[Any]) -> dict[str, Any] | None:
    """The options of a reset that a world knows. PettingZoo's own checkers give others, which no environment minds."""
    if options is None or world.reset_options is None:
        return options
    return {name: value for name, value in options.items() if name in world.reset_options}


class SeatsEnv(AECEnv):
    """An AEC environment that can be shown, as text or as a picture.

    Args:
        name: for `metadata`.
        speech: what a teacher's action is, one of `SPEECHES`.
        render_mode: None, `ansi`, `rgb_array` or `human`, a window.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's convention)
        "render_modes": ["ansi", "human", "rgb_array"],
        "name": "seats_v0",
        "is_parallelizable": False,
        "render_fps": 4,
    }

    max_turns: int
    """Actions that a student has in an episode."""
    label: str
    """The id by which it was made, or what is taught."""

    def __init__(self, name: str, speech: str, render_mode: str | None) -> None:
        if speech not in SPEECHES:
            raise ValueError(f"speech {speech!r} is unknown; allowed: {', '.join(SPEECHES)}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode {render_mode!r} is unknown; allowed: None, {allowed}")
        self.metadata = {**self.metadata, "name": f"{name}_v0"}
        self.label = name
        self.speech, self.render_mode = speech, render_mode
        self._window: Window | None = None
        self.agents: list[str] = []
        self.observation_spaces: dict[str, spaces.Space[Any]] = {}
        self.action_spaces: dict[str, spaces.Space[Any]] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.label} speech={self.speech!r} {self._company()}>"

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

    def render(self) -> "str | Frame | None":
        """In mode `ansi` what `as_text` says, in mode `rgb_array` the `frame`; in mode `human` it is shown in a window.

        Raises:
            RuntimeError: in mode `human` there is no display.
        """
        if self.render_mode is None:
            logger.warn(
                "render() shows nothing without a render mode; make the environment with one, as in "
                "render_mode='rgb_array'"
            )
            return None
        if self.render_mode == "ansi":
            return self.as_text()
        frame = self.frame()
        if self.render_mode == "rgb_array":
            return frame
        if self._window is None:
            from pz_envs.window import Window

            self._window = Window(self.metadata["name"], self.metadata["render_fps"])
        self._window.show(frame)
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    @abstractmethod
    def moment_of(self, student: str) -> Moment[Any]:
        """A student's last turn, as its teacher sees it: privileged."""

    def turns_left(self, student: str = STUDENT) -> int:
        """How many actions a student has yet, if nothing else ends its episode."""
        return self.max_turns - self.moment_of(student).turn

    @property
    @abstractmethod
    def truth_now(self) -> Any:
        """The truth of the world as it is, or that of each world: what `go_on` can begin with."""

    @abstractmethod
    def go_on(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson: the streams go on, and what was spent of a budget stays spent.

        Args:
            start: the truth to begin with, as of `truth_now`; None: as a reset of the world draws it.
            options: the world's.
        """

    @abstractmethod
    def as_text(self) -> str:
        """The state of affairs for human eyes, in words."""

    def frame(self) -> "Frame":
        """The state of affairs for human eyes, uint8 (height, width, 3).

        Raises:
            RuntimeError: the environment was made in another way than by `raw_env` with a render mode.
        """
        raise RuntimeError(
            f"a bare {type(self).__name__} keeps nothing to draw; make it by raw_env(render_mode='rgb_array')"
        )

    @abstractmethod
    def _company(self) -> str:
        """Who teaches, and whom, for `repr`."""

    @abstractmethod
    def _act(self, agent: str, action: Any) -> None:
        """The turn of an agent that is alive."""

    def _open(self) -> None:
        """Seat everybody at the beginning of an episode; infos are up to the environment."""
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {}
        self._skip_agent_selection = None


class OrderEnforcing(OrderEnforcingWrapper):
    """PettingZoo's check of the calling order, which says what it wraps."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.env!r}>"


def entitled(policy: Any, env: SeatsEnv, student: str = STUDENT) -> dict[str, Any]:
    """The info that a policy in a student's seat may see.

    That is the seat's own with `turns_left`, less the atoms for a reader of words, and with `reward` (of its last turn;
    with the atoms for a reader of advice) or the privileged `moment` for one that learns from these; see `reads` of
    students.
    """
    return told(policy, env.infos[student], env.turns_left(student), env.moment_of(student))


def told(policy: Any, info: dict[str, Any], turns_left: int, moment: Moment[Any]) -> dict[str, Any]:
    """The info that a policy in a student's seat may see, as in `entitled`, of a seat's own info and last turn."""
    info = {**info, "turns_left": turns_left}
    reads = getattr(policy, "reads", "atoms")
    if reads in ("nothing", "reward", "words"):
        info.pop("atoms", None)  # there are none before the teacher has spoken
    if reads in ("reward", "atoms and reward"):
        info["reward"] = moment.reward
    elif reads == "truth":
        info["moment"] = moment
    return info
