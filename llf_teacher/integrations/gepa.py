"""Prompts that GEPA improves by our feedback: `gepa.optimize({ADVICE: "..."}, ..., adapter=LLFAdapter(ask))`.

What is optimised is advice to the student, one text under the name `ADVICE`, which stands behind what it is told of the
task. What GEPA reflects on is what the teacher said of each turn.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from gepa import EvaluationBatch

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.students.conversation import Message
from teachers.spec import unknown

ADVICE = "advice"
"""The component of a candidate."""


class Game(NamedTuple):
    """An episode to play, an example of GEPA's."""

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
            f"Turn {turn['turn']}. {_done(turn)}Teacher: {turn['feedback'] or '-'}" for turn in self.turns
        )


class LLFAdapter:
    """An adapter for `gepa.optimize`: examples are `Game`s, the candidate is `{ADVICE: text}`.

    Args:
        ask: the model, messages in, an answer out.
        score: which of `SCORES` counts; regret counts negatively.
        settings: more of `Dialogue`, such as `teacher` and `feedback_type`.

    Raises:
        ValueError: there is no such score.
    """

    propose_new_texts = None  # GEPA's own way to reflect

    def __init__(self, ask: Callable[[list[Message]], str], *, score: str = "return", **settings: Any) -> None:
        if score not in SCORES:
            raise ValueError(unknown("score", score, SCORES))
        self.ask, self.score, self.settings = ask, score, settings

    def evaluate(
        self, batch: Sequence[Game], candidate: Mapping[str, str], capture_traces: bool = False
    ) -> EvaluationBatch[Played, dict[str, float]]:
        """Play the episodes with the candidate's advice."""
        played = [self.play(game, candidate[ADVICE]) for game in batch]
        return EvaluationBatch(
            outputs=[each.scores for each in played],
            scores=[self.worth(each) for each in played],
            trajectories=played if capture_traces else None,
        )

    def make_reflective_dataset(
        self,
        candidate: Mapping[str, str],
        eval_batch: EvaluationBatch[Played, dict[str, float]],
        components_to_update: Iterable[str],
    ) -> dict[str, list[dict[str, Any]]]:
        """What was asked, done and said in each episode."""
        records = [
            {
                "Inputs": {"task": played.turns[0]["instruction"], "environment": played.game.id},
                "Generated Outputs": [_done(turn).strip() for turn in played.turns[1:]],
                "Feedback": played.words(),
                "Scores": played.scores,
            }
            for played in eval_batch.trajectories or ()
        ]
        return dict.fromkeys(components_to_update, records)

    def play(self, game: Game, advice: str) -> Played:
        """An episode."""
        dialogue = Dialogue(*game, **self.settings)
        try:
            while not dialogue.over:
                dialogue.answer(self.ask(_advised(dialogue.messages, advice)))
                dialogue.speak()
        finally:
            dialogue.close()
        return Played(game, dialogue.scores(), dialogue.record())

    def worth(self, played: Played) -> float:
        """The score that counts; more is better."""
        score = played.scores[self.score]
        return -score if self.score == "regret" else score


def _advised(messages: list[Message], advice: str) -> list[Message]:
    system, *rest = messages
    return [{**system, "content": f"{system['content'].strip()}\n\n{advice}".strip()}, *rest]


def _done(turn: Mapping[str, Any]) -> str:
    if not turn["turn"]:
        return ""
    failed = turn.get("parse_failure")
    what = f"no action, but {failed!r}" if failed is not None else turn.get("action_words") or turn["action"]
    return f"Student: {what}. Reward: {turn['reward']:g}. "
