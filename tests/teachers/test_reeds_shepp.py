"""Reeds-Shepp words: each leads where it says, and none is shorter than is thought beforehand."""

import math

import numpy as np

from teachers.oracles.parking import driving, paths
from teachers.oracles.parking.model import Ground, brake
from teachers.oracles.parking.paths import cheapest, targets
from teachers.oracles.parking.reeds_shepp import PIECES, backwards, forwards, nearby, one_cusp, two_cusps

GROUND = Ground((10.0, 14.0, math.pi / 2), 1.44, (), 34.5, 20.5)
ENDS = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 4.0))


def words(x, y, turn, most=math.inf):
    """All that lead there."""
    kinds = (forwards, backwards, one_cusp, two_cusps, nearby)
    return [word for kind in kinds for word in kind(x, y, turn, math.sin(turn), math.cos(turn), most)]


def drive(word):
    """Where a word leads from the origin."""
    x = y = heading = 0.0
    number, lengths = word
    assert not any(lengths[len(PIECES[number]) :])
    for piece, length in zip(PIECES[number], lengths, strict=False):
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
        found = words(x, y, turn)
        assert found
        assert len({number for number, _ in found}) == len(found)
        for word in found:
            end_x, end_y, heading = drive(word)
            assert math.hypot(end_x - x, end_y - y) < 1e-6
            assert abs(math.sin((heading - turn) / 2)) < 1e-6
            shapes.add(PIECES[word[0]])
    assert {"LSL", "LSR", "LRL", "LRLR", "LRSL", "LRSR", "LRSLR", "RSRL"} <= shapes


def test_straight_ahead_and_straight_back_are_shortest():
    for x in (3.0, -3.0):
        _, lengths = min(words(x, 0.0, 0.0), key=lambda word: sum(map(abs, word[1])))
        assert sum(lengths) == x


def test_words_are_left_out_only_if_they_are_too_long():
    rng = np.random.default_rng(1)
    for x, y, turn in rng.uniform((-5, -5, -math.pi), (5, 5, math.pi), (300, 3)).tolist():
        every, most = words(x, y, turn), rng.uniform(1, 12)
        some = words(x, y, turn, most)
        assert set(some) <= set(every)
        assert all(sum(map(abs, lengths)) > most for _, lengths in set(every) - set(some))


def starts(car):
    """Where paths may begin: there, and after braking."""
    stops = [brake(GROUND, car, wheel) for wheel in (0, 100, -100)]
    return [(0, car), *[(len(actions), there) for stopped, actions, there in stops if stopped]]


def test_paths_come_by_their_cost_and_the_cheapest_is_the_first_of_all():
    """Most words are not computed before the first is known; from anywhere, at any speed, after braking, too."""
    rng = np.random.default_rng(2)
    for car in rng.uniform((-25, -12, -4, -6), (25, 12, 4, 6), (400, 4)).tolist():
        places = targets(GROUND, starts(tuple(car)), ENDS)
        every = paths.paths(places, math.inf)
        order = [(path.cost, path.number) for path in every]
        assert order == sorted(order)
        assert len({path.number for path in every}) == len(every)
        assert cheapest(places) == every[:1]
        most = every[len(every) // 2].cost
        assert paths.paths(places, most) == [path for path in every if path.cost <= most]
    assert cheapest([]) == []


def test_few_paths_are_reckoned_up_before_the_first_is_known_and_not_all_before_the_second(monkeypatch):
    """Words are dropped by their distances and headings: of some hundreds, few are made into paths."""
    reckoned = []
    cost = paths._cost

    def count(target, lengths):
        reckoned.append(target)
        return cost(target, lengths)

    monkeypatch.setattr(paths, "_cost", count)
    rng = np.random.default_rng(3)
    until = np.zeros(3)
    for car in rng.uniform((-25, -12, -4, -6), (25, 12, 4, 6), (100, 4)).tolist():
        places = targets(GROUND, starts(tuple(car)), ENDS)
        reckoned.clear()
        (best,) = cheapest(places)
        until[0] += len(reckoned)
        for number, dearer in ((1, driving._DEARER), (2, math.inf)):
            paths.paths(places, best.cost + dearer)
            until[number] += len(reckoned)
    first, second, every = until / 100
    print(f"{first:.1f} paths before the first, {second:.1f} before the second, {every:.1f} before the last")
    assert first < 12
    assert second < every / 2
