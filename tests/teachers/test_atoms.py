"""Utterances are strings that carry atoms; claims are plain frozen values."""

import copy
import dataclasses
import pickle
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pz_envs.family import all_families
from teachers import common
from teachers.atoms import (
    HN,
    HP,
    KINDS,
    SILENCE,
    Atom,
    Claim,
    FeedbackType,
    Label,
    Moment,
    R,
    Utterance,
    Verdict,
    action_of,
    claim,
    confidence,
    contradictions,
    opposed,
    unhedged,
)
from teachers.common import Late, Probably, Reward, Right, Solved, TryAgain, hedge
from teachers.oracle import claims_of

FAMILY_CLAIMS = {family.name: family.oracle_class().claims() for family in all_families()}
CLAIMS = {**FAMILY_CLAIMS, "common": claims_of(common.__name__)}
ATOM = Atom(Reward(reward=0.5), "You get 0.5.", 3)
COPIES = [copy.copy, copy.deepcopy, *(lambda value, p=p: pickle.loads(pickle.dumps(value, p)) for p in range(6))]


def some(cls, value=1):
    """An instance with the same value in every field; the types of fields are not checked by claims, but for hedges."""
    if cls is Probably:
        return cls(claim=Solved(), p=0.5 + value / 10)
    return cls(**{field.name: value for field in dataclasses.fields(cls)})


def test_an_utterance_is_its_text():
    said = Utterance("Well done.", (ATOM,))
    assert isinstance(said, str)
    assert said == "Well done."
    assert hash(said) == hash("Well done.")
    assert f"{said}" == str(said) == "Well done."
    assert {"Well done.": 1}[said] == 1
    assert said.atoms == (ATOM,)


def test_an_utterance_of_atoms_joins_their_texts():
    said = Utterance.of([ATOM, Atom(TryAgain(), "Try again.", 3)])
    assert said == "You get 0.5. Try again."
    assert [atom.kind for atom in said.atoms] == ["r", "hn"]


def test_silence_says_nothing():
    assert SILENCE == Utterance() == Utterance.of([]) == ""
    assert SILENCE.atoms == ()
    assert not SILENCE


@given(text=st.text(), copied=st.sampled_from(COPIES))
def test_copies_of_an_utterance_keep_text_and_atoms(text, copied):
    said = Utterance(text, (ATOM, Atom(TryAgain(), text, 0)))
    twin = copied(said)
    assert type(twin) is Utterance
    assert twin == said
    assert twin.atoms == said.atoms


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_an_utterance_is_copied_as_itself(copied):
    said = Utterance("Well done.", (ATOM,))
    assert copied(said) is said
    assert copied([said])[0] is said


def test_kinds_are_in_speaking_order():
    assert [str(kind) for kind in KINDS] == ["r", "hp", "hn", "fp", "fn"]
    assert R == "r"


@pytest.mark.parametrize("home", CLAIMS)
def test_claims_say_when_they_are_true(home):
    for cls in CLAIMS[home]:
        assert issubclass(cls, Claim)
        assert cls is Late or cls.__doc__.startswith("Neither true nor false" if cls is Probably else "True "), cls
        assert cls.holds is not Claim.holds or cls is Late, cls


@pytest.mark.parametrize("home", FAMILY_CLAIMS)
def test_claims_are_filed_by_their_class(home):
    for cls in FAMILY_CLAIMS[home]:
        assert cls.kind is None or type(cls.kind) is FeedbackType, cls
        assert some(cls).kind is cls.kind


def test_every_family_has_claims_of_every_kind_that_it_gives_and_of_none():
    for family in all_families():
        oracle = family.oracle_class()
        assert {cls.kind for cls in oracle.claims()} | {Reward.kind} == {None, *oracle.feedback_types}, family.name


@pytest.mark.parametrize("home", CLAIMS)
def test_claims_are_keyword_only(home):
    for cls in CLAIMS[home]:
        fields = dataclasses.fields(cls)
        assert all(field.kw_only for field in fields), cls
        with pytest.raises(TypeError, match="positional argument"):
            pytest.fail(f"{cls(*[1] * max(len(fields), 1))}")


@pytest.mark.parametrize("home", CLAIMS)
def test_claims_are_frozen_slotted_hashable_values(home):
    for cls in CLAIMS[home]:
        claim = some(cls)
        for field in dataclasses.fields(cls):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(claim, field.name, 2)
        assert not hasattr(claim, "__dict__"), cls
        assert claim == some(cls)
        assert hash(claim) == hash(some(cls))
        if dataclasses.fields(cls):
            assert claim != some(cls, 2)
        assert copy.deepcopy(claim) == pickle.loads(pickle.dumps(claim)) == claim


def test_claims_of_different_classes_differ():
    classes = [cls for home in CLAIMS.values() for cls in home]
    assert len({some(cls) for cls in classes}) == len(classes)


def test_a_late_claim_has_the_kind_of_what_it_says():
    assert Late(claim=Solved(), turn=2).kind == "hp"
    assert Late(claim=TryAgain(), turn=2).kind == "hn"


def test_a_claim_that_does_not_say_when_it_holds_cannot_be_checked():
    with pytest.raises(TypeError, match=r"Claim does not implement holds\(moment, lab\)"):
        Claim().holds(Moment.opening(None), None)


@claim
class _Counted(Verdict):
    before: int
    after: int

    def applies(self, moment, lab):
        return self.before != self.after

    def good(self, moment, lab):
        return self.before < self.after


