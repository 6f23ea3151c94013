"""A curriculum: an agent chooses the task of each lesson, in which a teacher and a student take turns."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from pz_envs.assembly import assemble
from pz_envs.global_state import GlobalState, Shared
from pz_envs.lifetime_env import LifetimeEnv
from pz_envs.numbers import Field
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.seats import STUDENT, SeatsEnv, checked_options
from pz_envs.settings import Settings
from pz_envs.subject import Seating, Subject
from teachers.atoms import Moment
from teachers.budget import Budget
from teachers.spec import is_count

__all__ = ["CURRICULUM", "SEATING", "Curriculum", "CurriculumEnv", "CurriculumTask"]

CURRICULUM = "curriculum_0"
AHEAD = "ahead"
"""The key of a task for the start of its lessons."""
_STARTS: tuple[Mapping[str, Any], ...] = ({AHEAD: 0.75}, {AHEAD: 0.5}, {AHEAD: 0.25}, {})
_COLUMNS = (
    "share of the lessons that were spent on the task",
    "mean return of the student in it, 0 before the first",
    "return in the latest of them",
    "that less the one before, 0 before the second",
)


class CurriculumTask(NamedTuple):
    """A task: a choice of the curriculum."""

    options: Mapping[str, Any]
    """Options of the world."""
    ahead: float
    """Share of the oracle's plan from the opening that is already done at the start, 0 to 1."""


