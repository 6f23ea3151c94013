"""The teacher's seat, in arrays."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from llf_teacher.gym.lifetime import NEAR, check_vary, drawn, is_whole
from llf_teacher.gym.teacher_env import TeacherEnv
from llf_teacher.gym.vector.lifetimes import Lifetimes, columns
from llf_teacher.gym.vector.rows import RowsEnv
from llf_teacher.students.batches import learners
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student, frozen
from pz_envs.settings import check_flags
from pz_envs.teacher_view import LEGAL, SUBSET_BITS
from teachers.atoms import FP, KINDS
from teachers.batches import Moments
from teachers.feedback import MIXED, parse_kinds
from teachers.seeds import Seeds
from teachers.session import BIT, check_cost, is_count
from teachers.spec import unknown
from worlds.batches import Bools, Floats, Ints, Rows, chosen, merged, most
from worlds.batches.streams import Streams

_COUNT = SUBSET_BITS.sum(1)
_FIRST = (SUBSET_BITS.cumsum(1)[:, None] <= np.arange(len(KINDS) + 1)[:, None]) & (SUBSET_BITS[:, None] > 0)
WITHIN = (_FIRST * [BIT[kind] for kind in KINDS]).sum(2).astype(np.uint8)
"""Per subset what is left of it if only so many atoms can be said, in speaking order; shape (32, 6)."""
Paid = Callable[[Moments[Any], Floats], Floats]
"""The teacher's reward of turns, given the moments and their regret."""


def _student_reward(moments: Moments[Any], regret: Floats) -> Floats:
    return moments.reward


def _student_progress(moments: Moments[Any], regret: Floats) -> Floats:
    return -regret


def _success_minus_cost(moments: Moments[Any], regret: Floats) -> Floats:
    return (moments.over & moments.success).astype(np.float64)


REWARDS: dict[str, Paid] = {
    function.__name__.lstrip("_"): function for function in (_student_reward, _student_progress, _success_minus_cost)
}
"""The named rewards of `pz_envs.rewards` in arrays."""


