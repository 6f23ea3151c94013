"""An episode whose student is asked by others, turn by turn: a framework sends the messages and brings the answers."""

from typing import Any

from llf_teacher.episodes.record import EpisodeRow, TurnRow, summary, turns_as_dicts
from llf_teacher.episodes.scenes import Scene, turn_row
from llf_teacher.gym import make
from llf_teacher.students.conversation import Conversation, Message
from llf_teacher.students.student import Telling
from llf_teacher.studies.definition.custom_specs import parse_teacher
from pz_envs.answers import split_thought
from pz_envs.seats import STUDENT
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
"""What frameworks log of an episode, each with its field of `EpisodeRow`."""


class Dialogue:
    """Plays what a study plays: of the same seed the same world, the same prompts and words, and the same end.

    A turn has two halves: `answer` is the student's, `speak` the teacher's. The teacher has opened already.

    Args:
        id: an id of `llf_teacher.ids()`.
        seed: of the episode.
        teacher: as studies name it.
        history, max_prompt_tokens: see `Conversation`.
        settings: more of `llf_teacher.make`, such as `feedback_type` and `max_turns`.

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
        self.env = make(id, text=True, teacher=parse_teacher(teacher), **settings)
        self.talk = Conversation(
            self.env, history=history, max_prompt_tokens=max_prompt_tokens, rng=Seeds(seed).stream("student")
        )
        self.turns: list[TurnRow] = []
        """What has been played; the first is the opening."""
        self._lab = self.env.aec.world.scratch()
        self._moments: list[Any] = []
        self._told: dict[str, Any] = {}
        self.env.aec.reset(seed)
        self.speak()

    @property
    def over(self) -> bool:
        """Whether there is nothing more to answer: the episode has ended, or its task is solved."""
        return self.env.family.is_over(self._moments[-1])

    def answer(self, text: str, told: Telling | None = None) -> None:
        """The student's half of a turn: what the model said to `messages`, and what is known of its cost."""
        told = told or {}
        action = self.talk.answer(text, input_tokens=told.get("input_tokens"))
        self._told = {"answer": split_thought(text).answer, "thought": self.talk.thought or None, **told}
        self.env.aec.student_turn(action)

    def speak(self, words: str | None = None) -> None:
        """The teacher's half: these words, or what the teacher of the settings says."""
        aec = self.env.aec
        if words is None:
            aec.take_suggestion()
        else:
            aec.teacher_turn(words)
        self._moments.append(aec.moment)
        seen = aec.observe(STUDENT)
        if self.turns:
            seen = {**seen, "instruction": ""}
        atoms = tuple((atom, atom.label(self._moments, self._lab)) for atom in aec.said)
        self.turns.append(
            turn_row(aec, self.env.family.name, Scene(aec.moment, seen, atoms), self.env.teacher)._replace(**self._told)
        )
        self.messages: list[Message] = [] if self.over else self.talk.ask(seen)
        """What to send to the model; nothing if the episode is over."""

    def episode(self) -> EpisodeRow:
        """What came of it, as a study keeps it."""
        return summary(self.env.family.name, "words", self.turns)

    def record(self) -> list[dict[str, Any]]:
        """The turns as JSON values, with what was said and whether it holds; the first is the opening."""
        return turns_as_dicts(self.turns)

    def scores(self) -> dict[str, float]:
        """The same as numbers, by the names of `SCORES`."""
        row = self.episode()
        return {name: float(getattr(row, field)) for name, field in SCORES.items()}

    def close(self) -> None:
        """Close the world."""
        self.env.close()
