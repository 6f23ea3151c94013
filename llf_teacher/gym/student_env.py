"""Gymnasium's view of the student's seat."""

from collections.abc import Iterable
from typing import Any

from gymnasium import spaces

from llf_teacher.gym.seat_env import SeatEnv
from llf_teacher.registry import entry
from pz_envs.subject import Subject
from pz_envs.tutoring import STUDENT, TEACHER
from teachers.atoms import SILENCE, Moment, Utterance
from teachers.feedback import parse_kinds
from teachers.personality import Personality
from teachers.phrasebook import Paraphrase
from teachers.teacher import Teacher
from teachers.voice import Voice


class StudentEnv(SeatEnv):
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
