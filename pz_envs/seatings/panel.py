"""A panel: several teachers, who need not agree, and one student."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import Frank, refuse_messages
from pz_envs.seatings.tutoring import SEATING as TUTORING
from pz_envs.seatings.tutoring import TutoringEnv, words_space
from pz_envs.seats import STUDENT, TEACHER, SeatsEnv
from pz_envs.subject import Seating, Subject
from pz_envs.teacher_seat import CHOICES, PROSE, Purse, TeacherSeat, message_space, price
from teachers.atoms import KINDS, SILENCE, Moment, Utterance
from teachers.personality import Personality
from teachers.teacher import Teacher
from worlds.spaces import Prose

__all__ = ["MOST", "SEATING", "Panel", "PanelEnv", "check_teachers"]

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
    Teacher, `speech="claims"`:
        As with `kinds`, and as in `TutoringEnv`: it is asked again after each claim that it says.
    Teacher, `speech="message"`:
        Observation: Dict of `state`, `action` (`Prose`) as in `TutoringEnv`, and `heard` (`Prose`), what others have
        said before it in this round. Action: `Prose`; an `Utterance` brings its atoms along. What it says of the
        instruction is not repeated.
    The notice that the student's text was no action is heard from the first who gives it in a round.
    Info: the privileged `moment`; with `kinds` also `trimmed`, with `message` `suggestion`, with `claims` `claims`
    and `sentences`, as in `TutoringEnv`.
    A student who asks (`ask_cost`) asks all teachers: a round of answers follows, and then it acts.

    Rewards: at the student's step the student gets the world's reward, and each teacher its `teacher_reward`, by its
    own oracle; at its own step a teacher pays `cost` for each atom of feedback, within a `budget` of its own.

    Seeds: as for `TutoringEnv`; each teacher has streams of its own. Without a seed the streams go on.

    Args:
        desk: the `TutoringEnv` of the student, with `speech="kinds"` in place of `message`; see `Panel.raw_env`.
        teachers: 1 to 16, each with an oracle of its own; the first is the desk's.
        speech: `kinds`, `claims` or `message`.
        order: `fixed` or `random`.
        cost: paid by a teacher per atom of feedback, at least 0.
        budget: atoms of feedback that each teacher may say in an episode. None: any number.
        render_mode: see `SeatsEnv`; the desk has to have the same.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {**SeatsEnv.metadata, "name": "panel_v0"}  # noqa: RUF012 (PettingZoo's convention)

    def __init__(
        self,
        desk: TutoringEnv,
        teachers: Sequence[Teacher],
        *,
        speech: str = "kinds",
        order: str = "fixed",
        cost: float = 0.01,
        budget: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(f"panel_{desk.name}", speech, render_mode)
        check_teachers(teachers)
        if order not in ORDERS:
            raise ValueError(f"order {order!r} is unknown; allowed: {', '.join(ORDERS)}")
        self.desk, self.order = desk, order
        self.teachers = tuple(f"{TEACHER[:-1]}{i}" for i in range(len(teachers)))
        self.max_turns = desk.max_turns
        self.possible_agents = [*self.teachers, STUDENT]
        self.seats = {
            agent: TeacherSeat(
                teacher, Purse(cost, budget), desk.max_turns, desk.world.reward_range, desk.ask_cost is not None
            )
            for agent, teacher in zip(self.teachers, teachers, strict=True)
        }
        students = desk.observation_space(STUDENT)
        said = spaces.Dict({teacher: Prose(PROSE) for teacher in self.teachers})
        self.observation_spaces[STUDENT] = spaces.Dict({**students, "said": said})  # type: ignore[dict-item]
        self.action_spaces[STUDENT] = desk.action_space(STUDENT)
        for teacher, seat in self.seats.items():
            if speech == "message":
                self.observation_spaces[teacher] = spaces.Dict({**words_space(), "heard": Prose(PROSE * len(teachers))})
                self.action_spaces[teacher] = message_space()
            else:
                self.observation_spaces[teacher] = seat.view_space(speech, heard=spaces.MultiBinary(len(KINDS)))
                self.action_spaces[teacher] = spaces.Discrete(CHOICES[speech])

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the world's."""
        self.desk.reset(seed, options)
        for seat in self.seats.values():
            seat.purse.spent = seat.trimmed = 0
        self._open_panel()

    def go_on(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson; see `SeatsEnv`."""
        self.desk.go_on(start, options)
        self._open_panel()

    @property
    def truth_now(self) -> Any:
        """The world's truth as it is."""
        return self.desk.truth_now

    def _open_panel(self) -> None:
        desk = self.desk
        self._order_rng = desk.seeds.stream("order")
        _, *others = self.seats.values()
        for number, seat in enumerate(others, 1):
            seat.teacher.begin(desk.seeds, number)
            seat.teacher.open(desk.moment)  # which looks at the world; the student has the instruction already
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
        observation = self.seats[agent].observe(self.speech, self.agent_selection == agent)
        observation["heard"] = np.array([kind in kinds for kind in KINDS], np.int8)
        return observation

    def moment_of(self, student: str) -> Moment[Any]:
        """The student's last turn."""
        return self.desk.moment

    def as_text(self) -> str:
        """The world, and the last words of each teacher."""
        words = "\n".join(f"{teacher}: {self._said[teacher]}" for teacher in self.teachers)
        return f"{self.desk.as_text()}\n{words}"

    def frame(self) -> Any:
        """The desk, where each sentence has its speaker."""
        return self.desk.frame()

    def close(self) -> None:
        """Close the world."""
        super().close()
        self.desk.close()

    def _company(self) -> str:
        return f"{[seat.teacher for seat in self.seats.values()]}"

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            self._learn(action)
            return
        seat = self.seats[agent]
        if self.speech == "claims":
            before = len(seat.choosing)
            done = seat.choose(action)
            self._charge(agent, len(seat.choosing) - before)
            if not done:
                return
            said = self._with_speaker(agent, seat.chosen())
        else:
            kinds = self.speech == "kinds"
            said = self._with_speaker(agent, seat.say(action) if kinds else seat.feedback(action))
            self._charge(agent, price(said))
            if kinds:
                self.infos[agent] = {**self.infos[agent], "trimmed": seat.trimmed}
        self._spoken[agent] = said
        if self._waiting:
            self.agent_selection = self._waiting.pop(0)
        else:
            self._end_round()

    def _learn(self, action: Any) -> None:
        """The student's turn."""
        desk = self.desk
        desk.student_turn(action)
        self.infos[STUDENT] = desk.infos[STUDENT]
        asked = desk.seat.asked
        teachers = {
            agent: 0.0 if asked else desk.teacher_reward(desk.moment, seat.teacher.oracle)
            for agent, seat in self.seats.items()
        }
        self._pay(STUDENT, {**teachers, STUDENT: desk.rewards[STUDENT]})
        self._begin_round()

    def _charge(self, agent: str, atoms: int) -> None:
        """Let a teacher pay."""
        self._pay(agent, {**dict.fromkeys(self.possible_agents, 0.0), agent: self.seats[agent].purse.pay(atoms)})

    def _begin_round(self) -> None:
        order = list(self.teachers)
        if self.order == "random":
            self._order_rng.shuffle(order)
        self._spoken: dict[str, Utterance] = {}
        moment, asked = self.desk.moment, self.desk.seat.asked
        for teacher in order:
            seat = self.seats[teacher]
            seat.see(moment, asked)
            self.infos[teacher] = seat.info(self.speech)
        self.agent_selection, *waiting = order
        self._waiting: list[str] = waiting

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


class Panel(Seating):
    """Several teachers, one student."""

    def raw_env(
        self,
        subject: Subject,
        *,
        teachers: Sequence[str | Personality] = ("oracle", "oracle"),
        speech: str = "kinds",
        order: str = "fixed",
        cost: float = 0.01,
        budget: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> PanelEnv:
        """Several teachers of these personalities and one student; see `PanelEnv`.

        Other arguments are those of `Tutoring.raw_env`, `max_cycles`, `text`, `feedback_type`, `ask_cost`, ..., and the
        world's options.

        Raises:
            ValueError: an argument is not allowed.
        """
        check_teachers(teachers)
        if "teacher" in options:
            raise ValueError(f"a panel has teachers=[...], not teacher={options['teacher']!r}")
        if options.get("numbers"):
            raise ValueError("a panel's student hears each of its teachers in words; allowed: numbers=False")
        first, *others = teachers
        chosen = "kinds" if speech == "message" else speech
        desk = TUTORING.raw_env(subject, speech=chosen, teacher=first, render_mode=render_mode, **options)
        voices = {key: options[key] for key in _TEACHING if key in options}
        return PanelEnv(
            desk,
            [desk.teacher, *(subject.make_teacher(desk.world, each, **voices) for each in others)],
            speech=speech,
            order=order,
            cost=cost,
            budget=budget,
            render_mode=render_mode,
        )

    def parallel_env(self, subject: Subject, *, speech: str = "kinds", **settings: Any) -> ParallelSeats:
        """The student alone; each teacher says all that its personality would say.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"`.
        """
        refuse_messages(speech)
        env = self.seats(subject, speech=speech, **settings)
        teachers = [agent for agent in env.possible_agents if agent != STUDENT]
        return ParallelSeats(env, {teacher: Frank() for teacher in teachers})


_TEACHING = ("instruction_type", "feedback_type", "voice", "paraphrase")
SEATING = Panel()
