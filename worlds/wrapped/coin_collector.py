"""TextWorld's coin collector as a Gymnasium environment: find the coin in a chain of rooms. Needs the extra `alfworld`.

The games are those of `textworld.challenges.coin_collector` (Côté et al. 2018, TextWorld: A Learning Environment for
Text-based Games), played by TextWorld's own engine. Its narrative needs games that are compiled; in its place, rooms
are described in plain sentences.
"""

import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium import spaces

COMMANDS = ("go north", "go south", "go east", "go west", "take coin")
"""The commands, by the numbers of actions."""
_SEEDS = 2**31
_LENGTH = 1000  # of a description, at most


@lru_cache(maxsize=64)  # to make one takes a second
def _game(level: int, seed: int) -> str:
    """A game as JSON."""
    import textworld
    from textworld.challenges import coin_collector

    options = textworld.GameOptions()
    options.seeds = seed
    game = coin_collector.make({"level": level}, options)
    with tempfile.TemporaryDirectory() as folder:
        game.save(str(path := Path(folder) / "game.json"))
        return path.read_text(encoding="utf-8")


class CoinCollector(gymnasium.Env[str, Any]):
    """Another game for each seed. The coin pays 1 and ends the episode; each action costs something.

    Args:
        level: from 1 to 300, as TextWorld counts them; up to 100 it is the number of rooms, all on the way to the coin.
        cost: of an action.
    """

    def __init__(self, level: int = 5, cost: float = 0.01) -> None:
        self._level, self._cost = level, cost
        self.action_space = spaces.Discrete(len(COMMANDS))
        self.observation_space = spaces.Text(_LENGTH, charset="".join(map(chr, range(32, 127))))
        self.reward_range = (-cost, 1 - cost)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[str, dict[str, Any]]:
        """Begin a new game."""
        import textworld

        super().reset(seed=seed)
        game = _game(self._level, int(self.np_random.integers(_SEEDS)))
        infos = textworld.EnvInfos(admissible_commands=True, policy_commands=True, won=True)
        with tempfile.TemporaryDirectory() as folder:
            (path := Path(folder) / "game.json").write_text(game, encoding="utf-8")
            self._engine = textworld.start(str(path), infos)
        self._state = self._engine.reset()
        return self._describe(), {}

    def step(self, action: Any) -> tuple[str, float, bool, bool, dict[str, Any]]:
        """Give a command. One that is not possible here changes nothing."""
        if COMMANDS[action] in self._state["admissible_commands"]:
            self._state, _, _ = self._engine.step(COMMANDS[action])
        won = bool(self._state["won"])
        return self._describe(), won - self._cost, won, False, {"success": won}

    def policy_commands(self) -> list[str]:
        """TextWorld's own way to the coin from here on."""
        return list(self._state["policy_commands"])

    def _describe(self) -> str:
        facts = [(each.name, *(var.name for var in each.arguments)) for each in self._state["_facts"]]
        (room,) = (place for name, *rest in facts if name == "at" and rest[0] == "P" for place in rest[1:])
        names = self._state["game"].infos
        exits = [command for command in COMMANDS[:4] if command in self._state["admissible_commands"]]
        coin = " There is a coin." if COMMANDS[4] in self._state["admissible_commands"] else ""
        return f"You are in the {names[room].name}.{coin} You can {' or '.join(exits) or 'go nowhere'}."
