"""A lifetime: several episodes of the same seats as one AEC environment; students can learn across the episodes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from typing_extensions import override

from pz_envs.global_state import Seated, Shared
from pz_envs.seats import TEACHER, SeatsEnv, role_of
from pz_envs.student_view import info_for
from teachers.atoms import Moment

__all__ = ["FinalStep", "LifetimeEnv"]

_FINAL = ("final_obs", "final_info", "final_terminated")


class FinalStep(NamedTuple):
    """The last step of a student's episode."""

    observation: Any
    """The last observation, after the teacher's last word."""
    info: dict[str, Any]
    turns_left: int
    moment: Moment[Any]
    """The student's last moment of the episode: privileged."""
    terminated: bool

    def info_for(self, policy: Any) -> dict[str, Any]:
        """The info that a policy in the student's seat may see."""
        return info_for(policy, self.info, self.turns_left, self.moment)


class LifetimeEnv(SeatsEnv):
    """An AEC environment of several episodes of the same seats: `reset` begins the first, the last one ends it.

    All episodes begin in the same state of the same worlds, with fresh randomness; the next one begins when every
    student has ended the last. A student whose episode has ended waits without a turn; its info has `waits`. No agent
    leaves `agents` before the last episode. Budgets are for the whole lifetime. Cumulative rewards go on over the end
    of an episode.

    In a student's first turn of an episode its info has the last step of the episode before, named as by Gymnasium's
    vector environments with autoreset: `final_obs`, `final_info`, and `final_terminated`, False if it was truncated.

    Teachers observe one more entry: `episode`, Box (1,) float32, the share of the episodes that are over.

    Args:
        seats: the environment; also `unwrapped`.
        episodes: number of episodes, at least 2.
    """

    def __init__(self, seats: SeatsEnv, episodes: int) -> None:
        super().__init__(seats.label, seats.speech, seats.render_mode)
        self.seats, self.episodes, self.metadata = seats, episodes, seats.metadata
        self.max_turns, self.possible_agents = seats.max_turns, seats.possible_agents
        self.action_spaces = seats.action_spaces
        share = spaces.Box(0, 1, (1,), np.float32)
        for agent in self.possible_agents:
            space = seats.observation_space(agent)
            self.observation_spaces[agent] = spaces.Dict({**space, "episode": share}) if _is_teacher(agent) else space  # type: ignore[dict-item]  # a Dict
        self._final_steps: dict[str, FinalStep] = {}
        self.episode = 0
        """Episodes that are over."""

    @property
    def unwrapped(self) -> SeatsEnv:
        """The environment without the lifetime."""
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
        self._start, self._options = self.seats.current_truth, options
        self.episode = 0
        self._final_steps = {}
        self._open()
        self._follow()
        self._show_masks()

    def step(self, action: Any) -> None:
        """Let the agent whose turn it is act.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        self._act(self.agent_selection, action)
        self._follow()
        self._show_masks()

    @property
    @override
    def seated(self) -> Sequence[Seated]:
        return self.seats.seated

    def shared(self) -> list[Shared]:
        """The numbers of the seats, and the share of the episodes that are over."""
        share = self.episode / self.episodes
        return [*self.seats.shared(), Shared("episode", "share of the episodes that are over", share)]

    def _observe(self, agent: str) -> Any:
        observation = self.seats.observe(agent)
        if _is_teacher(agent):
            observation["episode"] = np.array([self.episode / self.episodes], np.float32)
        return observation

    def pop_final_step(self, student: str) -> FinalStep | None:
        """The last step of the student's last episode, in its first turn of the next one; later calls return None."""
        final = self._final_steps.get(student)
        self._forget(student)
        return final

    def moment_of(self, student: str) -> Moment[Any]:
        """The last moment of a student: privileged."""
        return self.seats.moment_of(student)

    @property
    @override
    def current_truth(self) -> Any:
        return self.seats.current_truth

    @override
    def as_text(self) -> str:
        return self.seats.as_text()

    @override
    def frame(self) -> Any:
        return self.seats.frame()

    @override
    def render(self) -> Any:
        return self.seats.render()

    def close(self) -> None:
        """Close the seats."""
        self.seats.close()

    def _describe_seats(self) -> str:
        return f"episodes={self.episodes} {self.seats!r}"

    def _act(self, agent: str, action: Any) -> None:
        seats = self.seats
        seats.step(action)
        if agent not in seats.agents:  # its last episode has ended
            del self._cumulative_rewards[agent], self.infos[agent]
            self.rewards = seats.rewards
            return
        self._forget(agent)
        self._pay_all(agent, seats.rewards)
        if self.episode + 1 < self.episodes:
            self._bridge()

    def _bridge(self) -> None:
        """Remove from the seats the agents whose episode has ended; go on when none is left."""
        seats = self.seats
        while seats.agents and (seats.terminations[agent := seats.agent_selection] or seats.truncations[agent]):
            if not _is_teacher(agent):
                info, moment = seats.infos[agent], seats.moment_of(agent)
                terminated = seats.terminations[agent]
                self._final_steps[agent] = FinalStep(
                    seats.observe(agent), info, seats.turns_left(agent), moment, terminated
                )
                self.infos[agent] = {**info, "waits": True}
            seats.step(None)
        if not seats.agents:
            self.episode += 1
            self._go_on()

    def _go_on(self) -> None:
        """Begin the next episode."""
        self.seats.start_next_episode(self._start, self._options)
        self._recall()

    def _recall(self) -> None:
        """Put the last steps of the last episode into the students' infos."""
        for student, final in self._final_steps.items():
            last = final.observation, final.info, final.terminated
            self.seats.infos[student].update(zip(_FINAL, last, strict=True))

    def _follow(self) -> None:
        """Copy from the seats the selected agent and the infos, in the last episode also which agents are left."""
        seats = self.seats
        if self.episode + 1 == self.episodes:
            self.agents, self.terminations, self.truncations = seats.agents, seats.terminations, seats.truncations
        self.infos = self.infos | seats.infos
        self.agent_selection = seats.agent_selection

    def _forget(self, student: str) -> None:
        """Drop the last step of a student's last episode."""
        if self._final_steps.pop(student, None):
            for key in _FINAL:
                self.seats.infos[student].pop(key, None)


def _is_teacher(agent: str) -> bool:
    return role_of(agent) == role_of(TEACHER)
