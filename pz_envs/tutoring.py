"""The two seats: a teacher and a student take turns over a world."""

import copy
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding

from pz_envs.rewards import TeacherReward, parse_teacher_reward, student_reward
from pz_envs.seats import SPEECHES, STUDENT, TEACHER, SeatsEnv
from pz_envs.teacher_seat import PROSE, SUBSETS, Purse, TeacherSeat, message_space, price
from pz_envs.text_mode import legal_text, parse_action
from teachers.atoms import FN, FP, SILENCE, Moment, ParseFailure, Utterance
from teachers.teacher import Teacher
from worlds.spaces import Prose
from worlds.world import World

__all__ = ["SPEECHES", "STUDENT", "SUBSETS", "TEACHER", "TutoringEnv"]

_new = tuple.__new__  # a NamedTuple's own constructor takes three times as long


class TutoringEnv(SeatsEnv):
    """An AEC environment with the agents `teacher_0` and `student_0`.

    The teacher opens; then student and teacher alternate, and the teacher has the last word: after the
    student's final action nothing terminates until the teacher has spoken.

    Student:
        Observation: Dict of `state` (the world's space; `Prose` with `text=True`), `instruction` and
        `feedback` (`Prose`), what the teacher last said. Of an opening utterance with atoms the advice for
        the first action is feedback and the rest is the instruction. Action: the world's space; `Prose` with
        `text=True`. A text that is no action is a `ParseFailure` (in the info as `parse_failure`): the world
        does not step, the turn counts.
        Info: what the world tells, with `success`, and `atoms`, what was said last.

    Teacher, `speech="message"`:
        Observation: Dict of `state` and `action` (`Prose`), the world and the student's last action as text.
        Action: `Prose`; an `Utterance` brings its atoms along. Info: the privileged `moment`.

    Teacher, `speech="kinds"`:
        Observation: Dict of
            `available`, MultiBinary(5): the kinds of which there is a claim to say, in the order r, hp, hn, fp, fn;
            `features`, Box (5,) float32: turn / max_cycles, 0 to 1; the last reward, in the world's `reward_range`;
            importance of the next action, 0 to the oracle's `max_importance`; share of the budget that is left, 0 to 1,
            1 without a budget; 1 if the episode is over, else 0;
            `action_mask`, int8 (32,).
        The claims are the tutor's after its personality: true, if that does not err.
        Action: Discrete(32), the subset of kinds to say, bit i for kind i; kinds of which there is nothing to
        say are not said. `reset` says the instruction itself. Info: the privileged `moment`.

    Rewards: at the student's step the student gets the world's reward and the teacher its `teacher_reward`; at
    the teacher's step the teacher pays `cost` for each atom of feedback that it says, one for a text without atoms.

    Args:
        world: what is taught.
        tutor: the teacher whose oracle sees the truth, and who speaks when `speech="kinds"`.
        name: for `metadata`.
        max_cycles: turns of the student after which the episode is truncated, at least 1.
        repeated: whether success is that of a single action, so that a text which is no action does not keep it.
        speech: `message` or `kinds`.
        text: text in, text out for the student.
        cost: paid by the teacher per atom of feedback, at least 0.
        budget: atoms of feedback that the teacher may say in an episode; what exceeds it is not said. None: any number.
        teacher_reward: the teacher's reward of a student's turn: `student_reward`, `student_progress`,
            `success_minus_cost`, or a function of the `Moment` and the `Oracle`; see `pz_envs.rewards`.
        until_success: whether success ends the episode; it does not where the task is `repeated`.
        render_mode: None, `ansi` or `human`.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {**SeatsEnv.metadata, "name": "tutoring_v0"}  # noqa: RUF012 (PettingZoo's convention)

    def __init__(
        self,
        world: World,
        tutor: Teacher,
        *,
        name: str = "tutoring",
        max_cycles: int = 30,
        repeated: bool = False,
        speech: str = "message",
        text: bool = False,
        cost: float = 0.01,
        budget: int | None = None,
        teacher_reward: str | TeacherReward = student_reward,
        until_success: bool = False,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(name, speech, render_mode)
        if not isinstance(max_cycles, int) or max_cycles < 1:
            raise ValueError(f"max_cycles (or max_turns) must be an integer of at least 1, got {max_cycles!r}")
        self.name, self.world, self.tutor = name, world, tutor
        self.max_cycles, self.text = max_cycles, text
        self.repeated, self.until_success = repeated, until_success and not repeated
        self.purse = Purse(cost, budget)
        self.seat = TeacherSeat(tutor, self.purse, max_cycles, world.reward_range)
        self.teacher_reward = parse_teacher_reward(teacher_reward)
        self._own_reward = self.teacher_reward is not student_reward
        self.possible_agents = [TEACHER, STUDENT]
        self._texts = text or isinstance(world.action_space, spaces.Text)
        self.observation_spaces[STUDENT] = spaces.Dict(
            {
                "state": Prose(PROSE) if text else copy.deepcopy(world.observation_space),
                "instruction": Prose(PROSE),
                "feedback": Prose(PROSE),
            }
        )
        self.action_spaces[STUDENT] = Prose(PROSE) if text else copy.deepcopy(world.action_space)
        if speech == "message":
            self.observation_spaces[TEACHER] = words_space()
            self.action_spaces[TEACHER] = message_space()
        else:
            self.observation_spaces[TEACHER] = self.seat.kinds_space()
            self.action_spaces[TEACHER] = spaces.Discrete(SUBSETS)
        self.start: Any = None
        """A world's truth with which every episode begins; None: each begins as the world's reset draws it."""
        self._rng: np.random.Generator | None = None
        self._episode = 0  # counted from the last seed
        self.state_now: Any = None
        """The world's observation as the student sees it; made anew by each action, and handed out as it is."""

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the world's."""
        if seed is not None or self._rng is None:
            self._rng, _ = seeding.np_random(seed)
            self._episode = 0
        world = self.world
        self._state, world_info = world.reset(seed=int(self._rng.integers(2**31)), options=options)
        if self.start is not None:
            world.restore(self.start)
            self._state = world.observe()
        self._see()
        self._open()
        self.turn = self.purse.spent = 0
        self.ended = (False, False)
        self.instruction: str = SILENCE
        self.feedback: str = SILENCE
        self.moment = Moment.opening(world.truth)
        self.infos[STUDENT] = world_info | {"atoms": ()}
        self._pass_to_teacher()
        if self.speech == "kinds" or self._own_reward:
            self.tutor.begin(self._rng.bit_generator.seed_seq, self._episode)  # type: ignore[attr-defined]
            self._episode += 1
            opening = self.tutor.open(self.moment)
            if self.speech == "kinds":
                self.instruction = opening
                self.infos[STUDENT]["atoms"] = opening.atoms

    def observe(self, agent: str) -> dict[str, Any]:
        """What an agent sees now."""
        if agent == STUDENT:
            state = self.state_now
            state = state.copy() if type(state) is dict else copy.copy(state)
            return {"state": state, "instruction": self.instruction, "feedback": self.feedback}
        return self.describe() if self.speech == "message" else self.seat.observe(self.agent_selection == TEACHER)

    def describe(self) -> dict[str, str]:
        """The world and the student's last action as text."""
        action = self.moment.action
        if type(action) is ParseFailure:
            action = action.got
        return {"state": self.world.describe(self._state), "action": "" if action is None else f"{action}"}

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            self.student_turn(action)
        else:
            self.teacher_turn(action)

    def student_turn(self, action: Any) -> None:
        """The student acts.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        world, before = self.world, self.moment.after
        action = self._understand(action)
        turn = self.turn = self.turn + 1
        if type(action) is ParseFailure:
            late = turn >= self.max_cycles
            self.ended = (False, late)
            reward = world.failure_reward
            success = self.moment.success and not self.repeated
            self.moment = Moment.unread(before, action, reward, success, turn, late)
            self._state = copy.deepcopy(self._state)  # each observation is new, also if nothing happened
            self._see()
            info: dict[str, Any] = {"success": success, "parse_failure": action}
        else:
            self._state, reward, terminated, truncated, info = world.advance(action)
            self._see()
            if self.until_success and info["success"]:
                terminated = True
            late = not terminated and (truncated or turn >= self.max_cycles)
            self.ended = (terminated, late)
            over = terminated or late
            self.moment = _new(Moment, (before, action, reward, world.truth, info["success"], turn, over))
        self.infos[STUDENT] = info
        own = self.teacher_reward(self.moment, self.tutor.oracle) if self._own_reward else reward
        self._pay(STUDENT, own, reward)
        self._pass_to_teacher()

    def teacher_turn(self, action: Any) -> None:
        """The teacher speaks; a finished episode ends with it.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        said = self.seat.say(action) if self.speech == "kinds" else self.seat.allow(action)
        self._pay(TEACHER, self.purse.pay(self.hear(said)), 0.0)

    def hear(self, said: str) -> int:
        """Let the student hear the teacher's words, which ends a finished episode; the number of atoms to pay for."""
        atoms = said.atoms if type(said) is Utterance else ()
        info = self.infos[STUDENT]
        if self.turn == 0 and self.speech == "message":
            self.instruction, self.feedback = _split(said, atoms)
            cost = len(self.feedback.atoms) if atoms else 0
        else:
            self.feedback = said
            # After an executed action nothing but feedback is said.
            cost = len(atoms) if atoms and self.moment.before is not None else price(said)
            if self.turn == 0:
                atoms = info["atoms"] + atoms
        info["atoms"] = atoms
        terminated, truncated = self.ended
        if terminated or truncated:
            self.terminations = {TEACHER: terminated, STUDENT: terminated}
            self.truncations = {TEACHER: truncated, STUDENT: truncated}
        self.agent_selection = STUDENT
        return cost

    def as_text(self) -> str:
        """The world and the teacher's last words."""
        words = self.feedback or self.instruction
        return f"{self.world.describe(self._state)}\nTeacher: {words}".lstrip("\n")

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _see(self) -> None:
        self.state_now = self.world.describe(self._state) if self.text else self._state

    def _understand(self, action: Any) -> Any:
        """The student's action in canonical form, or a `ParseFailure`."""
        if not self._texts:
            return self.world.legal(action)
        if not isinstance(action, str):
            raise ValueError(f"the student's action must be a string, got {action!r}; the state is unchanged")
        return parse_action(action, self.world) if self.text else legal_text(action, self.world)

    def _pass_to_teacher(self) -> None:
        self.seat.see(self.moment)
        self.infos[TEACHER] = {"moment": self.moment}
        self.agent_selection = TEACHER

    def _pay(self, actor: str, teacher: float, student: float) -> None:
        self.rewards = {TEACHER: teacher, STUDENT: student}
        cumulative = self._cumulative_rewards
        cumulative[actor] = 0.0
        cumulative[TEACHER] += teacher
        cumulative[STUDENT] += student


def words_space() -> spaces.Dict:
    """The space of `TutoringEnv.describe`."""
    return spaces.Dict({"state": Prose(PROSE), "action": Prose(PROSE)})


def _split(said: str, atoms: tuple[Any, ...]) -> tuple[str, Any]:
    """An opening utterance as instruction and feedback: advice for the first action is feedback."""
    advice = [atom for atom in atoms if atom.kind in (FP, FN)]
    if not advice:
        return said, SILENCE
    return Utterance.of([atom for atom in atoms if atom.kind not in (FP, FN)]), Utterance.of(advice)
