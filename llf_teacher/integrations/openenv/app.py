"""The server: `uvicorn llf_teacher.integrations.openenv.app:app`."""

from openenv.core.env_server.http_server import create_app

from llf_teacher.integrations.openenv.environment import FeedbackServerEnvironment
from llf_teacher.integrations.openenv.models import FeedbackAction, FeedbackObservation

SESSIONS = 64
"""Greatest number of clients at once."""

app = create_app(
    FeedbackServerEnvironment, FeedbackAction, FeedbackObservation, env_name="llf_teacher", max_concurrent_envs=SESSIONS
)
