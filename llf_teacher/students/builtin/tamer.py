"""tamer: predicts what a trainer will say of each action, and does what promises most praise."""

from dataclasses import dataclass

from llf_teacher.students.evaluated import Evaluated, EvaluatedPolicy, Features, Table, check_shares


class _Policy(EvaluatedPolicy["Tamer"]):
    """A table of expected labels."""

    def clear(self) -> None:
        """Expect nothing."""
        self._human = Table(self.actions)

    def hear(self, state: Features, action: int, label: float) -> None:
        """A step towards the label; silence is no sample."""
        if label:
            self._human.add(state, self.spec.alpha * (label - self._human(state)[action]), action)

    def choose(self, here: Features) -> int:
        """What promises most; the trainer's word is no reward to be summed up, so the horizon is a single action."""
        return self.best(self._human(here))


@dataclass(frozen=True)
class Tamer(Evaluated):
    """TAMER (Knox & Stone 2009): supervised learning of the trainer's praise (1) and blame (-1), acted on greedily."""

    alpha: float = 0.3
    """Step size, 0 to 1."""
    reads = "atoms"
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        check_shares(self, "alpha")
