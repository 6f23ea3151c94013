"""LLF-Bench's `utils`."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

__all__ = ["generate_combinations_dict"]


def generate_combinations_dict(choices: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """All combinations of one value per key."""
    return [dict(zip(choices, values, strict=True)) for values in product(*choices.values())]
