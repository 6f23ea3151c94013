"""Episodes as what improves prompts takes them: which to play, what came of it, and what there is to reflect on."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.students.conversation import Message
from teachers.spec import unknown


class Game(NamedTuple):
    """An episode to play, an example to learn from."""

    id: str
    """An id of `llf_teacher.ids()`."""
    seed: int


class Played(NamedTuple):
    """An episode that was played."""

    game: Game
    scores: dict[str, float]
    """By the names of `SCORES`."""
    turns: list[dict[str, Any]]
    """As `Dialogue.record` has them."""

    def words(self) -> str:
        """What was seen, done and said, turn by turn."""
        return "\n\n".join(
            f"Turn {turn['turn']}. {done(turn)}Teacher: {turn['feedback'] or '-'}" for turn in self.turns
        )

    def worth(self, score: str) -> float:
        """The score of that name; more is better, so that regret counts negatively."""
        value = self.scores[score]
        return -value if score == "regret" else value


def play(game: Game, ask: Callable[[list[Message]], str], **settings: Any) -> Played:
    """Play an episode with a model, messages in, an answer out; `settings` are more of `Dialogue`."""
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
        ValueError: there is no such score.
    """
    if score not in SCORES:
        raise ValueError(unknown("score", score, SCORES))


def done(turn: Mapping[str, Any]) -> str:
    """What the student did in a turn, and what the world paid; nothing in the opening."""
    if not turn["turn"]:
        return ""
    failed = turn.get("parse_failure")
    what = f"no action, but {failed!r}" if failed is not None else turn.get("action_words") or turn["action"]
    return f"Student: {what}. Reward: {turn['reward']:g}. "
