"""What students have in common that hold a conversation with a chat model, or with a function that stands for one."""

from abc import abstractmethod
from typing import Any, TypeVar

from llf_teacher.students.conversation import Conversation, Message
from llf_teacher.students.student import Policy, Student

S_co = TypeVar("S_co", bound=Student, covariant=True)


class TalkingPolicy(Policy[S_co]):
    """Keeps the conversation of an episode, or of a lifetime of episodes."""

    _talk: Conversation | None = None
    _goes_on = False

    @property
    def talk(self) -> Conversation:
        """The conversation, made when it is first asked for."""
        if self._talk is None:
            self._talk = self.converse()
        return self._talk

    def begin(self) -> None:
        """Have said nothing, unless the episode before was the same student's."""
        if not self._goes_on:
            self._talk = None
        self._opening, self._goes_on = True, False

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """What is answered; the seat finds the action in it."""
        seen = observation if self._opening else {**observation, "instruction": ""}
        self._opening = False
        return self.reply(self.talk.ask(seen, info.get("turns_left")))

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Remember the episode in the next one."""
        self.talk.next_episode(f"{observation['feedback']!s}")
        self._goes_on = True

    @abstractmethod
    def converse(self) -> Conversation:
        """A new conversation."""

    @abstractmethod
    def reply(self, messages: list[Message]) -> str:
        """Send messages, tell `talk` the answer, and return the action."""
