"""Gymnasium's view of the teacher's seat."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Unpack, cast

import numpy as np
from gymnasium import spaces

from llf_teacher.gym.lifetime_statistics import LifetimeStatistics, lifetime_space
from llf_teacher.gym.seat_env import SeatEnv
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from llf_teacher.students.variation import check_vary, draw_student
from pz_envs.numbers import Field, Flat
from pz_envs.rewards import TeacherReward
from pz_envs.settings import Settings, SettingsKeywords, takes_settings
from pz_envs.subject import Subject
from pz_envs.teacher_view import choices_of, mask_space
from teachers.atoms import Moment
from teachers.oracle import Oracle

LifetimeReward = Callable[[Moment[Any], Oracle[Any, Any], LifetimeStatistics], float]
"""A reward function for the teacher, given a student's turn and the lifetime before it."""


class TeacherEnv(SeatEnv):
    """The teacher's seat; observation, action and reward are those of `teacher_0` in `pz_envs.seatings.tutoring`.

    A step is the teacher's turn and the student's next one. The reward is the sum of both.

    With `actions="compact"` the actions are `subsets`: only subsets of the kinds that feedback type and oracle allow
    (two for one kind). `action_mask` then has as many entries; `trimmed` still numbers all 32 subsets.

    With `episodes` above 1, one episode of this environment is a lifetime: several episodes of one student, which can
    learn across them (`q_learning(forget=False, trust=1.0)`). Each lifetime has a new student, one budget of advice,
    and one world, which begins in the same state with fresh randomness (`same_world`). After the teacher's last turn of
    an episode the next one begins. The observation has one more entry, `lifetime`, Box (9,) from 0 to 1:

    0. episodes that are over / episodes
    1. moving average of the success of episodes, weight 0.2 for the latest
    2. 1 if the student's last action was optimal, else 0
    3. moving average of number 2 over the turns, weight 0.1 for the latest
    4. n / (n + 4) for n earlier visits of the student's state in this lifetime
    5. n / (n + 4) for n of these visits with advised actions
    6. 1 if the student has announced its next action, else 0
    7. 1 if the announced action is a mistake, else 0: it has less value than another, or, where actions have no
       values, the oracle would criticise it
    8. n / (n + 4) for n turns of the oracle's plan from here, at most `max_turns`; 0 without one, or when it is over

    With `teacher_numbers=True` the observation is one flat Box of all these, with the layout `fields`, and the info has
    the `action_mask`.

    Info: that of `teacher_0`, such as the privileged `moment`, and `trimmed`, the kinds of the last action that could
    not be said; `student`, its spec, or None for a policy of your own; and `intention`, the announced action, if there
    is one.

    A student with `forget=False` keeps what it has learned until a reset with a seed, which makes a new one. A policy
    of your own is never replaced; only its `reset` is called.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        student: a spec string, a `Student`, a policy with `reset(rng)` and `act(observation, info)`, or a function that
        makes such a policy from a random generator at each reset.
        settings: the settings of the lesson; None: the defaults, with `speech="kinds"`, in a lifetime
            `until_success=True`, and `text=True` if the student reads texts.
        actions: with `speech="kinds"`, `all` or `compact`.
        episodes: the student's episodes in one episode of this environment, at least 1.
        same_world: whether the episodes of a lifetime begin in the same state of the world.
        vary: parameters of the student that each reset draws uniformly, with their least and greatest value, such as
            `{"alpha": (0.1, 0.9)}`; between two integers it draws an integer: `{"trust": (0, 1)}` gives 0 or 1.
        announce: whether the student announces its next action before the teacher speaks; learners can. Traits change
            only what is heard and done afterwards.
        keywords: fields of `pz_envs.settings.Settings` that replace the settings', and the world's options.
            `teacher_reward` may also be a function of three arguments, `Moment`, `Oracle` and the student's
            `LifetimeStatistics` before the turn.

    Raises:
        ValueError: an argument is not allowed.
    """

    @takes_settings(speech="kinds")
    def __init__(
        self,
        env_id: str | Subject,
        *,
        settings: Settings | None = None,
        student: str | Student | Any = "obedient",
        actions: str = "all",
        episodes: int = 1,
        same_world: bool = True,
        vary: Mapping[str, Any] | None = None,
        announce: bool = False,
        **keywords: Unpack[SettingsKeywords],
    ) -> None:
        if not isinstance(episodes, int) or episodes < 1:
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        defaults: dict[str, Any] = {"speech": "kinds", "until_success": episodes > 1}
        if isinstance(student, str | Student):
            student = parse_student(student)
            if keywords.get("numbers"):
                raise ValueError(
                    f"numbers=True is not supported by the student {student}, which reads no numbers; give a policy of "
                    "your own, with reset(rng) and act(observation, info)"
                )
            defaults["text"] = student.text
        self.life: LifetimeStatistics | None = None
        """The statistics of the lifetime; None in a single episode."""
        reward = getattr(settings, "teacher_reward", "student_reward")
        paid: Any = self._paid_by(keywords.pop("teacher_reward", reward))
        settled = {**keywords, "teacher_reward": paid}
        super().__init__(env_id, settings, settled, episodes=episodes, last_words=1, **defaults)
        self.action_space = self.teacher_view.action_space
        self.episodes, self.same_world, self.announce = episodes, same_world, announce
        self._spec, self._vary = student, dict(vary or {})
        if self._vary:
            check_vary(student, self._vary)
        given = isinstance(student, Student)
        self.student: Any = self._make_student(np.random.default_rng(0)) if given else student
        self._renews = episodes > 1 or bool(self._vary) or not (given or _is_policy(student))
        self._remembers = given and not getattr(student, "forget", True)
        if given or _is_policy(student) or isinstance(student, type):  # a function's policy is checked when it is made
            self._check_announces(self.student)
        self.subsets = choices_of(actions, self.session.teacher, self.settings.speech)
        """With `speech="kinds"`, the subset of kinds that each action says."""
        self._compact = np.array(self.subsets) if actions == "compact" else None
        more: dict[str, spaces.Space[Any]] = {"lifetime": lifetime_space()} if episodes > 1 else {}
        if self._compact is not None:
            self.action_space = spaces.Discrete(len(self.subsets))
            more["action_mask"] = mask_space(len(self.subsets))
        seen: spaces.Space[Any] = self.teacher_view.observation_space
        if more:
            seen = spaces.Dict({**self.teacher_view.observation_space, **more})
        self.flat = Flat(seen) if self.settings.teacher_numbers else None
        """Writes observations as one array; None without `teacher_numbers`."""
        self.observation_space = seen if self.flat is None else self.flat.space

    @property
    def fields(self) -> tuple[Field, ...]:
        """The fields of an observation, in their order; empty without `teacher_numbers=True`."""
        return () if self.flat is None else self.flat.fields

    def __repr__(self) -> str:
        student = str(self._spec) if isinstance(self._spec, Student) else self._spec
        return f"<{type(self).__name__} {self.env_id} student={student!r} {self.session.teacher!r}>"

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode or a lifetime; the teacher speaks first."""
        self._restart(seed, options)
        self._running = True
        seeds = self.session.seeds
        self._start: Any = None
        if self._renews or (self._remembers and seed is not None):
            self.student = self._make_student(seeds.stream("class"))
        if self.episodes > 1 or self._sees_life:
            self._options = options
            self.life = LifetimeStatistics(self.student_view, self.episodes)
            self.life.arrive()
            if self.same_world:
                self._start = self.session.moment.after
        self.student.reset(seeds.stream("student"))
        return self._observe()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Speak; then the student acts.

        Raises:
            ResetNeeded: before `reset`, or after the episode's end.
            ValueError: the action is outside the action space; nothing has changed.
        """
        self._check_running()
        session, teacher, life = self.session, self.teacher_view, self.life
        if self._compact is not None:
            if not self.action_space.contains(action):
                raise ValueError(f"the action must be an integer from 0 to {len(self.subsets) - 1}, got {action!r}")
            action = self.subsets[action]
        reward = teacher.act(action)
        terminated = truncated = False
        if session.heard or session.over:  # a finished episode leaves no time for a second claim
            if life is not None:
                life.said()
            if session.over:
                terminated, truncated = session.terminated, session.truncated
                self._running = life is not None and self.episodes > 1 and self._next_episode(life, terminated)
                if self._running:
                    terminated = truncated = False
            else:
                view = self.student_view
                view.act(self.student.act(view.observe(), view.info_for(self.student)))
                reward += teacher.reward()
                if life is not None and not session.asked:
                    life.acted()
                    life.arrive()
                if self.render_mode == "human":
                    self.render()
        observation, info = self._observe()
        return observation, reward, terminated, truncated, info

    def resume_from(
        self,
        moment: Moment[Any],
        *,
        terminated: bool,
        spent: int,
        start: Any,
        done: bool,
        past: Sequence[Moment[Any]] = (),
    ) -> None:
        """Go on from a moment of another environment's episode; the teacher speaks next.

        Call `reset` before, which begins the random streams. Student and lifetime are restored separately.

        Args:
            moment: the moment, with the world's truths.
            terminated: whether the student's episode has ended there for a reason other than its length.
            spent: atoms said in this lifetime.
            start: the truth with which the episodes of the lifetime begin.
            done: whether the teacher has spoken for the last time.
            past: the earlier moments of the episode.
        """
        self.session.resume_from(moment, terminated, past)
        self.teacher_view.teacher_turn.budget.spent = spent
        self._start, self._running = start, not done

    def _paid_by(self, reward: str | TeacherReward | LifetimeReward) -> str | TeacherReward:
        """A reward of moment, oracle and lifetime as a function of moment and oracle."""
        self._sees_life = callable(reward) and len(inspect.signature(reward).parameters) == 3
        if not self._sees_life:
            return cast("str | TeacherReward", reward)
        self._reward = cast(LifetimeReward, reward)
        return self._reward_of_life

    def _reward_of_life(self, moment: Moment[Any], oracle: Oracle[Any, Any]) -> float:
        return self._reward(moment, oracle, cast(LifetimeStatistics, self.life))

    def _make_student(self, rng: np.random.Generator) -> Any:
        """A new student."""
        student = self._spec
        if not isinstance(student, Student):
            made = student if _is_policy(student) else student(rng)
            self._check_announces(made)
            return made
        if self._vary:
            student = draw_student(student, self._vary, rng)
        self._drawn = str(student)
        return student.seat(self.family, self.session.world)

    def _check_announces(self, student: Any) -> None:
        if self.announce and not hasattr(student, "intend"):
            raise ValueError(
                f"the student {self._spec!s} has no intend(observation, info), which announce=True needs; allowed: "
                "announce=False"
            )

    def _next_episode(self, life: LifetimeStatistics, terminated: bool) -> bool:
        """End an episode of a lifetime and begin the next; returns whether there is a next one."""
        session, view, student = self.session, self.student_view, self.student
        if hasattr(student, "finish"):
            student.finish(view.observe(), view.info_for(student), terminated)
        life.end_episode()
        if life.episode == life.episodes:
            return False
        session.start_next_episode(self._start, self._options)
        student.reset(session.seeds.stream("student"))
        life.arrive()
        return True

    def _observe(self) -> tuple[Any, dict[str, Any]]:
        life = self.life
        observation, info = self.teacher_view.observe(self._running), self.teacher_view.info()
        if self._compact is not None:
            observation["action_mask"] = observation["action_mask"][self._compact]
        intention = None
        if self.announce and self._running and not self.session.over:
            intention = self.student.intend(self.student_view.observe(), self.student_view.info_for(self.student))
        if intention is not None:  # Gymnasium's vector environments need the same type in each step, or no entry
            info["intention"] = intention
        info["student"] = self._drawn if isinstance(self._spec, Student) else None
        if life is not None and self.episodes > 1:
            observation["lifetime"] = life.features(intention)
        if self.flat is None:
            return observation, info
        return self.flat.of(observation), info | {"action_mask": observation["action_mask"]}

    def action_masks(self) -> np.ndarray:
        """Which actions are legal now, bool of shape (actions,), as learners with action masks need it.

        Raises:
            ValueError: the speech is not `kinds`.
        """
        if self.settings.speech != "kinds":
            raise ValueError(
                f"action_masks() needs speech='kinds'; with speech={self.settings.speech!r} any text can be said"
            )
        mask: np.ndarray = self.teacher_view.observe(self._running)["action_mask"]
        return (mask if self._compact is None else mask[self._compact]).astype(bool)


def _is_policy(student: Any) -> bool:
    """Whether it is a policy, not a function or a class that makes policies."""
    return hasattr(student, "act") and not isinstance(student, type)
