"""What the header of a GGUF file says of its model. No weight is read."""

import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

_MAGIC, _VERSIONS = b"GGUF", (2, 3)
_TEXT, _LIST = 8, 9  # types of values besides numbers
_NUMBERS = {0: "B", 1: "b", 2: "H", 3: "h", 4: "I", 5: "i", 6: "f", 7: "?", 10: "Q", 11: "q", 12: "d"}
_LONGEST = 64_000_000  # bytes of a text
_MOST = 16_000_000  # elements of a list, metadata entries or tensors
_HALF = 2  # bytes of a number in the cache of keys and values


class Header(NamedTuple):
    """A model by the header of its file."""

    architecture: str
    size: int
    """Size of the file, in bytes."""
    context: int
    """Tokens of context that it was trained for; 0: unknown."""
    vocabulary: int
    """Number of tokens that it knows; 0: unknown."""
    template: str
    """Its chat template; empty: none, as of base models."""
    bytes_per_token: int
    """Memory that a token of context takes, in bytes; 0: unknown."""


def read_header(path: Path) -> Header:
    """Read the header of a file.

    Raises:
        ValueError: the file is no GGUF, is incomplete, or is a part of one; the message has the remedy.
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        if (magic := file.read(4)) != _MAGIC:
            raise ValueError(
                f"{path} is no GGUF file: it begins with {magic!r}, not with {_MAGIC!r}; give a model in llama.cpp's "
                "format GGUF"
            )
        size = os.fstat(file.fileno()).st_size
        try:
            values, end = _read(file)
        except (EOFError, OverflowError, UnicodeDecodeError):
            raise ValueError(f"{path} is incomplete or damaged: its header ends early; get the file again") from None
    if end > size:
        raise ValueError(f"{path} is incomplete: it has {size} bytes of more than {end}; get the file again")
    if (parts := _number(values.get("split.count"))) > 1:
        raise ValueError(
            f"{path} is one of {parts} parts; merge them first, with llama.cpp's `llama-gguf-split --merge`"
        )
    kind = f"{values.get('general.architecture', '')}"
    own = {name.removeprefix(f"{kind}."): value for name, value in values.items() if name.startswith(f"{kind}.")}
    return Header(
        architecture=kind,
        size=size,
        context=_number(own.get("context_length")),
        vocabulary=_number(values.get("tokenizer.ggml.tokens")) or _number(own.get("vocab_size")),
        template=f"{values.get('tokenizer.chat_template', '')}",
        bytes_per_token=_bytes_per_token(own),
    )


def _read(file: BinaryIO) -> tuple[dict[str, Any], int]:
    """The metadata, a list of texts as its length, and the place where the data of the last tensor begins.

    Raises:
        EOFError, OverflowError, UnicodeDecodeError: the header is damaged.
    """
    (version,) = _unpack(file, "I")
    if version not in _VERSIONS:
        raise OverflowError
    tensors, entries = _unpack(file, "QQ")
    if max(tensors, entries) > _MOST:
        raise OverflowError
    values = {_text(file): _value(file, _unpack(file, "I")[0]) for _ in range(entries)}
    last = 0
    for _ in range(tensors):
        _text(file)
        (dimensions,) = _unpack(file, "I")
        *_, offset = _unpack(file, f"{min(dimensions, 8)}QIQ")
        last = max(last, offset)
    alignment = _number(values.get("general.alignment")) or 32
    return values, -(-file.tell() // alignment) * alignment + last


def _unpack(file: BinaryIO, form: str) -> tuple[Any, ...]:
    size = struct.calcsize(f"<{form}")
    data = file.read(size)
    if len(data) < size:
        raise EOFError
    return struct.unpack(f"<{form}", data)


def _text(file: BinaryIO) -> str:
    (length,) = _unpack(file, "Q")
    if length > _LONGEST:
        raise OverflowError
    return b"".join(_unpack(file, f"{length}s")).decode("utf-8", "replace")


def _value(file: BinaryIO, kind: int) -> Any:
    if kind == _TEXT:
        return _text(file)
    if kind != _LIST:
        if kind not in _NUMBERS:
            raise OverflowError
        return _unpack(file, _NUMBERS[kind])[0]
    inner, length = _unpack(file, "IQ")
    if length > _MOST:
        raise OverflowError
    if inner in _NUMBERS:
        return list(_unpack(file, f"{length}{_NUMBERS[inner]}"))
    if inner != _TEXT:  # llama.cpp takes no list of lists
        raise OverflowError
    for _ in range(length):
        _text(file)
    return length


def _number(value: Any) -> int:
    return value if isinstance(value, int) else 0


def _bytes_per_token(own: Mapping[str, Any]) -> int:
    """Memory of a token's keys and values in all layers."""
    layers, heads = _number(own.get("block_count")), own.get("attention.head_count")
    keys = own.get("attention.head_count_kv", heads)
    each = _number(heads) or max((*(heads if isinstance(heads, list) else ()), 1))
    width = _number(own.get("embedding_length")) // each
    key, value = (_number(own.get(f"attention.{name}_length")) or width for name in ("key", "value"))
    per_layer = sum(keys) if isinstance(keys, list) else layers * _number(keys)
    return per_layer * (key + value) * _HALF
