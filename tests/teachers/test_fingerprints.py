"""Fingerprints of states."""

import numpy as np
import pytest
from lessons import fits

from teachers.fingerprint import Fingerprints


class Opaque:
    """What has nothing but its place in memory."""


def test_fingerprints_are_equal_for_equal_values_only():
    prints = Fingerprints()
    values = [0, 1, -1, 0.5, "", "0", None, (), (0,), ((0,),), (0, 0), frozenset("ab"), {"a": 1}, {"a": 2}, 2**60]
    assert len({prints.of(value) for value in values}) == len(values)
    for one, other in ((1, 1.0), (True, 1), ([1, 2], (1, 2)), (frozenset("ba"), {"a", "b"}), (np.float64(0.5), 0.5)):
        assert prints.of(one) == prints.of(other) == Fingerprints().of(one)
    assert prints.of(np.arange(3)) == prints.of(np.arange(3)) != prints.of(np.arange(3.0))
    shares = [prints.share((i,)) for i in range(2000)]
    assert all(0 <= share < 1 for share in shares)
    assert fits(sum(share < 0.3 for share in shares), len(shares), 0.3)
    with pytest.raises(TypeError, match=r"an? Opaque has no fingerprint; states must be made of"):
        prints.of((1, Opaque()))
