"""Towns: worlds that share a law, such as where treasures lie. A town's number determines its law."""

from typing import Any

import numpy as np

__all__ = ["town_stream"]


def town_stream(family: str, town: Any) -> np.random.Generator | None:
    """The random stream that draws the law of a town; None without a town.

    Args:
        family: the family's name.
        town: the value of the option `town`: a number of at least 0, or None.

    Raises:
        ValueError: the town is not allowed.
    """
    if town is None:
        return None
    if type(town) is not int or town < 0:
        raise ValueError(f"town must be None or an integer of at least 0, got {town!r}")
    return np.random.default_rng([town, *family.encode()])
