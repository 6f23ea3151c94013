"""The student's seat over a session: what is seen from it, what its action means, and how an episode looks."""

import copy
from typing import Any

from gymnasium import spaces

from pz_envs.answers import split_thought
from pz_envs.asking import ASK, asking_space, read_question
from pz_envs.frames import Watch
from pz_envs.numbers import Field, Numbers
from pz_envs.settings import Settings
from pz_envs.text_mode import failure
from teachers.atoms import Moment
from teachers.session import LONGEST, Session
from worlds.pictures import Text
from worlds.pictures.canvas import Frame
from worlds.spaces import Prose

__all__ = ["StudentView", "info_for"]


class StudentView:
    """The seat of the student; `pz_envs.seatings.tutoring.TutoringEnv` says what its spaces hold.

    Args:
        session: what is played.
        settings: of the lesson.
        image: the space of the image that is seen beside the text; None: there is none.
        watch: keeps the episode to draw it; None: it cannot be drawn.
    """

    def __init__(
        self,
        session: Session,
        settings: Settings,
        image: spaces.Space[Any] | None = None,
        watch: Watch | None = None,
    ) -> None:
        world = session.world
        self.session, self.watch = session, watch
        self.text, self.visual = settings.text, image is not None
        self.numbers = Numbers(world, session.max_turns, settings.embed) if settings.numbers else None
        self.words_space = spaces.Dict(
            {
                "state": Prose(LONGEST) if self.text else copy.deepcopy(world.observation_space),
                "instruction": Prose(LONGEST),
                "feedback": Prose(LONGEST),
                **({} if image is None else {"image": image}),
            }
        )
        """What is observed, if not in numbers."""
        self.observation_space: spaces.Space[Any] = self.numbers.space if self.numbers else self.words_space
        acts = Prose(LONGEST) if self.text else copy.deepcopy(world.action_space)
        self.action_space: spaces.Space[Any] = acts if session.ask_cost is None else asking_space(acts)

    @property
    def fields(self) -> tuple[Field, ...]:
        """What the numbers of an observation are, in their order; none without `numbers`."""
        return () if self.numbers is None else self.numbers.fields

    @property
    def turns_left(self) -> int:
        """How many actions the student has yet, if nothing else ends the episode."""
        return self.session.max_turns - self.session.moment.turn

    def act(self, action: Any) -> float:
        """Act, or ask where the action does; the student's reward.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        session = self.session
        if session.ask_cost is not None:
            if isinstance(action, str) and isinstance(self.action_space, spaces.Text):
                action = split_thought(action)
            asks, action = read_question(action, self.action_space)
            if asks and not session.asked:
                return session.ask()
            if asks:
                action = failure(ASK, session.world)
        return session.act(action).reward

    def state(self) -> Any:
        """The world as it is seen; made anew by each action, and handed out as it is."""
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
        """The info: that of the session, without `atoms` beside numbers; a new dict in each turn."""
        info = self.session.info
        if self.numbers is None:
            return info
        return {name: value for name, value in info.items() if name != "atoms"}

    def info_for(self, policy: Any) -> dict[str, Any]:
        """The info that a policy in this seat may see; see `info_for`."""
        return info_for(policy, self.info(), self.turns_left, self.session.moment)

    # How the episode looks.

    def description(self) -> str:
        """The world as text, as the student sees it."""
        return self.session.world.describe(self.session.state)

    def image(self) -> Any:
        """The image beside the text: the world's own, if it has one, else its picture, of what the student may know."""
        if self.watch is None or self.session.world.options.get("visual"):
            return self.session.state["image"]
        return self.watch.view(self.description())

    def frame(self) -> Frame:
        """The episode now, uint8 (480, 640, 3).

        Raises:
            RuntimeError: nothing keeps it.
        """
        return self.kept().frame(self.description())

    def pieces(self) -> Text:
        """The turn, the student's action and the world in text, each piece with its role; errors as in `frame`."""
        return self.kept().text(self.description())

    def as_text(self) -> str:
        """The world, the teacher's last words, and, if the episode is kept, the turn and the student's action."""
        session = self.session
        world = self.description() if self.watch is None else "".join(piece for piece, _ in self.pieces())
        return f"{world}\nTeacher: {session.feedback or session.instruction}".lstrip("\n")

    def kept(self) -> Watch:
        """What keeps the episode; errors as in `frame`."""
        if self.watch is None:
            raise RuntimeError("nothing keeps the episode to draw it; make it with render_mode='rgb_array'")
        return self.watch


def info_for(policy: Any, info: dict[str, Any], turns_left: int, moment: Moment[Any]) -> dict[str, Any]:
    """The info that a policy in a student's seat may see.

    That is the seat's own with `turns_left`, less the atoms for a reader of words, and with `reward` (of its last turn;
    with the atoms for a reader of advice) or the privileged `moment` for a policy that learns from these; see `reads`
    of students.

    Args:
        policy: says by `reads` what it learns from; "atoms" if it does not.
        info: the seat's own.
        turns_left: actions that it has yet.
        moment: its last turn.
    """
    info = {**info, "turns_left": turns_left}
    reads = getattr(policy, "reads", "atoms")
    if reads in ("nothing", "reward", "words"):
        info.pop("atoms", None)  # there are none before the teacher has spoken
    if reads in ("reward", "atoms and reward"):
        info["reward"] = moment.reward
    elif reads == "truth":
        info["moment"] = moment
    return info
