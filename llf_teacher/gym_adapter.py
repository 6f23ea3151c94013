"""Gymnasium's view of the two seats: `StudentEnv` has a fixed teacher, `TeacherEnv` a fixed student."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from llf_teacher.lifetime import Lifetime, check_vary, drawn, lifetime_space
from llf_teacher.registry import entry
from llf_teacher.student import Student, entitled, parse_student
from pz_envs.family import Subject
from pz_envs.lesson import Lesson
from pz_envs.tutoring import STUDENT, TEACHER
from teachers.atoms import SILENCE, Moment, Utterance
from teachers.feedback import parse_kinds
from teachers.oracle import Oracle
from teachers.personality import Personality
from teachers.phrasebook import Paraphrase, Phrases
from teachers.teacher import Teacher
from teachers.voice import Voice
from worlds.wrapped.old_gym import OldGym

__all__ = ["Lesson", "OldGym", "StudentEnv", "TeacherEnv", "prompt", "teach"]


class _Flat(gymnasium.Env):
    """One seat of a `TutoringEnv` as a Gymnasium environment."""

    metadata = {"render_modes": ["ansi", "human"], "render_fps": 4}  # noqa: RUF012 (Gymnasium's convention)

    def __init__(
        self, seat: str, env_id: str | Subject, max_turns: int | None, render_mode: str | None, **settings: Any
    ) -> None:
        self.family: Subject
        options: dict[str, Any] = {}
        if isinstance(env_id, Subject):
            self.env_id, self.family = env_id.name, env_id
        else:
            self.env_id, self.family, options, _ = entry(env_id)
        self.aec = self.family.raw_env(max_cycles=max_turns, render_mode=render_mode, **{**options, **settings})
        self.render_mode = render_mode
        self.action_space = self.aec.action_space(seat)
        self._partner_rng: np.random.Generator | None = None
        self._running = False

    @property
    def reward_range(self) -> tuple[float, float]:
        """Least and greatest reward that the world pays for one step."""
        return self.aec.world.reward_range

    def _restart(self, seed: int | None, options: dict[str, Any] | None) -> np.random.Generator:
        """Reset the seats; the partner's random stream for this episode. Without a seed all streams go on."""
        super().reset(seed=seed)
        if seed is not None or self._partner_rng is None:
            seats, self._partner_rng = self.np_random.spawn(2)
            self.aec.reset(int(seats.integers(2**31)), options)
        else:
            self.aec.reset(None, options)
        self._running = True
        return self._partner_rng.spawn(1)[0]

    def _check_running(self) -> None:
        if not self._running:
            raise ResetNeeded("the episode has not begun, or has ended; call reset() before step()")

    def render(self) -> str | None:
        """What `TutoringEnv.render` gives."""
        return self.aec.render()

    def close(self) -> None:
        """Close the world."""
        self.aec.close()