class CurriculumEnv(LifetimeEnv):
    """An AEC environment with the agents `curriculum_0`, `teacher_0` and `student_0`: lessons in tasks of its choice.

    Turn order: `curriculum_0` chooses a task; then teacher and student play a lesson in it, as in `TutoringEnv`, whose
    spaces and rewards they have. This repeats for all `lessons`. Then `tests` lessons of the last task follow, without
    a choice; then all agents end. The student's info has the last step of the lesson before, and
    teachers observe `episode`, as in `LifetimeEnv`; budgets are for all lessons.

    Curriculum: Observation: flat Box, float32, with `curriculum_fields`: the share of remaining lessons, and for each
    task how often it was chosen and the student's return in it. Action: Discrete(number of tasks). Reward: at the end
    of each test, the student's return in it; else 0. Info: `task`, the task of the last lesson, -1 before the first,
    and `returns`, the student's return in it.

    A task consists of options of the world, such as a `town`, and of a start: all lessons of a task begin in the same
    state of the seed's world, with fresh randomness.

    Args:
        rooms: an environment for each task; tasks with the same options share one.
        tasks: the tasks; tests use the last one.
        lessons: number of lessons with a choice, at least 1.
        tests: number of lessons of the last task after these, at least 0.

    Raises:
        ValueError: a task has other spaces than the first.
    """

    def __init__(self, rooms: Sequence[TutoringEnv], tasks: Sequence[CurriculumTask], lessons: int, tests: int) -> None:
        super().__init__(rooms[0], lessons + tests)
        for number, room in enumerate(rooms):
            for agent in rooms[0].possible_agents:
                for kind in ("observation", "action"):
                    first, own = (getattr(each, f"{kind}_space")(agent) for each in (rooms[0], room))
                    if first != own:
                        raise ValueError(
                            f"task {number} has another {kind} space of {agent} than task 0: {own}, not {first}; give "
                            "tasks whose spaces are the same"
                        )
        self.rooms, self.tasks, self.lessons, self.tests = tuple(rooms), tuple(tasks), lessons, tests
        self.task = -1
        """The task of the latest lesson; -1 before the first."""
        self.starts: list[Any] = []
        """The truth with which the lessons of each task begin: privileged."""
        self.possible_agents = [CURRICULUM, *rooms[0].possible_agents]
        low, high = (bound * self.max_turns for bound in rooms[0].session.world.reward_range)
        low, high = min(low, 0.0), max(high, 1.0)
        fields = [Field("left", slice(0, 1), "share of the lessons that are left")]
        for number in range(len(tasks)):
            for column, meaning in enumerate(_COLUMNS):
                place = 1 + len(_COLUMNS) * number + column
                fields.append(Field(f"task_{number}.{column}", slice(place, place + 1), meaning))
        self.curriculum_fields = tuple(fields)
        """The fields of the curriculum's observation."""
        least, greatest = (0.0, low, low, low - high), (1.0, high, high, high - low)
        self.observation_spaces[CURRICULUM] = spaces.Box(
            np.array([0.0, *least * len(tasks)], np.float32), np.array([1.0, *greatest * len(tasks)], np.float32)
        )
        self.action_spaces = {**self.action_spaces, CURRICULUM: spaces.Discrete(len(tasks))}

    @property
    def unwrapped(self) -> SeatsEnv:
        """The same environment."""
        return self

    def fields_of(self, agent: str) -> tuple[Field, ...]:
        """The fields of an agent's observation if it is one array, else an empty tuple."""
        return self.curriculum_fields if agent == CURRICULUM else super().fields_of(agent)

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin; without a seed the random streams go on. `options` are the worlds', in each lesson."""
        for room in dict.fromkeys(self.rooms):
            checked_options(options, room.session.world)  # before any room begins
        for room in dict.fromkeys(self.rooms):
            room.reset(seed, options)
        self._begin(options)

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin again: the streams go on, and spent budgets stay spent."""
        for room in dict.fromkeys(self.rooms):
            room.start_next_episode(start, options)
        self._begin(options)

    def _begin(self, options: dict[str, Any] | None) -> None:
        self._options, self.episode, self._final_steps = options, 0, {}
        ways: dict[SeatsEnv, list[Any]] = {}
        self.starts = []
        for room, task in zip(self.rooms, self.tasks, strict=True):
            if task.ahead and room not in ways:
                ways[room] = _way(room)
            self.starts.append(ways[room][int(task.ahead * len(ways[room]))] if task.ahead else room.current_truth)
        self._earned: list[list[float]] = [[] for _ in self.tasks]
        self.task, self._return = -1, 0.0
        self.seats = self.rooms[0]
        self._open()
        self.infos = {**self.seats.infos, CURRICULUM: self._choices()}
        self.agent_selection = CURRICULUM
        self._show_masks()

    def close(self) -> None:
        """Close the rooms."""
        for room in dict.fromkeys(self.rooms):
            room.close()

    def _observe(self, agent: str) -> Any:
        if agent != CURRICULUM:
            return super()._observe(agent)
        numbers = [max(1 - self.episode / self.lessons, 0.0)]
        for earned in self._earned:
            mean = sum(earned) / len(earned) if earned else 0.0
            change = earned[-1] - earned[-2] if len(earned) > 1 else 0.0
            numbers += (min(len(earned) / self.lessons, 1.0), mean, earned[-1] if earned else 0.0, change)
        space = self.observation_spaces[CURRICULUM]
        return np.clip(np.array(numbers, np.float32), space.low, space.high)  # type: ignore[attr-defined]  # a Box

    def step(self, action: Any) -> None:
        """Let the agent whose turn it is act.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._was_dead_step(action)
            return
        if agent == CURRICULUM:
            if not self.action_spaces[CURRICULUM].contains(action):
                raise ValueError(f"the curriculum must choose a task from 0 to {len(self.tasks) - 1}, got {action!r}")
            self._pay_all(CURRICULUM, {})
            self._teach(int(action))
        else:
            self.seats.step(action)
            self._forget(agent)
            self._pay_all(agent, self.seats.rewards)
            if agent == STUDENT:
                self._return += self.seats.rewards[STUDENT]
            self.infos |= self.seats.infos
            self.agent_selection = self.seats.agent_selection
            self._bridge()
        self._show_masks()

    def _teach(self, task: int) -> None:
        """Begin a lesson in a task."""
        self.task, self._return, self.seats = task, 0.0, self.rooms[task]
        self.seats.start_next_episode(self.starts[task], self._options)
        self._recall()
        self.infos |= self.seats.infos
        self.agent_selection = self.seats.agent_selection

    def _go_on(self) -> None:
        """After a lesson, let the curriculum choose, begin a test, or end."""
        self._earned[self.task].append(self._return)
        if self.episode > self.lessons:
            self.rewards[CURRICULUM] = self._return
            self._cumulative_rewards[CURRICULUM] += self._return
        self.infos[CURRICULUM] = self._choices()
        if self.episode == self.episodes:
            self.infos[STUDENT] = self._final_steps[STUDENT].info
            self.truncations = dict.fromkeys(self.agents, True)
            self.agent_selection = STUDENT
        elif self.episode < self.lessons:
            self.agent_selection = CURRICULUM
        else:
            self._teach(len(self.tasks) - 1)

    def _choices(self) -> dict[str, Any]:
        return {"task": self.task, "returns": self._return}

    # The state of all seats; between rooms only the bounds differ.

    def shared(self) -> list[Shared]:
        """The numbers of a lifetime, and the task."""
        now = [Shared(f"task_{i}", "1 in lessons of this task", float(i == self.task)) for i in range(len(self.tasks))]
        return [*super().shared(), *now]

    @cached_property
    def _global_states(self) -> dict[SeatsEnv, GlobalState]:
        return {room: GlobalState(self.possible_agents, room.seated, self.shared()) for room in self.rooms}

    @property
    def _global_state(self) -> GlobalState:
        return self._global_states[self.seats]

    @cached_property
    def state_space(self) -> spaces.Box:
        """The space of `state`, the same object each time."""
        found = [each.space for each in self._global_states.values()]
        low, high = np.min([each.low for each in found], axis=0), np.max([each.high for each in found], axis=0)
        return spaces.Box(low, high, dtype=np.float32)


