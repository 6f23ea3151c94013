"""drifting(after, to): becomes another personality from a turn on."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View, parse_personality
from teachers.spec import check_range


@dataclass(frozen=True)
class Drifting(Personality):
    """Passes everything on in its first turns, and then does what another personality does that begins only now."""

    after: int = 10
    """The first turn of the other personality, at least 0."""
    to: str = "silent"
    """Its spec."""

    source = "Bignold et al. 2021"

    def __post_init__(self) -> None:
        check_range("after", self.after, 0, 1_000_000, int)
        to = parse_personality(self.to)
        try:
            same = parse_personality(str(to)) == to
        except ValueError:
            same = False
        if not same:
            raise ValueError(
                f"to must be a spec, or a personality that one can name, got {to!r}; "
                "put it into a module of its name under teachers/personalities/"
            )
        object.__setattr__(self, "to", str(to))

    @property
    def needs(self) -> frozenset[str]:  # type: ignore[override]
        """What the other one needs."""
        return parse_personality(self.to).needs

    @property
    def honest(self) -> bool:  # type: ignore[override]
        """If the other one is."""
        return parse_personality(self.to).honest

    class Stage(Stage):
        """Holds the other one."""

        def begin(self) -> None:
            """Start it."""
            self._other = parse_personality(self.spec.to).start(self.rng)

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Pass on, or leave it to the other one."""
            return claims if view.turn < self.spec.after else self._other.speak(claims, view)
