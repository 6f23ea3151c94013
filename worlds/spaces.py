"""Prose: a space for natural language."""

import multiprocessing
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import create_shared_memory, iterate, read_from_shared_memory, write_to_shared_memory

__all__ = ["Prose"]

_PRINTABLE = "".join(map(chr, range(32, 127)))


class _Words(spaces.Text):
    """The class with a registered `iterate`: SuperSuit iterates over texts by the space of a single text.

    `Prose` itself must not be registered: for a Tuple of registered spaces, Gymnasium iterates over the items' items.
    """


@iterate.register(_Words)
def _iterate(space: _Words, items: Iterable[str]) -> Iterator[str]:  # type: ignore[misc]  # its fallback is generic
    return iter(items)


class Prose(_Words):
    """Any Unicode text of at most `max_length` characters, also the empty text.

    `gymnasium.spaces.Text` has an alphabet, checks each character and does not support text in shared
    memory; here `contains` checks only type and length, and samples are short printable ASCII.

    Args:
        max_length: greatest number of characters.
        seed: seed of the space's own random stream.
        sample_length: greatest length of a sample.
    """

    def __init__(self, max_length: int = 8192, seed: Any = None, sample_length: int = 64) -> None:
        super().__init__(max_length, min_length=0, charset=_PRINTABLE, seed=seed)
        self.sample_length = min(sample_length, max_length)

    def contains(self, x: Any) -> bool:
        """Whether `x` is a string that is not too long."""
        return isinstance(x, str) and len(x) <= self.max_length

    def sample(self, mask: Any = None, probability: Any = None) -> str:
        """A short string of printable ASCII; masks are as in `gymnasium.spaces.Text`."""
        if mask is not None or probability is not None:
            return super().sample(mask, probability)
        length = int(self.np_random.integers(self.sample_length + 1))
        return "".join(_PRINTABLE[i] for i in self.np_random.integers(len(_PRINTABLE), size=length).tolist())

    def __repr__(self) -> str:
        return f"Prose({self.max_length})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Prose) and other.max_length == self.max_length

    __hash__ = spaces.Text.__hash__


class _SharedText:
    """A view on text in shared memory; deep copies, such as AsyncVectorEnv makes of observations, are plain strings."""

    def __init__(self, rows: np.ndarray) -> None:
        self._rows = rows

    def _read(self) -> tuple[str, ...]:
        return tuple(
            row[1 : 1 + row[0]].astype("<u4").tobytes().decode("utf-32-le", "surrogatepass") for row in self._rows
        )

    def __deepcopy__(self, memo: dict[int, Any]) -> tuple[str, ...]:
        return self._read()

    def __iter__(self) -> Any:
        return iter(self._read())

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, i: Any) -> Any:
        return self._read()[i]


def _rows(space: Prose, shared_memory: Any, n: int = -1) -> np.ndarray:
    """Shared memory with a row per environment: the length of the text, then its code points."""
    return np.frombuffer(shared_memory.get_obj(), dtype=np.int32).reshape(n, space.max_length + 1)


@create_shared_memory.register(Prose)
def _create(space: Prose, n: int = 1, ctx: Any = multiprocessing) -> Any:
    return ctx.Array("i", n * (space.max_length + 1))


@read_from_shared_memory.register(Prose)
def _read(space: Prose, shared_memory: Any, n: int = 1) -> _SharedText:
    return _SharedText(_rows(space, shared_memory, n))


@write_to_shared_memory.register(Prose)
def _write(space: Prose, index: int, value: str, shared_memory: Any) -> None:
    # Python strings may contain lone surrogates, UTF-32 may not: they are encoded unchanged.
    codes = np.frombuffer(str(value).encode("utf-32-le", "surrogatepass"), dtype="<u4")
    row = _rows(space, shared_memory)[index]
    row[0] = len(codes)
    row[1 : 1 + len(codes)] = codes
