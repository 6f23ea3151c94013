"""drifting(after, to): becomes another personality from a turn on."""

from dataclasses import dataclass

from teachers.personality import Claims, Personality, Stage, View, parse_personality
from teachers.spec import Count


class _Drift(Stage["Drifting"]):
    """Keeps the other personality's stage."""

    def begin(self) -> None:
        self._other = parse_personality(self.spec.to).start(self.rng)

    def speak(self, claims: Claims, view: View) -> Claims:
        return claims if view.turn < self.spec.after else self._other.speak(claims, view)


@dataclass(frozen=True)
class Drifting(Personality):
    """Passes on every claim in its first turns, then acts as another personality that starts at that turn."""

    after: Count = 10
    """The first turn of the other personality, at least 0."""
    to: str = "silent"
    """Its spec."""

    source = "Bignold et al. 2021"
    stage = _Drift

    def __post_init__(self) -> None:
        super().__post_init__()
        to = parse_personality(self.to)
        try:
            same = parse_personality(str(to)) == to
        except ValueError:
            same = False
        if not same:
            raise ValueError(
                f"to must be a spec, or a personality that has one, got {to!r}; define it in a module, outside "
                "functions and classes"
            )
        object.__setattr__(self, "to", str(to))

    @property
    def needs(self) -> frozenset[str]:
        """The needs of the other personality."""
        return parse_personality(self.to).needs

    @property
    def honest(self) -> bool:
        """Whether the other personality is honest."""
        return parse_personality(self.to).honest
