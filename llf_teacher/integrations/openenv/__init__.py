"""OpenEnv: a server of environments with teachers, for clients of its protocol.

`openenv.yaml` describes it, and `uvicorn llf_teacher.integrations.openenv.app:app` serves it; with
`ENABLE_WEB_INTERFACE=true` it can be played at `/web`.
"""
