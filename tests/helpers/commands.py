"""`llf` as a user meets it, in this process or in one of its own.

Most tests ask what a command says and does, which is the same in both, while a process of its own imports everything
anew, which takes a second or three.
"""

import contextlib
import importlib
import io
import os
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

from llf_teacher.cli import main


def llf(*arguments, cwd=".", text="", **environment):
    """Run a command in this process; its exit status and what it printed, as `subprocess.run` gives them.

    Nothing stays of it, and so no module that lies in its folder, where another test may have one of the same name.
    """
    words = [str(argument) for argument in arguments]
    out, err = io.StringIO(), io.StringIO()
    known, terminate = set(sys.modules), signal.getsignal(signal.SIGTERM)
    importlib.invalidate_caches()
    with (
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        patch("sys.stdin", io.StringIO(text)),
        patch("sys.argv", ["llf", *words]),
        patch("__main__.__package__", None),  # else `python -m pytest` would be the name of the command
        patch("sys.path", [*sys.path]),
        patch.dict(os.environ, environment),
    ):
        try:
            main()
            status = 0
        except SystemExit as left:
            status = left.code or 0
        finally:
            signal.signal(signal.SIGTERM, terminate)
            for name in set(sys.modules) - known:
                file = getattr(sys.modules[name], "__file__", None)
                if file and Path(file).parent == Path.cwd():
                    del sys.modules[name]
    return subprocess.CompletedProcess(words, status, out.getvalue(), err.getvalue())


def llf_apart(*arguments, cwd=".", text="", **environment):
    """The same in a process of its own, for what is about processes, or shows that there nothing else is printed."""
    command = [sys.executable, "-m", "llf_teacher", *map(str, arguments)]
    env = os.environ | environment
    return subprocess.run(command, cwd=cwd, input=text, capture_output=True, text=True, check=False, env=env)
