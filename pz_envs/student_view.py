"""The student's view of a session: observations, actions, infos and rendering."""

import copy
from typing import Any

from gymnasium import spaces

from pz_envs.frames import EpisodeRenderer
from pz_envs.numbers import Field, Numbers
from pz_envs.settings import Settings
from pz_envs.text.actions import failure
from pz_envs.text.questions import ASK, asking_space, read_question
from pz_envs.text.thoughts import split_thought
from teachers.atoms import Moment
from teachers.belief import Sealed
from teachers.session import Session
from teachers.teacher_turn import LONGEST
from worlds.pictures import Text
from worlds.pictures.canvas import Frame
from worlds.spaces import Prose

__all__ = ["StudentView", "info_for"]


class StudentView:
    """The student's seat; `pz_envs.seatings.tutoring.TutoringEnv` describes its spaces.

    Args:
        session: the session.
        settings: the settings of the lesson.
        image: the space of the image beside the text; None: there is no image.
        renderer: renders the episode; None: no rendering.
    """

    def __init__(
        self,
        session: Session,
        settings: Settings,
        image: spaces.Space[Any] | None = None,
        renderer: EpisodeRenderer | None = None,
    ) -> None:
        world = session.world
        self.session, self.renderer = session, renderer
        self.text, self.visual = settings.text, image is not None
        self.embed = settings.embed
        self.numbers = Numbers(world, session.max_turns, settings.embed) if settings.numbers else None
        self.words_space = spaces.Dict(
            {
                "state": Prose(LONGEST) if self.text else copy.deepcopy(world.observation_space),
                "instruction": Prose(LONGEST),
                "feedback": Prose(LONGEST),
                **({} if image is None else {"image": image}),
            }
        )
        """The observation space without `numbers`."""
        self.observation_space: spaces.Space[Any] = self.numbers.space if self.numbers else self.words_space
        acts = Prose(LONGEST) if self.text else copy.deepcopy(world.action_space)
        self.action_space: spaces.Space[Any] = acts if session.ask_cost is None else asking_space(acts)

    @property
    def fields(self) -> tuple[Field, ...]:
        """The fields of an observation in numbers, in their order; empty without `numbers`."""
        return () if self.numbers is None else self.numbers.fields

    @property
    def turns_left(self) -> int:
        """The student's remaining actions, if nothing else ends the episode."""
        return self.session.max_turns - self.session.moment.turn

    def act(self, action: Any) -> float:
        """Act, or ask if the action is a question.

        Returns:
            The student's reward.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        session = self.session
        if session.ask_cost is None:
            return session.act(action).reward
        asks, action = self._parted(action)
        if asks and not session.asked:
            return session.ask()
        return session.act(failure(ASK, session.world) if asks else action).reward

    def check(self, action: Any) -> None:
        """Raise a ValueError if `act` would."""
        asks, action = self._parted(action)
        if not asks:
            self.session.read(action)

    def _parted(self, action: Any) -> tuple[bool, Any]:
        """Whether an action is a question, and the world's action that it contains."""
        if self.session.ask_cost is None:
            return False, action
        if isinstance(action, str) and isinstance(self.action_space, spaces.Text):
            action = split_thought(action)
        return read_question(action, self.action_space)

    def state(self) -> Any:
        """The world as the student sees it, not copied, since each action makes a new object."""
        session = self.session
        return session.world.describe(session.state) if self.text else session.state

    def observe(self) -> Any:
        """The observation."""
        session, state = self.session, self.state()
        if self.numbers is not None:
            return self.numbers.of(state, session.moment.turn, session.instruction, session.feedback, session.atoms)
        state = state.copy() if type(state) is dict else copy.copy(state)
        seen = {"state": state, "instruction": session.instruction, "feedback": session.feedback}
        return seen | {"image": self.image()} if self.visual else seen

    def info(self) -> dict[str, Any]:
        """The session's info, a new dict in each turn; it has no `atoms` with `numbers`."""
        info = self.session.info
        if self.numbers is None:
            return info
        return {name: value for name, value in info.items() if name != "atoms"}

    def info_for(self, policy: Any) -> dict[str, Any]:
        """The info that a policy in this seat may see; see `info_for`."""
        return info_for(policy, self.info(), self.turns_left, self.session.moment)

    # Rendering.

    def description(self) -> str:
        """The world as text, as the student sees it."""
        return self.session.world.describe(self.session.state)

    def image(self) -> Any:
        """The image beside the text: the world's own image, if any, else its picture without the truth."""
        if self.renderer is None or self.session.world.options.get("visual"):
            return self.session.state["image"]
        return self.renderer.view(self.description())

    def frame(self) -> Frame:
        """The frame of the last turn, uint8 (480, 640, 3).

        Raises:
            RuntimeError: there is no renderer.
        """
        return self.require_renderer().frame(self.description())

    def pieces(self) -> Text:
        """The turn, the student's action and the world as text, in styled pieces; errors as in `frame`."""
        return self.require_renderer().text(self.description())

    def as_text(self) -> str:
        """The world and the teacher's last words; with a renderer the turn and the student's action, too."""
        session = self.session
        world = self.description() if self.renderer is None else "".join(piece for piece, _ in self.pieces())
        return f"{world}\nTeacher: {session.feedback or session.instruction}".lstrip("\n")

    def require_renderer(self) -> EpisodeRenderer:
        """The renderer; errors as in `frame`."""
        if self.renderer is None:
            raise RuntimeError("the environment has no renderer; make it with render_mode='rgb_array'")
        return self.renderer


def info_for(policy: Any, info: dict[str, Any], turns_left: int, moment: Moment[Any]) -> dict[str, Any]:
    """The info that a policy in a student's seat may see.

    It is the seat's info with `turns_left`. The other entries depend on the policy's `reads`, by default "atoms": for
    "nothing", "reward" and "words" there are no `atoms`; for "reward" and "atoms and reward" there is the last turn's
    `reward`; for "truth" there is the privileged `moment`. If the policy `draws_worlds`, there is the moment `sealed`;
    `teachers.belief.Belief` draws from it the worlds that agree with what the student saw.

    Args:
        policy: the policy.
        info: the seat's.
        turns_left: the student's remaining actions.
        moment: the student's last moment.
    """
    info = {**info, "turns_left": turns_left}
    reads = getattr(policy, "reads", "atoms")
    if reads in ("nothing", "reward", "words"):
        info.pop("atoms", None)  # missing before the teacher's first word
    if reads in ("reward", "atoms and reward"):
        info["reward"] = moment.reward
    elif reads == "truth":
        info["moment"] = moment
    if getattr(policy, "draws_worlds", False):
        info["sealed"] = Sealed(moment)
    return info
