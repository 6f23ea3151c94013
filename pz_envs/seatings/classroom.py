"""A classroom: one teacher with limited attention, and several students."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.assembly import Parts, assemble
from pz_envs.frames import tile_frames
from pz_envs.global_state import Seated, Shared
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import Attention, refuse_unread
from pz_envs.seats import STUDENT, TEACHER, SeatsEnv, checked_options
from pz_envs.settings import Settings, check_flags
from pz_envs.subject import Seating, Subject
from pz_envs.teacher_view import CHOICES, CLAIM_COLUMNS, LEGAL, SUBSET_BITS, mask_space, words_space
from teachers.atoms import KINDS, SILENCE, Moment
from teachers.budget import Budget
from teachers.seeds import Seeds
from teachers.spec import check_cost, is_count
from teachers.teacher_turn import CLAIMS, LONGEST
from worlds.pictures.canvas import Frame
from worlds.spaces import Prose

__all__ = ["MOST", "SEATING", "Classroom", "ClassroomEnv"]

MOST = 64
"""Greatest number of students."""
_ATTENDED = 5  # index of this column of `students`


class ClassroomEnv(SeatsEnv):
    """An AEC environment with the agents `teacher_0` and `student_0` to `student_<n - 1>`.

    Each student has a session of its own, as in `TutoringEnv`; students do not hear each other.

    Turn order:
        `reset` gives every student the instruction, free of charge. Then rounds follow. In a round the teacher is
        first: it has up to `attention` turns, and addresses one student in each, or nobody, which ends its part of the
        round. A student without address hears nothing, with one exception: with `speech="kinds"` it hears, free of
        charge, that its last text was no action. With `speech="message"` only the teacher can say so. Then every
        remaining student acts, in the order of the numbers. A student whose episode has ended (by the world, after
        `max_cycles` turns, or by success if `until_success` holds and the task is not repeated) can be addressed for
        the last time in the teacher's next part; then it is terminated or truncated and leaves `agents`. When the last
        student leaves, the teacher's episode ends, too: terminated if every student was, else truncated.

    Student:
        Observation, action and info are those of `TutoringEnv`'s student. With `ask_cost` it may ask, once a turn. It
        pays, and its world does not step. The teacher at once has an extra turn to advise this student; then the
        student acts.

    Teacher, `speech="kinds"`:
        Observation: Dict of
            `students`, Box (n, 6) float32, per student: turn / max_cycles, 0 to 1; its last reward, in the world's
            `reward_range`; importance of its next action, 0 to the oracle's `max_importance`; 1 if its episode is
            over, else 0; 1 until it leaves, else 0; 1 if it was addressed in this round, else 0;
            `available`, MultiBinary (n, 5): the kinds with a claim for it, in the order r, hp, hn, fp, fn;
            `remaining`, Box (2,) float32: share of the round's attention and share of the budget that are left, 0 to 1;
            `action_mask`, int8 (1 + 31 n,);
            `asking`, MultiBinary (n,), only with `ask_cost`: the student that asks.
        Action: Discrete(1 + 31 n). 0: nobody; `address(i, subset)` = 31 i + subset: to student i the claims of a subset
        of the kinds, bit j of `subset` (1 to 31) for kind j.
    Teacher, `speech="claims"`:
        As with `kinds`, with 32 in place of 31: `address(i, c)` = 32 i + c says claim c (1 to 32) of those for student
        i; and `claims`, Box (n, 32, 8) int8, the kind and the role of each claim, as in `TutoringEnv`.
    Teacher, `speech="message"`:
        Observation: Dict of `student_<i>`, each a Dict of `state` and `action` (`Prose`), the student's world and last
        action as text, both empty once it has left.
        Action: Dict of `student`, Discrete(n + 1), 0 for nobody, i + 1 for student i, and `words`, `Prose`; an
        `Utterance` brings its atoms along. Atoms of the instruction are left out.
    Info of the teacher: the privileged `moments`, a tuple with a `Moment` per student; `asking`, the number of the
    student that asks, if one does; with `kinds` also `trimmed`, the kinds of its last action that were left unsaid, as
    a subset's number; with `message` also `suggestions`, per student what the personality would say (empty for a
    student that has left), and `suggestion`, its answer to a question. Attention for a student that has left, or for
    the second time in a round, is lost.

    Rewards: at a student's step it gets its world's reward, and the teacher its `teacher_reward`; so over a round the
    teacher gets the sum over the class. At the teacher's step it pays `attention_cost` for addressing a student, and
    `cost` for each atom of feedback; one `budget` is for the whole class.

    Seeds: `reset(seed)` gives the seed itself to the first student's `TutoringEnv`, and to all of them with
    `same_world`: then all begin in equal worlds with equal random streams. Else the seeds of the others are drawn.
    Without a seed the streams go on.

    Args:
        lessons: the parts of one session per student, with equal settings and one budget.
        settings: the settings of each session.
        name: the environment's first label.
        attention: students that the teacher can address in a round, 1 to their number.
        same_world: whether all students begin in equal worlds.
        attention_cost: paid by the teacher for addressing a student, at least 0.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(
        self,
        lessons: Sequence[Parts],
        settings: Settings,
        name: str = "tutoring",
        *,
        attention: int = 1,
        same_world: bool = False,
        attention_cost: float = 0.01,
    ) -> None:
        count = len(lessons)
        if not is_count(attention, count):
            raise ValueError(
                f"attention must be an integer from 1 to {count}, the number of students, got {attention!r}"
            )
        check_cost("attention_cost", attention_cost)
        check_flags(same_world=same_world)
        super().__init__(f"classroom_{name}", settings.speech, settings.render_mode)
        self.sessions = tuple(parts.session for parts in lessons)
        """The session of each student."""
        self.student_views = tuple(parts.student_view for parts in lessons)
        """The view of each student."""
        self.teacher_views = tuple(parts.teacher_views[0] for parts in lessons)
        """The teacher's view of each student's session."""
        self.budget, self.max_turns = self.teacher_views[0].teacher_turn.budget, self.sessions[0].max_turns
        self._choices: int = CHOICES.get(settings.speech, 2) - 1  # actions for one student
        self.attention, self.attention_cost, self.same_world = attention, attention_cost, same_world
        self.students = tuple(f"{STUDENT[:-1]}{i}" for i in range(count))
        self._number = {student: i for i, student in enumerate(self.students)}
        self.possible_agents = [TEACHER, *self.students]
        self._asking: int | None = None
        self._rows: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self.seeds = Seeds()
        """The streams of this environment's episodes, beside those of the sessions."""
        self.observation_spaces[TEACHER] = self._teacher_observation_space()
        self.action_spaces[TEACHER] = self._teacher_action_space()
        for student, view in zip(self.students, self.student_views, strict=True):
            self.observation_spaces[student], self.action_spaces[student] = view.observation_space, view.action_space

    def address(self, student: int, said: int) -> int:
        """The teacher's action that says a subset of the kinds (1 to 31) or a claim (1 to 32) to a student (from 0)."""
        return self._choices * student + said

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the worlds'."""
        world = self.sessions[0].world
        options = checked_options(options, world)  # before any session begins
        if seed is None:
            self.seeds.episode += 1
        else:
            self.seeds = Seeds(seed)
        seeds = self.seeds.stream("class").integers(2**31, size=len(self.sessions)).tolist()
        if seed is not None:
            seeds[0] = seed
        for session, own in zip(self.sessions, seeds, strict=True):
            session.open(seeds[0] if self.same_world else own, options)
        self._open_class()

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson; see `SeatsEnv`."""
        self.seeds.episode += 1
        for i, session in enumerate(self.sessions):
            session.start_next_episode(None if start is None else start[i], checked_options(options, session.world))
        self._open_class()

    @property
    def current_truth(self) -> tuple[Any, ...]:
        """The truth of each student's world."""
        return tuple(session.moment.after for session in self.sessions)

    def _open_class(self) -> None:
        self._open()
        for student, view in zip(self.students, self.student_views, strict=True):
            self.infos[student] = view.info()
        self._paid = TEACHER
        self._terminated = True
        self._class = list(range(len(self.sessions)))
        self._trimmed = 0
        self._begin_round()
        self._show_masks()

    @property
    def seated(self) -> list[Seated]:
        """The students with their teacher."""
        views = zip(self.students, self.student_views, self.teacher_views, strict=True)
        return [Seated(student, view, {TEACHER: teacher}) for student, view, teacher in views]

    def shared(self) -> list[Shared]:
        """The attention of the round."""
        left = getattr(self, "_left", 0) / self.attention
        return [Shared("attention", "share of the round's attention that is left", left)]

    def _observe(self, agent: str) -> Any:
        if agent != TEACHER:
            return self.student_views[self._number[agent]].observe()
        if self.speech == "message":
            gone = {"state": "", "action": ""}
            return {
                student: teacher.words() if i in self._class else gone.copy()
                for i, (student, teacher) in enumerate(zip(self.students, self.teacher_views, strict=True))
            }
        if self._rows is None:
            self._rows = self._table()
        rows, true, mask = self._rows
        speaks = self.agent_selection == TEACHER
        observation = {
            "students": rows.copy(),
            "available": true.copy(),
            "remaining": np.array((self._left / self.attention, self.budget.share), np.float32),
            "action_mask": mask.copy() if speaks else np.eye(1, len(mask), dtype=np.int8)[0],  # nobody
        }
        if self.speech == "claims":
            present = set(self._class)
            blank = np.zeros((CLAIMS, len(CLAIM_COLUMNS)), np.int8)
            tables = [teacher.table() if i in present else blank for i, teacher in enumerate(self.teacher_views)]
            observation["claims"] = np.array(tables)
        if self.sessions[0].ask_cost is not None:
            observation["asking"] = np.array([i == self._asking for i in range(len(self.sessions))], np.int8)
        return observation

    def moment_of(self, student: str) -> Moment[Any]:
        """The last moment of a student: privileged."""
        return self.sessions[self._number[student]].moment

    def as_text(self) -> str:
        """The text of each session."""
        views = zip(self.students, self.student_views, strict=True)
        return "\n\n".join(f"{student}: {view.as_text()}" for student, view in views)

    def frame(self) -> Frame:
        """The frames of all sessions, in rows; more than four at half their size."""
        return tile_frames([view.frame() for view in self.student_views])

    def close(self) -> None:
        """Close the window and the worlds."""
        super().close()
        for session in self.sessions:
            session.world.close()

    def _describe_seats(self) -> str:
        return f"students={len(self.sessions)} {self.sessions[0].teacher!r}"

    def _act(self, agent: str, action: Any) -> None:
        if agent == TEACHER:
            self._teach(action)
            return
        i = self._number[agent]
        reward = self.student_views[i].act(action)
        self.infos[agent] = self.student_views[i].info()
        self._pay(agent, self.teacher_views[i].reward(), reward)
        if self.sessions[i].asked:
            self._asking, self._rows = i, None
            self.infos[TEACHER] = self._teacher_info()
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
        self._moments: tuple[Moment, ...] = tuple(session.moment for session in self.sessions)
        self._suggestions = tuple(
            session.suggest() if self.speech == "message" and i in self._unheard else SILENCE
            for i, session in enumerate(self.sessions)
        )
        self.infos[TEACHER] = self._teacher_info()
        self.agent_selection = TEACHER

    def _teacher_info(self) -> dict[str, Any]:
        """The teacher's info."""
        info: dict[str, Any] = {"moments": self._moments}
        if self.speech == "message":
            info["suggestions"] = self._suggestions
        elif self.speech == "kinds":
            info["trimmed"] = self._trimmed
        if self._asking is not None:
            info["asking"] = self._asking
            if self.speech == "message":
                info["suggestion"] = self.sessions[self._asking].suggest()
        return info

    def _teach(self, action: Any) -> None:
        """The teacher's turn."""
        i, said = self._parse_action(action)
        self._trimmed = 0 if i is None else said  # the student has heard nothing of it yet
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
                reward += self._address(i, said)
        self._pay(TEACHER, reward, 0.0)
        self.infos[TEACHER] = self._teacher_info()
        if not self._left or not self._unheard:
            self._end_teacher_part()

    def _answer(self, asking: int, i: int | None, said: Any) -> None:
        """The teacher's answer to the student that asks; words for another student are lost."""
        reward = 0.0 if i is None else -self.attention_cost
        if i == asking:
            reward += self._say(asking, said)
        else:
            self._end_turn(asking)
        self._pay(TEACHER, reward, 0.0)
        self._asking, self._rows = None, None
        self.infos[TEACHER] = self._teacher_info()
        self.agent_selection = self.students[asking]

    def _say(self, i: int, said: Any) -> float:
        """Speak to a student; returns the teacher's reward."""
        session, teacher = self.sessions[i], self.teacher_views[i]
        reward = teacher.act(said)
        if not session.heard:  # each turn says one claim
            session.choose(0)
        self._trimmed = teacher.teacher_turn.trimmed if self.speech == "kinds" else self._trimmed
        return reward

    def _end_turn(self, i: int) -> None:
        """Say nothing to a student, apart from the free notice that its text was no action."""
        session = self.sessions[i]
        if self.speech == "message" or session.asked:
            session.say(SILENCE)
        else:
            session.say_kinds(0)

    def _parse_action(self, action: Any) -> tuple[int | None, Any]:
        """The student that an action addresses, and its content: a subset, a claim's number or words.

        Raises:
            ValueError: the action is outside the action space.
        """
        space = self.action_spaces[TEACHER]
        if self.speech == "message":
            if not space.contains(action):
                raise ValueError(
                    f"the teacher's action must be a dict of `student`, 0 to {len(self.sessions)}, and `words`, a "
                    f"string of at most {LONGEST} characters, got {action!r:.80}"
                )
            student = int(action["student"]) - 1
            return (None if student < 0 else student), action["words"]
        last = self._choices * len(self.sessions)
        if not (type(action) is int and 0 <= action <= last) and not space.contains(action):
            raise ValueError(f"the teacher's action must be an integer from 0 to {last}, got {action!r}")
        student, said = divmod(int(action) - 1, self._choices)
        return (None if student < 0 else student), said + 1

    def _address(self, i: int, said: Any) -> float:
        """Speak to a student that has not been addressed in this round; returns the teacher's reward."""
        del self._unheard[i]
        reward = self._say(i, said)
        if self._rows is not None:
            rows, true, mask = self._rows
            rows[i, _ATTENDED] = 1
            mask[1 + self._choices * i : 1 + self._choices * (i + 1)] = 0
            if not self.budget.left:
                true[:] = 0
                mask[1:] = 0
        return reward

    def _end_teacher_part(self) -> None:
        """End the teacher's part of the round: the others hear nothing, and students whose episode is over leave."""
        for i in self._unheard:
            self._end_turn(i)
        self._unheard = {}
        leaving = [i for i in self._class if self.sessions[i].over]
        for i in leaving:
            session, student = self.sessions[i], self.students[i]
            self.terminations[student], self.truncations[student] = session.terminated, session.truncated
            self._terminated &= session.terminated
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
        """The teacher's `students`, `available` and `action_mask`."""
        rows, true, legal = [], [], []
        present = set(self._class)
        nothing = np.zeros(self._choices, np.int8)
        for i, teacher in enumerate(self.teacher_views):
            turn, reward, importance, _, over = teacher.teacher_turn.features(teacher.teacher_turn.moment)
            here = i in present
            heard = here and i not in self._unheard
            available = teacher.teacher_turn.available() if here else 0
            rows.append((turn, reward, 0.0 if over else importance, over, here, heard))
            true.append(available)
            mute = not here or (heard if self._asking is None else i != self._asking)
            if mute:
                legal.append(nothing)
            else:
                legal.append(LEGAL[available, 1:] if self.speech == "kinds" else teacher.choices()[1:])
        mask = np.ones(1 + self._choices * len(rows), np.int8)
        mask[1:] = np.concatenate(legal)
        return np.array(rows, np.float32), SUBSET_BITS[true], mask

    def _teacher_observation_space(self) -> spaces.Dict:
        count = len(self.sessions)
        if self.speech == "message":
            return spaces.Dict({student: words_space() for student in self.students})
        low, high = self.teacher_views[0].feature_bounds()
        more: dict[str, spaces.Space[Any]] = {}
        if self.speech == "claims":
            more["claims"] = spaces.Box(0, 1, (count, CLAIMS, len(CLAIM_COLUMNS)), np.int8)
        if self.sessions[0].ask_cost is not None:
            more["asking"] = spaces.MultiBinary(count)
        keep = [0, 1, 2, 4, 4, 4]  # `present` and `addressed` have the bounds of `over`
        return spaces.Dict(
            {
                "students": spaces.Box(np.tile(low[keep], (count, 1)), np.tile(high[keep], (count, 1))),
                "available": spaces.MultiBinary((count, len(KINDS))),
                "remaining": spaces.Box(0, 1, (2,), np.float32),
                "action_mask": mask_space(1 + self._choices * count),
                **more,
            }
        )

    def _teacher_action_space(self) -> spaces.Space[Any]:
        count = len(self.sessions)
        if self.speech == "message":
            return spaces.Dict({"student": spaces.Discrete(count + 1), "words": Prose(LONGEST)})
        return spaces.Discrete(1 + self._choices * count)


