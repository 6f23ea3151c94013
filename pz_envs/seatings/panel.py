"""A panel: several teachers, which may disagree, and one student."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.assembly import Parts, assemble
from pz_envs.global_state import Seated
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import SayAll, SaySuggestion, refuse_unread
from pz_envs.seats import STUDENT, TEACHER, OneSessionEnv
from pz_envs.settings import Settings
from pz_envs.subject import Seating, Subject
from teachers.atoms import KINDS, SILENCE
from teachers.personality import Personality
from teachers.teacher import Teacher
from teachers.teacher_turn import LONGEST
from worlds.spaces import Prose

__all__ = ["MOST", "SEATING", "Panel", "PanelEnv", "check_teachers"]

MOST = 16
"""Greatest number of teachers."""
ORDERS = ("fixed", "random")


def check_teachers(teachers: Any) -> None:
    """Check the teachers of a panel.

    Raises:
        ValueError: they are not a list, or not 1 to 16.
    """
    if isinstance(teachers, str) or not isinstance(teachers, Sequence):
        raise ValueError(f"teachers must be a list of 1 to {MOST}, such as ['oracle', 'silent'], got {teachers!r}")
    if not 1 <= len(teachers) <= MOST:
        raise ValueError(f"teachers must be 1 to {MOST}, got {len(teachers)}")


def policies_of(teachers: Sequence[Any]) -> dict[int, Any]:
    """The policies among the teachers of a panel, by number.

    Raises:
        ValueError: an element is not a teacher.
    """
    found = {i: each for i, each in enumerate(teachers) if not isinstance(each, str | Personality | Teacher)}
    for i, each in found.items():
        if isinstance(each, type) or not (hasattr(each, "reset") and hasattr(each, "act")):
            raise ValueError(
                f"teachers[{i}] must be a spec string, a personality, a Teacher, or a policy with reset(rng) and "
                f"act(observation, info), got {each!r}"
            )
    return found


class PanelEnv(OneSessionEnv):
    """An AEC environment with the agents `teacher_0` to `teacher_<m - 1>` and `student_0`, over one session.

    Turn order:
        `reset` gives the student the instruction, free of charge. Then rounds follow: each teacher speaks once, then
        the student acts. With `order="fixed"` the teachers speak in the order of their numbers, with `random` in
        an order that is drawn anew for each round. After the student's last action each teacher speaks once
        more; then all agents end together, and the student has these words in the `last()` of its dead step.

    Student:
        Observation: as for `TutoringEnv`'s student, but `feedback` has the words of all teachers in speaking order;
        and `said`, Dict of `teacher_<i>` (`Prose`), the words of each. Action and info as for `TutoringEnv`; each atom
        has its `speaker`.

    Teacher, `speech="kinds"`:
        Observation: Dict of `available`, `features` and `action_mask` as in `TutoringEnv`, with its own budget, and
        `heard`, MultiBinary (5): the kinds that other teachers have said earlier in this round, in the order r, hp, hn,
        fp, fn. Action: Discrete(32), the subset of the kinds to say. It can say the claims of its own personality.
    Teacher, `speech="claims"`:
        As with `kinds`, and as in `TutoringEnv`: it acts again after each claim.
    Teacher, `speech="message"`:
        Observation: Dict of `state`, `action` (`Prose`) as in `TutoringEnv`, and `heard` (`Prose`), the words of other
        teachers earlier in this round. Action: `Prose`; an `Utterance` brings its atoms along. Atoms of the instruction
        are left out.
    If several teachers say that the student's text was no action, only the first notice in a round is heard.
    Info: the privileged `moment`; with `kinds` also `trimmed`, with `message` `suggestion`, with `claims` `claims`
    and `sentences`, as in `TutoringEnv`.
    A student that asks (`ask_cost`) asks all teachers: a round of answers follows, and then it acts.

    Rewards: at the student's step the student gets the world's reward, and each teacher its `teacher_reward`, by its
    own oracle; at its own step a teacher pays `cost` for each atom of feedback, within a `budget` of its own.

    Seeds: as for `TutoringEnv`; each teacher has streams of its own. Without a seed the streams go on.

    Args:
        parts: the parts of a session with 1 to 16 teachers.
        settings: the settings of the session.
        name: the environment's first label.
        order: `fixed` or `random`.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(self, parts: Parts, settings: Settings, name: str = "tutoring", *, order: str = "fixed") -> None:
        if order not in ORDERS:
            raise ValueError(f"order {order!r} is unknown; allowed: {', '.join(ORDERS)}")
        session, student_view, views = parts
        super().__init__(session, student_view, f"panel_{name}", settings.speech, settings.render_mode)
        self.order = order
        self.teacher_views = {f"{TEACHER[:-1]}{i}": view for i, view in enumerate(views)}
        """The view of each teacher, by agent."""
        self.teachers = tuple(self.teacher_views)
        self.possible_agents = [*self.teacher_views, STUDENT]
        said = spaces.Dict({teacher: Prose(LONGEST) for teacher in self.teacher_views})
        self.observation_spaces[STUDENT] = spaces.Dict({**self.student_view.words_space, "said": said})
        self.action_spaces[STUDENT] = self.student_view.action_space
        heard = Prose(LONGEST * len(views)) if settings.speech == "message" else spaces.MultiBinary(len(KINDS))
        for teacher, view in self.teacher_views.items():
            self.observation_spaces[teacher] = spaces.Dict({**view.observation_space, "heard": heard})
            self.action_spaces[teacher] = view.action_space

    def _enter(self) -> None:
        super()._enter()
        self._order_rng = self.session.seeds.stream("order")
        self._said: dict[str, str] = dict.fromkeys(self.teacher_views, SILENCE)
        self._begin_round()

    @property
    def seated(self) -> list[Seated]:
        """The student with its teachers."""
        return [Seated(STUDENT, self.student_view, self.teacher_views)]

    def _observe(self, agent: str) -> dict[str, Any]:
        if agent == STUDENT:
            return {**self.student_view.observe(), "said": dict(self._said)}
        heard = self.session.said_so_far()
        observation = self.teacher_views[agent].observe(self.agent_selection == agent)
        if self.speech == "message":
            return {**observation, "heard": str(heard)}
        kinds = {atom.kind for atom in heard.atoms}
        observation["heard"] = np.array([kind in kinds for kind in KINDS], np.int8)
        return observation

    def as_text(self) -> str:
        """The world and the last words of each teacher."""
        words = "\n".join(f"{teacher}: {said}" for teacher, said in self._said.items())
        return f"{super().as_text()}\n{words}"

    def _describe_seats(self) -> str:
        return f"{[each.teacher for each in self.session.teacher_turns]}"

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            reward = self.student_view.act(action)
            self.infos[STUDENT] = self.student_view.info()
            rewards = {each: view.reward() for each, view in self.teacher_views.items()}
            self._pay_all(STUDENT, {**rewards, STUDENT: reward})
            self._begin_round()
            return
        view = self.teacher_views[agent]
        self._pay_all(agent, {agent: view.act(action)})
        if self.speech == "kinds":
            self.infos[agent] = {**self.infos[agent], "trimmed": view.teacher_turn.trimmed}
        if self.session.heard:
            self._said = {teacher: view.teacher_turn.said or SILENCE for teacher, view in self.teacher_views.items()}
            self._select_student()
        elif view.teacher_turn.said is not None:
            self.agent_selection = self._waiting.pop(0)

    def _begin_round(self) -> None:
        order = list(self.teacher_views)
        if self.order == "random":
            self._order_rng.shuffle(order)
        for teacher in order:
            self.infos[teacher] = self.teacher_views[teacher].info()
        self.agent_selection, *waiting = order
        self._waiting: list[str] = waiting


