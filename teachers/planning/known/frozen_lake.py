"""FrozenLake: squares of ice, on which a step may slip."""

from teachers.planning.known import Known


def _describe(observation: int) -> str:
    return f"You are on square {int(observation)}. Squares are numbered from 0 at the top left, row by row."


KNOWN = Known(action_words={"left": 0, "down": 1, "right": 2, "up": 3}, describe=_describe)
