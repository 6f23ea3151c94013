"""Readers of what people and models say to a student."""

from functools import cache

from pz_envs.family import own_families
from pz_envs.subject import Subject
from teachers.near import load_synonyms
from teachers.reading import LayeredReader, own_phrases
from teachers.schema import Vocabulary


@cache
def known_phrases() -> tuple[tuple[str, str, str], ...]:
    """The phrases of this distribution's families: family, phrase, and the kind of its claim."""
    found = []
    for family in own_families():
        classes = Vocabulary(family.oracle_class().claims()).classes
        for name, phrases in own_phrases(family.phrasebook, classes).items():
            found += [(family.name, phrase, f"{classes[name].kind}") for phrase in phrases]
    return tuple(found)


def make_reader(subject: Subject, vocabulary: Vocabulary | None = None) -> LayeredReader:
    """The reader of a subject's sentences; it takes about a second to learn the phrases.

    Args:
        subject: what is taught.
        vocabulary: its claims; None: those of its oracle.
    """
    classes = (vocabulary or subject.vocabulary()).classes
    others = [(phrase, kind) for family, phrase, kind in known_phrases() if family != subject.name]
    return LayeredReader(subject.phrasebook, classes, load_synonyms(subject.name), others=others)
