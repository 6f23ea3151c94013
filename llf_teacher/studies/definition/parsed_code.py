"""Parsed code, in a form in which only what it does counts."""

import ast
import hashlib
from typing import Any

_BYTES = 8  # of a digest


def plain(node: Any, *, docs: bool = False) -> Any:
    """Parsed code as tuples, the same in all releases of Python, without positions and statements that do nothing.

    Args:
        node: the code.
        docs: whether docstrings count.
    """
    if isinstance(node, list):
        kept = (each for each in node if not _does_nothing(each, docs))
        return tuple(plain(each, docs=docs) for each in kept)
    if isinstance(node, ast.Constant):
        return "Constant", repr(node.value)
    if isinstance(node, ast.AST):
        values = ((name, plain(getattr(node, name, None), docs=docs)) for name in node._fields)
        return type(node).__name__, *((name, value) for name, value in values if value not in (None, ()))
    return node


def _does_nothing(node: Any, docs: bool) -> bool:
    if isinstance(node, ast.Pass):
        return True
    string = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    return string and not docs


def digest_of(content: bytes) -> str:
    """A digest of a text."""
    return hashlib.blake2b(content, digest_size=_BYTES).hexdigest()
