"""A room whose temperature goes up or down by a degree a turn, and a temperature that is wanted."""

from types import MappingProxyType
from typing import NamedTuple

from gymnasium import spaces

from worlds.world import World, illegal

KNOBS = ("cool", "hold", "heat")
COLDEST, HOTTEST = 5, 35


class Truth(NamedTuple):
    """Degrees Celsius."""

    now: int
    wanted: int


class Thermostat(World):
    """Observes the temperature, turns one of three knobs; 1 is paid at the wanted temperature, which ends it."""

    reward_range = (0.0, 1.0)
    action_words = MappingProxyType({knob: number for number, knob in enumerate(KNOBS)})
    action_syntax = "cool, hold or heat, or its number (0, 1, 2)"

    def __init__(self, least=2, most=6, *, render_mode=None):
        super().__init__(render_mode=render_mode, least=least, most=most)
        self.observation_space = spaces.Discrete(HOTTEST - COLDEST + 1, start=COLDEST)
        self.action_space = spaces.Discrete(len(KNOBS))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        away = int(self.np_random.integers(self.options["least"], self.options["most"] + 1))
        now = int(self.np_random.integers(15, 25))
        self._load(Truth(now, now + away * int(self.np_random.choice([-1, 1]))))
        return self.observe(), {"success": False}

    @property
    def truth(self):
        return self._truth

    def legal(self, action):
        if isinstance(action, bool) or not self.action_space.contains(action):
            raise illegal(action, self.action_syntax)
        return int(action)

    def advance(self, action):
        now = min(max(self._truth.now + action - 1, COLDEST), HOTTEST)
        self._load(self._truth._replace(now=now))
        success = now == self._truth.wanted
        return now, float(success), success, False, {"success": success}

    def describe(self, observation):
        return f"It is {observation} degrees."

    def sample_action(self, rng):
        return int(rng.integers(len(KNOBS)))

    def _load(self, truth):
        self._truth = truth

    def observe(self):
        return self._truth.now
