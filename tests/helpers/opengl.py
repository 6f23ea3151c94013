"""Programs that draw by off-screen OpenGL, in a process of their own: MuJoCo takes its driver from the environment."""

import os
import subprocess
import sys

import pytest


def run(code, gl="egl"):
    """A program, run where there is no display; `gl` is MuJoCo's driver."""
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"} | {"MUJOCO_GL": gl}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)


def with_opengl(code):
    """What a program prints that draws; skips where nothing can draw."""
    result = run(code)
    if "images need off-screen OpenGL" in result.stderr:
        pytest.skip("no off-screen OpenGL here; on Debian libegl1 brings it")
    assert result.returncode == 0, result.stderr
    return result.stdout
