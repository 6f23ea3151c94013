"""Every phrase of every voice, with the values of a claim, is read back as that claim; what is not is listed."""

import contextlib
from collections import defaultdict

import pytest

from pz_envs.checking import ClaimReader
from pz_envs.family import own_families
from teachers.atoms import Moment
from teachers.templates import Template
from teachers.testing import Pupil
from teachers.voice import voice_names

pytestmark = pytest.mark.full
FAMILIES = ("bandits", "gridworld", "optimization", "poem")
ABSTAINS = {"poem": {"Shorten", "Write"}}
"""Per family the claims that some phrases do not read back: their words leave out what the claim has."""


def said(family, vocabulary, turns=200):
    """A claim of each class that occurs in random play, or needs no more than an action, with its moment."""
    options = family.environments[family.showcase[0]]
    turns = max(turns // 20, 1) if family.slow else turns
    pupil = Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns, turns=turns)
    found = {}
    for oracle, moment in pupil.judged():
        for claim in (*oracle.judge(moment), *oracle.clues(moment.after)):
            for each in (claim, *claim.coarser(moment, oracle.lab), *claim.counterparts(moment, oracle.lab)):
                if type(each) in vocabulary.classes.values():
                    found.setdefault(type(each), (each, moment))
        if moment.before is not None:
            for name, cls in vocabulary.classes.items():
                with contextlib.suppress(ValueError):  # it has other fields
                    found.setdefault(cls, (vocabulary.claim_of({"type": name}, moment), moment))
    return found


@pytest.mark.parametrize(
    "family", [each for each in own_families() if each.name in FAMILIES], ids=lambda each: each.name
)
def test_phrases_are_read_back(family):
    world = family.make_world(**family.environments[family.showcase[0]])
    vocabulary, reader = family.vocabulary(world), ClaimReader(family, world)
    wrong, unread, right = defaultdict(list), defaultdict(list), 0
    for cls, (claim, moment) in said(family, vocabulary).items():
        phrases = dict.fromkeys(each for voice in voice_names() for each in family.phrasebook(voice).templates(cls))
        for phrase in phrases:
            text = Template(phrase).format(claim)
            reader.see(Moment.opening(moment.after))
            reader.see(moment._replace(turn=1))
            found = [each.claim for each in reader.read(text) if each.claim is not None]
            if found == [claim] or [Template(phrase).format(each) for each in found if type(each) is cls] == [text]:
                right += 1  # a number may be rounded in the phrase
            else:
                (wrong if found else unread)[cls.__name__].append((text, found))
    print(family.name, right, {name: len(each) for name, each in unread.items()})
    assert not wrong
    assert set(unread) == ABSTAINS.get(family.name, set()), unread
    assert right > 100
