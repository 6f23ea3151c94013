"""A panel: several teachers, who need not agree, and one student."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding

from pz_envs.seats import STUDENT, TEACHER, SeatsEnv
from pz_envs.teacher_seat import PROSE, SUBSETS, Purse, TeacherSeat, message_space, price
from pz_envs.tutoring import TutoringEnv, words_space
from teachers.atoms import KINDS, SILENCE, Utterance
from teachers.teacher import Teacher
from worlds.spaces import Prose

MOST = 16
"""Greatest number of teachers."""
ORDERS = ("fixed", "random")


def check_teachers(teachers: Any) -> None:
    """Check the teachers of a panel.

    Raises:
        ValueError: they are no list, or too few or too many.
    """
    if isinstance(teachers, str) or not isinstance(teachers, Sequence):
        raise ValueError(f"teachers must be a list of 1 to {MOST}, such as ['oracle', 'silent'], got {teachers!r}")
    if not 1 <= len(teachers) <= MOST:
        raise ValueError(f"teachers must be 1 to {MOST}, got {len(teachers)}")


class PanelEnv(SeatsEnv):
    """An AEC environment with the agents `teacher_0` to `teacher_<m - 1>` and `student_0`.

    Turn order:
        `reset` gives the student the instruction, free of charge. Then round follows round: each teacher speaks once,
        then the student acts. With `order="fixed"` the teachers speak in the order of their numbers, with `random` in
        an order that is drawn anew for each round. After the student's last action each teacher has a last word; then
        all seats end together, and the student reads the last words in its dead step's `last()`.

    Student:
        Observation: that of `TutoringEnv`'s student, where `feedback` is what all teachers said, in the order in which
        they spoke; and `said`, Dict of `teacher_<i>` (`Prose`), what each of them said. Action and info are those of
        `TutoringEnv`; each atom tells its `speaker`.

    Teacher, `speech="kinds"`:
        Observation: Dict of `available`, `features` and `action_mask` as in `TutoringEnv`, with its own budget, and
        `heard`, MultiBinary (5): the kinds that others have said before it in this round, in the order r, hp, hn, fp,
        fn. Action: Discrete(32), the subset of the kinds to say. What it can say are the claims of its own personality.
    Teacher, `speech="message"`:
        Observation: Dict of `state`, `action` (`Prose`) as in `TutoringEnv`, and `heard` (`Prose`), what others have
        said before it in this round. Action: `Prose`; an `Utterance` brings its atoms along. What it says of the
        instruction is not repeated.
    The notice that the student's text was no action is heard from the first who gives it in a round.
    Info: the privileged `moment`.

    Rewards: at the student's step the student gets the world's reward, and each teacher its `teacher_reward`, by its
    own oracle; at its own step a teacher pays `cost` for each atom of feedback, within a `budget` of its own.

    Seeds: `reset(seed)` seeds the student's world, each teacher and the order. Without a seed the streams go on.

    Args:
        desk: the `TutoringEnv` of the student, with `speech="kinds"`; see `Subject.panel_env`.
        tutors: the teachers, 1 to 16, each with an oracle of its own; the first is the desk's.
        speech: `kinds` or `message`.
        order: `fixed` or `random`.
        cost: paid by a teacher per atom of feedback, at least 0.
        budget: atoms of feedback that each teacher may say in an episode. None: any number.
        render_mode: None, `ansi` or `human`.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {**SeatsEnv.metadata, "name": "panel_v0"}  # noqa: RUF012 (PettingZoo's convention)

    def __init__(
        self,
        desk: TutoringEnv,
        tutors: Sequence[Teacher],
        *,
        speech: str = "kinds",
        order: str = "fixed",
        cost: float = 0.01,
        budget: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(f"panel_{desk.name}", speech, render_mode)
        check_teachers(tutors)
        if order not in ORDERS:
            raise ValueError(f"order {order!r} is unknown; allowed: {', '.join(ORDERS)}")
        self.desk, self.order = desk, order
        self.teachers = tuple(f"{TEACHER[:-1]}{i}" for i in range(len(tutors)))
        self.possible_agents = [*self.teachers, STUDENT]
        self.seats = {
            teacher: TeacherSeat(tutor, Purse(cost, budget), desk.max_cycles, desk.world.reward_range)
            for teacher, tutor in zip(self.teachers, tutors, strict=True)
        }
        students = desk.observation_space(STUDENT)
        said = spaces.Dict({teacher: Prose(PROSE) for teacher in self.teachers})
        self.observation_spaces[STUDENT] = spaces.Dict({**students, "said": said})  # type: ignore[dict-item]
        self.action_spaces[STUDENT] = desk.action_space(STUDENT)
        for teacher, seat in self.seats.items():
            if speech == "message":
                self.observation_spaces[teacher] = spaces.Dict({**words_space(), "heard": Prose(PROSE * len(tutors))})
                self.action_spaces[teacher] = message_space()
            else:
                self.observation_spaces[teacher] = seat.kinds_space(heard=spaces.MultiBinary(len(KINDS)))
                self.action_spaces[teacher] = spaces.Discrete(SUBSETS)
        self._rng: np.random.Generator | None = None

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the world's."""
        if seed is not None or self._rng is None:
            self._rng, _ = seeding.np_random(seed)
        desk = self.desk
        desk.reset(int(self._rng.integers(2**31)), options)
        self._order_rng, *streams = self._rng.spawn(len(self.teachers))
        _, *others = self.seats.values()
        for seat, stream in zip(others, streams, strict=True):
            seat.tutor.reset(stream)
            seat.tutor.open(desk.moment)  # which looks at the world; the student has the instruction already
        for seat in self.seats.values():
            seat.purse.spent = 0
        self._open()
        self.infos[STUDENT] = desk.infos[STUDENT]
        self._said: dict[str, str] = dict.fromkeys(self.teachers, SILENCE)
        self._begin_round()

    def observe(self, agent: str) -> dict[str, Any]:
        """What an agent sees now."""
        if agent == STUDENT:
            return {**self.desk.observe(STUDENT), "said": dict(self._said)}
        heard = self._joined()
        if self.speech == "message":
            return {**self.desk.describe(), "heard": str(heard)}
        kinds = {atom.kind for atom in heard.atoms}
        observation = self.seats[agent].observe(self.agent_selection == agent)
        observation["heard"] = np.array([kind in kinds for kind in KINDS], np.int8)
        return observation

    def as_text(self) -> str:
        """The world, and the last words of each teacher."""
        words = "\n".join(f"{teacher}: {self._said[teacher]}" for teacher in self.teachers)
        return f"{self.desk.as_text()}\n{words}"

    def close(self) -> None:
        """Close the world."""
        self.desk.close()

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            desk = self.desk
            desk.student_turn(action)
            self.infos[STUDENT] = desk.infos[STUDENT]
            teachers = {
                teacher: desk.teacher_reward(desk.moment, seat.tutor.oracle) for teacher, seat in self.seats.items()
            }
            self._pay(STUDENT, {**teachers, STUDENT: desk.moment.reward})
            self._begin_round()
            return
        seat = self.seats[agent]
        said = self._with_speaker(agent, seat.say(action) if self.speech == "kinds" else seat.feedback(action))
        self._pay(agent, {**dict.fromkeys(self.possible_agents, 0.0), agent: seat.purse.pay(price(said))})
        self._spoken[agent] = said
        if self._waiting:
            self.agent_selection = self._waiting.pop(0)
        else:
            self._end_round()

    def _begin_round(self) -> None:
        order = list(self.teachers)
        if self.order == "random":
            self._order_rng.shuffle(order)
        self._spoken: dict[str, Utterance] = {}
        for teacher in order:
            self.seats[teacher].see(self.desk.moment)
            self.infos[teacher] = {"moment": self.desk.moment}
        self.agent_selection, *self._waiting = order

    def _with_speaker(self, teacher: str, said: str) -> Utterance:
        """Words whose atoms tell who says them; a notice that has been given in this round is left out."""
        atoms = said.atoms if type(said) is Utterance else ()
        given = [atom.claim for words in self._spoken.values() for atom in words.atoms if atom.kind is None]
        if any(atom.claim in given for atom in atoms):
            said = Utterance.of(atoms := tuple(atom for atom in atoms if atom.claim not in given))
        return Utterance(said, tuple(atom._replace(speaker=teacher) for atom in atoms))

    def _joined(self) -> Utterance:
        """What has been said in this round."""
        said = [words for words in self._spoken.values() if words]
        return Utterance(" ".join(said), tuple(atom for words in said for atom in words.atoms))

    def _end_round(self) -> None:
        desk = self.desk
        self._said = {teacher: self._spoken[teacher] for teacher in self.teachers}
        desk.hear(self._joined())
        terminated, truncated = desk.ended
        if terminated or truncated:
            self.terminations = dict.fromkeys(self.agents, terminated)
            self.truncations = dict.fromkeys(self.agents, truncated)
        self.agent_selection = STUDENT

    def _pay(self, actor: str, rewards: dict[str, float]) -> None:
        self.rewards = rewards
        self._cumulative_rewards[actor] = 0.0
        for agent, reward in rewards.items():
            self._cumulative_rewards[agent] += reward
