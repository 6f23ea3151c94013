"""The student's seat, in arrays."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from llf_teacher.gym.student_env import StudentEnv
from llf_teacher.gym.vector.rows import RowsEnv
from pz_envs.teacher_view import SUBSET_BITS
from teachers.atoms import FN, FP, KINDS, R, Utterance
from teachers.feedback import MIXED, parse_kinds
from teachers.phrasebook import Paraphrase
from teachers.session import BIT
from teachers.voice import Voice
from worlds.batches import Bools, Floats, Ints, Rows


class StudentVectorEnv(RowsEnv):
    """Many students' seats, each in front of a teacher who says all that is true: `StudentEnv` in arrays.

    Observation: Dict of `observation`, what the world shows, and of what the teacher says in numbers:
        `said`, MultiBinary(5): the kinds, in the order r, hp, hn, fp, fn;
        `told`: the reward that r tells, 0 where it is not said;
        `advised`, `warned`: the action that fp advises and that fn warns of; of finitely many -1 where none is, of
        points the middle of the box. Verdicts, hp and hn, are about the action that was taken.
    Action: the world's. Info: `success`.

    `lesson` gives a row as a scalar environment, `words` what the teacher says there in words.

    Args:
        env_id: an id of `llf_teacher.ids()` whose family can be played in arrays.
        num_envs: rows.
        feedback_type: `a`, `n`, or kinds, as in `llf_teacher.make`; it is the same in each turn, so not `m`.
        teacher: `oracle`; no other teacher speaks in arrays.
        max_turns, until_success: as in `StudentEnv`.
        instruction_type, voice, paraphrase: of `words` and `lesson`.
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
        feedback_type: str | Iterable[str] = "a",
        teacher: str = "oracle",
        max_turns: int | None = None,
        until_success: bool = False,
        instruction_type: str = "b",
        voice: Voice = "plain",
        paraphrase: Paraphrase = "random",
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        **options: Any,
    ) -> None:
        if teacher != "oracle":
            raise ValueError(f"in arrays only the teacher 'oracle' speaks, got {teacher!r}; others: mode 'sync'")
        if feedback_type == MIXED:
            raise ValueError("feedback_type 'm' is not supported in arrays; allowed: a, n, or kinds; 'm': mode 'sync'")
        kinds = parse_kinds(feedback_type)
        super().__init__(env_id, num_envs, max_turns, until_success, autoreset_mode, options)
        self._wanted = np.uint8(sum(BIT[kind] for kind in kinds))
        self._lesson: dict[str, Any] = {
            "feedback_type": feedback_type,
            "max_turns": self.max_turns,
            "until_success": until_success,
            "instruction_type": instruction_type,
            "voice": voice,
            "paraphrase": paraphrase,
            **self.world_options,
        }
        self._scribe = StudentEnv(env_id, **self._lesson)
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
        self._seat(spaces.Dict(space), world.action_space)

    def __repr__(self) -> str:
        return self._shown(teacher="oracle", feedback_type=self._lesson["feedback_type"])

    def lesson(self, row: int) -> StudentEnv:
        """The scalar environment in a row's state, after the teacher has spoken.

        From there both agree as long as the row is in the same episode.
        """
        row = self._check_row(row)
        env = StudentEnv(self.env_id, **self._lesson)
        env.reset(seed=row)
        self._resume(env, row)
        env.session.world.np_random = self._streams.stream(row)
        return env

    def words(self, rows: Iterable[int]) -> list[Utterance]:
        """What the teacher says now in some rows, with its atoms; at first the instruction, too."""
        said = []
        for row in rows:
            if not self._scribe._running:
                self._scribe.reset(seed=0)
            self._resume(self._scribe, self._check_row(row))
            said.append(Utterance.of(self._scribe.session.atoms))
        return said

    def _resume(self, env: StudentEnv, row: int) -> None:
        env.resume_from(self.moment(row), bool(self.terminated()[row]))

    def _begin(self, rows: Ints, seeds: Sequence[int | None]) -> None:
        """There is nothing beside the worlds."""

    def _play(self, actions: npt.NDArray[Any], rows: Rows) -> tuple[Floats, Bools, Bools]:
        self._act(actions, rows)
        over, terminated = self.moments.over[rows], self.terminated(rows)
        return self.moments.reward[rows], terminated, over & ~terminated

    def _observe(self) -> dict[str, Any]:
        kinds, advised, warned = self.oracle.judge(self.moments)
        kinds = kinds & self._wanted
        return {
            "observation": self.worlds.observe(),
            "said": SUBSET_BITS.take(kinds, axis=0),
            "told": np.where(kinds & BIT[R], self.moments.reward, 0.0),
            "advised": self._where(kinds & BIT[FP], advised),
            "warned": self._where(kinds & BIT[FN], warned),
        }

    def _where(self, said: Ints, actions: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The actions where they are said."""
        heard = said.astype(bool).reshape(-1, *(1,) * (actions.ndim - 1))
        return np.where(heard, actions, self._nothing)

    def _infos(self) -> dict[str, Any]:
        return {"success": self.moments.success.copy(), "_success": np.ones(self.num_envs, bool)}


def _named(space: spaces.Space[Any]) -> tuple[spaces.Space[Any], Any]:
    """The space of an action that may be named, and what stands for none."""
    if isinstance(space, spaces.Discrete):
        return spaces.Discrete(int(space.n) + 1, start=-1), np.int64(-1)
    return space, (space.low + space.high) / 2  # type: ignore[attr-defined]  # there are batches of Discrete and Box alone
