"""The teacher's seat, in arrays."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from llf_teacher.gym.lifetime_statistics import NEAR
from llf_teacher.gym.teacher_env import TeacherEnv
from llf_teacher.gym.vector.lifetime_statistics import LifetimeStatisticsBatch, columns
from llf_teacher.gym.vector.rows import SHOWN, RowsEnv
from llf_teacher.gym.vector.spoken import Spoken
from llf_teacher.students.batches import Seats
from llf_teacher.students.batches.traited import students
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student, frozen
from llf_teacher.students.variation import check_vary, draw_student, is_integer_range
from pz_envs.settings import FIELDS, Settings, SettingsKeywords, check_flags, takes_settings
from pz_envs.teacher_view import LEGAL, SUBSET_BITS
from teachers.atoms import FP
from teachers.batches import Moments
from teachers.feedback import BIT
from teachers.seeds import Seeds
from teachers.spec import is_count, unknown
from worlds.batches import Bools, Floats, Ints, Rows, merged
from worlds.batches.streams import Streams

_PRICES = ("cost", "budget", "teacher_reward")
_USED = SHOWN | {"teacher", "feedback_type", *_PRICES, "teacher_numbers", "max_turns", "until_success"}
REWARDS: dict[str, Callable[[Moments[Any], Floats], Floats]] = {
    "student_reward": lambda moments, _: moments.reward,
    "student_progress": lambda _, regret: -regret,
    "success_minus_cost": lambda moments, _: (moments.over & moments.success).astype(np.float64),
}
"""The named rewards of `pz_envs.rewards` in arrays: functions of the turns' moments and regret."""


