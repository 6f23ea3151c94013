"""Endpoints by name: where they are, and which variable has their key, is said beside the study, not in it.

A file `llf-endpoints.toml` in the folder where a study is run, or the one that `LLF_LLM_ENDPOINTS` names, has a table
each, as in `[endpoints.local]` with `base_url = "http://localhost:8000/v1"` and, if need be, `key = "MY_VARIABLE"`; or
the environment has `LLF_LLM_ENDPOINT_LOCAL=http://localhost:8000/v1`.
"""

import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from llf_teacher.models import settings
from teachers.spec import unknown

FILE = "llf-endpoints.toml"
_NAME = re.compile(r"[A-Za-z][\w-]*")
_KEYS = ("base_url", "key")


class Address(NamedTuple):
    """Where a named endpoint is."""

    base_url: str
    key: str = settings.KEY
    """Name of the environment variable with its key."""


def check_name(name: Any) -> str:
    """An endpoint's name.

    Raises:
        ValueError: it is none.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ValueError(f"endpoint must be a name of letters, digits, - and _, such as 'local', got {name!r}")
    return name


def place_of(name: str, environment: Mapping[str, str] = os.environ) -> Address:
    """Where an endpoint is.

    Raises:
        ValueError: nobody says so, or what is said is not allowed.
    """
    variable = f"{settings.ENDPOINT}_{name.upper().replace('-', '_')}"
    if address := environment.get(variable):
        return Address(checked_url(address, variable))
    given = environment.get(settings.ENDPOINTS)
    path = Path(given or FILE)
    if not given and not path.is_file():
        raise ValueError(f"nobody says where the endpoint {name!r} is: set {variable}, or write {FILE}")
    try:
        tables: Any = tomllib.loads(path.read_text("utf-8")).get("endpoints", {})
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(tables, dict) or not isinstance(table := tables.get(name), dict):
        raise ValueError(f"{path}: {unknown('endpoint', name, sorted(tables) if isinstance(tables, dict) else ())}")
    if unknown_names := [key for key in table if key not in _KEYS]:
        raise ValueError(f"{path}: endpoints.{name}: {unknown('key', unknown_names[0], _KEYS)}")
    where = f"{path}: endpoints.{name}.base_url"
    return Address(checked_url(table.get("base_url"), where), f"{table.get('key', settings.KEY)}")


def checked_url(url: Any, name: str = "base_url") -> str:
    """An endpoint's address without a slash at its end. The message does not repeat it: it may hold a secret.

    Raises:
        ValueError: it is no such address.
    """
    try:
        parts = urlsplit(url) if isinstance(url, str) else None
    except ValueError:
        parts = None
    if parts is None or parts.scheme not in ("http", "https") or not parts.netloc:
        raise ValueError(f"{name} must be an address such as http://localhost:8000/v1")
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise ValueError(f"{name} must hold no user, password or query: a key goes into {settings.KEY}")
    return f"{url}".rstrip("/")
