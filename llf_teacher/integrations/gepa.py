"""Prompts that GEPA improves by our feedback: `gepa.optimize({ADVICE: "..."}, ..., adapter=LLFAdapter(ask))`.

GEPA optimises advice to the student, one text under the name `ADVICE`, which follows the task in the system prompt. It
reflects on the teacher's words of each turn.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from gepa import EvaluationBatch

from llf_teacher.integrations.games import Game, Played, check_score, done, play
from llf_teacher.students.conversation import Message

ADVICE = "advice"
"""The name of a candidate's component."""


class LLFAdapter:
    """An adapter for `gepa.optimize`: examples are `Game`s, the candidate is `{ADVICE: text}`.

    Args:
        ask: the model, messages in, an answer out.
        score: the name of one of `SCORES`; regret is negated.
        settings: other arguments of `Dialogue`, such as `teacher` and `feedback_type`.

    Raises:
        ValueError: the score is unknown.
    """

    propose_new_texts = None  # GEPA's own way to reflect

    def __init__(self, ask: Callable[[list[Message]], str], *, score: str = "return", **settings: Any) -> None:
        check_score(score)
        self.ask, self.score, self.settings = ask, score, settings

    def evaluate(
        self, batch: Sequence[Game], candidate: Mapping[str, str], capture_traces: bool = False
    ) -> EvaluationBatch[Played, dict[str, float]]:
        """Play the episodes with the candidate's advice."""
        played = [self.play(game, candidate[ADVICE]) for game in batch]
        return EvaluationBatch(
            outputs=[each.scores for each in played],
            scores=[each.worth(self.score) for each in played],
            trajectories=played if capture_traces else None,
        )

    def make_reflective_dataset(
        self,
        candidate: Mapping[str, str],
        eval_batch: EvaluationBatch[Played, dict[str, float]],
        components_to_update: Iterable[str],
    ) -> dict[str, list[dict[str, Any]]]:
        """Task, actions, the teacher's words and scores of each episode."""
        records = [
            {
                "Inputs": {"task": played.turns[0]["instruction"], "environment": played.game.id},
                "Generated Outputs": [done(turn).strip() for turn in played.turns[1:]],
                "Feedback": played.words(),
                "Scores": played.scores,
            }
            for played in eval_batch.trajectories or ()
        ]
        return dict.fromkeys(components_to_update, records)

    def play(self, game: Game, advice: str) -> Played:
        """Play an episode with advice."""
        return play(game, lambda messages: self.ask(_advised(messages, advice)), **self.settings)


def _advised(messages: list[Message], advice: str) -> list[Message]:
    system, *rest = messages
    return [{**system, "content": f"{system['content'].strip()}\n\n{advice}".strip()}, *rest]