class TeacherVectorEnv(RowsEnv):
    """Teachers' seats in arrays, each with a student that learns: `TeacherEnv` with `speech="kinds"`.

    Observation, action, reward, lifetimes, budgets and announcements are those of `TeacherEnv`; the episodes of a
    lifetime begin in the same state of one world. Info: `intention`, the announced action, -1 without one; `trimmed`.
    `lesson` gives a row as a scalar environment.

    Args:
        env_id: an id of `llf_teacher.ids()` whose family can be played in arrays.
        num_envs: number of rows.
        student: a spec string or a `Student` with a form in arrays; None: `q_learning(trust=1.0)`, or `obedient` where
            actions are points of a box.
        settings: the settings of the lessons; None: the defaults, in a lifetime with `until_success=True`.
        actions, episodes, vary, announce: as in `TeacherEnv`.
        autoreset_mode: one of Gymnasium's modes.
        keywords: fields of `pz_envs.settings.Settings` that replace them, the world's options, and options of the
            family's batch, such as `pool`. Allowed are `teacher` (personalities that withhold or delay kinds of
            claims; see `Personality.in_arrays`), `feedback_type` (not `m`: it is the same in each turn), `cost`,
            `budget`, `teacher_reward` (a name of `pz_envs.rewards`), `teacher_numbers`, `max_turns`, `until_success`,
            `render_mode` and `theme`.

    Raises:
        ValueError: an argument is not allowed.
    """

    instead = "TeacherEnv"

    @takes_settings(without=FIELDS - _USED)
    def __init__(
        self,
        env_id: str,
        num_envs: int = 1,
        *,
        settings: Settings | None = None,
        student: str | Student | None = None,
        actions: str = "all",
        episodes: int = 1,
        vary: Mapping[str, Any] | None = None,
        announce: bool = False,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **keywords: Unpack[SettingsKeywords],
    ) -> None:
        check_flags(announce=announce)
        if not is_count(episodes):
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        until_success = episodes > 1
        super().__init__(env_id, num_envs, settings, keywords, autoreset_mode, used=_USED, until_success=until_success)
        space = self.worlds.world.action_space
        default = "q_learning(trust=1.0)" if isinstance(space, spaces.Discrete) else "obedient"
        spec = parse_student(default if student is None else student)
        reward = self.settings.teacher_reward
        if not isinstance(reward, str) or reward not in REWARDS:
            raise ValueError(f"in arrays there is no such reward: {unknown('teacher_reward', reward, REWARDS)}")
        states = self.worlds.number_states(self.max_turns + 1)
        self._pupil_streams = Streams(np.zeros(num_envs, np.uint64))
        self.students = students(spec, Seats(num_envs, states, space, self._pupil_streams, self.teacher.late))
        """The students, in arrays."""
        if episodes == 1 and not self.students.spec.forget:
            raise ValueError("a student with forget=False is for lifetimes of several episodes; give episodes")
        self._vary = dict(vary or {})
        if self._vary:
            check_vary(spec, self._vary)
        self.actions, self.episodes, self.announce = actions, episodes, announce
        self.cost, self.budget = self.settings.cost, self.settings.budget
        self._reward = reward
        self.lives = LifetimeStatisticsBatch(num_envs, states, episodes)
        """The statistics of the lifetimes."""
        self.spent = np.zeros(num_envs, np.int64)
        """Atoms said in each lifetime, int64 (rows,)."""
        self._trimmed, self._everywhere = np.zeros(num_envs, np.int64), np.ones(num_envs, bool)
        self._finished = np.zeros(num_envs, bool)
        self._start = self.worlds.state
        scalar = self._scalar(
            replace(spec, **{name: ends[1] for name, ends in self._vary.items()})
        )  # raises the errors of the scalar environment
        self._low, self._high = scalar.teacher_view.low, scalar.teacher_view.high
        self.fields = scalar.fields
        """The fields of a row's observation, in their order; empty without `teacher_numbers=True`."""
        self._flat = scalar.flat
        self.subsets = scalar.subsets
        """The subset of kinds that each action says."""
        self._subsets = np.array(self.subsets)
        self._legal = LEGAL[:, self._subsets]
        self._set_spaces(scalar.observation_space, scalar.action_space)

    def __repr__(self) -> str:
        teacher, feedback_type = str(self.teacher.personality), self.settings.feedback_type
        return self._repr(student=str(self.students.spec), teacher=teacher, feedback_type=feedback_type)

    def _scalar(self, student: Student) -> TeacherEnv:
        """A row's scalar environment."""
        return TeacherEnv(
            self.env_id,
            settings=replace(self.scalar_settings, speech="kinds"),
            until_success=self.settings.until_success,  # otherwise TeacherEnv would take its own default
            student=student,
            actions=self.actions,
            episodes=self.episodes,
            announce=self.announce,
        )

    def lesson(self, row: int) -> TeacherEnv:
        """The scalar environment in a row's state, before the teacher speaks.

        From there both agree until the end of the lifetime, under the same actions.
        """
        row = self._check_row(row)
        env = self._scalar(self.students.student(row))
        env.reset(seed=row)
        done, terminated = bool(self._finished[row]), bool(self.terminated()[row])
        start = self.worlds.truth(self._start, row)
        spent, past = int(self.spent[row]), self._before(row)
        env.resume_from(self.moment(row), terminated=terminated, spent=spent, start=start, done=done, past=past)
        env.session.world.np_random = self._streams.stream(row)
        seen = [frozen(self.worlds.seen(row, place)) for place in range(self.lives.visits.shape[1])]
        self.students.teach(env.student, row, int(self.moments.turn[row]), seen, int(self.lives.here[row]))
        env.session.seeds = _RowSeeds(row, env.student.rng)
        if env.life is not None:
            env.life.restore(**self.lives.restore_arguments(row, seen))
        return env

    def action_masks(self) -> Bools:
        """Which actions are legal now, bool (rows, actions), as learners with action masks need it."""
        return self._mask().astype(bool)

    def _begin(self, rows: Ints, seeds: Sequence[int | None]) -> None:
        """Begin lifetimes with new students."""
        self._pupil_streams.states[rows] = self._draws.integers(2**64, size=len(rows), dtype=np.uint64)
        self.students.enrol(rows, self._draw_parameters(len(rows), seeds))
        self.spent[rows] = self._trimmed[rows] = 0
        self._finished[rows] = False
        self._start = merged(self._start, rows, self.worlds.taken(self.worlds.state, rows))
        self.lives.begin(rows, self.worlds.place(rows))

    def _draw_parameters(self, count: int, seeds: Sequence[int | None]) -> dict[str, npt.NDArray[Any]]:
        """The drawn parameters; a row with a seed has those of the scalar environment."""
        parameters: dict[str, npt.NDArray[Any]] = {}
        for name in sorted(self._vary):
            low, high = self._vary[name]
            whole = is_integer_range(low, high)
            draw = self._draws.integers(low, high + 1, count) if whole else self._draws.uniform(low, high, count)
            parameters[name] = np.asarray(draw)
        for i, seed in enumerate(seeds if self._vary else ()):
            if seed is not None:
                student = draw_student(self.students.spec, self._vary, Seeds(seed).stream("class"))
                for name, values in parameters.items():
                    values[i] = getattr(student, name)
        return parameters

    def _play(self, actions: npt.NDArray[Any], rows: Rows) -> tuple[Floats, Bools, Bools]:
        """The teacher's turn, then the student's; at the end of an episode the opening of the next."""
        here = self._all_rows[rows]
        wanted = self._subsets[actions]
        left = None if self.budget is None else np.maximum(self.budget - self.spent[rows], 0)
        said, atoms = self._spoken.say(wanted, rows, left)
        self._trimmed[rows] = wanted & ~said
        self.spent[rows] += atoms
        reward = np.zeros(self.num_envs)
        reward[rows] = -self.cost * atoms
        self.lives.said(here[(said & BIT[FP]) > 0])
        over = self.moments.over[rows]
        self._finished[rows] = False
        if over.any():
            last = here[over]
            self._end(last, said[over])
            self._act_of_students(here[~over], said[~over], reward)
        else:
            self._act_of_students(here, said, reward)
        finished = self._finished[rows]
        terminated = finished & self.terminated(rows)
        return reward[rows], terminated, finished & ~terminated

    def _act_of_students(self, rows: Ints, said: Ints, reward: Floats) -> None:
        if not len(rows):
            return
        places = self.lives.here[rows]
        actions = self.students.act(rows, places, self.moments.reward[rows], self._spoken.heard(rows, said))
        self._act(actions, rows if len(rows) < self.num_envs else slice(None))
        regret = self._stakes.regret(self.moments)  # in the states before the turn
        reward[rows] += REWARDS[self._reward](self.moments, regret)[rows]
        self.lives.acted(rows, regret[rows] <= NEAR)
        self.lives.arrive(rows, self.worlds.place(rows))

    def _end(self, rows: Ints, said: Ints) -> None:
        """End episodes, and begin the next ones of lifetimes that go on."""
        if self.episodes > 1:
            places, rewards = self.lives.here[rows], self.moments.reward[rows]
            self.students.finish(rows, places, rewards, self.terminated(rows), self._spoken.heard(rows, said))
            self.lives.end_episode(rows, self.moments.success[rows])
        ends = (self.lives.episode[rows] == self.episodes) | (self.episodes == 1)
        self._finished[rows[ends]] = True
        on = rows[~ends]
        if len(on):
            self.worlds.state = merged(self.worlds.state, on, self.worlds.taken(self._start, on))
            self._open(on)
            self.lives.arrive(on, self.worlds.place(on))
            if self.worlds.states is None:
                lost = self.students.lost(on)
                bound = self.worlds.forget(on, lost)
                self.lives.forget(on, lost, bound)
                self.students.forget(on, lost, bound)
            self.students.begin(on)

    def _observe(self) -> Any:
        moments = self.moments
        self._spoken = Spoken(self._judge()[0])
        share = np.ones(self.num_envs)
        if self.budget is not None:
            share = np.maximum(self.budget - self.spent, 0) / self.budget
        self._stakes = self.oracle.stakes(moments.after)
        paid = np.clip(moments.reward, self._low, self._high)
        observed: dict[str, npt.NDArray[Any]] = {
            "available": SUBSET_BITS.take(self._available(), axis=0),
            "features": columns(moments.turn / self.max_turns, paid, self._stakes.importance, share, moments.over),
            "action_mask": self._mask(),
        }
        self._intention = np.full(self.num_envs, -1)
        if self.announce:
            rows = np.flatnonzero(~moments.over)
            self._intention[rows] = self.students.intend(rows, self.lives.here[rows], moments.reward[rows])
        if self.episodes > 1:
            announced = self._intention >= 0
            mistake = announced & self._stakes.mistakes(np.maximum(self._intention, 0)) if self.announce else announced
            way = np.where(moments.over, 0, self.oracle.plan_length(moments.after, self.max_turns))
            observed["lifetime"] = self.lives.features(announced, mistake, way)
        return observed if self._flat is None else self._flat.of(observed, self.num_envs)

    def _available(self) -> Ints:
        kinds = self._spoken.kinds
        return kinds if self.budget is None else np.where(self.spent < self.budget, kinds, 0)

    def _mask(self) -> npt.NDArray[np.int8]:
        """The subsets that can be said; only silence when a lifetime is over."""
        return self._legal.take(np.where(self._finished, 0, self._available()), axis=0)

    def _infos(self) -> dict[str, Any]:
        masked = {} if self._flat is None else {"action_mask": self._mask(), "_action_mask": self._everywhere}
        return masked | {
            "intention": self._intention,
            "_intention": self._intention >= 0,
            "trimmed": self._trimmed.copy(),
            "_trimmed": self._everywhere.copy(),
        }


class _RowSeeds(Seeds):
    """The seeds of a scalar lesson; its student draws from the stream of a row in all episodes."""

    def __init__(self, seed: int, student: np.random.Generator) -> None:
        super().__init__(seed)
        self._student = student

    def stream(self, name: str, seat: int = 0) -> np.random.Generator:
        """The stream of the base class, except for the student."""
        return self._student if name == "student" else super().stream(name, seat)
