"""Functions that worlds, teachers and all students share; an agent that replaces one would change others' episodes."""

import builtins
import math
import random
from operator import is_
from types import ModuleType

import numpy as np


def _functions(module: ModuleType) -> dict[str, object]:
    return {name: value for name, value in vars(module).items() if callable(value) and not name.startswith("_")}


_SHARED = [(module, _functions(module)) for module in (builtins, math, random, np, np.random, np.linalg)]
"""Each module with its functions and classes as they were when this module was imported, before any agent."""


def put_back() -> list[str]:
    """Undo all replacements; the names of what was replaced."""
    found = []
    for module, functions in _SHARED:
        now = vars(module)
        if all(map(is_, map(now.get, functions), functions.values())):
            continue
        for name, value in functions.items():
            if now.get(name) is not value:
                setattr(module, name, value)
                found.append(f"{module.__name__}.{name}")
    return found
