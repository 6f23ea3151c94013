"""What people and models say in an episode: its sentences are read, made into claims, and checked in the simulator."""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property
from typing import Any, NamedTuple

from scipy.stats import binom, binomtest

from pz_envs.reading import build_claim, make_reader, said_by
from pz_envs.subject import Subject
from teachers.atoms import Claim, Moment
from teachers.oracle import Oracle
from teachers.reading import LayeredReader, SentenceReading
from teachers.reliability import share_of_clusters
from teachers.schema import LONGEST_TEXT, Vocabulary, holds, sentences_of
from worlds.world import World

__all__ = ["ALONE", "MODEL", "NOT_READ", "UNBUILT", "CheckedSentence", "ClaimReader", "Model", "share_false"]

READ, READ_RIGHT = 96, 91
"""How many sentences were read that no choice was made by, and how many of these right; all by the near layer.

Measured on tests/reading/last.txt, as docs/how-claims-are-checked.md says. No sentence there is of
the exact layer, which is taken to be no better.
"""
ALONE, MODEL = ("exact", "near"), "model"
"""The layers that need no model, whose errors `share_false` knows, and the last one."""
TRUE, FALSE, BUILT, UNBUILT, HEDGED, NOT_READ = "true", "false", "built", "unbuilt", "hedged", "not read"
"""What can become of a sentence: its claim is true, or false, or there is no truth to check it by; no single claim says
it, or its claim cannot be checked; it only hedges a claim; it is not read.
"""
MOST_SENTENCES = 256
"""The most sentences of a text that are read, and `LONGEST_TEXT` the most characters; the rest is not read."""
Model = Callable[[str, Vocabulary], Any]
"""The last layer: gets a sentence and what can be said, which has no episode, and answers as `Vocabulary.read` takes
it. It reads the sentence if its answer has one claim and no problem.
"""


class CheckedSentence(NamedTuple):
    """A sentence with what became of it."""

    text: str
    layer: str
    """The layer that read it, one of `ALONE` or `MODEL`; empty: there is no claim."""
    claim: Claim[Any] | None
    about_turn: int
    """The turn that it speaks of."""
    outcome: str
    """One of `TRUE`, `FALSE`, `BUILT`, `UNBUILT`, `HEDGED`, `NOT_READ`."""
    candidates: tuple[str, ...] = ()
    """If there is no claim, what came nearest, or why there is none."""

    @property
    def holds(self) -> bool | None:
        """Whether its claim is true; None: it was not checked."""
        return {TRUE: True, FALSE: False}.get(self.outcome)


class ClaimReader:
    """Reads the sentences of an episode into claims, and checks these where the truth is known.

    The phrases are learnt with the first text, which takes up to two seconds. Whatever is said, nothing is executed,
    and time and memory are bounded.

    Args:
        subject: what is taught.
        world: one of its options, which decide what actions there are.
        oracle: follows the episode; None: for a student, who has no truth, so that no claim is checked.
        model: the last layer, which is asked for sentences that the others did not read.
    """

    def __init__(
        self,
        subject: Subject,
        world: World[Any, Any, Any],
        oracle: Oracle[Any, Any] | None = None,
        model: Model | None = None,
    ) -> None:
        self._subject, self._world, self._oracle, self._model = subject, world, oracle, model
        self._moments: list[tuple[Moment[Any], tuple[Claim[Any], ...]]] = []

    @cached_property
    def _vocabulary(self) -> Vocabulary:
        return self._subject.vocabulary(self._world)

    @cached_property
    def _reader(self) -> LayeredReader:
        return make_reader(self._subject, self._vocabulary)

    def see(self, moment: Moment[Any], own: Iterable[Claim[Any]] = ()) -> None:
        """The next turn; turn 0 begins another episode.

        Args:
            moment: of the turn; for a student, one that only has its action, as `did` makes it.
            own: what the oracle would say of it. A number that is rounded as there is true, if the claim is.
        """
        if not moment.turn:
            vars(self).pop("_reader", None)  # which begins with the voice that it met last
        self._moments[moment.turn :] = [(moment, tuple(own))]

    def did(self, action: Any, turn: int) -> None:
        """The next turn of a student: its action, in the form of the world; None at the opening, turn 0."""
        acted = None if action is None else ()
        self.see(Moment(acted, action, 0.0, (), False, turn, False))

    def read(self, text: str) -> Iterator[CheckedSentence]:
        """The sentences of a text that was said in the last turn, in order."""
        if not text.strip():
            return
        kept, rest = text[:LONGEST_TEXT], sentences_of(text[LONGEST_TEXT:])
        readings = self._reader.read(kept)
        for i, reading in enumerate(readings):
            yield self._checked(reading) if i < MOST_SENTENCES else self._without(reading.text, NOT_READ, _TOO_LONG)
        yield from (self._without(each, NOT_READ, _TOO_LONG) for each in rest)

    def _without(self, text: str, outcome: str, *candidates: str) -> CheckedSentence:
        return CheckedSentence(text, "", None, self._moments[-1][0].turn, outcome, candidates)

    def _checked(self, reading: SentenceReading) -> CheckedSentence:
        about = self._moments[-1][0].turn if reading.about_turn is None else reading.about_turn
        if not 0 <= about < len(self._moments):
            return self._without(reading.text, UNBUILT, f"there is no turn {about} yet")
        moment, own = self._moments[about]
        if reading.claim is not None:
            built = build_claim(reading, self._subject, self._vocabulary, moment)
            if built.claim is None:
                return self._without(reading.text, UNBUILT, *built.candidates)
            return self._judged(reading, reading.layer, built.claim, about, own)
        if reading.hedged or self._model is None:
            return self._without(reading.text, HEDGED if reading.hedged else NOT_READ, *reading.candidates)
        found = self._vocabulary.read(self._model(reading.text, self._vocabulary), moment)
        if len(found.claims) != 1 or found.problems:
            why = found.problems[0] if found.problems else f"the model answers {len(found.claims)} claims"
            return self._without(reading.text, NOT_READ, f"{why:.200}")
        return self._judged(reading, MODEL, found.claims[0], about, own)

    def _judged(
        self, reading: SentenceReading, layer: str, claim: Claim[Any], about: int, own: tuple[Claim[Any], ...]
    ) -> CheckedSentence:
        """A sentence with its claim, and whether that is true."""
        oracle, (moment, _) = self._oracle, self._moments[about]
        outcome = BUILT
        if oracle is not None:
            try:
                # Rounded as it is said, a number may be just wrong: what the oracle itself would say so is true.
                alike = said_by(reading, self._subject, (*own, *oracle.clues(moment.after)))
                true = any(holds(each, moment, oracle) for each in alike) or claim.means(moment, oracle)
            except Exception as error:  # the check of a claim need not be ready for any field
                return self._without(reading.text, UNBUILT, f"it cannot be checked: {error!s:.80}")
            outcome = TRUE if true else FALSE
        return CheckedSentence(reading.text, layer, claim, about, outcome)


