"""A lifetime as one game: so many episodes of the same seats, whose students may learn from each for the next."""

from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from pz_envs.seats import TEACHER, SeatsEnv, role_of
from pz_envs.student_view import info_for
from teachers.atoms import Moment

__all__ = ["Ending", "LifetimeEnv"]

_FINAL = ("final_obs", "final_info", "final_terminated")


class Ending(NamedTuple):
    """How an episode ended for a student."""

    observation: Any
    """What it saw and heard last."""
    info: dict[str, Any]
    turns_left: int
    moment: Moment[Any]
    """Privileged."""
    terminated: bool

    def info_for(self, policy: Any) -> dict[str, Any]:
        """The info that a policy in the student's seat may see."""
        return info_for(policy, self.info, self.turns_left, self.moment)


class LifetimeEnv(SeatsEnv):
    """An AEC environment of several episodes of the same seats, one game from `reset` to the end of the last of them.

    Each episode begins in the same state of the same worlds, with fresh randomness; the next one begins when all
    students have ended theirs. Who has ended waits without a turn, its info saying `waits`. Nobody leaves before the
    last episode. Budgets are for the whole lifetime. What agents earn adds up over the end of an episode.

    In its first turn of an episode the info of a student has how its last one ended, as in vectors of Gymnasium's that
    reset themselves: `final_obs`, `final_info`, and `final_terminated`, False if it was cut off.

    Teachers observe one entry more: `episode`, Box (1,) float32, the share of the episodes that are over.

    Args:
        seats: what is played; also `unwrapped`.
        episodes: how many, at least 2.
    """

    def __init__(self, seats: SeatsEnv, episodes: int) -> None:
        super().__init__(seats.metadata["name"].removesuffix("_v0"), seats.speech, seats.render_mode)
        self.seats, self.episodes = seats, episodes
        self.max_turns, self.possible_agents = seats.max_turns, seats.possible_agents
        self.action_spaces = seats.action_spaces
        share = spaces.Box(0, 1, (1,), np.float32)
        for agent in self.possible_agents:
            space = seats.observation_space(agent)
            self.observation_spaces[agent] = spaces.Dict({**space, "episode": share}) if _teaches(agent) else space  # type: ignore[dict-item]  # a teacher's is a Dict
        self._endings: dict[str, Ending] = {}
        self.episode = 0
        """Episodes that are over."""

    @property
    def unwrapped(self) -> SeatsEnv:
        """The seats that are played."""
        return self.seats

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin a lifetime; without a seed the random streams go on. `options` are the worlds', in each episode."""
        self.seats.reset(seed, options)
        self._begin(options)

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another lifetime: the streams go on, and what was spent of budgets stays spent."""
        self.seats.start_next_episode(start, options)
        self._begin(options)

    def _begin(self, options: dict[str, Any] | None) -> None:
        self._start, self._options = self.seats.truth_now, options
        self.episode = 0
        self._endings = {}
        self._open()
        self._follow()

    def step(self, action: Any) -> None:
        """Let the agent whose turn it is act.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        self._act(self.agent_selection, action)
        self._follow()

    def observe(self, agent: str) -> Any:
        """What an agent sees now."""
        observation = self.seats.observe(agent)
        if _teaches(agent):
            observation["episode"] = np.array([self.episode / self.episodes], np.float32)
        return observation

    def take_ending(self, student: str) -> Ending | None:
        """How the student's last episode ended, in its first turn of the next; it is told once."""
        ending = self._endings.get(student)
        self._forget(student)
        return ending

    def moment_of(self, student: str) -> Moment[Any]:
        """A student's last turn."""
        return self.seats.moment_of(student)

    @property
    def truth_now(self) -> Any:
        """As of the seats."""
        return self.seats.truth_now

    def as_text(self) -> str:
        """As of the seats."""
        return self.seats.as_text()

    def frame(self) -> Any:
        """As of the seats."""
        return self.seats.frame()

    def render(self) -> Any:
        """As of the seats."""
        return self.seats.render()

    def close(self) -> None:
        """Close the seats."""
        self.seats.close()

    def _parties(self) -> str:
        return f"episodes={self.episodes} {self.seats!r}"

    def _act(self, agent: str, action: Any) -> None:
        seats = self.seats
        seats.step(action)
        if agent not in seats.agents:  # it had ended its last episode
            del self._cumulative_rewards[agent], self.infos[agent]
            self.rewards = seats.rewards
            return
        self._forget(agent)
        self._cumulative_rewards[agent] = 0.0
        self.rewards = dict.fromkeys(self.agents, 0.0) | seats.rewards
        for each, reward in seats.rewards.items():
            self._cumulative_rewards[each] += reward
        if self.episode + 1 < self.episodes:
            self._bridge()

    def _bridge(self) -> None:
        """Let those leave the seats who have ended an episode that is not the last; begin the next after all have."""
        seats = self.seats
        while seats.agents and (seats.terminations[agent := seats.agent_selection] or seats.truncations[agent]):
            if not _teaches(agent):
                info, moment = seats.infos[agent], seats.moment_of(agent)
                terminated = seats.terminations[agent]
                self._endings[agent] = Ending(seats.observe(agent), info, seats.turns_left(agent), moment, terminated)
                self.infos[agent] = {**info, "waits": True}
            seats.step(None)
        if not seats.agents:
            self.episode += 1
            seats.start_next_episode(self._start, self._options)
            for student, ending in self._endings.items():
                seats.infos[student].update(
                    zip(_FINAL, (ending.observation, ending.info, ending.terminated), strict=True)
                )

    def _follow(self) -> None:
        """Take over from the seats whose turn it is, and in the last episode who is there."""
        seats = self.seats
        if self.episode + 1 == self.episodes:
            self.agents, self.terminations, self.truncations = seats.agents, seats.terminations, seats.truncations
        self.infos = self.infos | seats.infos
        self.agent_selection = seats.agent_selection

    def _forget(self, student: str) -> None:
        """The end of its last episode is behind a student."""
        if self._endings.pop(student, None):
            for key in _FINAL:
                self.seats.infos[student].pop(key, None)


def _teaches(agent: str) -> bool:
    return role_of(agent) == role_of(TEACHER)
