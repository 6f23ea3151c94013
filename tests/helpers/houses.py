"""What other processes play: tests hand it to them, so it has to be in a module that they can import."""

import worlds.alfworld
from worlds.alfworld.stock import StockEngine


def play_in_textworld(seed):
    """The answers to a few commands."""
    world = worlds.alfworld.Alfworld(engine="textworld", games="generated")
    world.reset(seed=seed)
    return [world.step(command)[0] for command in ("look", world.commands()[0], "inventory")]


def plan_by_downward(played, queue):
    """Put the length of Fast Downward's plan for a game into a queue."""
    env = StockEngine(played)._env
    queue.put(len(env._pddl_state.replan(env._entity_infos)))
