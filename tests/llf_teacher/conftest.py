"""What several modules of these tests ask for by name."""

import pytest

import llf_teacher.compat


@pytest.fixture
def llfbench():
    llf_teacher.compat.install()
    import llfbench

    yield llfbench
    llf_teacher.compat.uninstall()
