"""Some seats of an AEC environment as a parallel environment, with policies in the others."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from pettingzoo import ParallelEnv
from pettingzoo.utils.conversions import turn_based_aec_to_parallel_wrapper

from pz_envs.lifetime_env import LifetimeEnv
from pz_envs.seats import STUDENT, SeatsEnv, role_of
from teachers.seeds import Seeds


class TurnBasedParallelEnv(turn_based_aec_to_parallel_wrapper):
    """PettingZoo's parallel form of a turn-based environment, in which agents take turns.

    In each step one agent acts, first a teacher; then `active_agent` in all infos says which is next. The actions of
    the other agents are ignored. `metadata` has `turn_based`, and a name that says so.
    """

    @property
    def metadata(self) -> dict[str, Any]:  # the environment's label may change
        """The metadata of the environment, with the name of this form."""
        own = self.env.metadata
        name, _, version = own["name"].rpartition("_v")
        return {**own, "name": f"{name}-turns_v{version}", "turn_based": True}

    @metadata.setter
    def metadata(self, given: dict[str, Any]) -> None:
        """Ignored: PettingZoo's wrapper sets the environment's metadata."""

    @property
    def env(self) -> SeatsEnv:
        """The AEC environment."""
        env: SeatsEnv = self.aec_env.unwrapped
        return env

    def step(self, actions: Mapping[str, Any]) -> Any:
        """Let the agent whose turn it is act; a ValueError if its action is missing, and nothing has changed."""
        if self.agents and (agent := self.env.agent_selection) not in actions:
            raise ValueError(f"the actions lack {agent}, whose turn it is, got those of {', '.join(actions) or 'none'}")
        return super().step(actions)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.env!r}>"


class ParallelSeats(ParallelEnv):
    """The agents of an AEC environment without partners, in parallel: each acts once in a step.

    In a classroom with a policy in the teacher's seat these are the students, which act at the same time. With policies
    in the students' seats the teacher is the only agent, as libraries for a single agent require.

    A step passes each agent's action to the environment at that agent's turn, and ends when an agent is to act again.
    An agent's reward is the sum of its rewards since its turn. Observations, infos and spaces are the environment's. In
    a lifetime the actions of agents that wait are ignored. An agent that terminates or is truncated leaves `agents` in
    that step. Teachers and students cannot act at the same time: a student would act before it hears the teacher.

    Args:
        env: the environment, bare: `raw_env(...)`, `raw_env(seating="classroom", ...)`.
        partners: per agent a policy with `reset(rng)` and `act(observation, info)`. A student's info is the result of
            `SeatsEnv.info_for`; a `finish(observation, info, terminated)` is optional, and called when the student's
            episode has ended.

    Raises:
        ValueError: a partner's agent does not exist, every agent has a partner, or teachers and students are left.
    """

    def __init__(self, env: SeatsEnv, partners: Mapping[str, Any]) -> None:
        for agent in partners:
            if agent not in env.possible_agents:
                raise ValueError(f"there is no agent {agent!r}; allowed: {', '.join(env.possible_agents)}")
        self.env, self.partners = env, dict(partners)
        self.possible_agents = [agent for agent in env.possible_agents if agent not in partners]
        if not self.possible_agents:
            raise ValueError("partners play every agent; leave at least one agent without a partner")
        if len({role_of(agent) for agent in self.possible_agents}) > 1:
            raise ValueError(
                "the agents without a partner must be teachers alone or students alone, since both act in turns; got "
                f"partners for {', '.join(partners) or 'no agent'}; give a partner to every teacher or to every "
                "student, or play the AEC environment turn by turn"
            )
        self.agents: list[str] = []
        self.render_mode = env.render_mode
        self._seeds = Seeds()
        self._rngs: dict[str, np.random.Generator] = {}

    @property
    def metadata(self) -> dict[str, Any]:  # the environment's label may change
        """The metadata of the environment."""
        return {**self.env.metadata, "is_parallelizable": True}

    @property
    def state_space(self) -> spaces.Box:
        """The space of `state`, the same object each time."""
        return self.env.state_space

    def state(self) -> npt.NDArray[np.float32]:
        """The state of the environment, all agents included: privileged; see `pz_envs.global_state`."""
        return self.env.state()

    def __repr__(self) -> str:
        partners = ", ".join(f"{agent}: {partner!r}" for agent, partner in self.partners.items())
        return f"<{type(self).__name__} {self.env!r}, with {partners or 'no partners'}>"

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """The agent's observation space, the same object each time."""
        space: spaces.Space[Any] = self.env.observation_space(agent)
        return space

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """The agent's action space, the same object each time."""
        space: spaces.Space[Any] = self.env.action_space(agent)
        return space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin an episode; without a seed the random streams go on."""
        self.env.reset(seed, options)
        if seed is None:
            self._seeds.episode += 1
        else:
            self._seeds = Seeds(seed)
        for agent, partner in self.partners.items():
            role, _, number = agent.rpartition("_")
            self._rngs[agent] = self._seeds.stream(role, int(number))
            partner.reset(self._rngs[agent])
        self.agents = self.possible_agents[:]
        self._play({})
        infos = {agent: self.env.infos[agent] for agent in self.agents}
        return {agent: self.env.observe(agent) for agent in self.agents}, infos

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Let every agent act once; agents that wait for the next episode of a lifetime may be left out.

        Raises:
            ValueError: an agent's action is missing, or is outside of its space; nothing has changed.
        """
        env = self.env
        waiting = {agent for agent in self.agents if "waits" in env.infos[agent]}  # for the next episode
        if missing := [agent for agent in self.agents if agent not in actions and agent not in waiting]:
            raise ValueError(
                f"the actions lack {', '.join(missing)}; each agent that is left must act: {', '.join(self.agents)}"
            )
        acting = {agent: actions[agent] for agent in self.agents if agent not in waiting}
        for agent, action in acting.items():
            try:
                env.check_action(agent, action)
            except ValueError as error:
                raise ValueError(f"{agent}: {error}") from error
        results = self._play(acting)
        for agent in self.agents:
            if agent not in results:
                reward = 0.0 if agent in waiting else env._cumulative_rewards[agent]  # its sum is paid
                results[agent] = env.observe(agent), reward, False, False, env.infos[agent]
        ordered = {agent: results[agent] for agent in self.agents}
        self.agents = [agent for agent in self.agents if agent in env.agents]
        return (
            {agent: result[0] for agent, result in ordered.items()},
            {agent: result[1] for agent, result in ordered.items()},
            {agent: result[2] for agent, result in ordered.items()},
            {agent: result[3] for agent, result in ordered.items()},
            {agent: result[4] for agent, result in ordered.items()},
        )

    def render(self) -> Any:
        """The environment's render."""
        return self.env.render()

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def _play(self, actions: dict[str, Any]) -> dict[str, tuple[Any, float, bool, bool, dict[str, Any]]]:
        """Play until an agent without an action is selected; returns the results of the agents that have ended."""
        env, ended = self.env, {}
        while env.agents:
            agent = env.agent_selection
            partner = self.partners.get(agent)
            if env.terminations[agent] or env.truncations[agent]:
                if partner is None:
                    ended[agent] = env.last()
                elif hasattr(partner, "finish"):
                    partner.finish(env.observe(agent), self._info(agent), env.terminations[agent])
                env.step(None)
            elif partner is not None:
                self._begin_next(agent)
                env.step(partner.act(env.observe(agent), self._info(agent)))
            elif agent in actions:
                env.step(actions.pop(agent))
            else:
                break
        return ended

    def _begin_next(self, agent: str) -> None:
        """In a lifetime, finish the last episode of a student that a partner plays, and reset the partner."""
        env, partner = self.env, self.partners[agent]
        if isinstance(env, LifetimeEnv) and (final := env.pop_final_step(agent)):
            if hasattr(partner, "finish"):
                partner.finish(final.observation, final.info_for(partner), final.terminated)
            partner.reset(self._rngs[agent])

    def _info(self, agent: str) -> dict[str, Any]:
        """A partner's info."""
        if role_of(agent) == role_of(STUDENT):
            return self.env.info_for(self.partners[agent], agent)
        return self.env.infos[agent]