_TOO_LONG = f"of a text at most {MOST_SENTENCES} sentences and {LONGEST_TEXT} characters are read"


def share_false(
    episodes: Iterable[Iterable[tuple[str, bool]]],
    right: int = READ_RIGHT,
    known: int = READ,
    *,
    here: bool = False,
) -> tuple[float, float]:
    """An interval of at least 95 % for the share of a teacher's sentences that are false, by those that were read.

    The reader errs on texts: one that is misread is misread as often as it is said, and may be called true or false
    then. So of T different texts at most k are misread, the quantile of 98.75 % of the binomial distribution of T texts
    at the greatest rate of errors, the end of the one-sided interval of 98.75 % of Clopper and Pearson (The use of
    confidence or fiducial limits, Biometrika 26 (1934), 404-413) for `right` of `known`. The share is lowest if the k
    texts that were called false most often were misread, and highest if those were that were called true most often.
    The bounds are the outer ends of intervals of 97.5 % for these two shares, by `share_of_clusters`, since what is
    said in an episode may all be true or all be false; together they hold with 95 % (Bonferroni). With few texts or
    episodes they are near 0 and 1.

    Sentences that a model read must not be counted here: nothing is known of its errors. The rate is that of plain
    speech; of a teacher that sets traps for the reader it may be greater.

    Args:
        episodes: for each, or for each seed if these are the unit, the sentences that were read, with whether each was
            called false.
        right: readings that were right, of those of different texts whose truth is known.
        known: number of those.
        here: whether the share is that of these sentences alone, of which only the reader's errors are not known.
    """
    called = [Counter((" ".join(text.casefold().split()), false) for text, false in each) for each in episodes]
    every = Counter(itertools.chain(*(each.elements() for each in called)))
    if not every:
        return 0.0, 1.0
    misread = int(binom.ppf(0.9875, len({text for text, _ in every}), _most_often(known - right, known)))
    ends = []
    for end in (0, 1):
        often = Counter({text: count for (text, false), count in every.items() if false != end})
        wrong = {text for text, _ in often.most_common(misread)}
        found = [
            (each.total(), sum(n for (text, false), n in each.items() if (end if text in wrong else false)))
            for each in called
        ]
        share = sum(false for _, false in found) / every.total()
        ends.append(share if here else share_of_clusters(found, 0.975)[end])
    return ends[0], ends[1]


@cache
def _most_often(wrong: int, known: int) -> float:
    """The greatest rate of errors; see `share_false`."""
    return float(binomtest(wrong, known, alternative="less").proportion_ci(0.9875, "exact").high)
