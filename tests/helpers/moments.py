"""Oracles that look at a truth made by hand, and the moments there."""

from teachers.atoms import Moment


def started(oracle_class, world, truth):
    """An oracle that looks at a hand-made truth."""
    world.restore(truth)
    oracle = oracle_class(world.scratch)
    oracle.start(truth)
    return oracle


def opening(truth):
    return Moment.opening(truth)


def turn(world, truth, action, number=1):
    world.restore(truth)
    _, reward, _, _, info = world.step(action)
    return Moment(truth, world.legal(action), reward, world.truth, info["success"], number, False)
