"""The decision of a sequential design at an interim analysis, while a study is played."""

from typing import NamedTuple

from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.report.data import Data, read
from llf_teacher.studies.store import Store


class Decision(NamedTuple):
    """The result of an interim analysis."""

    analysis: int
    """Counted from 1."""
    of: int
    """Number of interim analyses."""
    seeds: int
    """Number of seeds so far."""
    level: float
    """The greatest adjusted p-value that is significant."""
    comparisons: int
    """Number of primary comparisons."""
    significant: int
    """Number of significant primary comparisons."""
    stops: bool
    """Whether the study ends before its last analysis."""

    def __str__(self) -> str:
        then = "it was the last" if self.analysis == self.of else "the study goes on"
        return (
            f"Interim analysis {self.analysis} of {self.of}, after {self.seeds} seeds: {self.significant} of "
            f"{self.comparisons} primary comparisons are significant, adjusted for the analyses and by Holm's method "
            f"(p <= {self.level:.2g}); "
            f"{'the study ends here, as it declares' if self.stops else then}."
        )


def decision(data: Data) -> Decision | None:
    """The result of the last complete interim analysis; None before the first, and without a design."""
    if data.test is None or not data.test.analysis:
        return None
    return Decision(
        data.test.analysis,
        len(data.study.interim_analyses["at"]),
        len(data.test.seeds),
        data.test.level,
        len(data.primary),
        len(data.significant),
        data.stopped,
    )


def decide(store: Store, study: Study) -> Decision | None:
    """The result of the last complete interim analysis of a store; None under the conditions of `decision`."""
    return None if store.empty or not study.interim_analyses else decision(read(store, study))
