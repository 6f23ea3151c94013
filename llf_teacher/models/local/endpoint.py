"""The endpoint of a model of this machine: its server starts when the first answer is not in the cache."""

import contextlib
import os
import threading
import time
import weakref
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from llf_teacher.models import LLMError, NoAnswerError
from llf_teacher.models.cache import MEMORY, Cache
from llf_teacher.models.client import Endpoint
from llf_teacher.models.local import options
from llf_teacher.models.local.catalogue import PREFIX, digest_of, find, name_of
from llf_teacher.models.local.server import Running, ServerLease, check_engine
from llf_teacher.models.replies import Answer, Prices
from llf_teacher.models.retries import PassingError
from llf_teacher.models.settings import TIMEOUT, ClientSettings

PAUSE = 5.0
"""Seconds after a server's unexpected end in which this process starts no other: what is under way ends first."""
_NOWHERE = "http://127.0.0.1:9/v1"  # before the server has an address
_SECONDS = 600.0  # of a request; a slow machine reads a long prompt


class LocalEndpoint(Endpoint):
    """A model of this machine. Many threads may use it at once; as many as there are slots are answered.

    Args:
        model: of a spec, in canonical form.
        settings: as of any endpoint; there is no key.
    """

    def __init__(self, model: str, settings: ClientSettings) -> None:
        super().__init__(_NOWHERE, settings)
        self.base_url = f"the local model {name_of(model)!r}"  # in messages
        self._model = model
        self._one = threading.Lock()
        self._lease: ServerLease | None = None
        self._slots: threading.Semaphore | None = None
        self.ended = ""
        """Why it answers no more; empty as long as it does."""
        self.ended_at = 0.0

    def _identity(self, model: str) -> dict[str, str]:
        return {}  # its model has the digest

    def _once(self, key: str, whole: dict[str, Any], request: dict[str, Any], prices: Prices | None) -> Answer:
        server, slots = self._server()
        with slots:
            if self.ended:
                raise LLMError(self.ended)
            try:
                return super()._once(key, whole, request, prices)
            except NoAnswerError as error:
                if "context" not in f"{error}":
                    raise
                raise NoAnswerError(f"{error}; or set {options.CONTEXT} to more than {server.context}") from None
            except PassingError:
                if self._lease is None or self._lease.lives():
                    raise
                self.ended, self.ended_at = self._why_ended(), time.monotonic()
                self._lease.close()
                raise LLMError(self.ended) from None

    def _server(self) -> tuple[Running, threading.Semaphore]:
        """The server, to which the client is pointed, and its slots.

        Raises:
            LLMError: there is none.
        """
        with self._one:
            if self.ended:
                raise LLMError(self.ended)
            try:
                if self._lease is None:
                    self._lease = ServerLease(find(self._model))
                    weakref.finalize(self, self._lease.close)
                server = self._lease.running()
            except (ValueError, OSError, ModuleNotFoundError) as error:
                raise LLMError(f"{error}") from None
            if self._slots is None:
                self._slots = threading.BoundedSemaphore(server.slots)
                self._client.base_url, self._client.api_key = f"{server.url}/v1", server.key
            return server, self._slots

    def _why_ended(self) -> str:
        lease = self._lease
        words, log = ("", "") if lease is None else (lease.last_words(), lease.log)
        return (
            f"the server of {self.base_url} ended while it was asked, perhaps for want of memory; its log is {log} and "
            f"ends with {words!r}. The same command starts it again and goes on"
        )


def connect_local(model: str) -> LocalEndpoint:
    """The endpoint of a model, the same in the same process as long as its server lives."""
    settings = local_settings()
    place = model, settings, os.getpid()
    with _connecting:
        found = _connected.get(place)
        if found is None or (found.ended and time.monotonic() - found.ended_at >= PAUSE):
            found = _connected[place] = LocalEndpoint(model, settings)
        return found


_connecting = threading.Lock()
_connected: dict[tuple[str, ClientSettings, int], LocalEndpoint] = {}


def local_settings(environment: Mapping[str, str] = os.environ) -> ClientSettings:
    """The settings of a client for models of this machine: without a key, and with more time."""
    settings = ClientSettings.read("", environment, key_in="")
    return settings if environment.get(TIMEOUT) else replace(settings, timeout=_SECONDS)


def asked_as(model: str) -> str:
    """The name of a model in requests, and so in the cache: by its digest alone."""
    return f"{PREFIX}{digest_of(model)}"


def check_local(model: str, environment: Mapping[str, str]) -> None:
    """Check that a model can be asked here, or that its answers are in the cache.

    Raises:
        ValueError: it is not at hand, or an option is not allowed.
        ModuleNotFoundError: llama.cpp is not installed.
    """
    options.slots(environment)
    path = local_settings(environment).cache
    try:
        check_engine()
        find(model)
    except (ValueError, ModuleNotFoundError):
        if path == MEMORY or not os.path.exists(path):
            raise
        with contextlib.closing(Cache(path)) as cache:
            if all(each["model"] != asked_as(model) for each in cache.by_model()):
                raise
