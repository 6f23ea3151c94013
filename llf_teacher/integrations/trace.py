"""A guide for the trainers of Trace (`opto`), with the interface that they call; it imports nothing of them.

An example is an environment and a seed, and a response is the action of its first turn, which suits environments that
ask one question repeatedly.
"""

from collections.abc import Iterable
from typing import Any

from llf_teacher.integrations.dialogue import Dialogue
from llf_teacher.students.conversation import as_prompt


class TeachingGuide:
    """Gives the teacher's words as feedback on a response, and the reward as its score.

    Args:
        settings: arguments of `Dialogue`, except `id` and `seed`.
    """

    def __init__(self, **settings: Any) -> None:
        self.settings = settings

    def dataset(self, ids: Iterable[str], seeds: Iterable[int]) -> dict[str, list[Any]]:
        """Examples for a trainer: prompts as `inputs`, ids with seeds as `infos`."""
        infos = [(id, seed) for seed in seeds for id in ids]
        return {"inputs": [as_prompt(self._begin(info).messages) for info in infos], "infos": infos}

    def get_feedback(self, query: Any, response: Any, reference: tuple[str, int], **_: Any) -> tuple[float, str]:
        """Score and feedback.

        Args:
            query: the prompt; unused.
            response: the answer.
            reference: id and seed of the prompt.
        """
        dialogue = self._begin(reference)
        dialogue.answer(f"{response}")
        dialogue.speak()
        dialogue.close()
        turn = dialogue.turns[-1]
        return turn.reward, turn.feedback

    def metric(self, query: Any, response: Any, reference: tuple[str, int], **_: Any) -> float:
        """The score alone."""
        return self.get_feedback(query, response, reference)[0]

    __call__ = get_feedback

    def _begin(self, info: tuple[str, int]) -> Dialogue:
        id, seed = info
        return Dialogue(id, seed, **self.settings)
