"""Tutoring: a teacher and a student take turns over a world."""

import copy
from typing import Any

from pz_envs.asking import ASK, read_question
from pz_envs.seatings.tutoring.seats import TutoringSeats
from pz_envs.seatings.tutoring.words import split
from pz_envs.seats import STUDENT, TEACHER, SeatsEnv
from pz_envs.teacher_seat import price
from pz_envs.text_mode import failure, legal_text, parse_action
from teachers.atoms import Moment, ParseFailure, Utterance

__all__ = ["TutoringEnv"]

_new = tuple.__new__  # a NamedTuple's own constructor takes three times as long


class TutoringEnv(TutoringSeats):
    """An AEC environment with the agents `teacher_0` and `student_0`.

    The teacher opens; then student and teacher alternate, and the teacher has the last word: after the student's final
    action nothing terminates until the teacher has spoken.

    Student:
        Observation: Dict of `state` (the world's space; `Prose` with `text=True`), `instruction` and `feedback`
        (`Prose`), what the teacher last said, and `image`, if there is one. Of an opening utterance with atoms the
        advice for the first action is feedback and the rest is the instruction. Action: the world's space; `Prose` with
        `text=True`. A text that is no action is a `ParseFailure` (in the info as `parse_failure`): the world does not
        step, the turn counts. Info: what the world tells, with `success`, and `atoms`, what was said last.
        With `numbers=True` the observation is one flat Box, float32, of the state and of what was said; see
        `pz_envs.numbers`, and `fields` for what is where. The action is the world's, the info has no `atoms`.

    Teacher, `speech="message"`:
        Observation: Dict of `state` and `action` (`Prose`), the world and the student's last action as text.
        Action: `Prose`; an `Utterance` brings its atoms along, of which those are heard that `feedback_type` allows.
        Info: the privileged `moment`, and `suggestion`, the utterance that the seat's own teacher would say.

    Teacher, `speech="kinds"`:
        Observation: Dict of
            `available`, MultiBinary(5): the kinds of which there is a claim to say, in the order r, hp, hn, fp, fn;
            `features`, Box (5,) float32: turn / max_turns, 0 to 1; the last reward, in the world's `reward_range`;
            importance of the next action, 0 to the oracle's `max_importance`; share of the budget that is left, 0 to 1,
            1 without a budget; 1 if the episode is over, else 0;
            `action_mask`, int8 (32,).
        The claims are those of the seat's own teacher after its personality: true, if that does not err.
        Action: Discrete(32), the subset of kinds to say, bit i for kind i; kinds of which there is nothing to say are
        not said. `reset` says the instruction itself. Info: the privileged `moment`, and `trimmed`, the kinds of its
        last action of which nothing could be said, as a subset's number.

    Teacher, `speech="claims"`:
        Observation: as with `kinds`, with `action_mask` int8 (33,), and `claims`, Box (32, 8) int8: per claim that
        there is to say its kind, one of five, and whether it is about an action, a plan, or an edit of a text.
        Action: Discrete(33): i says claim i - 1, and the seat is asked again; 0, or what cannot be said, ends the
        teacher's turn, which ends by itself when nothing else can be said. The student hears all of it at once, in
        speaking order. Info: the privileged `moment`; `claims`, those of the numbers; and `sentences`, their sound.

    Asking, with `ask_cost`: in place of an action the student may ask, once a turn; see `pz_envs.asking` for how. The
    world does not step and the turn does not count; the teacher is asked for its advice (fp, fn) on the moment, its
    observation has one more entry `asked`, MultiBinary(1), its info `asked`, and then the student acts. A second
    question in a turn is taken for a text that is no action: it costs the turn.

    Rewards: at the student's step it gets the world's reward, or pays `ask_cost` for a question, and the teacher gets
    its `teacher_reward`; at its own step the teacher pays `cost` for each atom of feedback, one for a text without any.

    Seeds: `reset(seed)` is the bare world's; all other streams are those of `teachers.seeds.Seeds`, or go on.

    Args:
        world: what is taught.
        teacher: its oracle sees the truth; it speaks, or says what there is to choose from, or makes suggestions.
        max_cycles: turns of the student after which the episode is truncated, at least 1.
        repeated: whether success is that of a single action, so that a text which is no action does not keep it.
        speech: `message`, `kinds` or `claims`.
        text, image: text in, text out for the student, with an image beside it of this space, if it is one.
        numbers, embed: numbers in for the student, and what gives the vector of a text for them.
        cost: paid by the teacher per atom of feedback, at least 0.
        budget: atoms of feedback that the teacher may say in an episode; what exceeds it is not said. None: any number.
        purse: cost and budget that the seat shares with others; None: its own.
        teacher_reward: the teacher's reward of a student's turn: `student_reward`, `student_progress`,
            `success_minus_cost`, or a function of the `Moment` and the `Oracle`; see `pz_envs.rewards`.
        until_success: whether success ends the episode; it does not where the task is `repeated`.
        ask_cost: what the student pays for asking, at least 0; None: it cannot ask.
        failure_reward: of a text that is no action, in the world's `reward_range`; None: the world's own.
        name, render_mode: for `metadata`, and of `SeatsEnv`.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {**SeatsEnv.metadata, "name": "tutoring_v0"}  # noqa: RUF012 (PettingZoo's convention)

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            self.student_turn(action)
        else:
            self.teacher_turn(action)

    def student_turn(self, action: Any) -> None:
        """The student acts, or asks.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        if self.ask_cost is not None:
            asks, action = read_question(action, self.action_spaces[STUDENT])
            if asks and not self._asked:
                self._ask(self.ask_cost)
                return
            if asks:
                action = failure(ASK, self.world)
        reward = self._move(action)
        own = self.teacher_reward(self.moment, self.teacher.oracle) if self._own_reward else reward
        self._pay(own, reward)
        self._pass_to_teacher()

    def take_turn(self, action: Any) -> float:
        """The student acts, and the teacher says what its seat suggests; the student's reward.

        That is `student_turn` and `take_suggestion`, in one go where nothing comes between them.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        if not self._at_once:
            self.student_turn(action)
            reward: float = self.rewards[STUDENT]
            self.take_suggestion()
            return reward
        reward = self._move(action)
        moment = self.moment
        said = self.seat.speak(moment)
        self.infos[TEACHER] = {"moment": moment, "suggestion": said}
        self._cumulative_rewards[STUDENT] = 0.0 + reward
        self._charge(self.hear(said))
        return reward

    def _move(self, action: Any) -> float:
        """What the student's action does to the world, or a text that is none; the world's reward."""
        if self._texts:
            action = self.understand(action)
        elif type(action) is not ParseFailure:
            action = self.world.legal(action)
        world, before = self.world, self.moment.after
        turn = self.turn = self.turn + 1
        if type(action) is ParseFailure:
            late = turn >= self.max_turns
            self.ended = (False, late)
            reward = world.failure_reward if self.failure_reward is None else self.failure_reward
            success = self.moment.success and not self.repeated
            self.moment = Moment.unread(before, action, reward, success, turn, late)
            self._state = copy.deepcopy(self._state)  # each observation is new, also if nothing happened
            info: dict[str, Any] = {"success": success, "parse_failure": action}
        else:
            self._state, reward, terminated, truncated, info = world.advance(action)
            if self.until_success and info["success"]:
                terminated = True
            late = not terminated and (truncated or turn >= self.max_turns)
            self.ended = (terminated, late)
            over = terminated or late
            self.moment = _new(Moment, (before, action, reward, world.truth, info["success"], turn, over, None))
        self.infos[STUDENT], self.said = info, ()
        self._asked = False
        return reward

    def _ask(self, cost: float) -> None:
        """The student asks for advice on what it sees; nothing else happens."""
        self._asked = True
        self._state = copy.deepcopy(self._state)
        told = {key: value for key, value in self.infos[STUDENT].items() if key not in ("atoms", "parse_failure")}
        self.infos[STUDENT], self.said = told, ()
        self._pay(0.0, -cost)
        self._pass_to_teacher()

    def teacher_turn(self, action: Any) -> None:
        """The teacher speaks; a finished episode ends with it.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        seat = self.seat
        if self.speech == "kinds":
            self._charge(self.hear(seat.say(action)))
            if seat.trimmed != self.infos[TEACHER]["trimmed"]:
                self.infos[TEACHER] = {**self.infos[TEACHER], "trimmed": seat.trimmed}
        elif self.speech == "message":
            self._charge(self.hear(seat.allow(action)))
        else:
            chosen = len(seat.choosing)
            done = seat.choose(action)
            self._charge(len(seat.choosing) - chosen)
            if done:
                self.hear(seat.chosen())

    def take_suggestion(self) -> None:
        """The teacher says what its seat suggests: all of it, but for what an instruction or the budget may not say."""
        said = self.infos[TEACHER]["suggestion"]
        self._charge(self.hear(said if self.turn and self.purse.budget is None else self.seat.allow(said)))

    def hear(self, said: str) -> int:
        """Let the student hear the teacher's words, which ends a finished episode; the number of atoms to pay for."""
        atoms = said.atoms if type(said) is Utterance else ()
        opens = not (self.turn or self._asked)
        if opens and self.speech == "message":
            self.instruction, advice = split(said, atoms)
            self.feedback = advice
            cost = len(advice.atoms)
        else:
            self.feedback = said
            cost = len(atoms) if atoms and self.moment.before is not None else price(said)  # then all is feedback
            if opens:
                atoms = self.said + atoms
        self.said = atoms
        if self._numbers is None:  # of learners from numbers few know what to do with an info of objects
            self.infos[STUDENT]["atoms"] = atoms
        if True in self.ended:
            self.terminations, self.truncations = (dict.fromkeys(self.agents, ended) for ended in self.ended)
        self.agent_selection = STUDENT
        return cost

    def understand(self, action: Any) -> Any:
        """The student's action in canonical form, or a `ParseFailure`; who has found one already gives that."""
        if type(action) is ParseFailure:
            return action
        if not self._texts:
            return self.world.legal(action)
        if not isinstance(action, str):
            raise ValueError(f"the student's action must be a string, got {action!r}; the state is unchanged")
        return parse_action(action, self.world) if self.text else legal_text(action, self.world)

    def _pass_to_teacher(self) -> None:
        seat = self.seat
        seat.see(self.moment, self._asked)
        self.infos[TEACHER] = seat.info(self.speech, not (self.turn or self._asked))
        self.agent_selection = TEACHER

    def _pay(self, teacher: float, student: float) -> None:
        """Rewards of the student's turn; what is paid between two turns of an agent adds up, to a sum never -0.0."""
        self.rewards = {TEACHER: teacher, STUDENT: student}
        self._cumulative_rewards[TEACHER] += teacher
        self._cumulative_rewards[STUDENT] = 0.0 + student

    def _charge(self, atoms: int) -> None:
        """Rewards of the teacher's turn."""
        cost = self.purse.pay(atoms)
        self.rewards = {TEACHER: cost, STUDENT: 0.0}
        self._cumulative_rewards[TEACHER] = 0.0 + cost
