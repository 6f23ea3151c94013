"""Functions that worlds, teachers and all students share; an agent that replaces one would change others' episodes."""

import bisect
import builtins
import collections
import contextlib
import copy
import dataclasses
import functools
import hashlib
import heapq
import itertools
import json
import math
import operator
import pathlib
import random
import re
import statistics
import time
import zlib
from collections.abc import Mapping
from operator import is_
from types import ModuleType
from typing import Any

import numpy as np

_LIBRARY = (bisect, builtins, collections, contextlib, copy, dataclasses, functools, hashlib, heapq, itertools, json)
_MODULES = (*_LIBRARY, math, operator, pathlib, random, re, statistics, time, zlib, np, np.random, np.linalg)
_IMMUTABLE = 1 << 8  # flag of types whose attributes cannot be set (Py_TPFLAGS_IMMUTABLETYPE)


def _functions(module: ModuleType) -> dict[str, object]:
    """The public functions, classes and constants of a module."""
    shared = {name: value for name, value in vars(module).items() if callable(value) or type(value) in (int, float)}
    return {name: value for name, value in shared.items() if not name.startswith("_")}


def _methods(cls: type) -> dict[str, object]:
    return {name: value for name, value in vars(cls).items() if callable(value) or isinstance(value, _BOUND)}


_BOUND = (classmethod, property)


def _shared() -> list[tuple[Any, Mapping[str, object]]]:
    found: list[tuple[Any, Mapping[str, object]]] = [(module, _functions(module)) for module in _MODULES]
    names = {module.__name__ for module in _MODULES}
    classes = {value for _, functions in found for value in functions.values() if type(value) is type}
    mutable = [
        each for each in classes if not each.__flags__ & _IMMUTABLE and each.__module__.partition(".")[0] in names
    ]
    return found + [(each, _methods(each)) for each in sorted(mutable, key=lambda each: each.__qualname__)]


_SHARED = _shared()
"""Each module and class with its functions as they were when this module was imported, before any agent."""


def put_back() -> dict[str, str]:
    """Undo all replacements; what each was replaced by, by the name of what was replaced."""
    found = {}
    for place, functions in _SHARED:
        now = vars(place)
        if all(map(is_, map(now.get, functions), functions.values())):
            continue
        owner = f"{place.__module__}.{place.__qualname__}" if isinstance(place, type) else place.__name__
        for name, value in functions.items():
            if now.get(name) is not value:
                found[f"{owner}.{name}"] = _origin(now[name]) if name in now else "nothing"
                setattr(place, name, value)
    return found


def _origin(value: object) -> str:
    """The module and name of a function or class; of anything else, of its class."""
    known = value if hasattr(value, "__qualname__") else type(value)
    return f"{getattr(known, '__module__', None) or 'builtins'}.{known.__qualname__}"
