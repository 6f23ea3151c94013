"""What is read of an episode's words is checked where the truth is known."""

import numpy as np
import pytest

from llf_teacher.registry import PREFIX, entry
from pz_envs.family import own_families
from pz_envs.text.claims import EXACT, ClaimReader
from teachers.common import Late, Probably
from teachers.session import Session
from teachers.voice import voice_names

QUICK = ("bandits", "gridworld", "movies", "optimization", "poem")
GRID = entry("llf-gridworld-v0").family


def played(family, teacher="oracle", said=None, seed=0, turns=4):
    """What becomes of the sentences of a lesson: those of the teacher, or those that are given, turn by turn."""
    world = family.make_world(**entry(PREFIX + family.showcase[0]).options)
    session = Session(world, [family.make_teacher(world, teacher)], max_turns=family.max_turns, instructs=True)
    reader, rng = ClaimReader(family, world, session.teacher.oracle), np.random.default_rng(seed)
    session.open(seed)
    found = []
    while True:
        session.speak()
        reader.see(session.moment, session.teacher_turns[0].claims())
        words = session.feedback if said is None else said[session.moment.turn]
        found += reader.read(str(words))
        if session.over or session.moment.turn == (turns if said is None else len(said) - 1):
            return found
        session.act(world.legal(world.sample_action(rng)) if said is None else 2 if session.moment.turn else 3)


@pytest.mark.parametrize("family", [each for each in own_families() if each.name in QUICK], ids=lambda each: each.name)
def test_honest_teachers_say_nothing_false_and_liars_nothing_true(family):
    honest = played(family)
    assert [each for each in honest if each.holds is False] == []
    assert sum(each.holds is True for each in honest) >= 5
    assert {each.layer for each in honest if each.holds} == {EXACT}
    lied = played(family, "mistake(eps=1)")
    assert sum(each.holds is False for each in lied) >= 3
    assert [each for each in lied if each.holds] == []


def test_the_turn_that_a_sentence_names_is_the_one_checked():
    first = "You should not have gone south in kitchen-2. It did not bring you closer to the treasure."
    late = next(phrase for phrase in GRID.phrasebook().templates(Late) if phrase.endswith("{text}"))
    hedged = next(phrase for phrase in GRID.phrasebook().templates(Probably) if phrase.endswith("{text}"))
    said = [first, late.format(turn=1, text=first), late.format(turn=7, text=first)]
    found = played(GRID, said=["", "", *said, hedged.format(percent=80, text=first)])
    assert [each.outcome for each in found] == ["false", "true", "unbuilt", "hedged"]
    assert [each.holds for each in found] == [False, True, None, None]


@pytest.mark.parametrize("name", ["gridworld", "bandits"])
def test_phrases_of_claims_that_nobody_can_state_are_no_error(name):
    """A truism stands in for other claims, and has no form in JSON."""
    family = next(each for each in own_families() if each.name == name)
    reader = ClaimReader(family, family.make_world())
    reader.did(None, 0)
    found = list(reader.read("As everybody knows, the sky is blue. What a nice day."))
    assert [each.outcome for each in found] == ["unbuilt", "not read"]
    for voice in voice_names():
        for _, phrases in family.phrasebook(voice).items():
            for phrase in phrases:
                assert list(reader.read(phrase)), phrase


def test_what_is_no_phrase_is_not_read_and_has_no_claim():
    """A verdict in our words is checked; what a person means by others is not guessed."""
    said = ["", "Now head south. Keep your hands off the north door. What a nice day. Now head esat."]
    found = played(GRID, said=said)
    assert [each.outcome for each in found] == ["false", "not read", "not read", "unbuilt"]
    assert [each.claim is None for each in found] == [False, True, True, True]
