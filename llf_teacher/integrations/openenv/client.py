"""A typed client of the server; it needs `openenv` only."""

from typing import Any

from openenv.core import EnvClient
from openenv.core.client_types import StepResult
from openenv.core.env_server.types import State

from .models import FeedbackAction, FeedbackObservation  # relative: `pyproject.toml` makes a package of this folder


class FeedbackEnv(EnvClient[FeedbackAction, FeedbackObservation, State]):
    """A session with a server: `with FeedbackEnv(base_url="http://127.0.0.1:8000").sync() as env: ...`.

    `env.reset(id=..., seed=..., teacher=...)` begins an episode, `env.step(FeedbackAction(text="north"))` acts.
    """

    def _step_payload(self, action: FeedbackAction) -> dict[str, Any]:
        return {"text": action.text}

    def _parse_result(self, payload: dict[str, Any]) -> StepResult[FeedbackObservation]:
        seen = payload.get("observation") or {}
        reward, done = payload.get("reward"), bool(payload.get("done"))
        metadata = payload.get("metadata") or seen.get("metadata") or {}
        texts = {name: seen.get(name, "") for name in ("instruction", "observation", "feedback")}
        observation = FeedbackObservation(**texts, reward=reward, done=done, metadata=metadata)
        return StepResult(observation=observation, reward=reward, done=done, metadata=metadata)

    def _parse_state(self, payload: dict[str, Any]) -> State:
        return State(episode_id=payload.get("episode_id"), step_count=payload.get("step_count", 0))
