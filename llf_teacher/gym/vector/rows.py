"""The base of the vector environments of both seats: lessons in arrays, their steps and their resets."""

import inspect
from abc import abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from llf_teacher.gym.seat_env import SeatEnv, shorter
from llf_teacher.registry import entry
from pz_envs.settings import FIELDS, Settings
from pz_envs.window import FPS
from teachers.atoms import Moment
from teachers.batches import Moments, Said
from teachers.batches.teacher import TeacherBatch
from teachers.feedback import MIXED, number_of, parse_kinds
from teachers.spec import is_count, unknown
from worlds.batches import ALL, Bools, Floats, Ints, Rows, merged
from worlds.batches.streams import Streams

SHOWN = frozenset(("render_mode", "theme"))
"""The settings for rendering."""


_MOST = 1_000_000  # rows


class RowsEnv(VectorEnv[Any, Any, Any]):
    """Lessons in arrays, one in each row; a subclass plays one of the seats.

    Args:
        env_id: an id of `llf_teacher.ids()` whose family can be played in arrays.
        num_envs: number of rows.
        settings: the settings of the lessons; None: the defaults.
        keywords: fields that replace them, the world's options, and options of the family's batch.
        autoreset_mode: one of Gymnasium's modes.
        used: the fields of the settings that this seat uses.
        defaults: fields with other defaults at this seat.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {"render_modes": ["ansi", "rgb_array"], "render_fps": FPS}  # noqa: RUF012 (Gymnasium's convention)
    instead: ClassVar[str] = "vectorization_mode='sync'"
    """The alternative that takes all teachers, for errors."""
    moments: Moments[Any]
    """The last turn in each row."""

    def __init__(
        self,
        env_id: str,
        num_envs: int,
        settings: Settings | None,
        keywords: Mapping[str, Any],
        autoreset_mode: str | AutoresetMode,
        *,
        used: frozenset[str],
        **defaults: Any,
    ) -> None:
        self.env_id, self.family, own, _ = entry(env_id)
        if "max_episode_steps" in keywords:  # which `gymnasium.make_vec` passes
            keywords = {name: value for name, value in keywords.items() if name != "max_episode_steps"} | {
                "max_turns": shorter(keywords["max_episode_steps"], keywords.get("max_turns"))
            }
        if not is_count(num_envs, _MOST):
            raise ValueError(f"num_envs must be an integer from 1 to {_MOST}, got {num_envs!r}")
        self.settings = Settings.of(
            f"{env_id} in arrays (vectorization_mode='sync' takes more)",
            {**own, **keywords},
            (*self.family.options(), *(self.family.batch_options() if self.family.world_batch else ())),
            given=settings,
            others=set(inspect.signature(type(self)).parameters) - {"env_id"},
            refused=FIELDS - used - {"options"},
            elsewhere=self.family.elsewhere,
            **defaults,
        )
        self.num_envs, self.render_mode = num_envs, self.settings.render_mode
        if self.render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(
                f"render_mode {self.render_mode!r} is not supported in arrays; allowed: None, ansi, rgb_array; others: "
                "vectorization_mode='sync'"
            )
        self.max_turns = self.settings.max_turns or self.family.max_turns
        modes = [mode.value for mode in AutoresetMode]
        if autoreset_mode not in (*AutoresetMode, *modes):
            raise ValueError(unknown("autoreset_mode", autoreset_mode, modes))
        self.mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.mode}
        self.worlds, self.oracle = self.family.make_batch(num_envs, **self.settings.options)
        if (feedback_type := self.settings.feedback_type) == MIXED:  # drawn anew in each turn
            raise ValueError(
                f"feedback_type 'm' is not supported in arrays; allowed: a, n, or kinds; 'm': {self.instead}"
            )
        wanted = np.uint8(number_of(parse_kinds(feedback_type)))
        self.teacher = TeacherBatch(self.oracle, self.settings.teacher, wanted, num_envs, self.max_turns, self.instead)
        """The teachers, in arrays."""
        self._past: deque[Moments[Any]] = deque(maxlen=self.teacher.past)  # the latest first
        self._new = np.ones(num_envs, bool)  # the rows with a moment that is not judged yet
        self._ends = self.settings.until_success and not self.family.repeated
        self._all_rows = np.arange(num_envs)
        self._draws = np.random.default_rng()
        self._streams = Streams(np.zeros(num_envs, np.uint64))
        self._done: Bools | None = None

    def _repr(self, **arguments: Any) -> str:
        """The `repr` with some arguments."""
        shown = " ".join(f"{name}={value!r}" for name, value in arguments.items())
        return f"<{type(self).__name__} {self.env_id} num_envs={self.num_envs} {shown}>"

    def _set_spaces(self, observation: spaces.Space[Any], action: spaces.Space[Any]) -> None:
        """Set the spaces of a row and of all rows."""
        self.single_observation_space, self.single_action_space = observation, action
        self.observation_space = batch_space(observation, self.num_envs)
        self.action_space = batch_space(action, self.num_envs)

    @property
    def scalar_settings(self) -> Settings:
        """The settings of a row as a scalar environment."""
        arrays = self.family.batch_options()
        options = {name: value for name, value in self.settings.options.items() if name not in arrays}
        return replace(self.settings, max_turns=self.max_turns, options=options)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes in all rows, or in those of `options["reset_mask"]`.

        A row with a seed begins in the same state as the scalar environment with that seed; with one integer, row i has
        the seed `seed + i`. Chance after the start depends on the seeds of all rows: the same seeds in the same order
        give the same again. Rows without a seed begin at random.

        Raises:
            ValueError: a seed or an option is not allowed; nothing has changed.
        """
        left = dict(options or {})
        rows = self._masked(left.pop("reset_mask", None))
        self.worlds.world.check_reset(left)
        if left:
            raise ValueError(f"in arrays reset takes no options of the world, got {left!r}; allowed: reset_mask")
        seeds = self._seeds(seed)
        if self._done is None and len(rows) < self.num_envs:
            raise ResetNeeded("the first reset must be of all rows; call reset() without a reset_mask")
        given = np.array([seeds[row] is not None for row in rows.tolist()], bool)
        if len(rows) == self.num_envs and seed is not None:
            self._draws = np.random.default_rng([each for each in seeds if each is not None])
        self._streams.states[rows] = self._draws.integers(2**64, size=len(rows), dtype=np.uint64)
        if given.any():
            self.worlds.load_each(rows[given], (self._first(seeds[row]) for row in rows[given].tolist()))
        if not given.all():
            self.worlds.draw(rows[~given], self._draws)
        self._done = np.zeros(self.num_envs, bool) if self._done is None else self._done.copy()
        self._done[rows] = False
        self._open(rows)
        self._begin(rows, [seeds[row] for row in rows.tolist()])
        return self._observe(), self._infos()

    def _first(self, seed: int | None) -> Any:
        """The truth of the scalar world at its opening."""
        world = self.worlds.world
        world.reset(seed=seed)
        return world.truth

    def _masked(self, mask: Any) -> Ints:
        if mask is None:
            return self._all_rows
        if not isinstance(mask, np.ndarray) or mask.dtype != bool or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(
                f"reset_mask must be a bool array of shape ({self.num_envs},) with at least one True, got {mask!r}"
            )
        return np.flatnonzero(mask)

    def _seeds(self, seed: Any) -> list[int | None]:
        if seed is None or isinstance(seed, int | np.integer):
            seed = [None if seed is None else int(seed) + row for row in range(self.num_envs)]
        seeds = seed.tolist() if isinstance(seed, np.ndarray) else seed
        if not isinstance(seeds, Sequence) or len(seeds) != self.num_envs:
            raise ValueError(f"seed must be None, an integer or a list of {self.num_envs} of these, got {seed!r}")
        for row, each in enumerate(seeds):
            if each is not None and (not isinstance(each, int | np.integer) or each < 0):
                raise ValueError(f"the seed of row {row} must be None or an integer of at least 0, got {each!r}")
        return [None if each is None else int(each) for each in seeds]

    def step(self, actions: Any) -> tuple[Any, Floats, Bools, Bools, dict[str, Any]]:
        """Act in each row; after the end of an episode a row follows Gymnasium's autoreset mode.

        Raises:
            ResetNeeded: before `reset`, or in a row that has ended, if autoreset is disabled.
            ValueError: an action is outside the action space; nothing has changed.
        """
        if self._done is None:
            raise ResetNeeded("no episode has begun; call reset() before step()")
        actions = legal(self.single_action_space, actions, self.num_envs)
        ended = self._done
        rows: Rows = ALL
        if ended.any():
            if self.mode is AutoresetMode.DISABLED:
                row = int(ended.argmax())
                raise ResetNeeded(f"row {row} has ended; call reset(options={{'reset_mask': ...}}) before step()")
            rows = np.flatnonzero(~ended)
        none = np.zeros(self.num_envs, bool)
        reward, terminated, truncated = np.zeros(self.num_envs), none, none.copy()
        self._past.appendleft(self.moments)
        if isinstance(rows, slice) or len(rows):
            reward[rows], terminated[rows], truncated[rows] = self._play(actions[rows], rows)
        if not isinstance(rows, slice):
            self._reset_rows(np.flatnonzero(ended))
        self._done = terminated | truncated
        if self.mode is AutoresetMode.SAME_STEP and self._done.any():
            return self._same_step(reward, terminated, truncated)
        return self._observe(), reward, terminated, truncated, self._infos()

    def _same_step(
        self, reward: Floats, terminated: Bools, truncated: Bools
    ) -> tuple[Any, Floats, Bools, Bools, dict[str, Any]]:
        """Reset the rows that have ended; their last step is in the infos."""
        done = terminated | truncated
        rows = np.flatnonzero(done)
        last = np.full(self.num_envs, None, object)
        observed = self._observe()
        for row in rows.tolist():
            last[row] = _row(observed, row)
        final = {name: part & done if name[0] == "_" else part for name, part in self._infos().items()}
        infos = {"final_obs": last, "_final_obs": done, "final_info": final, "_final_info": done.copy()}
        self._reset_rows(rows)
        self._done = np.zeros(self.num_envs, bool)
        return self._observe(), reward, terminated, truncated, self._infos() | infos

    def _reset_rows(self, rows: Ints) -> None:
        """Begin episodes in rows that have ended."""
        self.worlds.draw(rows, self._draws)
        self._open(rows)
        self._begin(rows, [None] * len(rows))

    def _open(self, rows: Ints) -> None:
        """The moment before the first turn of an episode."""
        count, state, space = len(rows), self.worlds.state, self.worlds.world.action_space
        action = np.zeros((count, *(space.shape or ())), space.dtype)
        no = np.zeros(count, bool)
        everywhere = count == self.num_envs
        before = state if everywhere else self.moments.before
        opening = Moments(before, action, np.zeros(count), state, no, np.zeros(count, np.int64), no)
        self._note(ALL if everywhere else rows, opening)

    def _act(self, actions: npt.NDArray[Any], rows: Rows) -> None:
        """The student's turn in some rows."""
        turn = self.moments.turn[rows] + 1
        before = merged(self.moments.before, rows, self.worlds.taken(self.worlds.state, rows))
        reward, success = self.worlds.advance(actions, rows, self._streams)
        over = turn >= self.max_turns
        if self._ends:
            over = over | success
        self._note(rows, Moments(before, actions, reward, self.worlds.state, success, turn, over))

    def _note(self, rows: Rows, moments: Moments[Any]) -> None:
        """Store the moments of some rows; the given states are of all rows."""
        if not isinstance(rows, slice):
            now = self.moments
            parts = {}
            for name in ("action", "reward", "success", "turn", "over"):
                parts[name] = getattr(now, name).copy()
                parts[name][rows] = getattr(moments, name)
            moments = moments._replace(**parts)
        self.moments = moments
        self._new[rows] = True

    def _judge(self) -> tuple[Said, Moments[Any]]:
        """The claims in all rows, and the moments that they are about."""
        rows: Rows = ALL if self._new.all() else np.flatnonzero(self._new)
        self._new[:] = False
        return self.teacher.judge(self.moments, rows, self._past)

    def _before(self, row: int) -> list[Moment[Any]]:
        """The moments of a row's episode without the last one, from the opening on, if the teacher remembers any."""
        turns = min(int(self.moments.turn[row]), len(self._past))
        return [self._moment(self._past[ago], row) for ago in reversed(range(turns))]

    def terminated(self, rows: Rows = ALL) -> Bools:
        """Whether the student's episode has ended by success."""
        over: Bools = self.moments.over[rows]
        return over & self.moments.success[rows] if self._ends else np.zeros(len(over), bool)

    def moment(self, row: int) -> Moment[Any]:
        """The moment of a row in scalar form."""
        return self._moment(self.moments, row)

    def _moment(self, now: Moments[Any], row: int) -> Moment[Any]:
        worlds = self.worlds
        after, turn = worlds.truth(now.after, row), int(now.turn[row])
        if not turn:
            return Moment.opening(after)
        action = worlds.world.legal(now.action[row].tolist())
        success, over = bool(now.success[row]), bool(now.over[row])
        return Moment(worlds.truth(now.before, row), action, float(now.reward[row]), after, success, turn, over)

    @abstractmethod
    def lesson(self, row: int) -> SeatEnv:
        """The scalar environment in a row's state."""

    def render(self) -> tuple[Any, ...] | None:
        """The render of each row, in the form of Gymnasium's vector environments; None without a render mode."""
        return None if self.render_mode is None else tuple(self.lesson(row).render() for row in range(self.num_envs))

    def _check_row(self, row: Any) -> int:
        if self._done is None:
            raise ResetNeeded("no episode has begun; call reset() first")
        if not isinstance(row, int | np.integer) or not 0 <= row < self.num_envs:
            raise ValueError(f"a row must be an integer from 0 to {self.num_envs - 1}, got {row!r}")
        return int(row)

    @abstractmethod
    def _begin(self, rows: Ints, seeds: Sequence[int | None]) -> None:
        """Begin students and lifetimes in some rows; by default there are none."""

    @abstractmethod
    def _play(self, actions: npt.NDArray[Any], rows: Rows) -> tuple[Floats, Bools, Bools]:
        """Act in some rows.

        Returns:
            Rewards, and whether the rows are terminated and truncated.
        """

    @abstractmethod
    def _observe(self) -> Any:
        """The observations of all rows, in new arrays."""

    @abstractmethod
    def _infos(self) -> dict[str, Any]:
        """The infos of all rows."""