class StudentEnv(_Flat):
    """The student's seat.

    Observation: Dict of `observation` (the world's space; `Prose` with `text=True`), `instruction` (at reset, else
    empty) and `feedback` (at reset only if the teacher advises the first action).
    Action: the world's space; `Prose` with `text=True`. Text that is no action costs a turn and is
    answered; see `pz_envs.tutoring`.
    Info: what the world tells, with `success`; `atoms`, what was said, typed; `parse_failure` for text that was no
    action; the privileged `moment` with `privileged_info=True`.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        teacher, instruction_type, feedback_type, voice, paraphrase, visual: see `llf_teacher.make`.
        text: text in, text out: the observation is three strings, and so is the action.
        max_turns: turns after which the episode is truncated; None: the family's.
        privileged_info: put the teacher's `moment` into the info, and `changes`, what a rewriting voice did to
            numbers and names, if it did anything.
        render_mode: None, `ansi` or `human`.
        options: the world's.

    Raises:
        ValueError: an argument is not supported.
    """

    def __init__(
        self,
        env_id: str | Subject,
        *,
        teacher: str | Personality | Any = "oracle",
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: Voice = "plain",
        paraphrase: Paraphrase = "random",
        visual: bool = False,
        text: bool = False,
        max_turns: int | None = None,
        privileged_info: bool = False,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        if visual:
            if not (env_id if isinstance(env_id, Subject) else entry(env_id).family).visual:
                raise ValueError(f"visual=True is not supported by {env_id}: its world has no images; allowed: False")
            options["visual"] = True
        super().__init__(STUDENT, env_id, max_turns, render_mode, text=text, **options)
        if isinstance(teacher, str | Personality):
            teacher = self.family.make_teacher(
                self.aec.world,
                teacher,
                instruction_type=instruction_type,
                feedback_type=feedback_type,
                voice=voice,
                paraphrase=paraphrase,
            )
        elif not (hasattr(teacher, "reset") and hasattr(teacher, "act")):
            raise ValueError(
                f"teacher must be a spec string, a Personality, or a policy with reset(rng) and "
                f"act(observation, info), got {teacher!r}"
            )
        self.teacher = teacher
        self.privileged_info = privileged_info
        # A built-in teacher reads its moment only, and keeps to the feedback type: it is asked directly.
        self._speak = teacher.speak if isinstance(teacher, Teacher) else self._ask
        self.kinds = parse_kinds(feedback_type)
        """The kinds of feedback that were asked for."""
        seat = self.aec.observation_space(STUDENT)
        self.observation_space = spaces.Dict(
            {"observation": seat["state"], "instruction": seat["instruction"], "feedback": seat["feedback"]}
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the teacher gives its instruction."""
        self.teacher.reset(self._restart(seed, options))
        aec = self.aec
        aec.teacher_turn(self._speak(aec.moment))
        observation = {"observation": aec.state_now, "instruction": aec.instruction, "feedback": aec.feedback}
        return observation, self._info()

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Act, and hear what the teacher says of it.

        Raises:
            ResetNeeded: before `reset`, or after the episode's end.
            ValueError: the action is outside the action space; nothing has changed.
        """
        if not self._running:
            self._check_running()
        aec = self.aec
        aec.student_turn(action)
        moment = aec.moment
        aec.teacher_turn(self._speak(moment))
        terminated, truncated = aec.ended
        self._running = not moment.over
        observation = {"observation": aec.state_now, "instruction": SILENCE, "feedback": aec.feedback}
        if self.render_mode == "human":
            self.render()
        return observation, moment.reward, terminated, truncated, self._info()

    def _info(self) -> dict[str, Any]:
        info = self.aec.infos[STUDENT]
        if self.privileged_info:
            info["moment"] = self.aec.moment
            if changes := getattr(self.teacher, "changes", ()):
                info["changes"] = changes
        return info

    def _ask(self, moment: Moment) -> str:
        """What another policy in the teacher's seat says, as far as the feedback type allows.

        Text without atoms is of no kind: it passes unless no feedback is wanted at all.
        """
        said = self.teacher.act(self.aec.observe(TEACHER), self.aec.infos[TEACHER])
        if type(said) is Utterance:
            return Utterance.of([atom for atom in said.atoms if atom.kind is None or atom.kind in self.kinds])
        return said if self.kinds or moment.turn == 0 else SILENCE


class TeacherEnv(_Flat):
    """The teacher's seat; observation, action and reward as `teacher_0` has them in `pz_envs.tutoring`.

    A step is the teacher's turn and the student's next one. The reward is the sum of both.

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
    7. 1 if what it announced is a mistake, else 0
    8. n / (n + 4) for n turns of the oracle's plan from here, at most `max_turns`; 0 without one, or when it is over

    Info: the privileged `moment`; in a lifetime also `student`, its spec, and `intention`, what it announced or None.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        student: a spec string, a `Student`, a policy with `reset(rng)` and `act(observation, info)`, or a function of a
            random generator that makes such a policy, which is asked for a new one at each reset.
        speech: `kinds` or `message`.
        max_turns: turns after which the student's episode is truncated; None: the family's.
        episodes: episodes of the student in one of this environment, at least 1.
        same_world: whether the episodes of a lifetime begin in the same state of the world.
        vary: parameters of the student that are drawn at each reset, uniformly between their least and their greatest
            value, such as `{"alpha": (0.1, 0.9)}`.
        announce: whether the student announces, before the teacher speaks, what it means to do; learners can.
        render_mode: None, `ansi` or `human`.
        options: those of `pz_envs.family.Family.raw_env` (`cost`, `budget`, `teacher_reward`, `until_success`, ...) and
            the world's. In a lifetime `until_success` is True unless it is given.

    Raises:
        ValueError: an argument is not supported.
    """

    def __init__(
        self,
        env_id: str | Subject,
        *,
        student: str | Student | Any = "obedient",
        speech: str = "kinds",
        max_turns: int | None = None,
        episodes: int = 1,
        same_world: bool = True,
        vary: Mapping[str, Any] | None = None,
        announce: bool = False,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        if not isinstance(episodes, int) or episodes < 1:
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        if isinstance(student, str | Student):
            student = parse_student(student)
            options.setdefault("text", student.text)
        if episodes > 1:
            options.setdefault("until_success", True)
        super().__init__(TEACHER, env_id, max_turns, render_mode, speech=speech, **options)
        self.episodes, self.same_world, self.announce = episodes, same_world, announce
        self._spec, self._vary = student, dict(vary or {})
        if self._vary:
            check_vary(student, self._vary)
        given = isinstance(student, Student)
        self.student: Any = self._enrol(np.random.default_rng(0)) if given else student
        self._renews = episodes > 1 or bool(self._vary) or not (given or _is_policy(student))
        if announce and given and not hasattr(self.student, "intend"):
            raise ValueError(f"the student {student!s} cannot announce its actions; announce must be False")
        self._life: Lifetime | None = None
        self.observation_space = self.aec.observation_space(TEACHER)
        if episodes > 1:
            seat = self.observation_space
            self.observation_space = spaces.Dict({**seat, "lifetime": lifetime_space()})  # type: ignore[dict-item]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode or a lifetime; the teacher speaks first."""
        self.aec.start = None
        self._rng = self._restart(seed, options)
        if self._renews:
            self.student = self._enrol(self._rng)
        if self.episodes > 1:
            self._options = options
            self._life = Lifetime(self.aec, self.episodes)
            self._life.arrive()
            if self.same_world:
                self.aec.start = self.aec.moment.after
        self.student.reset(self._rng.spawn(1)[0] if self.episodes > 1 else self._rng)
        return self._observe()

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Speak, and see what the student does.

        Raises:
            ResetNeeded: before `reset`, or after the episode's end.
            ValueError: the action is outside the action space; nothing has changed.
        """
        self._check_running()
        aec, life = self.aec, self._life
        aec.teacher_turn(action)
        reward = aec.rewards[TEACHER]
        terminated, truncated = aec.ended
        if life is not None:
            life.said()
        if terminated or truncated:
            self._running = life is not None and self._next_episode(life, terminated)
            if self._running:
                terminated = truncated = False
        else:
            aec.student_turn(self.student.act(aec.observe(STUDENT), entitled(self.student, aec)))
            reward += aec.rewards[TEACHER]
            if life is not None:
                life.acted()
                life.arrive()
            if self.render_mode == "human":
                self.render()
        observation, info = self._observe()
        return observation, reward, terminated, truncated, info

    def _enrol(self, rng: np.random.Generator) -> Any:
        """A new student."""
        student = self._spec
        if not isinstance(student, Student):
            return student if _is_policy(student) else student(rng)
        if self._vary:
            student = drawn(student, self._vary, rng)
        self._drawn = student
        return student.seat(self.family, self.aec.world)

    def _next_episode(self, life: Lifetime, terminated: bool) -> bool:
        """End an episode of a lifetime; begin the next one, if there is one."""
        aec, student = self.aec, self.student
        if hasattr(student, "finish"):
            student.finish(aec.observe(STUDENT), entitled(student, aec), terminated)
        life.over()
        if life.episode == life.episodes:
            return False
        spent = aec.purse.spent
        aec.reset(None, self._options)
        aec.purse.spent = spent
        student.reset(self._rng.spawn(1)[0])
        life.arrive()
        return True

    def _observe(self) -> tuple[dict[str, Any], dict[str, Any]]:
        aec, life = self.aec, self._life
        observation, info = aec.observe(TEACHER), aec.infos[TEACHER]
        if life is not None:
            intention = None
            if self.announce and self._running and not any(aec.ended):
                intention = self.student.intend(aec.observe(STUDENT), entitled(self.student, aec))
            info["intention"] = intention
            info["student"] = str(self._drawn) if isinstance(self._spec, Student) else None
            observation["lifetime"] = life.features(intention)
        return observation, info

    def action_masks(self) -> np.ndarray:
        """Which subsets of kinds can be said now, bool (32,); the form that maskable learners ask for."""
        return self.aec.observe(TEACHER)["action_mask"].astype(bool)


def _is_policy(student: Any) -> bool:
    """Whether it acts itself, and is not a function or a class that makes such policies."""
    return hasattr(student, "act") and not isinstance(student, type)


def teach(
    env: gymnasium.Env | Callable[[], gymnasium.Env],
    oracle: Callable[..., Oracle] | None = None,
    *,
    phrases: Phrases | None = None,
    look: Callable[[gymnasium.Env], Any] | None = None,
    snapshot: str = "auto",
    success: Callable[..., Any] | None = None,
    describe: Callable[[Any], str] | None = None,
    action_words: Mapping[str, Any] | None = None,
    reward_range: tuple[float, float] | None = None,
    **settings: Any,
) -> StudentEnv:
    """The student's side of any Gymnasium environment, with a teacher in the other seat.

    Without an oracle it is reinforcement learning in words: the instruction is to maximize the accumulated rewards, and
    the feedback is the reward. The seats are the attribute `aec`, the lesson is `family`.

    Args:
        env: an environment, or a function without arguments that makes one.
        oracle: a subclass of `teachers.oracle.Oracle`.
        phrases: the oracle's phrases: a dict of lists by claim class or by its name, or the path of a TOML file.
        look, snapshot, success, describe, action_words, reward_range: see `worlds.wrapped.gym_world.GymWorld`.
        settings: those of `StudentEnv`: `teacher`, `instruction_type`, `feedback_type`, `text`, `max_turns`, ...

    Raises:
        ValueError: an argument is not supported.
    """
    lesson = Lesson(
        env,
        oracle,
        phrases=phrases,
        look=look,
        snapshot=snapshot,
        success=success,
        describe=describe,
        action_words=action_words,
        reward_range=reward_range,
    )
    return StudentEnv(lesson, **settings)


def prompt(observation: dict[str, Any]) -> str:
    """The parts of a text observation that are not empty, joined by blank lines: instruction, observation, feedback."""
    parts = (observation[key] for key in ("instruction", "observation", "feedback"))
    return "\n\n".join(str(part) for part in parts if part)
