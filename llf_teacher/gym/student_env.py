"""Gymnasium's view of the student's seat."""

from collections.abc import Sequence
from typing import Any, Unpack

from gymnasium import spaces

from llf_teacher.gym.seat_env import SeatEnv
from llf_teacher.models.waiting import awaited
from pz_envs.numbers import Field
from pz_envs.settings import Settings, SettingsKeywords, takes_settings
from pz_envs.subject import Subject
from teachers.atoms import SILENCE, Atom, Label, Moment
from teachers.teacher_turn import LONGEST
from teachers.words import VERDICTS

NOT_SEATED = ("speech", "teacher_numbers")
"""The settings of the teacher's seat, if a policy plays it."""


class StudentEnv(SeatEnv):
    """The student's seat.

    Observation: Dict of `observation` (the world's space; `Prose` with `text=True`), `instruction` (at reset, else
    empty) and `feedback` (at reset only if the teacher advises the first action); with `visual=True` and `text=True`
    `image`, too, uint8.
    With `numbers=True` it is one flat Box, float32, of the state and the claims, with the layout `fields`; then
    `session.atoms` has the claims, and the info has no `atoms`.
    Action: the world's space; `Prose` with `text=True`. A text that is not an action costs a turn and gets feedback;
    see `pz_envs.seatings.tutoring`.
    Info: the world's, with `success`; `atoms`, the claims heard last; `parse_failure` for a text that is not an action;
    with `privileged_info=True` also the `moment` and `true`, which says of each of the `atoms` whether it is true.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        settings: the settings of the lesson; None: the defaults.
        keywords: fields of `pz_envs.settings.Settings` that replace them, except `speech`, and the world's options.

    Raises:
        ValueError: an argument is not allowed.
    """

    @takes_settings(without=NOT_SEATED)
    def __init__(
        self, env_id: str | Subject, *, settings: Settings | None = None, **keywords: Unpack[SettingsKeywords]
    ) -> None:
        super().__init__(env_id, settings, keywords, refused=NOT_SEATED, policies=True)
        self.teacher = self.session.teacher if self._policy is None else self._policy
        """The session's teacher, or the user's policy."""
        self._speak = self.session.speak if self._policy is None else self._speak_by_policy
        self.privileged_info = self.settings.privileged_info
        view = self.student_view
        self._info = self._privileged if self.privileged_info else view.info
        self._lab = self.session.world.scratch() if self.privileged_info else self.session.world  # for checks
        self._moments: list[Moment[Any]] = []  # by turn; another turn's where one was played elsewhere
        self._numbers = view.numbers is not None
        self._asks = self.session.ask_cost is not None
        self.action_space = view.action_space
        self.observation_space = view.observation_space
        if not self._numbers:
            named = {"observation" if name == "state" else name: each for name, each in view.words_space.items()}
            self.observation_space = spaces.Dict(named)

    def __repr__(self) -> str:
        bound = "" if self._policy is None else f" feedback_type={self.session.teacher.feedback_type!r}"
        return f"<{type(self).__name__} {self.env_id} {self.teacher!r}{bound}>"

    @property
    def fields(self) -> tuple[Field, ...]:
        """The fields of an observation in numbers, in their order; empty without `numbers=True`."""
        return self.student_view.fields

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the teacher gives its instruction."""
        self._restart(seed, options)
        return self._begin_episode()

    def _begin_episode(self) -> tuple[Any, dict[str, Any]]:
        self._moments.clear()
        if self._policy is not None:
            awaited(self._policy.reset(self.session.seeds.stream("teacher")))
        self._speak()
        self._running = True
        if self.render_mode == "human":
            self.render()
        return self.observe(), self._info()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Act or ask; then the teacher speaks.

        Raises:
            ResetNeeded: before `reset`, or after the episode's end.
            ValueError: the action is outside the action space; nothing has changed.
        """
        if not self._running:
            self._check_running()
        session = self.session
        reward = self.student_view.act(action) if self._asks else session.act(action).reward
        self._speak()
        self._running = not (session.terminated or session.truncated)
        observation = self.observe()
        if self.render_mode == "human":
            self.render()
        return observation, reward, session.terminated, session.truncated, self._info()

    def start_next_episode(
        self, start: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin another episode of the same lesson: random streams go on, and a spent budget stays spent.

        Args:
            start: the truth to begin with, such as `moment.after` of an opening; None: the reset draws it.
            options: options of the world's `reset`.

        Returns:
            Observation and info, as of `reset`.

        Raises:
            ResetNeeded: before the first `reset`.
        """
        if not hasattr(self.session, "moment"):
            self._check_running()
        self.session.start_next_episode(start, options)
        return self._begin_episode()

    def resume_from(self, moment: Moment[Any], terminated: bool = False, past: Sequence[Moment[Any]] = ()) -> None:
        """Go on from a moment of another environment's episode, after the teacher has spoken about it.

        See `Session.resume_from`.
        """
        self.session.resume_from(moment, terminated, past)
        self._moments = [moment] * (moment.turn + 1)
        for each in past:
            self._moments[each.turn] = each
        self._speak()
        self._running = not moment.over

    def observe(self) -> Any:
        """The observation of `reset` or the last `step`."""
        view, session = self.student_view, self.session
        if self._numbers:
            return view.observe()
        instruction = SILENCE if session.moment.turn or session.asked else session.instruction
        state = view.state() if view.text else session.state
        seen = {"observation": state, "instruction": instruction, "feedback": session.feedback}
        return seen | {"image": view.image()} if view.visual else seen

    def _privileged(self) -> dict[str, Any]:
        """The seat's info with the privileged entries."""
        info = {**self.student_view.info(), "moment": self.session.moment}
        if "atoms" in info:
            info["true"] = self._true(info["atoms"])
        if changes := getattr(self.teacher, "changes", ()):
            info["changes"] = changes
        if unbuilt := self.session.teacher_turns[0].unbuilt:
            info["unbuilt"] = unbuilt
        return info

    def _true(self, atoms: Sequence[Atom]) -> tuple[bool | None, ...]:
        """Whether each claim of the last turn is true; None: neither, as of a hedge, or it cannot be checked."""
        moment, oracle = self.session.moment, self.session.teacher.oracle
        self._moments[moment.turn :] = [moment]
        known = (self._moments[atom.about_turn].turn == atom.about_turn for atom in atoms)
        labels = [
            atom.label(self._moments, self._lab, oracle) if there else Label.UNCHECKED
            for atom, there in zip(atoms, known, strict=True)
        ]
        return tuple(VERDICTS[label].holds if label in VERDICTS else None for label in labels)

    def _speak_by_policy(self) -> None:
        """The turn of a policy in the teacher's seat; a text that is too long is dropped."""
        said = awaited(self._policy.act(self.teacher_view.observe(), self.teacher_view.info()))
        self.session.say({"text": said} if isinstance(said, str) and len(said) > LONGEST else said)
