"""Endpoints by name: a study names them; a file or the environment has their addresses and the variables of their keys.

The file is `llf-endpoints.toml` in the folder where a study runs, or the file that `LLF_LLM_ENDPOINTS` names.
It has a table per endpoint, as in `[endpoints.local]` with `base_url = "http://localhost:8000/v1"` and, optionally,
`key = "MY_VARIABLE"`. Or the environment has `LLF_LLM_ENDPOINT_LOCAL=http://localhost:8000/v1`.
"""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from llf_teacher.models import settings
from llf_teacher.serialization import read_toml
from teachers.spec import unknown

FILE = "llf-endpoints.toml"
_NAME = re.compile(r"[A-Za-z][\w-]*")
_KEYS = ("base_url", "key")


class Address(NamedTuple):
    """The address of an endpoint and the variable of its key."""

    base_url: str
    key: str = settings.KEY
    """Name of the environment variable with its key."""


def check_name(name: Any) -> str:
    """Check an endpoint's name and return it.

    Raises:
        ValueError: the name has other characters than letters, digits, - and _.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ValueError(f"endpoint must be a name of letters, digits, - and _, such as 'local', got {name!r}")
    return name


def place_of(name: str, environment: Mapping[str, str] = os.environ) -> Address:
    """The address of an endpoint by its name.

    Raises:
        ValueError: there is no address, or it is not allowed.
    """
    variable = f"{settings.ENDPOINT}_{name.upper().replace('-', '_')}"
    if address := environment.get(variable):
        return Address(checked_url(address, variable))
    given = environment.get(settings.ENDPOINTS)
    path = Path(given or FILE)
    if not given and not path.is_file():
        raise ValueError(f"the endpoint {name!r} has no address: set {variable}, or write {FILE}")
    tables: Any = read_toml(path).get("endpoints", {})
    if not isinstance(tables, dict) or not isinstance(table := tables.get(name), dict):
        raise ValueError(f"{path}: {unknown('endpoint', name, sorted(tables) if isinstance(tables, dict) else ())}")
    for key in table:
        if key not in _KEYS:
            raise ValueError(f"{path}: endpoints.{name}: {unknown('key', key, _KEYS)}")
    where = f"{path}: endpoints.{name}.base_url"
    return Address(checked_url(table.get("base_url"), where), f"{table.get('key', settings.KEY)}")


def checked_url(url: Any, name: str = "base_url") -> str:
    """Check an endpoint's address; return it without a final slash, its scheme in lower case, as is asked of it later.

    No message shows the address: it may hold a secret.

    Raises:
        ValueError: the address is not allowed.
    """
    try:
        parts = urlsplit(url) if isinstance(url, str) else None
        named = parts is not None and parts.hostname and parts.port != 0  # a port that is none raises
    except ValueError:
        parts, named = None, False
    if parts is None or not named or parts.scheme not in ("http", "https") or not f"{url}".isprintable() or " " in url:
        raise ValueError(f"{name} must be an address such as http://localhost:8000/v1")
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise ValueError(f"{name} must hold no user, password or query: a key goes into {settings.KEY}")
    return f"{parts.scheme}{url[len(parts.scheme) :]}".rstrip("/")
