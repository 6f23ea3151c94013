"""What goes over the wire."""

from openenv.core.env_server.types import Action, Observation
from pydantic import Field


class FeedbackAction(Action):
    """What the student does."""

    text: str = Field(description="The action as text, as the instruction describes it")


class FeedbackObservation(Observation):
    """What the student sees and hears.

    `metadata` has `success`, the `kinds` of feedback that were given, and `failure`, why a text was no action, or null.
    """

    instruction: str = Field(default="", description="The task; given at the beginning")
    observation: str = Field(default="", description="What there is to see")
    feedback: str = Field(default="", description="What the teacher says")
