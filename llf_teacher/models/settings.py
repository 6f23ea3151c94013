"""Settings of the client from the environment, which are not part of a spec."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field

MODEL, BASE_URL, KEY = "LLF_LLM_MODEL", "LLF_LLM_BASE_URL", "LLF_LLM_API_KEY"
CACHE, BUDGET, TIMEOUT, RETRIES = "LLF_LLM_CACHE", "LLF_LLM_BUDGET", "LLF_LLM_TIMEOUT", "LLF_LLM_RETRIES"
ENDPOINT, ENDPOINTS = "LLF_LLM_ENDPOINT", "LLF_LLM_ENDPOINTS"
OPENAI = "https://api.openai.com/v1"


@dataclass(frozen=True, kw_only=True)
class ClientSettings:
    """Settings for requests to any model of an endpoint."""

    key: str = field(repr=False)
    """API key, sent as `Authorization: Bearer`; empty: none."""
    cache: str
    """SQLite file of answers and spending; `:memory:` keeps them for this process."""
    budget: float | None
    """Spending limit in USD, by the cache's ledger; None: no limit."""
    timeout: float
    """Time limit of a request, in seconds."""
    retries: int
    """Number of further attempts after a transient error."""

    @classmethod
    def read(cls, base_url: str, environment: Mapping[str, str] = os.environ, key_in: str = KEY) -> "ClientSettings":
        """The settings for an endpoint.

        `OPENAI_API_KEY` goes only to OpenAI or `OPENAI_BASE_URL`, `LLF_LLM_API_KEY` to any endpoint without its own
        variable.

        Raises:
            ValueError: a number or the cache's file is not allowed, or the key has impossible characters.
        """
        key = environment.get(key_in, "")
        if not key and key_in == KEY and base_url in (OPENAI, environment.get("OPENAI_BASE_URL", "").rstrip("/")):
            key = environment.get("OPENAI_API_KEY", "")
        key = key.strip()
        if not key.isascii() or not key.isprintable() or " " in key:
            raise ValueError(f"the key in {key_in} or OPENAI_API_KEY must be of printable ASCII without spaces")
        budget = environment.get(BUDGET)
        return cls(
            key=key,
            cache=_file(environment.get(CACHE)),
            budget=_number(BUDGET, budget) if budget else None,
            timeout=_number(TIMEOUT, environment.get(TIMEOUT) or "60"),
            retries=int(_number(RETRIES, environment.get(RETRIES) or "6")),
        )


def default(name: str, environment: Mapping[str, str] = os.environ) -> str:
    """A variable of the environment: `LLF_LLM_...`, else `OPENAI_...`, else the empty string."""
    return environment.get(name) or environment.get(name.replace("LLF_LLM", "OPENAI")) or ""


def _file(path: str | None) -> str:
    if path is not None and path.strip() == ":memory:":
        raise ValueError(
            f"{CACHE} must be the name of a file, got {path!r}: processes would not share answers and spending"
        )
    return path or ":memory:"


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise ValueError(f"{name} must be a number of at least 0, got {text!r}")
    return value