class Classroom(Seating):
    """One teacher and several students."""

    defaults = {"speech": "kinds", "until_success": True}  # noqa: RUF012 (as of `Seating`)

    def raw_env(
        self,
        subject: Subject,
        settings: Settings,
        *,
        students: int = 8,
        attention: int = 1,
        same_world: bool = False,
        attention_cost: float = 0.01,
    ) -> ClassroomEnv:
        """One teacher and several students; see `ClassroomEnv`.

        Args:
            subject: the subject.
            settings: of each session; the budget is for the whole class.
            students: their number, 1 to 64.
            attention: students that the teacher can address in a round, 1 to their number.
            same_world: whether all students begin in equal worlds.
            attention_cost: paid by the teacher for addressing a student, at least 0.

        Raises:
            ValueError: an argument is not allowed.
        """
        if not is_count(students, MOST):
            raise ValueError(f"students must be an integer from 1 to {MOST}, got {students!r}")
        budget = Budget(settings.cost, settings.budget)
        return ClassroomEnv(
            [assemble(subject, settings, budget=budget, instructs=True) for _ in range(students)],
            settings,
            subject.name,
            attention=attention,
            same_world=same_world,
            attention_cost=attention_cost,
        )

    def parallel_env(
        self, subject: Subject, settings: Settings, *, rule: str = "round_robin", **own: Any
    ) -> ParallelSeats:
        """The students, which act at the same time; a scripted teacher divides its attention among them by a rule.

        See `pz_envs.scripted.Attention` for the rules, and `pz_envs.parallel_seats.ParallelSeats`.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"`.
        """
        refuse_unread(settings.speech, settings.teacher_numbers)
        return ParallelSeats(self.seats(subject, settings, **own), {TEACHER: Attention(rule)})


SEATING = Classroom()
