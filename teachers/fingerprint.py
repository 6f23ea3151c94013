"""Fingerprints: a number for each state, the same in every process, for personalities that distinguish states."""

import dataclasses
import hashlib
import struct
from collections.abc import Mapping, Set
from enum import Enum
from typing import Any

import numpy as np

_BYTES = 8


class Fingerprints:
    """Fingerprints of truths and actions. Objects that truths share, such as a map, are hashed once."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Any, bytes]] = {}

    def __deepcopy__(self, memo: dict[int, Any]) -> "Fingerprints":
        return Fingerprints()  # digests are cached by address

    def __reduce__(self) -> tuple[Any, ...]:
        return Fingerprints, ()

    def of(self, value: Any) -> int:
        """A number of 64 bits that is equal for equal values.

        Raises:
            TypeError: the value contains an object that has no value of its own, only an address.
        """
        return int.from_bytes(self._digest(value), "big")

    def share(self, value: Any) -> float:
        """The fingerprint as a number in [0, 1)."""
        return (self.of(value) >> 11) / 2.0**53

    def _digest(self, value: Any) -> bytes:
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, float):
            return _hash(b"n", struct.pack("<d", value + 0.0))
        if isinstance(value, int):  # enumerations of numbers and truth values, too
            exact = abs(value) <= 2**53
            return _hash(b"n", struct.pack("<d", value)) if exact else _hash(b"i", str(int(value)).encode())
        if value is None or isinstance(value, str | bytes):
            return _hash(b"s", repr(value).encode("utf-8", "backslashreplace"))
        if isinstance(value, Enum):
            return _hash(b"e", value.name.encode())
        known = self._known.get(id(value))
        if known is None:
            known = self._known[id(value)] = value, self._compound(value)  # it is kept, so that its id stays its own
        return known[1]

    def _compound(self, value: Any) -> bytes:
        if isinstance(value, np.ndarray):
            return _hash(b"a", repr((value.shape, value.dtype.str)).encode(), value.tobytes())
        if isinstance(value, list | tuple):
            return _hash(b"t", *map(self._digest, value))
        if isinstance(value, Set):
            return _hash(b"u", *sorted(map(self._digest, value)))
        if isinstance(value, Mapping):
            return _hash(b"m", *sorted(self._digest(key) + self._digest(item) for key, item in value.items()))
        if dataclasses.is_dataclass(value):
            return _hash(b"d", *(self._digest(getattr(value, field.name)) for field in dataclasses.fields(value)))
        raise TypeError(
            f"a {type(value).__name__} has no fingerprint; states must be made of numbers, texts, tuples, sets"
        )


def _hash(*parts: bytes) -> bytes:
    digest = hashlib.blake2b(digest_size=_BYTES)
    for part in parts:
        digest.update(struct.pack("<q", len(part)))
        digest.update(part)
    return digest.digest()
