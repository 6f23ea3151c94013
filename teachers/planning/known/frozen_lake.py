"""FrozenLake: squares of ice, on which a step may slip."""

from teachers.planning.known import Known

KNOWN = Known(action_words={"left": 0, "down": 1, "right": 2, "up": 3})