class Panel(Seating):
    """Several teachers, one student."""

    defaults = {"speech": "kinds"}  # noqa: RUF012 (as of `Seating`)

    def raw_env(
        self,
        subject: Subject,
        settings: Settings,
        *,
        teachers: Sequence[str | Personality | Teacher] = ("oracle", "oracle"),
        order: str = "fixed",
    ) -> PanelEnv:
        """Several teachers and one student; see `PanelEnv`.

        Args:
            subject: the subject.
            settings: the settings of the lesson; each teacher has its own cost and budget.
            teachers: 1 to 16 personalities or teachers.
            order: `fixed` or `random`.

        Raises:
            ValueError: an argument is not allowed.
        """
        check_teachers(teachers)
        if policies := policies_of(teachers):
            raise ValueError(
                f"teachers[{min(policies)}] is a policy, which this form does not play; give a personality in its "
                f"place, such as 'oracle', and act for teacher_{min(policies)}, or take the parallel form"
            )
        if settings.teacher != Settings().teacher:
            raise ValueError(f"a panel does not use teacher={settings.teacher!r}; give its teachers as teachers=[...]")
        if settings.numbers:
            raise ValueError(
                "numbers=True is not supported in a panel, whose student hears each teacher in words; allowed: False"
            )
        parts = assemble(subject, settings, personalities=teachers, instructs=True)
        return PanelEnv(parts, settings, subject.name, order=order)

    def parallel_env(self, subject: Subject, settings: Settings, **own: Any) -> ParallelSeats:
        """The student alone; each teacher says all claims of its personality.

        A teacher may also be a policy with `reset(rng)` and `act(observation, info)`, which returns words or claims.
        Then all teachers observe and act as with `speech="message"`.

        Raises:
            ValueError: an argument is not allowed, such as `speech="message"` without a policy.
        """
        teachers = own.get("teachers", ())
        policies: Mapping[int, Any] = {}
        if isinstance(teachers, Sequence) and not isinstance(teachers, str):  # otherwise `raw_env` raises the error
            policies = policies_of(teachers)
        if not policies or settings.speech == "claims":
            refuse_unread(settings.speech, settings.teacher_numbers)
        if policies:
            own["teachers"] = ["oracle" if i in policies else each for i, each in enumerate(teachers)]
            settings = replace(settings, speech="message")
        env = self.seats(subject, settings, **own)
        scripted = SaySuggestion if policies else SayAll
        seats = [agent for agent in env.possible_agents if agent != STUDENT]
        return ParallelSeats(
            env, {agent: policies[i] if i in policies else scripted() for i, agent in enumerate(seats)}
        )


SEATING = Panel()
