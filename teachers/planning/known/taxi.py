"""Taxi: five by five squares, four stands, one passenger."""

from typing import Any

from teachers.planning.known import Known

_STANDS = ("red", "green", "yellow", "blue")


def _describe(observation: int) -> str:
    rest, destination = divmod(int(observation), 4)
    rest, passenger = divmod(rest, 5)
    row, column = divmod(rest, 5)
    where = "sits in the taxi" if passenger == 4 else f"waits at the {_STANDS[passenger]} stand"
    return (
        f"The taxi is in row {row}, column {column}, counted from 0 in the north-west. The passenger {where} and "
        f"wants to go to the {_STANDS[destination]} stand. The stands are in row and column: red 0 0, green 0 4, "
        "yellow 4 0, blue 4 3."
    )


def _lacks(env: Any) -> str:
    changes = getattr(env.unwrapped, "fickle_passenger", False)
    return "that the passenger may change the destination, as fickle_passenger=True has it" if changes else ""


KNOWN = Known(
    action_words={"south": 0, "north": 1, "east": 2, "west": 3, "pick up": 4, "drop off": 5},
    describe=_describe,
    lacks=_lacks,
)
