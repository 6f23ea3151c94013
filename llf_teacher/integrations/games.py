"""Episodes for optimisers of prompts: what to play, the scores, and the texts to reflect on."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.students.conversation import Message
from teachers.spec import unknown


class Game(NamedTuple):
    """An episode to play."""

    id: str
    """An id of `llf_teacher.ids()`."""
    seed: int


class Played(NamedTuple):
    """An episode after it was played."""

    game: Game
    scores: dict[str, float]
    """By the names of `SCORES`."""
    turns: list[dict[str, Any]]
    """As of `Dialogue.record`."""

    def words(self) -> str:
        """Actions, rewards and the teacher's words, turn by turn."""
        return "\n\n".join(
            f"Turn {turn['turn']}. {done(turn)}Teacher: {turn['feedback'] or '-'}" for turn in self.turns
        )

    def worth(self, score: str) -> float:
        """A score, where more is better: regret is negated."""
        value = self.scores[score]
        return -value if score == "regret" else value


def play(game: Game, ask: Callable[[list[Message]], str], **settings: Any) -> Played:
    """Play an episode with a model, messages in, an answer out; `settings` are other arguments of `Dialogue`."""
    dialogue = Dialogue(*game, **settings)
    try:
        while not dialogue.over:
            dialogue.answer(ask(dialogue.messages))
            dialogue.speak()
    finally:
        dialogue.close()
    return Played(game, dialogue.scores(), dialogue.record())


def check_score(score: str) -> None:
    """Check the name of a score.

    Raises:
        ValueError: the score is unknown.
    """
    if score not in SCORES:
        raise ValueError(unknown("score", score, SCORES))


def done(turn: Mapping[str, Any]) -> str:
    """The student's action and reward in a turn; empty for the opening."""
    if not turn["turn"]:
        return ""
    failed = turn.get("parse_failure")
    what = f"no action, but {failed!r}" if failed is not None else turn.get("action_words") or turn["action"]
    return f"Student: {what}. Reward: {turn['reward']:g}. "
