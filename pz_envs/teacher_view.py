"""The teacher's view of a session: observations, actions, infos and rewards."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.rewards import TeacherReward, parse_teacher_reward, student_reward
from teachers.atoms import KINDS, ActionClaim, EditClaim, ParseFailure, PlanClaim, unhedged
from teachers.common import Late
from teachers.feedback import SUBSETS, number_of
from teachers.session import Session
from teachers.teacher import Teacher
from teachers.teacher_turn import CLAIMS, LONGEST
from worlds.spaces import Prose

__all__ = [
    "CLAIM_COLUMNS",
    "LEGAL",
    "SUBSET_BITS",
    "TeacherView",
    "choices_of",
    "mask_space",
    "message_space",
    "words_space",
]

CHOICES = {"kinds": SUBSETS, "claims": 1 + CLAIMS}
"""Number of actions of a teacher that chooses, by its speech."""
CLAIM_COLUMNS = (*KINDS, "action", "plan", "edit")
"""The columns of `TeacherView.table`: the kinds of claims, then their roles."""
FEATURES = ("turn", "reward", "importance", "budget", "over")
"""The names of the numbers of `teachers.teacher_turn.TeacherTurn.features`."""
SUBSET_BITS = np.array([[subset >> i & 1 for i in range(len(KINDS))] for subset in range(SUBSETS)], np.int8)
"""For each subset, 1 for each kind in it, else 0; int8 of shape (32, 5)."""
LEGAL = np.array([[int(not said & ~true) for said in range(SUBSETS)] for true in range(SUBSETS)], np.int8)
"""For each subset of available kinds, 1 for each subset that can be said, else 0; int8 of shape (32, 32)."""
ACTIONS = ("all", "compact")
"""The subsets that a teacher chooses from: all, or only subsets of the kinds that feedback type and oracle allow."""
_FLOAT = np.dtype(np.float32)
_BITS, _MASKS = list(SUBSET_BITS), list(LEGAL)  # a list of rows, since indexing it is faster


class TeacherView:
    """The seat of a teacher; `pz_envs.seatings.tutoring.TutoringEnv` describes its spaces.

    Args:
        session: the session.
        speech: the form of its action: `message`, `kinds` or `claims`.
        reward: its reward of a student's turn; see `pz_envs.rewards`.
        number: the teacher's number in the session.
    """

    def __init__(
        self, session: Session, speech: str, reward: str | TeacherReward = "student_reward", number: int = 0
    ) -> None:
        self.session, self.speech, self.number = session, speech, number
        self.teacher_turn = session.teacher_turns[number]
        self.low, self.high = session.world.reward_range
        self._reward = parse_teacher_reward(reward)
        acts: dict[str, Callable[..., float]] = {
            "message": session.say,
            "kinds": session.say_kinds,
            "claims": session.choose,
        }
        self._act = acts[speech]
        self.observation_space: spaces.Dict = words_space() if speech == "message" else self._choosing_space()
        self.action_space: spaces.Space[Any] = (
            message_space() if speech == "message" else spaces.Discrete(CHOICES[speech])
        )

    def act(self, action: Any) -> float:
        """Speak.

        Returns:
            The teacher's reward for its words.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        return self._act(action, self.number)

    def reward(self) -> float:
        """The teacher's reward of the student's last action; 0 for a question."""
        session = self.session
        if session.asked:
            return 0.0
        moment, reward = session.moment, self._reward
        return moment.reward if reward is student_reward else reward(moment, self.teacher_turn.teacher.oracle)

    def observe(self, acts: bool = True) -> dict[str, Any]:
        """The observation. `acts`: whether it is the teacher's turn; otherwise only silence is legal."""
        if self.speech == "message":
            return self.words()
        available = self.teacher_turn.available()
        observation: dict[str, Any] = {
            "available": _BITS[available].copy(),
            "features": np.fromiter(self.teacher_turn.features(self.teacher_turn.moment), _FLOAT, 5),
        }
        if self.session.ask_cost is not None:
            observation["asked"] = np.array([self.session.asked], np.int8)
        if self.speech == "kinds":
            observation["action_mask"] = _MASKS[available if acts else 0].copy()
        else:
            observation["claims"] = self.table()
            observation["action_mask"] = self.choices() if acts else np.eye(1, 1 + CLAIMS, dtype=np.int8)[0]
        return observation

    def info(self) -> dict[str, Any]:
        """The info: the privileged `moment`, and the claims, or the suggestion and the claims that can be said."""
        turn = self.teacher_turn
        info: dict[str, Any] = {"moment": turn.moment}
        if self.speech == "kinds":
            info["trimmed"] = turn.trimmed
        elif self.speech == "message":
            info |= {"suggestion": turn.suggestion(), "vocabulary": turn.vocabulary, "unbuilt": turn.unbuilt}
        else:
            info |= {"claims": tuple(turn.listed()), "sentences": turn.sentences()}
        if turn.asked:
            info["asked"] = True
        return info

    def words(self) -> dict[str, str]:
        """The world and the student's last action as text."""
        session = self.session
        action = session.moment.action
        action = action.got if type(action) is ParseFailure else action
        return {"state": session.world.describe(session.state), "action": "" if action is None else f"{action}"}

    def feature_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest values of the features, float32 arrays of shape (5,)."""
        low, high = (0, self.low, 0, 0, 0), (1, self.high, self.teacher_turn.teacher.oracle.max_importance, 1, 1)
        return np.array(low, np.float32), np.array(high, np.float32)

    def table(self) -> np.ndarray:
        """For each available claim, 1 for its kind and its role, else 0; int8 (32, 8), with columns `CLAIM_COLUMNS`."""
        table = np.zeros((CLAIMS, len(CLAIM_COLUMNS)), np.int8)
        for i, claim in enumerate(self.teacher_turn.listed()):
            bare = unhedged(claim.claim if isinstance(claim, Late) else claim)
            roles = (isinstance(bare, role) for role in (ActionClaim, PlanClaim, EditClaim))
            table[i] = (*(claim.kind is kind for kind in KINDS), *roles)
        return table

    def choices(self) -> np.ndarray:
        """Which choices are legal, int8 (33,): 0 ends the turn, i says claim i - 1."""
        mask = np.zeros(1 + CLAIMS, np.int8)
        mask[self.teacher_turn.choices()] = 1
        return mask

    def _choosing_space(self) -> spaces.Dict:
        asked = {"asked": spaces.MultiBinary(1)} if self.session.ask_cost is not None else {}
        listed = {"claims": spaces.Box(0, 1, (CLAIMS, len(CLAIM_COLUMNS)), np.int8)} if self.speech == "claims" else {}
        return spaces.Dict(
            {
                "available": spaces.MultiBinary(len(KINDS)),
                "features": spaces.Box(*self.feature_bounds()),
                **asked,
                **listed,
                "action_mask": mask_space(CHOICES[self.speech]),
            }
        )


def choices_of(actions: str, teacher: Teacher, speech: str = "kinds") -> tuple[int, ...]:
    """The subset that each action number of a teacher says.

    Raises:
        ValueError: `actions` is unknown, or needs `speech="kinds"`.
    """
    if actions not in ACTIONS:
        raise ValueError(f"actions {actions!r} is unknown; allowed: {', '.join(ACTIONS)}")
    if actions == "all":
        return tuple(range(SUBSETS))
    if speech != "kinds":
        raise ValueError(f"actions='compact' needs speech='kinds', got {speech!r}; with it give actions='all'")
    able = number_of(teacher.kinds.intersection(teacher.oracle.feedback_types))
    return tuple(subset for subset in range(SUBSETS) if not subset & ~able)


def mask_space(actions: int) -> spaces.Box:
    """The space of an action mask."""
    return spaces.Box(0, 1, (actions,), np.int8)


def message_space() -> Prose:
    """The space of a teacher's message."""
    return Prose(LONGEST)


def words_space() -> spaces.Dict:
    """The space of the world and the student's last action as text."""
    return spaces.Dict({"state": Prose(LONGEST), "action": Prose(LONGEST)})
