"""The teacher: what it says when, what its settings bound, and that an episode can be repeated and copied."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from design import amount, sampled
from lessons import pupil
from shelf import COMPLETE, FAMILIES, RICH, lightest, pairs

from teachers.atoms import FN, FP, KINDS, SILENCE, Moment, ParseFailure, Utterance
from teachers.common import NotUnderstood

on_every_family = pytest.mark.parametrize("name", FAMILIES)
on_complete_families = pytest.mark.parametrize("name", COMPLETE)


def make(name, personality="oracle", turns=40, **settings):
    """A teacher and the moments of random play over two episodes or so."""
    short = replace(pupil(name), turns=turns)
    world = short.make_world()
    teacher = short.make_teacher(world, personality, **settings)
    return teacher, list(short.moments(world))


def begun(name, *args, seed=0, **settings):
    """A teacher that has opened the first episode, its words, and the moments that follow."""
    teacher, moments = make(name, *args, **settings)
    teacher.reset(np.random.default_rng(seed))
    return teacher, teacher.speak(moments[0]), moments[1:]


def talk(teacher, moments, seed=0):
    rng = np.random.default_rng(seed)
    said = []
    for moment in moments:
        if moment.turn == 0:
            teacher.reset(rng.spawn(1)[0])
        said.append(teacher.speak(moment))
    return said


def failure(moment, expected, over=False):
    return Moment(None, ParseFailure("jump!", expected), 0.0, moment.after, False, moment.turn + 1, over)


def claims(said):
    return [atom.claim for atom in said.atoms]


@on_complete_families
def test_the_opening_is_the_instruction_and_then_advice(name):
    _, said, _ = begun(name)
    kinds = [atom.kind for atom in said.atoms]
    instruction = kinds.count(None)
    assert instruction >= 2
    assert kinds[:instruction] == [None] * instruction
    assert kinds[instruction:] == [FP, FN]
    assert said == " ".join(atom.text for atom in said.atoms)
    assert {atom.about_turn for atom in said.atoms} == {0}


@on_every_family
def test_open_gives_the_instruction_alone(name):
    teacher, moments = make(name)
    teacher.reset(np.random.default_rng(0))
    assert {atom.kind for atom in teacher.open(moments[0]).atoms} == {None}


@on_every_family
def test_advice_ends_with_the_episode(name):
    teacher, _, moments = begun(name)
    last = moments[-1]._replace(over=True)
    said = teacher.speak(last)
    assert said
    assert not {FP, FN} & {atom.kind for atom in said.atoms}


@on_every_family
def test_who_says_nothing_asks_nothing_until_somebody_wants_to_know(name, monkeypatch):
    teacher, _, moments = begun(name, "delayed(turns=2) | silent")
    asked, judge = [], teacher.oracle.judge
    monkeypatch.setattr(teacher.oracle, "judge", lambda moment, kinds: asked.append(moment) or judge(moment, kinds))
    assert teacher.speak(moments[0]) == SILENCE
    assert not asked
    assert teacher.offered == judge(moments[0], teacher.kinds) != ()
    teacher, said, _ = begun(name, "silent | delayed(turns=2)")
    assert said.atoms
    assert not any(atom.kind for atom in said.atoms)


@on_every_family
@pytest.mark.parametrize("settings", [{}, {"feedback_type": "n"}, {"personality": "silent"}, {"feedback_type": "m"}])
def test_a_text_that_is_no_action_is_always_answered(name, settings):
    teacher, _, moments = begun(name, **settings)
    expected = teacher.oracle.lab.action_syntax
    moment = failure(moments[0], expected)
    said = teacher.speak(moment)
    notice, *rest = said.atoms
    assert notice.claim == NotUnderstood(got="jump!", expected=expected, why=moment.action.why)
    assert notice.claim.holds(moment, teacher.oracle.lab)
    assert "jump!" in notice.text
    assert expected in notice.text
    assert moment.action.why in notice.text
    assert {atom.kind for atom in rest} <= {FP, FN}
    assert rest or settings


@on_every_family
def test_after_the_last_text_that_is_no_action_there_is_no_advice(name):
    teacher, _, moments = begun(name)
    said = teacher.speak(failure(moments[0], teacher.oracle.lab.action_syntax, over=True))
    assert [type(claim) for claim in claims(said)] == [NotUnderstood]


@on_every_family
def test_an_instruction_type_takes_effect_at_the_next_opening(name):
    teacher, moments = make(name)
    teacher.reset(np.random.default_rng(0))
    last = teacher.oracle.instruction_types[-1]
    teacher.instruction_type = last
    assert teacher.instruction_type == last
    assert claims(teacher.open(moments[0])) == claims(begun(name, instruction_type=last, feedback_type="n")[1])


@pytest.mark.parametrize("value", ["", "d", "B", "bp", None, 5, ["b"]])
def test_other_instruction_types_are_refused(value):
    teacher, _ = make("bandits")
    with pytest.raises(ValueError, match=r"instruction type .* is not supported; allowed: b, p, c"):
        teacher.instruction_type = value
    assert teacher.instruction_type == "b"
    with pytest.raises(ValueError, match=r"instruction type .* is not supported"):
        make("bandits", instruction_type=value)


@pytest.mark.parametrize("value", ["", "x", "r+x", None, ["a"]])
def test_other_feedback_types_are_refused(value):
    teacher, _ = make("bandits", feedback_type="hp")
    with pytest.raises(ValueError, match="feedback type"):
        teacher.feedback_type = value
    assert teacher.feedback_type == "hp"
    with pytest.raises(ValueError, match="feedback type"):
        make("bandits", feedback_type=value)


@pytest.mark.parametrize("value", ["Random", None, 1.5, True])
def test_other_ways_to_paraphrase_are_refused(value):
    teacher, _ = make("bandits", paraphrase=3)
    with pytest.raises(ValueError, match="paraphrase must be"):
        teacher.paraphrase = value
    assert teacher.paraphrase == 3


@pytest.mark.parametrize(("value", "text"), [(["fn", "r"], "r+fn"), ({"hp"}, "hp"), ((), "n"), ("m", "m"), ("a", "a")])
def test_the_feedback_type_reads_as_files_hold_it(value, text):
    teacher, _ = make("bandits", feedback_type=value)
    assert teacher.feedback_type == text


@on_complete_families
@pytest.mark.parametrize("personality", ["oracle", "mistake"])
@pytest.mark.parametrize(("value", "kinds"), [("r+fp", {"r", FP}), ("n", set()), ("m", set(KINDS))])
def test_a_feedback_type_takes_effect_within_an_episode(name, personality, value, kinds):
    teacher, _, moments = begun(name, personality)
    teacher.feedback_type = value
    for moment in moments[:5]:
        assert {claim.kind for claim in claims(teacher.speak(moment))} <= kinds


@on_complete_families
@pytest.mark.parametrize("personality", ["oracle", "only(kinds='r+hp+hn+fp+fn')"])
def test_feedback_type_m_draws_the_kinds_of_each_turn(name, personality):
    teacher, _, moments = begun(name, personality, feedback_type="m")
    honest, _, _ = begun(name)
    richest = 0, moments[0]
    for moment in moments[:15]:
        said, true = claims(teacher.speak(moment)), claims(honest.speak(moment))
        kinds = {claim.kind for claim in said}
        assert said == [claim for claim in true if claim.kind in kinds]
        richest = max(richest, (len({claim.kind for claim in true}), moment), key=lambda each: each[0])
    assert len({tuple({c.kind: 0 for c in claims(teacher.speak(richest[1]))}) for _ in range(30)}) > 8


def test_a_paraphrase_takes_effect_at_once():
    teacher, _, moments = begun("bandits", feedback_type="r")
    templates = teacher.voice.templates(type(teacher.oracle.judge(moments[0])[0]))
    for i, template in enumerate(templates):
        teacher.paraphrase = i
        assert teacher.speak(moments[0]) == template.format(reward=moments[0].reward)


def test_nothing_to_say_is_silence():
    teacher, _, moments = begun("bandits", feedback_type="n")
    said = teacher.speak(moments[0])
    assert said == SILENCE == ""
    assert type(said) is Utterance


@on_every_family
def test_in_the_seat_it_says_what_it_says_of_the_moment(name):
    (seated, opening, moments), (alone, _, _) = begun(name), begun(name)
    assert opening
    for moment in moments[:5]:
        assert seated.act(None, {"moment": moment}) == alone.speak(moment)


@sampled(lambda name, personality, settings: {name, personality, str(settings)})
@pytest.mark.parametrize(("name", "personality"), pairs(names=RICH, spec=lightest))
@pytest.mark.parametrize("settings", [{}, {"instruction_type": "p", "feedback_type": "m"}], ids=["plain", "drawn"])
def test_the_same_stream_gives_the_same_episodes(name, personality, settings):
    turns = amount(8, full=40) if "worlds=" in personality else 40  # each of which draws many
    teacher, moments = make(name, personality, turns, **settings)
    first = talk(teacher, moments)
    assert talk(teacher, moments) == first == talk(make(name, personality, **settings)[0], moments)
    assert talk(teacher, moments, seed=1) != first


def test_a_copy_and_its_original_do_not_share_their_streams():
    teacher, _, moments = begun("bandits", "mistake(eps=0.5)")
    twin = copy.deepcopy(teacher)
    expected = [copy.deepcopy(teacher).speak(moments[0])]
    for _ in range(5):
        teacher.speak(moments[0])
    assert [twin.speak(moments[0])] == expected


def test_a_negative_zero_is_said_as_zero_whoever_came_first():
    teacher, _, moments = begun("bandits", feedback_type="r")
    teacher.paraphrase = 0
    said = {str(teacher.speak(moments[0]._replace(reward=reward))) for reward in (-0.0, 0.0, -0.0)}
    assert len(said) == 1
    assert "-0" not in said.pop()
