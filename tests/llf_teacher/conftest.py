"""What several modules of these tests ask for by name."""

import pytest

import llf_teacher.compat


@pytest.fixture
def llfbench():
    llf_teacher.compat.install()
    import llfbench

    yield llfbench
    llf_teacher.compat.uninstall()


@pytest.fixture
def no_settings(monkeypatch):
    """No settings for language models but a test's own."""
    for name in ("MODEL", "BASE_URL", "API_KEY", "CACHE", "BUDGET", "TIMEOUT", "RETRIES"):
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)
