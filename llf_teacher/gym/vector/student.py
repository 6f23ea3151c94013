"""The student's seat, in arrays."""

from collections.abc import Iterable, Sequence
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from llf_teacher.gym.student_env import StudentEnv
from llf_teacher.gym.vector.rows import SHOWN, RowsEnv
from pz_envs.numbers import Field, Numbers, RowClaims
from pz_envs.settings import FIELDS, Settings, SettingsKeywords, takes_settings
from pz_envs.teacher_view import SUBSET_BITS
from teachers.atoms import FN, FP, KINDS, R, Utterance
from teachers.batches import Said
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, Rows

_TEACHER = ("teacher", "feedback_type", "instruction_type", "voice", "paraphrase")
_USED = SHOWN | {*_TEACHER, "max_turns", "until_success", "numbers"}


class StudentVectorEnv(RowsEnv):
    """Students' seats in arrays, each with a teacher: `StudentEnv` in arrays.

    Observation: Dict of `observation`, the world's, and of the claims in numbers:
        `said`, MultiBinary(5): the kinds, in the order r, hp, hn, fp, fn;
        `told`: the reward in the claim of kind r, 0 without a claim; `advised`, `warned`: the action of fp and of fn;
        without a claim, -1 for a Discrete and the centre of a Box. Claims of kind hp and hn are about the last action.
        With a late teacher, such as `delayed(turns=2)`, all claims are about the turn that many turns ago. With
        `numbers=True` the observation is one flat Box, float32, with the numbers and `fields` of `StudentEnv`.
    Action: the world's. Info: `success`.

    `lesson` gives a row as a scalar environment, `words` the teacher's words in some rows.

    Args:
        env_id: an id of `llf_teacher.ids()` whose family can be played in arrays.
        num_envs: number of rows.
        settings: the settings of the lessons; None: the defaults.
        autoreset_mode: one of Gymnasium's modes.
        keywords: fields of `pz_envs.settings.Settings` that replace them, the world's options, and options of the
            family's batch, such as `pool`. Allowed are `teacher` (personalities that withhold or delay kinds of
            claims; see `Personality.in_arrays`), `feedback_type` (not `m`: it is the
            same in each turn), `max_turns`, `until_success`, `numbers`, `render_mode` and `theme`, and for `words` and
            `lesson` also `instruction_type`, `voice` and `paraphrase`.

    Raises:
        ValueError: an argument is not allowed.
    """

    @takes_settings(without=FIELDS - _USED)
    def __init__(
        self,
        env_id: str,
        num_envs: int = 1,
        *,
        settings: Settings | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **keywords: Unpack[SettingsKeywords],
    ) -> None:
        super().__init__(env_id, num_envs, settings, keywords, autoreset_mode, used=_USED)
        self._scribe = StudentEnv(env_id, settings=self.scalar_settings)
        world = self.worlds.world
        named, self._nothing = _named(world.action_space)
        low, high = world.reward_range
        space = {
            "observation": world.observation_space,
            "said": spaces.MultiBinary(len(KINDS)),
            "told": spaces.Box(min(low, 0.0), max(high, 0.0), (), np.float64),
            "advised": named,
            "warned": named,
        }
        self.numbers = Numbers(world, self.max_turns) if self.settings.numbers else None
        self._set_spaces(self.numbers.space if self.numbers else spaces.Dict(space), world.action_space)

    def __repr__(self) -> str:
        return self._repr(teacher=str(self.teacher.personality), feedback_type=self.settings.feedback_type)

    @property
    def fields(self) -> tuple[Field, ...]:
        """The fields of a row's observation in numbers, in their order; empty without `numbers=True`."""
        return () if self.numbers is None else self.numbers.fields

    def lesson(self, row: int) -> StudentEnv:
        """The scalar environment in a row's state, after the teacher has spoken.

        From there both agree until the end of the episode, under the same actions.
        """
        row = self._check_row(row)
        env = StudentEnv(self.env_id, settings=self.scalar_settings)
        env.reset(seed=row)
        self._resume(env, row)
        env.session.world.np_random = self._streams.stream(row)
        return env

    def words(self, rows: Iterable[int]) -> list[Utterance]:
        """The teacher's words in some rows, with their atoms; at the opening with the instruction."""
        said = []
        for row in rows:
            if not self._scribe._running:
                self._scribe.reset(seed=0)
            self._resume(self._scribe, self._check_row(row))
            said.append(Utterance.of(self._scribe.session.atoms))
        return said

    def _resume(self, env: StudentEnv, row: int) -> None:
        env.resume_from(self.moment(row), bool(self.terminated()[row]), self._before(row))

    def _begin(self, rows: Ints, seeds: Sequence[int | None]) -> None:
        """Nothing: the student's seat has no students."""

    def _play(self, actions: npt.NDArray[Any], rows: Rows) -> tuple[Floats, Bools, Bools]:
        self._act(actions, rows)
        over, terminated = self.moments.over[rows], self.terminated(rows)
        return self.moments.reward[rows], terminated, over & ~terminated

    def _observe(self) -> Any:
        said, about = self._judge()
        kinds, advised, warned = said.kinds, said.advised, said.warned
        if self.numbers is not None:
            claims, turn, late = _claims_of(said, about.action), self.moments.turn, self.teacher.late
            return self.numbers.of_rows(self.worlds.observe(), turn, about.reward, kinds, claims, late)
        return {
            "observation": self.worlds.observe(),
            "said": SUBSET_BITS.take(kinds, axis=0),
            "told": np.where(kinds & BIT[R], about.reward, 0.0),
            "advised": self._where(kinds & BIT[FP], advised),
            "warned": self._where(kinds & BIT[FN], warned),
        }

    def _where(self, said: Ints, actions: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The actions that are said; elsewhere the space's value for no action."""
        heard = said.astype(bool).reshape(-1, *(1,) * (actions.ndim - 1))
        return np.where(heard, actions, self._nothing)

    def _infos(self) -> dict[str, Any]:
        return {"success": self.moments.success.copy(), "_success": np.ones(self.num_envs, bool)}


def _claims_of(said: Said, action: npt.NDArray[Any]) -> RowClaims:
    """Whether each kind is said: r, hp, hn, fp, fn."""
    number = np.ones((len(action), len(KINDS)), np.int64)
    named = number.astype(bool)
    if said.verdicts is not None:
        number[:, 1:3] = said.verdicts
    if said.judges is not None:
        named[:, 1:3] = said.judges
    return RowClaims(number, named, (action, action, action, said.advised, said.warned))


def _named(space: spaces.Space[Any]) -> tuple[spaces.Space[Any], Any]:
    """The space of an action in a claim, and its value for no action."""
    if isinstance(space, spaces.Discrete):
        return spaces.Discrete(int(space.n) + 1, start=-1), np.int64(-1)
    return space, (space.low + space.high) / 2  # type: ignore[attr-defined]  # there are batches of Discrete and Box alone
