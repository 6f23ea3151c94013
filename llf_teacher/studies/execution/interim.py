"""What a sequential design decides at a look, while a study is played."""

from typing import NamedTuple

from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.report.data import Data, read
from llf_teacher.studies.store import Store


class Decision(NamedTuple):
    """What is decided at a look."""

    look: int
    """Counted from 1."""
    of: int
    seeds: int
    level: float
    """The greatest adjusted p-value that is a finding."""
    comparisons: int
    """Those that can differ."""
    found: int
    """Those of them that have found a difference."""
    stops: bool
    """Whether the study ends here, though it has more looks."""

    def __str__(self) -> str:
        what = "it was the last" if self.look == self.of else "the study goes on"
        return (
            f"Look {self.look} of {self.of}, after {self.seeds} seeds: {self.found} of {self.comparisons} comparisons "
            f"found a difference (p <= {self.level:.2g}, adjusted); "
            f"{'the study ends here, as it declares' if self.stops else what}."
        )


def decision(data: Data) -> Decision | None:
    """What is decided at the last look for which all has been played; None before the first, or without looks."""
    if data.test is None or not data.test.look:
        return None
    return Decision(
        data.test.look,
        len(data.study.looks["at"]),
        len(data.test.seeds),
        data.test.level,
        sum(len(section.differences) for section in data.sections),
        data.found,
        data.stopped,
    )


def decide(store: Store, study: Study) -> Decision | None:
    """The same, of what a store holds of a study."""
    return None if store.empty or not study.looks else decision(read(store, study))
