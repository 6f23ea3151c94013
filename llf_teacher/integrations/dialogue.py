"""An episode whose student is a framework's model: the framework sends the messages and returns the answers."""

from typing import Any

from llf_teacher.episodes.record import EpisodeRow, TurnRow, turns_as_dicts
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.gym import make
from llf_teacher.students.conversation import Conversation, Message
from llf_teacher.students.student import ModelReply
from pz_envs.text.thoughts import split_thought
from teachers.atoms import KINDS
from teachers.personality import Personality
from teachers.seeds import Seeds

SCORES = {
    "success": "success",
    "return": "total_reward",
    "regret": "regret",
    "turns": "turns",
    "parse_failures": "parse_failures",
    **{f"said_{kind}": f"said_{kind}" for kind in KINDS},
}
"""The scores of an episode: for each name, the field of `EpisodeRow`."""


class Dialogue:
    """Plays an episode as a study does: the same seed gives the same world, prompts and words, and ends alike.

    A turn has two halves: the student's `answer`, then the teacher's `speak`. The opening is already played.

    Args:
        id: an id of `llf_teacher.ids()`.
        seed: the seed of the episode.
        teacher: the teacher's spec, as in studies.
        history, max_prompt_tokens: see `Conversation`.
        settings: other keywords of `llf_teacher.make`, such as `feedback_type` and `max_turns`.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(
        self,
        id: str,
        seed: int,
        *,
        teacher: str | Personality = "oracle",
        history: int = 20,
        max_prompt_tokens: int | None = None,
        **settings: Any,
    ) -> None:
        self.env = make(id, text=True, teacher=teacher, **settings)
        self.talk = Conversation(
            self.env, history=history, max_prompt_tokens=max_prompt_tokens, rng=Seeds(seed).stream("student")
        )
        self._recorder = Recorder(self.env.family.name, self.env.student_view, self.env.teacher)
        self._answer: dict[str, Any] = {}
        self.env.session.open(seed)
        self.speak()

    @property
    def turns(self) -> list[TurnRow]:
        """The rows of the turns so far; the first is the opening."""
        return self._recorder.rows

    @property
    def over(self) -> bool:
        """Whether the episode has ended, or its task is solved, and the teacher has spoken."""
        return self.env.session.done

    def answer(self, text: str, reply: ModelReply | None = None) -> None:
        """The student's half of a turn: the model's answer to `messages`, with its tokens and seconds."""
        reply = reply or {}
        said = split_thought(text)
        action = self.talk.answer(said, input_tokens=reply.get("input_tokens"))
        self._answer = {"answer": said.answer, "thought": self.talk.thought or None, **reply}
        self.env.student_view.act(action)

    def speak(self, words: str | None = None) -> None:
        """The teacher's half of a turn: these words, or the words of the session's teacher."""
        session = self.env.session
        if words is None:
            session.speak()
        else:
            session.say(words)
        self._recorder.note(**self._answer)
        turn = session.turn
        seen = {**self.env.student_view.observe(), "instruction": turn.instruction}
        self.messages: list[Message] = [] if self.over else self.talk.ask(seen)
        """The messages for the model; empty if the episode is over."""

    def teacher_prompt(self) -> dict[str, str]:
        """The world, the student's last action and the suggestion of the session's teacher, as text."""
        return {**self.env.teacher_view.words(), "suggestion": self.env.session.suggest() or "nothing"}

    def episode(self) -> EpisodeRow:
        """The episode's row in a store."""
        return self._recorder.episode("words")

    def record(self) -> list[dict[str, Any]]:
        """The turns as JSON values, with the label of each claim; the first is the opening."""
        return turns_as_dicts(self.turns)

    def scores(self) -> dict[str, float]:
        """The scores, by the names of `SCORES`."""
        row = self.episode()
        return {name: float(getattr(row, field)) for name, field in SCORES.items()}

    def close(self) -> None:
        """Close the world."""
        self.env.close()
