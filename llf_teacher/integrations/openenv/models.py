"""The messages between client and server."""

from openenv.core.env_server.types import Action, Observation
from pydantic import Field


class FeedbackAction(Action):
    """The student's action."""

    text: str = Field(description="The action as text, as the instruction describes it")


class FeedbackObservation(Observation):
    """The student's observation.

    `metadata` has `success`, the `kinds` of the feedback, and `failure`, why a text was not an action, or null.
    """

    instruction: str = Field(default="", description="The task; given at the beginning")
    observation: str = Field(default="", description="What there is to see")
    feedback: str = Field(default="", description="What the teacher says")