def legal(space: spaces.Space[Any], actions: Any, rows: int) -> npt.NDArray[Any]:
    """The actions of all rows as an array.

    Raises:
        ValueError: the array has another shape or type, or an action is not in the space.
    """
    array: npt.NDArray[Any] = np.asarray(actions)
    if isinstance(space, spaces.Discrete):
        low, high = space.start, space.start + space.n - 1
        allowed, kinds = "integers", "iu"
    else:
        low, high = space.low, space.high  # type: ignore[attr-defined]  # batches have only Discrete and Box
        allowed, kinds = "numbers", "iuf"
    shape = (rows, *(space.shape or ()))
    if array.shape != shape or array.dtype.kind not in kinds:
        raise ValueError(f"actions must be {allowed} of shape {shape}, got {array.dtype} of shape {array.shape}")
    array = array.astype(space.dtype) + 0  # a copy, without negative zeros
    wrong: Bools = ~((array >= low) & (array <= high)).reshape(rows, -1).all(1)
    if wrong.any():
        row = int(wrong.argmax())
        raise ValueError(f"action {array[row]} of row {row} is not in {space}; nothing has changed")
    return array


def _row(observed: Any, row: int) -> Any:
    """The observation of a row."""
    if isinstance(observed, dict):
        return {name: _row(part, row) for name, part in observed.items()}
    return observed[row]
