"""A learner that asks for advice, and lifetimes with a teacher that observes it only then, or always."""

from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import TeacherEnv
from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.registry import entry
from llf_teacher.students.builtin.q_learning import QLearning
from llf_teacher.students.student import Policy, frozen, state_of

_LEARNER = QLearning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)
_ADVICE, _MISTAKE = 0b01000, FIELDS.index("mistake")
Asks = Callable[[list[float], int], bool]
"""Whether to ask, given the learned values of the actions and the number of earlier visits of the state."""
Answers = Callable[[float, bool], bool]
"""Whether to advise, given the importance of the next action and whether the announced one is a mistake."""


class Asker:
    """Learns Q-values, takes advice, and asks for it, at most once a turn.

    Args:
        learner: a policy of `q_learning`.
        asks: whether to ask; None: never.
    """

    reads = "atoms and reward"

    def __init__(self, learner: Policy[QLearning], asks: Asks | None) -> None:
        self._learner: Any = learner
        self._asks, self._question = asks, learner.action_count
        self._visits = Counter[Any]()

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""
        self._learner.reset(rng)
        self._asked = False

    def intend(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The learner's intention."""
        return self._learner.intend(observation, info)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Ask, or act like the learner."""
        state = frozen(state_of(observation))
        self._learner.intend(observation, info)  # learns from the last turn
        if not self._asked and self._asks and self._asks(self._learner.worth(), self._visits[state]):
            self._asked = True
            return self._question
        self._asked = False
        self._visits[state] += 1
        return self._learner.act(observation, info)

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """End an episode."""
        self._learner.finish(observation, info, terminated)


class Attended(NamedTuple):
    """The outcome of a lifetime."""

    regret: float
    """Per episode."""
    looked: float
    """Number of turns in which the teacher observed the student, while it had advice left."""
    said: float
    """Number of pieces of advice."""


def attended(
    id: str, asks: Asks | None, answers: Answers, *, seed: int, episodes: int, turns: int, budget: int, **options: Any
) -> Attended:
    """Play a lifetime in which the teacher advises at most `budget` times.

    Args:
        id: an environment with discrete actions.
        asks: whether the student asks; the teacher observes it only then. None: the teacher observes it in each turn.
        answers: whether the teacher advises when it observes.
        seed: of the world, the teacher and the student.
        episodes: of the lifetime.
        turns: greatest number of an episode.
        budget: pieces of advice, at least 1.
        options: of the world.
    """
    family, own = entry(id).family, entry(id).options
    world = family.make_world(**own, **options)
    env = TeacherEnv(
        id,
        student=lambda _: Asker(_LEARNER.seat(family, world), asks),
        episodes=episodes,
        max_turns=turns,
        feedback_type="fp",
        budget=budget,
        cost=0.0,
        ask_cost=0.0,
        announce=True,
        teacher_reward="student_progress",
        **options,
    )
    observation, _ = env.reset(seed=seed)
    regret, looked, said, done = 0.0, 0, 0, False
    while not done:
        importance, left, over = observation["features"][2:5].tolist()
        looks = left > 0 and not over and (asks is None or bool(observation["asked"][0]))
        looked += looks
        speaks = looks and answers(importance, bool(observation["lifetime"][_MISTAKE]))
        speaks = speaks and bool(observation["action_mask"][_ADVICE])
        said += speaks
        observation, reward, terminated, truncated, _ = env.step(_ADVICE if speaks else 0)
        regret -= float(reward)
        done = terminated or truncated
    env.close()
    return Attended(regret / episodes, float(looked), float(said))
