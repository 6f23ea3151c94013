"""What people and models say in an episode: its sentences are read, made into claims, and checked in the simulator."""

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import Any, NamedTuple

from pz_envs.reading import build_claim, make_reader, said_by
from pz_envs.subject import Subject
from teachers.atoms import Claim, Moment
from teachers.oracle import Oracle
from teachers.reading import Reader, SentenceReading, read_sentences
from teachers.schema import LONGEST_TEXT, Vocabulary, holds, sentences_of
from worlds.world import World

__all__ = ["EXACT", "MODEL", "NOT_READ", "UNBUILT", "CheckedSentence", "ClaimReader", "Model"]

EXACT, MODEL = "exact", "model"
"""How a sentence is read: it is word for word a phrase of ours, or a model reads it."""
TRUE, FALSE, BUILT, UNBUILT, HEDGED, NOT_READ = "true", "false", "built", "unbuilt", "hedged", "not read"
"""What can become of a sentence: its claim is true, or false, or there is no truth to check it by; no single claim says
it, or its claim cannot be checked; it only hedges a claim; it is not read.
"""
MOST_SENTENCES = 256
"""The most sentences of a text that are read, and `LONGEST_TEXT` the most characters; the rest is not read."""
Model = Callable[[str, Vocabulary], Any]
"""Gets a sentence that is no phrase, and what can be said, which has no episode, and answers as `Vocabulary.read` takes
it. It reads the sentence if its answer has one claim and no problem.
"""


class CheckedSentence(NamedTuple):
    """A sentence with what became of it."""

    text: str
    layer: str
    """How it was read, `EXACT` or `MODEL`; empty: there is no claim."""
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

    Whatever is said, nothing is executed, and time and memory are bounded.

    Args:
        subject: what is taught.
        world: one of its options, which decide what actions there are.
        oracle: follows the episode; None: for a student, who has no truth, so that no claim is checked.
        model: is asked for sentences that are no phrases, or of which these do not make a single claim.
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
    def _reader(self) -> Reader:
        return make_reader(self._subject)

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
        readings = read_sentences(self._reader, kept)
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
        if reading.claim is not None and reading.hedged:
            return self._without(reading.text, HEDGED, reading.claim.__name__)
        if reading.claim is not None:
            built = build_claim(reading, self._subject, self._vocabulary, moment)
            if built.claim is not None:
                return self._judged(reading, EXACT, built.claim, about, own)
            if self._model is None:
                return self._without(reading.text, UNBUILT, *built.candidates)
        if self._model is None:
            return self._without(reading.text, NOT_READ)
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
