"""The mirror: qualities of known teachers, cards of teachers, and teachers that fail."""

import pytest

from llf_teacher.suite.mirror import all_qualities, digest
from llf_teacher.suite.mirror.quality import ORDER
from teachers.personality import parse_personality

DIGEST = "ae18169f8fffbc6f"


def test_the_digest_is_that_of_the_version():
    """If not, a score means something else: give the mirror another version."""
    assert digest() == DIGEST


@pytest.mark.parametrize("name", all_qualities())
def test_a_quality_is_complete(name):
    each = all_qualities()[name]
    assert name in ORDER
    assert set(each.rests_on) <= set(all_qualities()) - {name}
    assert all(parse_personality(spec) for spec in each.teachers)
