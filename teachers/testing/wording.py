"""Faults of English phrases that a program can find; `check_wording` looks for them in an oracle's phrases."""

import re
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim
from teachers.common import Late
from teachers.phrasebook import Phrasebook
from teachers.testing.pupil import Pupil
from worlds.testing import require

__all__ = ["check_wording", "wording_problems"]

_EACH = 20  # claims of a class that are put into words
_without_quotes = partial(re.compile(r"""\"[^"]*"|(?<!\w)'[^']*'(?!\w)|`[^`]*`""").sub, "...")
_TWO_NUMBERS = re.compile(r"\d\s+[-+]?\d")
_OPENING = re.compile(r"([^?]*\?)\s+\S")
_YOU = re.compile(r"\byour?\b", re.IGNORECASE)
_SOMEBODY = re.compile(r"\b(?:(?:some|any)(?:body|one)|(?:was|were|been) tried|an? earlier)\b", re.IGNORECASE)
_PAST, _FUTURE = (
    re.compile(rf"\b(?:{words})\b", re.IGNORECASE)
    for words in ("was|were|did|had|went|have done|been|last|would have|should have", "now|next|from here")
)
_TENSES = {HP: ("future", _FUTURE), HN: ("future", _FUTURE), FP: ("past", _PAST), FN: ("past", _PAST)}
_ASSERTS = re.compile(
    r"\b(?:see|tell|know|notice|agree|explain|(?:teach|tell) you) (?:that|the|why|how|what|which)\b"
    r"|^(?:why (?:not|is|are|was|were|does|do|did)|what made)\b"
    r"|, (?:when|where|now that|seeing that|since|because|which|although|though)\b",
    re.IGNORECASE,
)


def check_wording(pupil: Pupil) -> None:
    """The phrases of the oracle's claims have none of the `wording_problems`."""
    world = pupil.make_world()
    book = pupil.make_teacher(world).voice
    problems = list(wording_problems(book, _claims(pupil)))
    require(not problems, "phrases that can be misread:\n  " + "\n  ".join(problems))


def _claims(pupil: Pupil) -> Iterator[Claim]:
    """Claims that occur in play, with their counterparts and coarser claims."""
    lab = pupil.make_world().scratch()
    for oracle, moment in pupil.judged():
        claims = oracle.judge(moment) + oracle.clues(moment.after)
        if moment.turn == 0:
            for type_ in oracle.instruction_types:
                claims += oracle.brief(moment.after, type_, np.random.default_rng(0))
        for claim in claims:
            yield from (claim, *claim.counterparts(moment, lab), *claim.coarser(moment, lab))


def wording_problems(book: Phrasebook, claims: Iterable[Claim] = ()) -> Iterator[str]:
    """The faults of the phrases of a book.

    A fault is: a question that does not assert the claim; an opening question that does not address the student, or
    whose tense does not fit the kind; phrases of opposite claims with the same words; and, in the sentences of the
    given claims, two numbers in a row.
    """
    templates = dict(book.items())
    for cls, each in templates.items():
        opposite: type[Claim] | None = getattr(cls, "opposite", None)
        denials = {_bare(other) for other in templates.get(opposite, ())} if opposite else set()
        for template in each:
            yield from (f"{cls.__name__}: {template!r} {problem}" for problem in _faults(cls, template))
            if opposite and _bare(template) in denials:
                yield f"{cls.__name__}: {template!r} has the same words as a phrase of its opposite {opposite.__name__}"
    said: dict[type[Claim], set[Claim]] = {}
    for claim in claims:
        known = said.setdefault(type(claim), set())
        if claim in known or len(known) >= _EACH or type(claim) not in templates:
            continue
        known.add(claim)
        for text in book.sentences(claim):
            if _TWO_NUMBERS.search(_without_quotes(text)):
                yield f"{type(claim).__name__}: {text!r} has two numbers in a row"


def _faults(cls: type[Claim], template: str) -> Iterator[str]:
    if cls is Late and not _PAST.search(template):
        yield "does not say that its turn is past"
    if (kind := cls.kind) not in _TENSES:
        return
    bare = _without_quotes(template)
    if opening := _OPENING.match(bare):
        tense, words = _TENSES[kind]
        if not _YOU.search(opening[1]):
            yield "opens with a question that does not speak of the student as you"
        if words.search(opening[1]):
            yield f"opens with a question in the {tense} tense"
        if _SOMEBODY.search(bare):
            yield "opens with a question and speaks of somebody else than the student"
    elif bare.endswith("?") and not _ASSERTS.search(bare):
        yield "asks and does not assert"


def _bare(template: str) -> tuple[Any, ...]:
    """The words of a template, whatever their order."""
    return tuple(sorted(re.findall(r"\{[^}]*\}|[\w'-]+", template.lower())))
