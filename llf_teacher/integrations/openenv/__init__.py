"""OpenEnv: a server of environments with teachers, and a client.

`openenv.yaml` describes the server, and `uvicorn llf_teacher.integrations.openenv.app:app` starts it; with
`ENABLE_WEB_INTERFACE=true` it can be played at `/web`. The folder is a package of OpenEnv's form, with a `Dockerfile`;
installed on its own it is the client, `llf_teacher_env`, without a simulator.
"""

from .client import FeedbackEnv
from .models import FeedbackAction, FeedbackObservation

__all__ = ["FeedbackAction", "FeedbackEnv", "FeedbackObservation"]
