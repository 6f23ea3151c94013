"""Claims made in a quarter of the time, for oracles that make many of them in each turn."""

from collections.abc import Callable
from dataclasses import fields, make_dataclass
from typing import Any

from teachers.atoms import ClaimT

__all__ = ["maker"]


def maker(cls: type[ClaimT]) -> Callable[..., ClaimT]:
    """What makes claims of a class from the values of all fields, in their order.

    A frozen dataclass fills its fields by a call each, and is called by keywords. Here a claim is filled before it
    freezes: until then it is of a subclass that is not frozen, which no one else sees.
    """
    unfrozen = {"__slots__": (), "__setattr__": object.__setattr__, "__delattr__": object.__delattr__}
    fresh: Any = type(cls.__name__, (cls,), unfrozen)
    names = [field.name for field in fields(cls)]  # type: ignore[arg-type]  # a dataclass
    fresh.__init__ = make_dataclass(cls.__name__, names).__init__  # type: ignore[misc]  # of a class

    def make(*values: Any) -> ClaimT:
        claim: ClaimT = fresh(*values)
        claim.__class__ = cls
        return claim

    return make
