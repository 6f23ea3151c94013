"""Gymnasium's view of the teacher's seat."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Unpack, cast

import numpy as np
from gymnasium import spaces

from llf_teacher.gym.lifetime import Lifetime, check_vary, drawn, lifetime_space
from llf_teacher.gym.seat_env import SeatEnv
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from pz_envs.rewards import TeacherReward
from pz_envs.settings import Settings, SettingsKeywords, takes_settings
from pz_envs.subject import Subject
from pz_envs.teacher_view import choices_of, mask_space
from teachers.atoms import Moment
from teachers.oracle import Oracle

LifetimeReward = Callable[[Moment[Any], Oracle[Any, Any], Lifetime], float]
"""The teacher's reward of a student's turn, given what the lifetime was like before it."""


class TeacherEnv(SeatEnv):
    """The teacher's seat; observation, action and reward as `teacher_0` has them in `pz_envs.seatings.tutoring`.

    A step is the teacher's turn and the student's next one. The reward is the sum of both.

    With `actions="compact"` there are only the actions that can ever be legal: `subsets` of the kinds that the feedback
    type and the oracle leave, two if that is one kind. `action_mask` is as long; `trimmed` is a subset as ever.

    With `episodes` above 1, one episode of this environment is a lifetime: so many episodes of one student, who may
    learn from each for the next (`q_learning(forget=False, trust=1.0)`). Each lifetime has a new student, one budget of
    advice, and one world, from the same start and with fresh randomness (`same_world`). The last word of an episode is
    followed by the opening of the next. The observation has one more entry, `lifetime`, Box (9,) from 0 to 1:

    0. episodes that are over / episodes
    1. moving average of the success of episodes, weight 0.2 for the latest
    2. 1 if the student's last action was optimal, else 0
    3. moving average of that over the turns, weight 0.1 for the latest
    4. n / (n + 4) for n earlier visits of the student's state in this lifetime
    5. n / (n + 4) for n of those visits in which an action was advised
    6. 1 if the student has announced its next action, else 0
    7. 1 if what it announced is a mistake, else 0: worth less than another action, or, where actions have no values,
       one with which the oracle would find fault
    8. n / (n + 4) for n turns of the oracle's plan from here, at most `max_turns`; 0 without one, or when it is over

    Info: that of `teacher_0`, such as the privileged `moment`, and `trimmed`, the kinds of the last action of which
    nothing could be said; `student`, its spec, or None for a policy of your own; and, if it has announced an action,
    that as `intention`.

    A student with `forget=False` remembers its earlier episodes until a reset with a seed, which brings a new one. A
    policy of your own that is given as it is always stays; only its `reset` is called.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        student: a spec string, a `Student`, a policy with `reset(rng)` and `act(observation, info)`, or a function of a
            random generator that makes such a policy, which is asked for a new one at each reset.
        settings: of the lesson; None: the defaults, with `speech="kinds"`, in a lifetime with `until_success=True`, and
            in texts if the student reads texts.
        actions: with `speech="kinds"`, `all` or `compact`.
        episodes: episodes of the student in one of this environment, at least 1.
        same_world: whether the episodes of a lifetime begin in the same state of the world.
        vary: parameters of the student that are drawn at each reset, uniformly between their least and their greatest
            value, such as `{"alpha": (0.1, 0.9)}`; between two integers an integer: `{"trust": (0, 1)}` gives 0 or 1.
        announce: whether the student announces, before the teacher speaks, what it means to do; learners can.
        keywords: fields of `pz_envs.settings.Settings` that are otherwise, and the world's options. `teacher_reward`
            may also be a function of three arguments, `Moment`, `Oracle` and the student's `Lifetime` as it was before
            the turn.

    Raises:
        ValueError: an argument is not supported.
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
                    f"the student {student} reads no numbers; numbers=True is for policies with reset(rng) and "
                    "act(observation, info) of your own"
                )
            defaults["text"] = student.text
        self.life: Lifetime | None = None
        """What the teacher remembers; None in a single episode."""
        reward = settings.teacher_reward if settings is not None else "student_reward"
        paid: Any = self._paid_by(keywords.pop("teacher_reward", reward))
        super().__init__(env_id, settings, {**keywords, "teacher_reward": paid}, **defaults)
        self.action_space = self.teacher_view.action_space
        self.episodes, self.same_world, self.announce = episodes, same_world, announce
        self._spec, self._vary = student, dict(vary or {})
        if self._vary:
            check_vary(student, self._vary)
        given = isinstance(student, Student)
        self.student: Any = self._enrol(np.random.default_rng(0)) if given else student
        self._renews = episodes > 1 or bool(self._vary) or not (given or _is_policy(student))
        self._remembers = given and not getattr(student, "forget", True)
        if (
            given or _is_policy(student) or isinstance(student, type)
        ):  # what a function makes is checked when it is made
            self._check_announces(self.student)
        self.subsets = choices_of(actions, self.session.teacher, self.settings.speech)
        """With `speech="kinds"`, the subset of kinds that each action says."""
        self._compact = np.array(self.subsets) if actions == "compact" else None
        self.observation_space = self.teacher_view.observation_space
        more: dict[str, spaces.Space[Any]] = {"lifetime": lifetime_space()} if episodes > 1 else {}
        if self._compact is not None:
            self.action_space = spaces.Discrete(len(self.subsets))
            more["action_mask"] = mask_space(len(self.subsets))
        if more:
            self.observation_space = spaces.Dict({**self.observation_space, **more})

    def __repr__(self) -> str:
        student = str(self._spec) if isinstance(self._spec, Student) else self._spec
        return f"<{type(self).__name__} {self.env_id} student={student!r} {self.session.teacher!r}>"

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode or a lifetime; the teacher speaks first."""
        self._restart(seed, options)
        seeds = self.session.seeds
        self._start: Any = None
        if self._renews or (self._remembers and seed is not None):
            self.student = self._enrol(seeds.stream("class"))
        if self.episodes > 1 or self._sees_life:
            self._options = options
            self.life = Lifetime(self.student_view, self.episodes)
            self.life.arrive()
            if self.same_world:
                self._start = self.session.moment.after
        self.student.reset(seeds.stream("student"))
        return self._observe()

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Speak, and see what the student does.

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
        if session.heard:
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

    def resume_from(self, moment: Moment[Any], *, terminated: bool, spent: int, start: Any, done: bool) -> None:
        """Go on from a moment of an episode that was played elsewhere; the teacher is the next to speak.

        Call `reset` before: the random streams are those that it has begun. Student and lifetime are restored apart.

        Args:
            moment: with the world's truths.
            terminated: whether the student's episode has ended there other than by its length.
            spent: atoms that were said.
            start: the truth with which the episodes of the lifetime begin.
            done: whether the last word has been said, too.
        """
        self.session.resume_from(moment, terminated)
        self.teacher_view.offer.purse.spent = spent
        self._start, self._running = start, not done

    def _paid_by(self, reward: str | TeacherReward | LifetimeReward) -> str | TeacherReward:
        """A reward that sees the lifetime as one of moment and oracle."""
        self._sees_life = callable(reward) and len(inspect.signature(reward).parameters) == 3
        if not self._sees_life:
            return cast("str | TeacherReward", reward)
        self._reward = cast(LifetimeReward, reward)
        return self._reward_of_life

    def _reward_of_life(self, moment: Moment[Any], oracle: Oracle[Any, Any]) -> float:
        return self._reward(moment, oracle, cast(Lifetime, self.life))

    def _enrol(self, rng: np.random.Generator) -> Any:
        """A new student."""
        student = self._spec
        if not isinstance(student, Student):
            made = student if _is_policy(student) else student(rng)
            self._check_announces(made)
            return made
        if self._vary:
            student = drawn(student, self._vary, rng)
        self._drawn = str(student)
        return student.seat(self.family, self.session.world)

    def _check_announces(self, student: Any) -> None:
        if self.announce and not hasattr(student, "intend"):
            raise ValueError(
                f"the student {self._spec!s} cannot announce its actions, since it has no intend(observation, info); "
                "announce must be False"
            )

    def _next_episode(self, life: Lifetime, terminated: bool) -> bool:
        """End an episode of a lifetime; begin the next one, if there is one."""
        session, view, student = self.session, self.student_view, self.student
        if hasattr(student, "finish"):
            student.finish(view.observe(), view.info_for(student), terminated)
        life.over()
        if life.episode == life.episodes:
            return False
        session.start_next_episode(self._start, self._options)
        student.reset(session.seeds.stream("student"))
        life.arrive()
        return True

    def _observe(self) -> tuple[dict[str, Any], dict[str, Any]]:
        life = self.life
        observation, info = self.teacher_view.observe(self._running), self.teacher_view.info()
        if self._compact is not None:
            observation["action_mask"] = observation["action_mask"][self._compact]
        intention = None
        if self.announce and self._running and not self.session.over:
            intention = self.student.intend(self.student_view.observe(), self.student_view.info_for(self.student))
        if intention is not None:  # Gymnasium's vectors want the same type in each step, or nothing
            info["intention"] = intention
        info["student"] = self._drawn if isinstance(self._spec, Student) else None
        if life is not None and self.episodes > 1:
            observation["lifetime"] = life.features(intention)
        return observation, info

    def action_masks(self) -> np.ndarray:
        """Which actions are legal now, bool, one each; the form that maskable learners ask for.

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
    """Whether it acts itself, and is not a function or a class that makes such policies."""
    return hasattr(student, "act") and not isinstance(student, type)
