"""Keys of states of environments of which nothing is known: all that they hold."""

import copy
import hashlib
import pickle
from dataclasses import dataclass
from typing import Any

import gymnasium
from gymnasium import spaces

_Env = gymnasium.Env[Any, Any]
_STEPS = 16  # of random play, which show what counts steps
_SEED = "_np_random_seed"  # of the episode, by Gymnasium
_PLAIN = (int, float, str, bool, bytes, type(None))


@dataclass(frozen=True)
class Contents:
    """The key of a state: a digest of an environment's attributes.

    It may tell apart states that are the same, which costs time; states that differ in these attributes it never takes
    for one.
    """

    names: tuple[str, ...]
    """Of the attributes."""
    counts: tuple[str, ...] = ()
    """Of those that count steps, which are left out."""

    def whole(self) -> "Contents":
        """The same with what counts steps."""
        return Contents(tuple(sorted({*self.names, *self.counts})))

    def __call__(self, env: _Env) -> bytes:
        """Read the attributes."""
        parts = [vars(env.unwrapped).get(name) for name in self.names]
        try:
            written = pickle.dumps(parts)
        except Exception:  # of an environment that was drawn since
            written = pickle.dumps([part if _writable(part) else None for part in parts])
        return hashlib.blake2b(written, digest_size=16).digest()


def contents_of(env: _Env) -> Contents:
    """A key by all attributes but those that count steps, draw random numbers, or cannot be written down.

    Args:
        env: an environment, which is reset and stepped.
    """
    env.reset(seed=0)
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    counts = {name for name, part in vars(env.unwrapped).items() if type(part) is int}
    for _ in range(_STEPS):
        before = dict(vars(env.unwrapped))
        _, _, terminated, truncated, _ = env.step(space.sample())
        counts = {name for name in counts if vars(env.unwrapped).get(name) == before[name] + 1}
        if terminated or truncated:
            env.reset(seed=0)
    parts = {name: part for name, part in vars(env.unwrapped).items() if name not in counts}
    names = sorted(name for name, part in parts.items() if name != _SEED and _writable(part))
    return Contents(tuple(names), tuple(sorted(counts)))


def _writable(part: Any) -> bool:
    if type(part) in _PLAIN:
        return True
    if isinstance(part, spaces.Space) or hasattr(part, "random") or type(part).__module__.startswith("gymnasium"):
        return False  # a generator draws what is not to be known
    try:
        pickle.dumps(part)
    except Exception:
        return False
    return True
