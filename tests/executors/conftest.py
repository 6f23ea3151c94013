"""Executors that need more than the core: `.ci/run ray` tests them where it is installed; plain pytest does not."""

from importlib.util import find_spec

collect_ignore = [] if find_spec("ray") else ["test_ray.py"]