@claim
class More(_Counted):
    """True if there are more than before."""

    kind = HP


@claim
class Fewer(_Counted):
    """True if there are fewer than before."""

    kind = HN


opposed(More, Fewer)
OPENING = Moment.opening(None)


def test_of_opposite_verdicts_one_holds_if_they_apply():
    assert More(before=1, after=2).holds(OPENING, None)
    assert not Fewer(before=1, after=2).holds(OPENING, None)
    assert Fewer(before=2, after=1).holds(OPENING, None)
    assert not More(before=2, after=1).holds(OPENING, None)
    assert not any(cls(before=1, after=1).holds(OPENING, None) for cls in (More, Fewer))


class _Bare(Claim):
    depth: int
    heights: ClassVar[int] = 3


def test_a_base_whose_fields_would_be_lost_is_refused():
    with pytest.raises(
        TypeError, match=r"the base \S*test_atoms\._Bare of Deep lacks the decorator @claim; write @claim"
    ):

        @claim
        class Deep(_Bare):
            pass

    @claim
    class Known(_Bare):
        depth: int

    assert Known(depth=2).depth == 2


def test_a_kind_that_is_none_is_refused():
    with pytest.raises(
        TypeError, match=r"Typed\.kind is 'fp'; allowed: R, HP, HN, FP, FN of teachers\.atoms, and None"
    ):

        @claim
        class Typed(Claim):
            kind = "fp"


def test_the_counterpart_of_a_verdict_is_the_opposite_one():
    assert More(before=1, after=2).counterparts(OPENING, None) == (Fewer(before=1, after=2),)
    assert Fewer(before=2, after=1).counterparts(OPENING, None) == (More(before=2, after=1),)
    assert More(before=1, after=2).opposing(after=0) == Fewer(before=1, after=0)


@pytest.mark.parametrize(
    ("method", "message"),
    [
        ("applies", r"Verdict does not implement applies\(moment, lab\)"),
        ("good", r"Verdict does not implement good\(moment, lab\)"),
    ],
)
def test_a_verdict_says_what_it_is_about_and_what_is_good(method, message):
    with pytest.raises(TypeError, match=message):
        getattr(Verdict(), method)(OPENING, None)


def test_there_is_no_past_where_no_action_was_executed():
    with pytest.raises(
        ValueError, match="no action was executed in turn 3; use `past` only where `before` is not None"
    ):
        _ = Moment.opening("here", 3).past
    assert OPENING._replace(before="there").past == "there"


@claim
class Walk(Claim):
    """True if these steps lead so far."""

    length: float
    steps: tuple[tuple[float, ...], ...] = ()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("length", np.float64(0.5)),
        ("length", np.int64(3)),
        ("length", np.float32(0.5)),
        ("length", np.bool_(True)),
        ("length", np.array(0.5)),
        ("steps", ((0.5,), (0.5, np.float64(0.5)))),
        ("steps", np.zeros((2, 2))),
    ],
)
def test_a_claim_holds_no_numbers_of_numpys(name, value):
    assert Walk(length=0.5, steps=((0.5, 1.0),)) == Walk(length=0.5, steps=((0.5, 1.0),))
    with pytest.raises(TypeError, match=rf"(?s)the field '{name}' of the claim Walk holds .*; allowed: str, int"):
        Walk(**{"length": 0.5, name: value})


def test_a_hedge_has_the_kind_and_the_action_of_what_it_hedges_and_a_probability_as_it_is_said():
    praise = Right.on((), action=3)
    said = hedge(praise, 0.9371)
    assert (said.p, said.percent, said.kind, action_of(said)) == (0.94, 94, "hp", 3)
    assert unhedged(said) is praise is unhedged(praise)
    assert (confidence(said), confidence(praise)) == (0.94, 1)
    assert [hedge(praise, p).p for p in (0.5001, 0.9999)] == [0.51, 0.99]
    assert hedge(said, 0.6) == hedge(praise, 0.6)
    assert hedge(Late(claim=praise, turn=2), 0.6) == Late(claim=hedge(praise, 0.6), turn=2)
    twin = pickle.loads(pickle.dumps(said))
    assert twin == said
    assert twin.claim._ground == ()


@pytest.mark.parametrize("p", [0.5, 1, 0.0, float("nan")])
def test_a_probability_lies_between_a_half_and_1(p):
    with pytest.raises(ValueError, match=r"p must be above 0\.5 and below 1"):
        hedge(Solved(), p)


@pytest.mark.parametrize("claim", [Late(claim=Solved(), turn=1), hedge(Solved(), 0.8)])
def test_only_a_flat_claim_is_hedged(claim):
    with pytest.raises(ValueError, match="a hedge needs a flat claim that is not late"):
        Probably(claim=claim, p=0.8)


def test_a_hedge_is_neither_true_nor_false_and_excludes_what_its_claim_excludes():
    now = Moment.opening(0)._replace(before=0, action=1)
    for flat, holds in ((TryAgain(), True), (Solved(), False)):
        said = hedge(flat, 0.8)
        assert Atom(said, "", 0).label([now], None) is Label.HEDGED
        assert said.holds(now, None) is holds
        (other,) = said.counterparts(now, None)
        assert other == hedge(flat.counterparts(now, None)[0], 0.8)
        pair = [Atom(said, "", 0), Atom(other.claim, "", 0)]
        assert len(contradictions(pair)) == len(contradictions([Atom(each.claim, "", 0) for each in (said, other)]))
        assert not contradictions([Atom(said, "", 0), Atom(flat, "", 0)])
