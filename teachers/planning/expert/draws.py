"""The random generators of an environment, which roll-outs seed anew: coming draws are nobody's to know."""

import random
from collections import deque
from collections.abc import Mapping
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any

import gymnasium
import numpy as np

_PLAIN = (
    *(str, bytes, int, float, complex, bool, type(None), np.ndarray, np.generic, type),
    *(ModuleType, FunctionType, BuiltinFunctionType, MethodType),
)
_GENERATORS = (np.random.Generator, np.random.RandomState, random.Random)


def generators(env: gymnasium.Env[Any, Any]) -> list[Any]:
    """All random generators that an environment holds, in attributes, lists and dicts of any depth."""
    found, seen, queue = [], set(), deque([env])
    while queue:
        each: Any = queue.popleft()
        if isinstance(each, _PLAIN) or id(each) in seen:
            continue
        seen.add(id(each))
        if isinstance(each, _GENERATORS):
            found.append(each)
        elif isinstance(each, Mapping):
            queue.extend(each.values())
        elif isinstance(each, list | tuple | deque):
            queue.extend(each)
        elif hasattr(each, "__dict__"):
            queue.extend(vars(each).values())
    return found


def reseed(env: gymnasium.Env[Any, Any], *seed: int) -> None:
    """Give an environment other draws to come. Its generators stay the same objects: parts may share them."""
    each: Any
    for each, source in zip(found := generators(env), np.random.SeedSequence(seed).spawn(len(found)), strict=True):
        if isinstance(each, np.random.Generator):
            each.bit_generator.state = type(each.bit_generator)(source).state
        else:
            each.seed(int(source.generate_state(1)[0]))