class TeacherVectorEnv(RowsEnv):
    """Many teachers' seats, each in front of a student who learns: `TeacherEnv` in arrays, with `speech="kinds"`.

    Observation, action, reward, lifetimes, budgets and announcements are as there; the oracle's claims are what there
    is to say, and the episodes of a lifetime begin in the same state of one world. Info: `intention`, what was
    announced, -1 where nothing was; `trimmed`, as there. `lesson` gives a row as a scalar environment.

    Args:
        env_id: an id of `llf_teacher.ids()` whose family can be played in arrays, with finitely many states.
        num_envs: rows.
        student: a spec string or a `Student` that can be played in arrays.
        actions, episodes, vary, announce, cost, budget, max_turns, until_success: as in `TeacherEnv`.
        feedback_type: `a`, `n`, or kinds; it is the same in each turn, so not `m`.
        teacher_reward: a name, as in `pz_envs.rewards`.
        autoreset_mode: one of Gymnasium's.
        options: the world's, and those of the family's batch, such as `pool`.

    Raises:
        ValueError: an argument is not supported.
    """

    def __init__(
        self,
        env_id: str,
        num_envs: int = 1,
        *,
        student: str | Student = "q_learning(trust=1.0)",
        actions: str = "all",
        episodes: int = 1,
        vary: Mapping[str, Any] | None = None,
        announce: bool = False,
        feedback_type: str | Iterable[str] = "a",
        cost: float = 0.01,
        budget: int | None = None,
        teacher_reward: str = "student_reward",
        max_turns: int | None = None,
        until_success: bool | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **options: Any,
    ) -> None:
        spec = parse_student(student)
        check_flags(announce=announce)
        check_cost("cost", cost)
        if not is_count(episodes):
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        if budget is not None and not is_count(budget):
            raise ValueError(f"budget must be None or an integer of at least 1, got {budget!r}")
        if teacher_reward not in REWARDS:
            raise ValueError(f"in arrays there is no such reward: {unknown('teacher_reward', teacher_reward, REWARDS)}")
        if feedback_type == MIXED:
            raise ValueError("feedback_type 'm' is not supported in arrays; allowed: a, n, or kinds; 'm': TeacherEnv")
        until_success = episodes > 1 if until_success is None else until_success
        super().__init__(env_id, num_envs, max_turns, until_success, autoreset_mode, options)
        space = self.worlds.world.action_space
        if self.worlds.states is None or not isinstance(space, spaces.Discrete):
            raise ValueError(
                f"tables need finitely many states and actions, which {env_id} has not; others: TeacherEnv"
            )
        self._pupil_streams = Streams(np.zeros(num_envs, np.uint64))
        self.students = learners(spec, num_envs, self.worlds.states, int(space.n), self._pupil_streams)
        """Who is taught."""
        if episodes == 1 and not self.students.spec.forget:
            raise ValueError("a student with forget=False is for lifetimes of several episodes; give episodes")
        self._vary = dict(vary or {})
        check_vary(spec, self._vary)
        self._wanted = np.uint8(sum(BIT[kind] for kind in parse_kinds(feedback_type)))
        self._lesson: dict[str, Any] = {
            "actions": actions,
            "episodes": episodes,
            "announce": announce,
            "feedback_type": feedback_type,
            "cost": cost,
            "budget": budget,
            "teacher_reward": teacher_reward,
            "max_turns": self.max_turns,
            "until_success": until_success,
            **self.world_options,
        }
        self.episodes, self.announce, self.cost, self.budget = episodes, announce, cost, budget
        self._reward = REWARDS[teacher_reward]
        self.lives = Lifetimes(num_envs, self.worlds.states, episodes)
        """What teachers remember."""
        self.spent = np.zeros(num_envs, np.int64)
        """Atoms that were said in each lifetime."""
        self._trimmed = np.zeros(num_envs, np.int64)
        self._finished = np.zeros(num_envs, bool)
        self._start = self.worlds.state
        scalar = TeacherEnv(env_id, student=spec, **self._lesson)
        self._low, self._high = scalar.teacher_view.low, scalar.teacher_view.high
        self.subsets = scalar.subsets
        """The subset of kinds that each action says."""
        self._subsets = np.array(self.subsets)
        self._legal = LEGAL[:, self._subsets]
        self._seat(scalar.observation_space, scalar.action_space)

    def __repr__(self) -> str:
        student, feedback_type = str(self.students.spec), self._lesson["feedback_type"]
        return self._shown(student=student, teacher="oracle", feedback_type=feedback_type)

    def lesson(self, row: int) -> TeacherEnv:
        """The scalar environment in a row's state, before the teacher speaks.

        From there both agree until the end of the lifetime, if their actions do.
        """
        row = self._check_row(row)
        env = TeacherEnv(self.env_id, student=self.students.student(row), **self._lesson)
        env.reset(seed=row)
        done, terminated = bool(self._finished[row]), bool(self.terminated()[row])
        start = self.worlds.truth(self._start, row)
        env.resume_from(self.moment(row), terminated=terminated, spent=int(self.spent[row]), start=start, done=done)
        env.session.world.np_random = self._streams.stream(row)
        seen = [frozen(self.worlds.seen(row, place)) for place in range(self.lives.visits.shape[1])]
        self.students.teach(env.student, row, int(self.moments.turn[row]), seen, int(self.lives.here[row]))
        env.session.seeds = _RowSeeds(row, env.student.rng)
        if env.life is not None:
            env.life.recall(**self.lives.recalled(row, seen))
        return env

    def action_masks(self) -> Bools:
        """Which actions are legal now, bool (rows, actions); the form that maskable learners ask for."""
        return self._mask().astype(bool)

    def _begin(self, rows: Ints, seeds: Sequence[int | None]) -> None:
        """Lifetimes begin, with new students."""
        self._pupil_streams.states[rows] = self._draws.integers(2**64, size=len(rows), dtype=np.uint64)
        self.students.enrol(rows, self._enrolled(len(rows), seeds))
        self.spent[rows] = self._trimmed[rows] = 0
        self._finished[rows] = False
        self._start = merged(self._start, rows, self.worlds.taken(self.worlds.state, rows))
        self.lives.begin(rows, self.worlds.place(rows))

    def _enrolled(self, count: int, seeds: Sequence[int | None]) -> dict[str, npt.NDArray[Any]]:
        """The parameters that are drawn: of a row with a seed as the scalar environment draws them."""
        parameters: dict[str, npt.NDArray[Any]] = {}
        for name in sorted(self._vary):
            low, high = self._vary[name]
            whole = is_whole(low, high)
            draw = self._draws.integers(low, high + 1, count) if whole else self._draws.uniform(low, high, count)
            parameters[name] = np.asarray(draw)
        for i, seed in enumerate(seeds if self._vary else ()):
            if seed is not None:
                student = drawn(self.students.spec, self._vary, Seeds(seed).stream("class"))
                for name, values in parameters.items():
                    values[i] = getattr(student, name)
        return parameters

    def _play(self, actions: npt.NDArray[Any], rows: Rows) -> tuple[Floats, Bools, Bools]:
        """The teacher's turn, then the student's, or the next episode's opening after the last word."""
        here = self._everybody[rows]
        wanted = self._subsets[actions]
        said = wanted.astype(np.uint8) & self._kinds[rows]
        if self.budget is not None:
            left = np.clip(self.budget - self.spent[rows], 0, len(KINDS))
            said = WITHIN[said, left]
        self._trimmed[rows] = wanted & ~said
        atoms = _COUNT[said]
        self.spent[rows] += atoms
        reward = np.zeros(self.num_envs)
        reward[rows] = -self.cost * atoms
        self.lives.said(here[(said & BIT[FP]) > 0])
        over = self.moments.over[rows]
        self._finished[rows] = False
        if over.any():
            last = here[over]
            self._end(last)
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
        heard = self.moments.reward[rows], said, self._advised[rows], self._warned[rows]
        self._act(self.students.act(rows, places, *heard), rows if len(rows) < self.num_envs else slice(None))
        regret = self._best - chosen(self._values, self.moments.action)  # which they were before
        reward[rows] += self._reward(self.moments, regret)[rows]
        self.lives.acted(rows, regret[rows] <= NEAR)
        self.lives.arrive(rows, self.worlds.place(rows))

    def _end(self, rows: Ints) -> None:
        """Episodes end; the next ones begin where the lifetime goes on."""
        if self.episodes > 1:
            places, rewards = self.lives.here[rows], self.moments.reward[rows]
            self.students.finish(rows, places, rewards, self.terminated(rows))
            self.lives.over(rows, self.moments.success[rows])
        ends = (self.lives.episode[rows] == self.episodes) | (self.episodes == 1)
        self._finished[rows[ends]] = True
        on = rows[~ends]
        if len(on):
            self.worlds.state = merged(self.worlds.state, on, self.worlds.taken(self._start, on))
            self._open(on)
            self.students.begin(on)
            self.lives.arrive(on, self.worlds.place(on))

    def _observe(self) -> dict[str, Any]:
        moments = self.moments
        kinds, self._advised, self._warned = self.oracle.judge(moments)
        self._kinds = kinds & self._wanted
        share = np.ones(self.num_envs)
        if self.budget is not None:
            share = np.maximum(self.budget - self.spent, 0) / self.budget
        self._values = self.oracle.values(moments.after)
        self._best = most(self._values)
        importance = np.minimum(self._best + most(-self._values), self.oracle.oracle.max_importance)
        paid = np.clip(moments.reward, self._low, self._high)
        observed = {
            "available": SUBSET_BITS.take(self._available(), axis=0),
            "features": columns(moments.turn / self.max_turns, paid, importance, share, moments.over),
            "action_mask": self._mask(),
        }
        self._intention = np.full(self.num_envs, -1)
        if self.announce:
            rows = np.flatnonzero(~moments.over)
            self._intention[rows] = self.students.intend(rows, self.lives.here[rows], moments.reward[rows])
        if self.episodes > 1:
            announced = self._intention >= 0
            worth = chosen(self._values, np.maximum(self._intention, 0))
            mistake = announced & (worth < self._best - NEAR)
            way = np.where(moments.over, 0, self.oracle.plan_length(moments.after, self.max_turns))
            observed["lifetime"] = self.lives.features(announced, mistake, way)
        return observed

    def _available(self) -> Ints:
        return self._kinds if self.budget is None else np.where(self.spent < self.budget, self._kinds, 0)

    def _mask(self) -> npt.NDArray[np.int8]:
        """The subsets that can be said; only silence once a lifetime is over."""
        return self._legal.take(np.where(self._finished, 0, self._available()), axis=0)

    def _infos(self) -> dict[str, Any]:
        return {
            "intention": self._intention,
            "_intention": self._intention >= 0,
            "trimmed": self._trimmed.copy(),
            "_trimmed": np.ones(self.num_envs, bool),
        }


class _RowSeeds(Seeds):
    """Seeds of a lesson whose student goes on drawing from the stream of a row, in later episodes, too."""

    def __init__(self, seed: int, student: np.random.Generator) -> None:
        super().__init__(seed)
        self._student = student

    def stream(self, name: str, seat: int = 0) -> np.random.Generator:
        """As the base but for the student's."""
        return self._student if name == "student" else super().stream(name, seat)
