"""A classroom: one teacher, many students, and never enough attention for all of them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pz_envs.seatings.classroom.spaces import sayings, teachers_choice, teachers_view
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.seats import STUDENT, TEACHER, SeatsEnv, check_flags, known_options
from pz_envs.teacher_seat import CLAIMS, LEGAL, PROSE, SUBSET_BITS, TRAITS, check_cost, is_count
from teachers.atoms import SILENCE, Moment
from teachers.seeds import Seeds

__all__ = ["MOST", "ClassroomEnv"]

MOST = 64
"""Greatest number of students."""
_ATTENDED = 5  # the column of `students`


class ClassroomEnv(SeatsEnv):
    """An AEC environment with the agents `teacher_0` and `student_0` to `student_<n - 1>`.

    Each student is taught in a world of its own, as in `TutoringEnv`; they do not hear each other.

    Turn order:
        `reset` gives every student the instruction, free of charge. Then round follows round. In a round the teacher
        comes first: it has up to `attention` turns, and with each turns to one student, or to nobody, which ends its
        part of the round. Who was not spoken to hears nothing; but with `speech="kinds"`, if its last text was no
        action, it hears the notice of that, free of charge. With `speech="message"` it hears that from no one but the
        teacher. Then every student that is left acts, in the order of the numbers. A student whose episode has ended
        (its world ended it, `max_cycles` turns are over, or it succeeded, `until_success` holds and the task is not
        repeated) can be spoken to for the last time in the teacher's next part, after which it is terminated or
        truncated and leaves `agents`. When the last one leaves, the teacher's seat ends, too: terminated if every
        student was, else truncated.

    Student:
        Observation, action and info are those of `TutoringEnv`'s student. With `ask_cost` it may ask, once a turn: it
        pays, and is not moved on; at once the teacher has one more turn, and attention for this student alone, to say
        what advice it wants to give; then the student acts.

    Teacher, `speech="kinds"`:
        Observation: Dict of
            `students`, Box (n, 6) float32, per student: turn / max_cycles, 0 to 1; its last reward, in the world's
            `reward_range`; importance of its next action, 0 to the oracle's `max_importance`; 1 if its episode is
            over, else 0; 1 until it leaves, else 0; 1 if it was spoken to in this round, else 0;
            `available`, MultiBinary (n, 5): the kinds of which there is a claim to say to it, in the order
            r, hp, hn, fp, fn;
            `purse`, Box (2,) float32: share of the round's attention and share of the budget that are left, 0 to 1;
            `action_mask`, int8 (1 + 31 n,);
            `asking`, MultiBinary (n,), only with `ask_cost`: the student that asks.
        Action: Discrete(1 + 31 n). 0: nobody; `address(i, subset)` = 31 i + subset: to student i the claims of a subset
        of the kinds, bit j of `subset` (1 to 31) for kind j.
    Teacher, `speech="claims"`:
        As with `kinds`, with 32 in place of 31: `address(i, c)` = 32 i + c says the one claim c (1 to 32) of those that
        there are to say to student i; and `claims`, Box (n, 32, 8) int8, what is to be known of each of them, as in
        `TutoringEnv`.
    Teacher, `speech="message"`:
        Observation: Dict of `student_<i>`, each a Dict of `state` and `action` (`Prose`), the student's world and last
        action as text, both empty once it has left.
        Action: Dict of `student`, Discrete(n + 1), 0 for nobody, i + 1 for student i, and `words`, `Prose`; an
        `Utterance` brings its atoms along. What words say of the instruction is not repeated.
    Info of the teacher: the privileged `moments`, a tuple with a `Moment` per student; `asking`, the number of the
    student who asks, if one does; with `kinds` also `trimmed`, the kinds of its last action of which nothing was said,
    as a subset's number; with `message` also `suggestions`, per student what its own teacher would say (empty for who
    has left), and `suggestion`, what it would answer.
    To turn to a student who has left, or a second time in a round, is to waste that attention.

    Rewards: at a student's step it gets its world's reward, and the teacher its `teacher_reward`; so over a round the
    teacher gets the sum over the class. At the teacher's step it pays `attention_cost` for turning to a student, and
    `cost` for each atom of feedback, out of one `budget` for the whole class.

    Seeds: `reset(seed)` gives the seed itself to the first student's `TutoringEnv`, and to all of them with
    `same_world`: then all begin in equal worlds, whose random streams are equal, too; the others get seeds that are
    drawn. Without a seed the streams go on.

    Args:
        desks: one `TutoringEnv` per student, all alike, of the same speech (`kinds` in place of `message`), which share
            the purse; see `Classroom.raw_env`.
        attention: students that the teacher can turn to in a round, 1 to their number.
        speech: `kinds`, `claims` or `message`.
        same_world: whether all students begin in equal worlds.
        attention_cost: paid by the teacher for turning to a student, at least 0.
        render_mode: see `SeatsEnv`; a frame has one of each desk, which has to have the same render mode.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {**SeatsEnv.metadata, "name": "classroom_v0"}  # noqa: RUF012 (PettingZoo's convention)

    def __init__(
        self,
        desks: Sequence[TutoringEnv],
        *,
        attention: int = 1,
        speech: str = "kinds",
        same_world: bool = False,
        attention_cost: float = 0.01,
        render_mode: str | None = None,
    ) -> None:
        count = len(desks)
        if not 1 <= count <= MOST:
            raise ValueError(f"students must be 1 to {MOST}, got {count}")
        if not is_count(attention, count):
            raise ValueError(
                f"attention must be an integer from 1 to {count}, the number of students, got {attention!r}"
            )
        check_cost("attention_cost", attention_cost)
        super().__init__(f"classroom_{desks[0].name}", speech, render_mode)
        check_flags(same_world=same_world)
        self.desks = tuple(desks)
        self.purse, self.max_turns = desks[0].purse, desks[0].max_turns
        self._sayings = sayings(speech)
        self.attention, self.attention_cost, self.same_world = attention, attention_cost, same_world
        self.students = tuple(f"{STUDENT[:-1]}{i}" for i in range(count))
        self._number = {student: i for i, student in enumerate(self.students)}
        self.possible_agents = [TEACHER, *self.students]
        self._asking: int | None = None
        self._rows: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self.seeds = Seeds()
        """The streams of this environment's episodes, beside those of the desks."""
        self.observation_spaces[TEACHER] = teachers_view(self.desks, speech)
        self.action_spaces[TEACHER] = teachers_choice(count, speech)
        for student, desk in zip(self.students, self.desks, strict=True):
            self.observation_spaces[student] = desk.observation_space(STUDENT)
            self.action_spaces[student] = desk.action_space(STUDENT)

    def address(self, student: int, said: int) -> int:
        """The teacher's action that says a subset of the kinds (1 to 31) or a claim (1 to 32) to a student (from 0)."""
        return self._sayings * student + said

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the worlds'."""
        world = self.desks[0].world
        world.check_reset(known_options(options, world))  # before any desk begins
        if seed is None:
            self.seeds.episode += 1
        else:
            self.seeds = Seeds(seed)
        seeds = self.seeds.stream("class").integers(2**31, size=len(self.desks)).tolist()
        if seed is not None:
            seeds[0] = seed
        for desk, own in zip(self.desks, seeds, strict=True):
            desk.reset(seeds[0] if self.same_world else own, options)
        self._open_class()

    def go_on(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson; see `SeatsEnv`."""
        self.seeds.episode += 1
        for i, desk in enumerate(self.desks):
            desk.go_on(None if start is None else start[i], options)
        self._open_class()

    @property
    def truth_now(self) -> tuple[Any, ...]:
        """The truth of each student's world."""
        return tuple(desk.truth_now for desk in self.desks)

    def _open_class(self) -> None:
        self._open()
        for student, desk in zip(self.students, self.desks, strict=True):
            self.infos[student] = desk.infos[STUDENT]
        self._paid = TEACHER
        self._terminated = True
        self._class = list(range(len(self.desks)))
        self._trimmed = 0
        self._begin_round()

    def observe(self, agent: str) -> Any:
        """What an agent sees now."""
        if agent != TEACHER:
            return self.desks[self._number[agent]].observe(STUDENT)
        if self.speech == "message":
            gone = {"state": "", "action": ""}
            return {
                student: desk.describe() if i in self._class else gone.copy()
                for i, (student, desk) in enumerate(zip(self.students, self.desks, strict=True))
            }
        if self._rows is None:
            self._rows = self._table()
        rows, true, mask = self._rows
        speaks = self.agent_selection == TEACHER
        observation = {
            "students": rows.copy(),
            "available": true.copy(),
            "purse": np.array((self._left / self.attention, self.purse.share), np.float32),
            "action_mask": mask.copy() if speaks else np.eye(1, len(mask), dtype=np.int8)[0],  # nobody
        }
        if self.speech == "claims":
            present = set(self._class)
            blank = np.zeros((CLAIMS, len(TRAITS)), np.int8)
            tables = [desk.seat.table() if i in present else blank for i, desk in enumerate(self.desks)]
            observation["claims"] = np.array(tables)
        if self.desks[0].ask_cost is not None:
            observation["asking"] = np.array([i == self._asking for i in range(len(self.desks))], np.int8)
        return observation

    def moment_of(self, student: str) -> Moment[Any]:
        """A student's last turn."""
        return self.desks[self._number[student]].moment

    def as_text(self) -> str:
        """Every desk."""
        desks = zip(self.students, self.desks, strict=True)
        return "\n\n".join(f"{student}: {desk.as_text()}" for student, desk in desks)

    def frame(self) -> Any:
        """Every desk, in rows; more than four at half their size."""
        from pz_envs.frames import tiled

        return tiled([desk.frame() for desk in self.desks])

    def close(self) -> None:
        """Close the worlds."""
        super().close()
        for desk in self.desks:
            desk.close()

    def _company(self) -> str:
        return f"students={len(self.desks)} {self.desks[0].teacher!r}"

    def _act(self, agent: str, action: Any) -> None:
        if agent == TEACHER:
            self._teach(action)
            return
        i = self._number[agent]
        desk = self.desks[i]
        desk.student_turn(action)
        self.infos[agent] = desk.infos[STUDENT]
        self._pay(agent, desk.rewards[TEACHER], desk.rewards[STUDENT])
        if desk.seat.asked:
            self._asking, self._rows = i, None
            self.infos[TEACHER] = self._privilege()
            self.agent_selection = TEACHER
            return
        self._next += 1
        if self._next < len(self._class):
            self.agent_selection = self.students[self._class[self._next]]
        else:
            self._begin_round()

    def _begin_round(self) -> None:
        self._unheard = dict.fromkeys(self._class)  # in the order of the numbers
        self._left = min(self.attention, len(self._class))
        self._asking = self._rows = None
        self._moments: tuple[Moment, ...] = tuple(desk.moment for desk in self.desks)
        self._suggestions = tuple(
            desk.seat.suggestion() if self.speech == "message" and i in self._unheard else SILENCE
            for i, desk in enumerate(self.desks)
        )
        self.infos[TEACHER] = self._privilege()
        self.agent_selection = TEACHER

    def _privilege(self) -> dict[str, Any]:
        """The teacher's info."""
        info: dict[str, Any] = {"moments": self._moments}
        if self.speech == "message":
            info["suggestions"] = self._suggestions
        elif self.speech == "kinds":
            info["trimmed"] = self._trimmed
        if self._asking is not None:
            info["asking"] = self._asking
            if self.speech == "message":
                info["suggestion"] = self.desks[self._asking].seat.suggestion()
        return info

    def _teach(self, action: Any) -> None:
        """A turn of the teacher."""
        i, said = self._understand(action)
        self._trimmed = 0 if i is None else said  # all of it, unless it is heard
        reward = 0.0
        if self._asking is not None:
            self._answer(self._asking, i, said)
            return
        if i is None:
            self._left = 0
        else:
            self._left -= 1
            reward = -self.attention_cost
            if i in self._unheard:
                reward += self._tell(i, said)
        self._pay(TEACHER, reward, 0.0)
        self.infos[TEACHER] = self._privilege()
        if not self._left or not self._unheard:
            self._dismiss()

    def _answer(self, asking: int, i: int | None, said: Any) -> None:
        """What the teacher says to a student who asks; what it says to another one is not heard."""
        desk = self.desks[asking]
        reward = 0.0 if i is None else -self.attention_cost
        if i == asking:
            reward += self._put(desk, said)
        else:
            desk.hear(SILENCE)
        self._pay(TEACHER, reward, 0.0)
        self._asking, self._rows = None, None
        self.infos[TEACHER] = self._privilege()
        self.agent_selection = self.students[asking]

    def _put(self, desk: TutoringEnv, said: Any) -> float:
        """Let a student hear something; what that costs, negated."""
        if self.speech == "kinds":
            words: str = desk.seat.say(said)
            self._trimmed = desk.seat.trimmed
        elif self.speech == "claims":
            desk.seat.choose(said)
            words = desk.seat.chosen()
        else:
            words = desk.seat.feedback(said)
        return self.purse.pay(desk.hear(words))

    def _understand(self, action: Any) -> tuple[int | None, Any]:
        """The student that an action turns to, and what it says: a subset or words.

        Raises:
            ValueError: the action is outside the action space.
        """
        space = self.action_spaces[TEACHER]
        if self.speech == "message":
            if not space.contains(action):
                raise ValueError(
                    f"the teacher's action must be a dict of `student`, 0 to {len(self.desks)}, and `words`, a string "
                    f"of at most {PROSE} characters, got {action!r:.80}"
                )
            student = int(action["student"]) - 1
            return (None if student < 0 else student), action["words"]
        last = self._sayings * len(self.desks)
        if not (type(action) is int and 0 <= action <= last) and not space.contains(action):
            raise ValueError(f"the teacher's action must be an integer from 0 to {last}, got {action!r}")
        student, said = divmod(int(action) - 1, self._sayings)
        return (None if student < 0 else student), said + 1

    def _tell(self, i: int, said: Any) -> float:
        """Say something to a student; the teacher's reward for that."""
        del self._unheard[i]
        reward = self._put(self.desks[i], said)
        if self._rows is not None:
            rows, true, mask = self._rows
            rows[i, _ATTENDED] = 1
            mask[1 + self._sayings * i : 1 + self._sayings * (i + 1)] = 0
            if not self.purse.left:
                true[:] = 0
                mask[1:] = 0
        return reward

    def _dismiss(self) -> None:
        """End the teacher's part of the round: silence for the others, the end for whose episode is over."""
        for i in self._unheard:
            desk = self.desks[i]
            desk.hear(SILENCE if self.speech == "message" else desk.seat.say(0))
        self._unheard = {}
        leaving = [i for i in self._class if any(self.desks[i].ended)]
        for i in leaving:
            terminated, truncated = self.desks[i].ended
            self.terminations[self.students[i]] = terminated
            self.truncations[self.students[i]] = truncated
            self._terminated &= terminated
            self._class.remove(i)
        self._next = 0
        if self._class:
            self.agent_selection = self.students[self._class[0]]
        else:
            self.terminations[TEACHER], self.truncations[TEACHER] = self._terminated, not self._terminated
        if leaving:
            self._rows = None
            self._deads_step_first()

    def _pay(self, agent: str, teacher: float, student: float) -> None:
        rewards, cumulative = self.rewards, self._cumulative_rewards
        if self._paid in rewards:
            rewards[self._paid] = 0.0
        cumulative[agent] = 0.0
        if agent != TEACHER:
            rewards[agent] = cumulative[agent] = student
        rewards[TEACHER] = teacher
        cumulative[TEACHER] += teacher
        self._paid = agent

    def _table(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What the teacher sees of each student, the kinds that are true, and the mask of its actions."""
        rows, true, legal = [], [], []
        present = set(self._class)
        nothing = np.zeros(self._sayings, np.int8)
        for i, desk in enumerate(self.desks):
            turn, reward, importance, _, over = desk.seat.features()
            here = i in present
            heard = here and i not in self._unheard
            available = desk.seat.available() if here else 0
            rows.append((turn, reward, 0.0 if over else importance, over, here, heard))
            true.append(available)
            mute = not here or (heard if self._asking is None else i != self._asking)
            if mute:
                legal.append(nothing)
            else:
                legal.append(LEGAL[available, 1:] if self.speech == "kinds" else desk.seat.choices()[1:])
        mask = np.ones(1 + self._sayings * len(rows), np.int8)
        mask[1:] = np.concatenate(legal)
        return np.array(rows, np.float32), SUBSET_BITS[true], mask
