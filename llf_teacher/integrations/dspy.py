"""Programs that DSPy improves by our feedback: `dspy.GEPA(feedback_metric(), ...).compile(LLFProgram(), trainset=...)`.

GEPA optimises the instructions of the predictor in the student's seat. It reflects on the prompts and answers, and on
the teacher's words of each turn.
"""

from collections.abc import Callable, Iterable
from typing import Any

import dspy
from dspy.utils.exceptions import AdapterParseError

from llf_teacher.integrations.games import Game, check_score, play
from llf_teacher.students.conversation import Message, text_of


class StudentTurn(dspy.Signature):
    """Do what the task says, and mind what the teacher says."""

    task: str = dspy.InputField(desc="what to do, and how to answer")
    history: dspy.History = dspy.InputField(desc="the turns so far")
    asked: str = dspy.InputField(desc="what is seen, and what the teacher says")
    answer: str = dspy.OutputField(desc="of the form that the task wants")


class LLFProgram(dspy.Module):
    """Plays an episode, without images. Its inputs are those of `examples`, its output has `played`, a `Played`.

    An answer that DSPy cannot parse is passed to the environment as it is.

    Args:
        settings: other arguments of `Dialogue`, such as `teacher` and `feedback_type`.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__()
        self.respond = dspy.Predict(StudentTurn)
        self.settings = settings

    def forward(self, id: str, seed: int) -> dspy.Prediction:
        """Play the episode."""
        return dspy.Prediction(played=play(Game(id, seed), self._ask, **self.settings))

    def _ask(self, messages: list[Message]) -> str:
        task, *past, asked = map(text_of, messages)
        history = [{"asked": said, "answer": answer} for said, answer in zip(past[::2], past[1::2], strict=True)]
        try:
            answer = self.respond(task=task, history=dspy.History(messages=history), asked=asked).answer
        except AdapterParseError as error:
            answer = error.lm_response
        return f"{answer}"


def examples(games: Iterable[tuple[str, int]]) -> list[dspy.Example]:
    """Examples for DSPy: episodes to play, given by ids of `llf_teacher.ids()` and seeds."""
    return [dspy.Example(**Game(*game)._asdict()).with_inputs(*Game._fields) for game in games]


def feedback_metric(score: str = "return") -> Callable[..., dspy.Prediction]:
    """A metric with the teacher's words as feedback, for `dspy.GEPA` and `dspy.Evaluate`.

    Args:
        score: the name of one of `SCORES`; regret is negated.

    Raises:
        ValueError: the score is unknown.
    """
    check_score(score)

    def metric(
        gold: dspy.Example, pred: dspy.Prediction, trace: Any = None, pred_name: Any = None, pred_trace: Any = None
    ) -> dspy.Prediction:
        return dspy.Prediction(score=pred.played.worth(score), feedback=pred.played.words())

    return metric
