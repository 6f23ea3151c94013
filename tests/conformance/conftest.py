"""What the tests of the kits share."""

import pytest


@pytest.fixture
def rejects():
    """A function that names the checks which reject a subject."""

    def names(checks, *subject):
        rejecting = []
        for check in checks:
            try:
                check(*subject)
            except (AssertionError, ValueError):
                rejecting.append(check.__name__)
        return rejecting

    return names
