"""The server process of a model: opens llama.cpp's server on a free loopback port, and ends with its last user.

It is run as a file, not imported. Its folder has `settings.json`, which says what to serve; `server.json`, which it
writes when it answers; and two lock files. It holds `server.lock` as long as it lives, and each user holds
`users.lock` together with the others. The kernel releases the locks of a process, however it ends.
"""

import fcntl
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

_LOOK = 0.25  # seconds between two looks at its users
_PATIENCE = 10.0  # seconds to wait while another process looks at the lock


def main(folder: Path) -> None:
    """Serve until there are no users."""
    own = os.open(folder / "server.lock", os.O_RDWR | os.O_CREAT, 0o600)
    if not _takes(own, _PATIENCE):
        sys.exit("another server of this model runs already")
    settings = json.loads((folder / "settings.json").read_text("utf-8"))
    server, url = open_server(settings)
    kept = {name: settings[name] for name in ("key", "slots", "context", "threads")}
    half = folder / f"server.{os.getpid()}.half"
    half.touch(0o600)
    half.write_text(json.dumps({"url": url, "pid": os.getpid(), **kept}), "utf-8")
    half.replace(folder / "server.json")
    users = os.open(folder / "users.lock", os.O_RDWR | os.O_CREAT, 0o600)
    seen = time.monotonic()
    while True:
        time.sleep(_LOOK)
        if not _takes(users, 0.0):
            seen = time.monotonic()
        elif time.monotonic() - seen > settings["linger"]:
            break  # it keeps the lock, so that a new user waits until it has ended
        else:
            fcntl.flock(users, fcntl.LOCK_UN)
    (folder / "server.json").unlink(missing_ok=True)
    del server


def open_server(settings: dict[str, Any]) -> tuple[Any, str]:
    """Load the model; llama.cpp's server and its address."""
    import xllamacpp

    params = xllamacpp.CommonParams()
    params.model.path = settings["path"]
    params.model_alias = {settings["alias"]}
    params.api_keys = [settings["key"]]
    params.port = 0  # a free one
    params.ui = False
    params.n_parallel = settings["slots"]
    params.n_ctx = settings["context"] * settings["slots"]
    params.cache_ram_mib = settings["prompts"]
    params.load_mode = xllamacpp.llama_load_mode.LLAMA_LOAD_MODE_NONE  # weights count as memory that is taken
    params.chat_template = settings["template"]
    for cores in (params.cpuparams, params.cpuparams_batch):
        cores.n_threads = settings["threads"]
    server = xllamacpp.Server(params)
    return server, server.listening_address


def _takes(lock: int, seconds: float) -> bool:
    """Whether a lock could be taken within some seconds."""
    end = time.monotonic() + seconds
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            time.sleep(0.05)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
