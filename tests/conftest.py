"""What all tests share."""

import gc
import os
import zlib

import numpy as np
import pytest
from design import mark_sizes, set_size
from hypothesis import HealthCheck, settings

import llf_teacher

os.environ.pop("ALFWORLD_DATA", None)  # so that games are generated, here and in other processes

_patient = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # other work may slow a machine
settings.register_profile("new", _patient)  # pytest --hypothesis-profile=new: other examples and draws each time
settings.register_profile("same", _patient, derandomize=True)
settings.load_profile("same")


def pytest_configure(config):
    """Before any test is imported, since many have amounts among their constants."""
    set_size(config.getoption("markexpr"))


@pytest.fixture
def rng(request):
    """Draws of a test, of each run the same; with `--hypothesis-profile=new` others each time."""
    new = request.config.getoption("--hypothesis-profile") == "new"
    return np.random.default_rng(None if new else zlib.crc32(request.node.name.encode()))


@pytest.fixture
def no_settings(monkeypatch):
    """No settings for language models but a test's own."""
    for name in ("MODEL", "BASE_URL", "API_KEY", "CACHE", "BUDGET", "TIMEOUT", "RETRIES"):
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)


@pytest.fixture
def short_trials():
    """Planners try environments less, but for tests that ask for `long_trials`, and by `pytest -m full`."""
    from trials import shorten  # imported late, as most tests plan nothing

    with pytest.MonkeyPatch.context() as monkeypatch:
        shorten(monkeypatch)
        yield monkeypatch


@pytest.fixture
def long_trials(short_trials):
    """Planners try environments at full length: for tests of what is found by that alone."""
    short_trials.undo()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Before pytest leaves out by marks what is not asked for."""
    mark_sizes(items, llf_teacher.__version__)


def pytest_collection_finish():
    """What was collected stays to the end: garbage collections need not go through it again and again."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish(session):
    """With `LLF_NO_SKIPS` a skipped test fails the run: where everything is installed, nothing may go untested."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None and reporter.stats.get("skipped") and os.environ.get("LLF_NO_SKIPS"):
        reporter.write_line("LLF_NO_SKIPS is set, and tests were skipped; pytest -rs says which and why", red=True)
        session.exitstatus = 1
