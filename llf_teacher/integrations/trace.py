"""A guide for the trainers of Trace (`opto`), of the shape that they call; it needs nothing of them.

An example is an environment and a seed, and a response is its first turn, which is all there is to it in environments
that ask one question again and again.
"""

from collections.abc import Iterable
from typing import Any

from llf_teacher.integrations.dialogue import Dialogue
from llf_teacher.students.conversation import as_prompt


class TeachingGuide:
    """Says of a response what the teacher says, and as its score what the world pays.

    Args:
        settings: those of `Dialogue`, but for `id` and `seed`.
    """

    def __init__(self, **settings: Any) -> None:
        self.settings = settings

    def dataset(self, ids: Iterable[str], seeds: Iterable[int]) -> dict[str, list[Any]]:
        """Examples for a trainer: prompts as `inputs`, and as `infos` what they are of, an id and a seed."""
        infos = [(id, seed) for seed in seeds for id in ids]
        return {"inputs": [as_prompt(self._begin(info).messages) for info in infos], "infos": infos}

    def get_feedback(self, query: Any, response: Any, reference: tuple[str, int], **_: Any) -> tuple[float, str]:
        """Score and feedback.

        Args:
            query: the prompt; it is not read.
            response: the answer to it.
            reference: what the prompt is of, an id and a seed.
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
