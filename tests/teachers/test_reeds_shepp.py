"""Reeds-Shepp words: each leads where it says."""

import math

import numpy as np

from teachers.oracles.parking.reeds_shepp import words


def drive(word):
    """Where a word leads from the origin."""
    x = y = heading = 0.0
    for piece, length in zip(word.pieces, word.lengths, strict=True):
        side = {"L": 1, "R": -1, "S": 0}[piece]
        if side:
            turned = heading + side * length
            x += side * (math.sin(turned) - math.sin(heading))
            y -= side * (math.cos(turned) - math.cos(heading))
            heading = turned
        else:
            x, y = x + length * math.cos(heading), y + length * math.sin(heading)
    return x, y, heading


def test_words_end_where_they_should():
    rng = np.random.default_rng(0)
    shapes = set()
    for x, y, turn in rng.uniform((-5, -5, -math.pi), (5, 5, math.pi), (500, 3)).tolist():
        found = list(words(x, y, turn))
        assert found
        for word in found:
            end_x, end_y, heading = drive(word)
            assert math.hypot(end_x - x, end_y - y) < 1e-6
            assert abs(math.sin((heading - turn) / 2)) < 1e-6
            shapes.add(word.pieces)
    assert {"LSL", "LSR", "LRL", "LRLR", "LRSL", "LRSR", "LRSLR", "RSRL"} <= shapes


def test_straight_ahead_and_straight_back_are_shortest():
    for x in (3.0, -3.0):
        word = min(words(x, 0.0, 0.0), key=lambda each: sum(map(abs, each.lengths)))
        assert sum(word.lengths) == x
