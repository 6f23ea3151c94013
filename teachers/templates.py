"""Templates: a paraphrase for the claims of a class, with slots for their fields."""

import re
import string
from collections.abc import Callable
from dataclasses import fields
from enum import Enum
from functools import lru_cache
from operator import attrgetter
from typing import Annotated, Any, get_args, get_origin

from teachers.atoms import Claim

__all__ = ["Template", "cache_key", "slots", "statements", "timeless"]

_SPEC = re.compile(r"\.\d+[efg]|d")
_CACHED = 1024  # sentences of a template, at most


class Template:
    """One paraphrase, compiled to a %-pattern, which is twice as fast as `str.format`."""

    __slots__ = ("cache", "pattern", "source", "values")

    def __init__(self, source: str) -> None:
        self.source = source
        parts, names = [], []
        for literal, field, spec, conversion in string.Formatter().parse(source):
            parts.append(literal.replace("%", "%%"))
            if field is not None:
                parts.append(f"%{spec or conversion or 's'}")
                names.append(field)
        self.pattern = "".join(parts)
        self.values: Callable[[Any], Any] = attrgetter(*names) if names else _no_values
        self.cache: dict[Any, str] = {}
        """Earlier sentences, by `cache_key`."""

    def format(self, claim: Any) -> str:
        """The sentence for a claim."""
        text: str = self.pattern % self.values(claim)
        return text

    def format_cached(self, key: Any, claim: Any) -> str:
        """Make the sentence for a claim and cache it."""
        if len(self.cache) >= _CACHED:
            self.cache.clear()
        text = self.cache[key] = self.format(claim)
        return text


def _no_values(claim: Any) -> tuple[()]:
    return ()


def cache_key(cls: type[Claim]) -> Callable[[Any], Any] | None:
    """A function that makes a cache key of a claim's fields; None for classes with too many different claims.

    A class has few different claims if all its fields are integers or members of enumerations.
    """
    names = [field.name for field in fields(cls)]  # type: ignore[arg-type]  # a dataclass
    return attrgetter(*names) if names and all(_is_discrete(field.type) for field in fields(cls)) else None  # type: ignore[arg-type]  # a dataclass


def statements(templates: tuple[Template, ...]) -> tuple[Template, ...]:
    """The templates that a hedge can precede: a question or an order cannot be likely, nor can a cheer."""
    return tuple(each for each in templates if not _ORDER.search(each.source))


@lru_cache(_CACHED)
def timeless(templates: tuple[Template, ...]) -> tuple[Template, ...]:
    """The templates that say nothing of now and here, which a late sentence means otherwise; all, if each does."""
    return tuple(each for each in templates if not _NOW.search(_SLOT.sub("", each.source))) or templates


_SLOT = re.compile(r"\{[^}]*\}")
_NOW = re.compile(r"\b(?:now|at present|presently|so far|at once|here|this (?:turn|time|room))\b", re.IGNORECASE)
_ORDER = re.compile(
    r"\?|\b(?:I advise|I would|My advice)\b|: answer\b"
    r"|(?:^|[.!] )(?:Add|Aim|Answer|Avoid|Begin|Better|Beware|Careful|Choose|Compare|Count|Cut|Do|Don't|Drop|Excellent"
    r"|Find|First|Fix|Get|Give|Go|Good|Great|Have|Improve|Keep|Leave|Let|Line up|Look|Make|Mind|Move|Name|Never|Next"
    r"|Not|Now|Please|Pull|Propose|Put|Rather|Read|Recommend|Remember|Repeat|Rewrite|Say|Search|Send|Skip|Start|Stay"
    r"|Take|That is it|Think|To get|Try|Unfortunately|Use|Watch|Well|Whatever|Work|Write|Yes|You could|You found)\b"
)
"""What questions, orders and cheers have."""


def _is_discrete(kind: Any) -> bool:
    if get_origin(kind) is Annotated:
        return _is_discrete(get_args(kind)[0])
    if get_origin(kind) is tuple:
        return all(_is_discrete(part) for part in get_args(kind) if part is not ...)
    return isinstance(kind, type) and issubclass(kind, int | Enum)


def slots(template: str) -> set[str]:
    """The names of a template's slots.

    Raises:
        ValueError: the braces do not match, or a slot has a format that is not allowed.
    """
    names = set()
    for _, field, spec, conversion in string.Formatter().parse(template):
        if field is None:
            continue
        if (spec and (conversion or not _SPEC.fullmatch(spec))) or conversion not in (None, "r"):
            raise ValueError(f"slot {field!r} has a bad format; allowed: none, !r, or such as :.3f, :.4g, :d")
        names.add(field)
    return names
