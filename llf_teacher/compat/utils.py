"""LLF-Bench's `utils`."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

__all__ = ["generate_combinations_dict"]


def generate_combinations_dict(choices: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Every way to choose one value for each key."""
    return [dict(zip(choices, values, strict=True)) for values in product(*choices.values())]
