"""TRL: an environment for `GRPOTrainer(environment_factory=...)`, in which a model acts by calling a tool."""

import copy
import json
from typing import Any

from llf_teacher.episodes.regret import turn_regret
from llf_teacher.gym import StudentEnv, make, prompt
from llf_teacher.students.conversation import Conversation, as_prompt
from teachers.seeds import Seeds

REWARDS = ("return", "success", "regret")
"""The reward of an episode: the sum of rewards, 1 for success in its last turn, or the negative sum of regrets (see
`llf_teacher.episodes.regret`).
"""
OVER = "The episode is over; there is nothing more to do."
_COLUMNS = ("teacher", "feedback_type", "instruction_type", "voice", "max_turns")


class FeedbackEnvironment:
    """An environment with a teacher for TRL: the model calls `act`, which returns the teacher's words.

    A row of the data set may have the columns `id`, `seed`, `teacher`, `feedback_type`, `instruction_type`, `voice` and
    `max_turns`; it needs no `prompt`, and other columns are ignored.

    Args:
        id: the environment of rows without an id.
        reward: the reward of an episode, one of `REWARDS`. Turns that the model did not take count as texts that are
            not actions.
        settings: keywords of `llf_teacher.make`; a row's columns replace them.

    Raises:
        ValueError: the reward is unknown.
    """

    def __init__(self, id: str = "", *, reward: str = "return", **settings: Any) -> None:
        if reward not in REWARDS:
            raise ValueError(f"reward must be one of {', '.join(REWARDS)}, got {reward!r}")
        self._id, self._reward, self._settings = id, reward, settings
        self._made: dict[str, StudentEnv] = {}

    def reset(self, **row: Any) -> str:
        """Begin an episode; TRL appends the returned text to the row's prompt.

        Raises:
            ValueError: the id is missing or unknown, or a setting is not allowed.
        """
        settings = self._settings | {name: row[name] for name in _COLUMNS if row.get(name) is not None}
        id, seed = row.get("id") or self._id, int(row.get("seed") or 0)
        if not id:
            raise ValueError(
                "id must be an environment's id, got none; add a column `id` to the data set, or pass `id=`"
            )
        self._env = self._environment(id, settings)
        observation, _ = self._env.reset(seed=seed)
        self._talk = Conversation(self._env, answer="tool", history=0, rng=Seeds(seed).stream("student"))
        self._paid = self._lost = 0.0
        return as_prompt(self._talk.ask(observation))

    def act(self, action: str, thought: str = "") -> str:
        """Take one action and hear what the teacher says of it.

        Args:
            action: The action, as the task describes it.
            thought: What the feedback means for this action, in a sentence or two.

        Returns:
            What the teacher says, and what there is to see.
        """
        if self._env.session.done:
            raise ValueError(OVER)
        observation = self._step(self._talk.answer(json.dumps({"thought": thought, "action": action})))
        if self._env.session.done:
            return f"{prompt(observation)}\n\n{OVER}".strip()
        asked: str = self._talk.ask(observation)[-1]["content"]
        return asked

    def get_reward(self) -> float:
        """The reward of the episode."""
        while not self._env.session.done:
            self._step("")
        if self._reward == "success":
            return float(self._env.session.moment.success)
        return self._paid if self._reward == "return" else -self._lost

    def _step(self, action: str) -> dict[str, Any]:
        session = self._env.session
        observation: dict[str, Any]
        observation, reward, _, _, _ = self._env.step(action)
        self._paid += reward
        if self._reward == "regret":  # an oracle may need time for it
            self._lost += turn_regret(session.teacher.oracle, session.moment)
        return observation

    def _environment(self, id: str, settings: dict[str, Any]) -> StudentEnv:
        """An environment, made once and reused."""
        name = repr((id, sorted(settings.items())))
        if name not in self._made:
            self._made[name] = make(id, text=True, **copy.deepcopy(settings))  # all are made with the same teacher
        return self._made[name]
