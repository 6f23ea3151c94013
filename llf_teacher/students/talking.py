"""Base of students that talk to a chat model, or to a function in place of one."""

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
        """The conversation, made on first use."""
        if self._talk is None:
            self._talk = self.converse()
        return self._talk

    def begin(self) -> None:
        """Begin an empty conversation, unless the same student goes on from an earlier episode."""
        if not self._goes_on:
            self._talk = None
        self._opening, self._goes_on = True, False

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """The answer; the seat finds the action in it."""
        seen = observation if self._opening else {**observation, "instruction": ""}
        self._opening = False
        listed = info.get(self.world.actions_key) or ()
        return self.reply(self.talk.ask(seen, info.get("turns_left"), listed))

    def did(self, action: Any) -> None:
        """Record in the conversation that this action replaced the answered one."""
        self.talk.did(f"{action}")

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Keep the conversation for the next episode."""
        self.talk.next_episode(f"{observation['feedback']!s}")
        self._goes_on = True

    @abstractmethod
    def converse(self) -> Conversation:
        """A new conversation."""

    @abstractmethod
    def reply(self, messages: list[Message]) -> str:
        """Send messages, pass the answer to `talk.answer`, and return the action."""
