"""Gymnasium's view of the student's seat."""

from collections.abc import Iterable
from typing import Any

from gymnasium import spaces

from llf_teacher.gym.seat_env import SeatEnv
from pz_envs.numbers import Embed, Field
from pz_envs.seats import STUDENT, TEACHER, check_flags
from pz_envs.subject import Subject
from teachers.atoms import SILENCE, Moment
from teachers.personality import Personality
from teachers.phrasebook import Paraphrase
from teachers.teacher import Teacher
from teachers.voice import Voice


class StudentEnv(SeatEnv):
    """The student's seat.

    Observation: Dict of `observation` (the world's space; `Prose` with `text=True`), `instruction` (at reset, else
    empty) and `feedback` (at reset only if the teacher advises the first action); with `visual=True` and `text=True`
    `image`, too, uint8.
    With `numbers=True` it is one flat Box, float32, of the state and of what was said: `fields` says what is where; the
    info has no `atoms` then, which `aec.said` are.
    Action: the world's space; `Prose` with `text=True`. Text that is no action costs a turn and is
    answered; see `pz_envs.seatings.tutoring`.
    Info: what the world tells, with `success`; `atoms`, what was said, typed; `parse_failure` for text that was no
    action; the privileged `moment` with `privileged_info=True`.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        teacher, instruction_type, feedback_type, voice, paraphrase, visual: see `llf_teacher.make`.
        text: text in, text out: the observation is three strings, and so is the action.
        numbers: numbers in, as most learners want them; see `pz_envs.numbers`.
        embed: with `numbers`, a function that gives the vector of a text, always of the same length; environments whose
            states or actions are texts need it.
        max_turns: turns after which the episode is truncated; None: the family's.
        privileged_info: put the teacher's `moment` into the info, and `changes`, what a rewriting voice did to
            numbers and names, if it did anything; and show the truth in frames.
        render_mode: None, `ansi`, `rgb_array` or `human`, a window; `theme="dark"` among the options makes it dark.
        options: `ask_cost`, with which the student may ask for advice (see `pz_envs.asking`), `failure_reward`, what a
            text earns that is no action (None: the world's own, which is less than some action's), and the world's.

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
        numbers: bool = False,
        embed: Embed | None = None,
        max_turns: int | None = None,
        privileged_info: bool = False,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        check_flags(visual=visual, privileged_info=privileged_info)
        policy = None
        if not isinstance(teacher, str | Personality | Teacher):
            if not (hasattr(teacher, "reset") and hasattr(teacher, "act")):
                raise ValueError(
                    f"teacher must be a spec string, a Personality, or a policy with reset(rng) and "
                    f"act(observation, info), got {teacher!r}"
                )
            policy, teacher = teacher, "oracle"
        super().__init__(
            STUDENT,
            env_id,
            max_turns,
            render_mode,
            teacher=teacher,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            voice=voice,
            paraphrase=paraphrase,
            text=text,
            visual=visual,
            numbers=numbers,
            embed=embed,
            privileged_info=privileged_info,
            **options,
        )
        self._policy = policy
        self.teacher = self.aec.teacher if policy is None else policy
        """Who speaks: the seat's own teacher, or the policy that was given."""
        self.privileged_info = privileged_info
        seat = self.aec.student_space
        self._numbers = bool(numbers)
        self.observation_space = spaces.Dict(
            {"observation" if name == "state" else name: space for name, space in seat.spaces.items()}
        )
        if numbers:
            self.observation_space = self.aec.observation_space(STUDENT)

    def __repr__(self) -> str:
        bound = "" if self._policy is None else f" feedback_type={self.aec.teacher.feedback_type!r}"
        return f"<{type(self).__name__} {self.env_id} {self.teacher!r}{bound}>"

    @property
    def fields(self) -> tuple[Field, ...]:
        """What the numbers of an observation are, in their order; none without `numbers=True`."""
        return self.aec.fields

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the teacher gives its instruction."""
        self._restart(seed, options)
        aec = self.aec
        if self._policy is not None:
            self._policy.reset(aec.seeds.stream("teacher"))
        self._speak()
        if self.render_mode == "human":
            self.render()
        return self._seen(aec.instruction), self._info(aec.infos[STUDENT])

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Act, or ask, and hear what the teacher says of it.

        Raises:
            ResetNeeded: before `reset`, or after the episode's end.
            ValueError: the action is outside the action space; nothing has changed.
        """
        if not self._running:
            self._check_running()
        aec = self.aec
        if self._policy is None:
            reward = aec.take_turn(action)
        else:
            aec.student_turn(action)
            reward = aec.rewards[STUDENT]
            self._speak()
        terminated, truncated = aec.ended
        self._running = not (terminated or truncated)
        observation = self._seen(SILENCE)
        if self.render_mode == "human":
            self.render()
        info = aec.infos[STUDENT]
        return observation, reward, terminated, truncated, self._info(info) if self.privileged_info else info

    def take_up(self, moment: Moment[Any], terminated: bool = False) -> None:
        """Go on from a moment of an episode that was played elsewhere, after the teacher has spoken of it.

        See `TutoringEnv.take_up`.
        """
        self.aec.take_up(moment, terminated)
        self._speak()
        self._running = not moment.over

    def _seen(self, instruction: str) -> Any:
        aec = self.aec
        if self._numbers:
            return aec.observe(STUDENT)
        seen = {"observation": aec.state_now, "instruction": instruction, "feedback": aec.feedback}
        return seen | {"image": aec.image()} if aec.visual else seen

    def _info(self, info: dict[str, Any]) -> dict[str, Any]:
        """The seat's info, with what is privileged if that is wanted."""
        if self.privileged_info:
            info["moment"] = self.aec.moment
            if changes := getattr(self.teacher, "changes", ()):
                info["changes"] = changes
        return info

    def _speak(self) -> None:
        """The teacher's turn."""
        aec = self.aec
        if self._policy is None:
            aec.take_suggestion()
        else:
            aec.teacher_turn(self._policy.act(aec.observe(TEACHER), aec.infos[TEACHER]))
