"""Reads what people and models say in an episode into claims, and checks the claims in the simulator."""

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import Any, NamedTuple

from pz_envs.text.claim_building import Language, build_claim, make_reader, said_by
from pz_envs.text.phrases import Reader, SentenceReading, read_sentences
from teachers.atoms import Claim, Moment
from teachers.oracle import Oracle
from teachers.schema import LONGEST_TEXT, Vocabulary, holds, sentences_of
from worlds.world import World

__all__ = ["EXACT", "MODEL", "NOT_READ", "UNBUILT", "CheckedSentence", "ClaimReader", "Model"]

EXACT, MODEL = "exact", "model"
"""How a sentence is read: it is word for word a phrase, or a model reads it."""
TRUE, FALSE, BUILT, UNBUILT, HEDGED, NOT_READ = "true", "false", "built", "unbuilt", "hedged", "not read"
"""Outcomes of a sentence: its claim is true; false; built, but there is no truth to check it by; unbuilt, since no
single claim says the sentence or its claim cannot be checked; hedged, since it only hedges a claim; not read.
"""
MOST_SENTENCES = 256
"""The most sentences that are read of a text; `LONGEST_TEXT` bounds the characters."""
Model = Callable[[str, Vocabulary], Any]
"""Gets a sentence that is no phrase and the vocabulary, without an episode; returns a message for `Vocabulary.read`.
The sentence is read if the message has one claim and no problem.
"""


class CheckedSentence(NamedTuple):
    """A sentence and its outcome."""

    text: str
    layer: str
    """How the sentence was read, `EXACT` or `MODEL`; empty: there is no claim."""
    claim: Claim[Any] | None
    about_turn: int
    """The turn that the sentence is about."""
    outcome: str
    """One of `TRUE`, `FALSE`, `BUILT`, `UNBUILT`, `HEDGED`, `NOT_READ`."""
    candidates: tuple[str, ...] = ()
    """Without a claim: the nearest claims, or why there is none."""

    @property
    def holds(self) -> bool | None:
        """Whether the claim is true; None: it was not checked."""
        return {TRUE: True, FALSE: False}.get(self.outcome)


class ClaimReader:
    """Reads the sentences of an episode into claims, and checks them where the truth is known.

    Nothing is ever executed, and time and memory are bounded.

    Args:
        subject: what is taught.
        world: a world with the options of the episode, which decide the actions.
        oracle: follows the episode; None: a student reads, which has no truth, so that no claim is checked.
        model: reads sentences that are no phrase, or that do not make a single claim by the phrase.
    """

    def __init__(
        self,
        subject: Language,
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
        """Note the next turn; turn 0 begins another episode.

        Args:
            moment: the turn; a student's only has its action, as `did` makes it.
            own: the oracle's claims of the turn. A number that is rounded as in their phrases is true if the claim is.
        """
        if not moment.turn:
            vars(self).pop("_reader", None)  # it begins with the voice that it met last
        self._moments[moment.turn :] = [(moment, tuple(own))]

    def did(self, action: Any, turn: int) -> None:
        """Note a student's next turn: its action in canonical form; None at the opening, turn 0."""
        acted = None if action is None else ()
        self.see(Moment(acted, action, 0.0, (), False, turn, False))

    def read(self, text: str) -> Iterator[CheckedSentence]:
        """The sentences of a text from the last turn, in order."""
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
        """A sentence with its claim, checked if there is an oracle."""
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
