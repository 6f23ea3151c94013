"""The random generators of an environment, which roll-outs seed anew: coming draws are nobody's to know."""

from typing import Any

import gymnasium
import numpy as np

from worlds.wrapped.snapshots import generators


def reseed(env: gymnasium.Env[Any, Any], *seed: int) -> None:
    """Give an environment other draws to come. Its generators stay the same objects: parts may share them."""
    each: Any
    for each, source in zip(found := generators(env), np.random.SeedSequence(seed).spawn(len(found)), strict=True):
        if isinstance(each, np.random.Generator):
            each.bit_generator.state = type(each.bit_generator)(source).state
        else:
            each.seed(int(source.generate_state(1)[0]))
