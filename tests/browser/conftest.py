"""The page in a real browser: `.ci/run browser` gets one and runs these tests; plain pytest leaves them out.

They are run where `LLF_BROWSER` is set: to a browser's path, or to 1 for the one that is found.
"""

import os

import pytest

collect_ignore_glob = [] if os.environ.get("LLF_BROWSER") else ["test_*.py"]


@pytest.fixture(scope="session")
def address():
    from browsing import serving

    with serving() as address:
        yield address


@pytest.fixture
def visitor():
    """Whose browser has had nothing to complain of in the end: no script failed, nothing broke the page's policy."""
    from browsing import browsing

    with browsing() as visitor:
        yield visitor
        logged = [entry for entry in visitor.driver.get_log("browser") if entry["level"] == "SEVERE"]
        assert not [entry for entry in logged if "Failed to load resource" not in entry["message"]], logged