def _way(room: TutoringEnv) -> list[Any]:
    """The truths along the oracle's plans, from the opening to success."""
    moment, oracle = Moment.opening(room.current_truth), room.session.teacher.oracle
    way = [moment.after]
    while len(way) <= room.max_turns and (plan := oracle.plan(moment.after, room.max_turns)):
        for action in plan:
            moment = oracle.try_out(moment, action)
            if moment.success:
                return way
            way.append(moment.after)
    return way


def _plans(room: TutoringEnv) -> bool:
    """Whether the oracle knows a way to a success that ends the lesson."""
    return "plan" in room.session.teacher.oracle.abilities() and not room.session.repeated


class Curriculum(Seating):
    """One agent that chooses tasks, one teacher, one student."""

    defaults = {"speech": "kinds", "until_success": True}  # noqa: RUF012 (as of `Seating`)

    def raw_env(
        self,
        subject: Subject,
        settings: Settings,
        *,
        tasks: Sequence[Mapping[str, Any]] | None = None,
        lessons: int = 20,
        tests: int = 1,
    ) -> CurriculumEnv:
        """An agent that chooses tasks, a teacher and a student; see `CurriculumEnv`.

        Args:
            subject: the subject.
            settings: the settings of all lessons.
            tasks: at least one, each a mapping of the world's options and of `ahead`, the share of the oracle's plan
                that is done at the start, from 0 to less than 1. Tests use the last task. None: starts at 3/4, 1/2 and
                1/4 of the plan, and at the opening; without plans, or if the task is repeated, only the opening.
            lessons: their number, at least 1.
            tests: number of lessons of the last task after these, at least 0.

        Raises:
            ValueError: an argument is not allowed.
        """
        if not is_count(lessons) or not (tests == 0 or is_count(tests)):
            raise ValueError(
                f"lessons must be an integer of at least 1 and tests of at least 0, got {lessons!r} and {tests!r}"
            )
        budget, made = Budget(settings.cost, settings.budget), dict[str, TutoringEnv]()

        def room(options: Mapping[str, Any]) -> TutoringEnv:
            key = repr(sorted(options.items()))
            if key not in made:
                own = replace(settings, options={**settings.options, **options})
                made[key] = TutoringEnv(assemble(subject, own, budget=budget), own, subject.name)
            return made[key]

        if tasks is None:
            tasks = _STARTS if _plans(room({})) else _STARTS[-1:]
        if not isinstance(tasks, Sequence) or not tasks or not all(isinstance(task, Mapping) for task in tasks):
            raise ValueError(
                f"tasks must be a list of at least one mapping, such as [{{'ahead': 0.5}}, {{}}], got {tasks!r}"
            )
        read = [_task(number, task, subject) for number, task in enumerate(tasks)]
        rooms = [room(task.options) for task in read]
        for number, (task, its) in enumerate(zip(read, rooms, strict=True)):
            if task.ahead and not _plans(its):
                raise ValueError(f"ahead of task {number} must be 0: {subject.name} has no plan that leads to success")
        return CurriculumEnv(rooms, read, lessons, tests)

    def seats(self, subject: Subject, settings: Settings, *, episodes: int = 1, **own: Any) -> SeatsEnv:
        """The bare AEC environment, itself a lifetime.

        Raises:
            ValueError: an argument is not allowed.
        """
        if episodes != 1:
            raise ValueError(f"a curriculum does not use episodes={episodes!r}; give lessons= and tests=")
        return super().seats(subject, settings, **own)


def _task(number: int, task: Mapping[str, Any], subject: Subject) -> CurriculumTask:
    """The task of a given mapping."""
    options = {name: value for name, value in task.items() if name != AHEAD}
    if unknown := [name for name in options if name not in subject.options()]:
        allowed = ", ".join((AHEAD, *subject.options()))
        raise ValueError(f"task {number} has an unknown option {unknown[0]!r}; allowed: {allowed}")
    ahead = task.get(AHEAD, 0.0)
    if isinstance(ahead, bool) or not isinstance(ahead, int | float) or not 0 <= ahead < 1:
        raise ValueError(f"ahead of task {number} must be a number from 0 to less than 1, got {ahead!r}")
    return CurriculumTask(options, float(ahead))


SEATING = Curriculum()
