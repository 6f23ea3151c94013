"""Personalities do what their definitions say, at the rates that they name, on every family."""

from collections import Counter
from dataclasses import replace
from functools import cache, lru_cache
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from design import COSTLY, amount, sampled
from lessons import ALPHA, fits, lab, pupil
from scipy.stats import chisquare
from shelf import FAMILIES, RICH, lightest, pairs

from teachers.atoms import KINDS, Moment, ParseFailure, contradictions
from teachers.common import Right, Solved, Truism, TryAgain, Wrong
from teachers.personalities.mistake import mistake

TURNS, FEW, FEWEST = amount(480, full=800), amount(90, full=150), 20


def length(name):
    """Turns of random play."""
    return TURNS // amount(4, full=1) if name in COSTLY else TURNS


@cache
def play(name):
    """Episodes of random play, each a list of moments; no teacher changes them."""
    episodes = []
    for moment in replace(pupil(name), turns=length(name)).moments(pupil(name).make_world()):
        if moment.turn == 0:
            episodes.append([])
        episodes[-1].append(moment)
    return episodes


@lru_cache(maxsize=50_000)
def holds(name, claim, moment):
    """Whether it does; most of what is said is said by many personalities, and some of it takes long to check."""
    return claim.holds(moment, lab(name))


@lru_cache(maxsize=32)  # the words of hundreds of teachers take much memory
def heard(name, personality="oracle", feedback_type="a", instruction_type="b", turns=TURNS):
    """What a teacher says in these episodes: per episode and turn an utterance."""
    teacher = pupil(name).make_teacher(
        pupil(name).make_world(), personality, feedback_type=feedback_type, instruction_type=instruction_type
    )
    rng = np.random.default_rng(0)
    said = []
    for episode in play(name):
        teacher.reset(rng.spawn(1)[0])
        said.append([teacher.speak(moment) for moment in episode])
        if sum(map(len, said)) - len(said) >= turns:
            break
    return said


def turns(name, *personalities, **settings):
    """The feedback of some teachers on each turn, as one tuple of claims for each, and the turn's moment."""
    taught = [heard(name, personality, **settings) for personality in personalities]
    for episode, *utterances in zip(play(name), *taught, strict=False):
        for moment, *said in zip(episode, *utterances, strict=True):
            yield moment, *(tuple(atom.claim for atom in each.atoms if atom.kind is not None) for each in said)


def feedback(name, personality, **settings):
    """Every atom of feedback, with the moment that it is about."""
    for episode, utterances in zip(play(name), heard(name, personality, **settings), strict=False):
        for said in utterances:
            yield from ((atom, episode[atom.about_turn]) for atom in said.atoms if atom.kind is not None)


def texts(name, personality, **settings):
    return [[str(said) for said in utterances] for utterances in heard(name, personality, **settings)]


on_every_family = pytest.mark.parametrize("name", RICH)


@on_every_family
def test_oracle_says_all_that_its_oracle_knows(name):
    oracle = pupil(name).make_teacher(lab(name)).oracle
    for moment, said in turns(name, "oracle"):
        if moment.turn == 0:
            oracle.start(moment.after)
        assert said == oracle.judge(moment)


@sampled(lambda name, kinds: {name, kinds})
@on_every_family
@pytest.mark.parametrize("kinds", ["r", "hp", "hn", "fp", "fn", "hp+fn", "r+hp+hn", "r+hp+hn+fp+fn"])
def test_only_says_the_oracles_claims_of_its_kinds(name, kinds):
    count = 0
    for _, said, true in turns(name, f"only(kinds={kinds!r})", "oracle"):
        assert said == tuple(claim for claim in true if claim.kind in kinds.split("+"))
        count += len(said)
    assert count > 20


@on_every_family
def test_mix_says_all_claims_of_some_kinds(name):
    for _, said, true in turns(name, "mix", "oracle"):
        kinds = {claim.kind for claim in said}
        assert said == tuple(claim for claim in true if claim.kind in kinds)


@sampled(lambda name, wanted: {name, wanted})
@on_every_family
@pytest.mark.parametrize("wanted", ["a", "r+fp"])
def test_mix_draws_every_non_empty_subset_equally_often(name, wanted):
    kinds = KINDS if wanted == "a" else tuple(wanted.split("+"))
    drawn = [frozenset(chosen) for size in range(1, len(kinds) + 1) for chosen in combinations(kinds, size)]
    # What is heard of a drawn subset is what it shares with the kinds of which there is something to say.
    heard_kinds = Counter()
    expected = Counter()
    for _, said, true in turns(name, "mix", "oracle", feedback_type=wanted):
        there = frozenset(claim.kind for claim in true)
        heard_kinds[there, frozenset(claim.kind for claim in said)] += 1
        expected.update({(there, subset & there): 0 for subset in drawn})
        for subset in drawn:
            expected[there, subset & there] += 1 / len(drawn)
    assert set(heard_kinds) <= set(expected)
    common = [key for key in expected if expected[key] >= 5]
    observed, ideal = [np.array([table[key] for key in common]) for table in (heard_kinds, expected)]
    rest = sum(heard_kinds.values()) - observed.sum(), sum(expected.values()) - ideal.sum()
    if rest[1] >= 5:
        observed, ideal = np.append(observed, rest[0]), np.append(ideal, rest[1])
    assert len(observed) > 2
    assert chisquare(observed, ideal * observed.sum() / ideal.sum()).pvalue > ALPHA


@on_every_family
def test_silent_says_the_instruction_only(name):
    for utterances in heard(name, "silent"):
        assert utterances[0]
        assert {atom.kind for atom in utterances[0].atoms} == {None}
        assert set(utterances[1:]) == {""}


@on_every_family
def test_retry_only_speaks_exactly_while_unsolved(name):
    for moment, said in turns(name, "retry_only"):
        assert said == (() if moment.success or moment.turn == 0 else (TryAgain(),))


@on_every_family
def test_retry_only_answers_a_text_that_is_no_action(name):
    teacher = pupil(name).make_teacher(lab(name), "retry_only")
    teacher.reset(np.random.default_rng(0))
    opening = play(name)[0][0]
    teacher.speak(opening)
    failure = Moment(None, ParseFailure("?", lab(name).action_syntax), 0.0, opening.after, False, 1, False)
    assert [type(atom.claim).__name__ for atom in teacher.speak(failure).atoms] == ["NotUnderstood", "TryAgain"]


@on_every_family
def test_placebo_replaces_each_claim_by_a_truism_of_its_kind(name):
    for _, said, true in turns(name, "placebo", "oracle"):
        assert [claim.kind for claim in said] == [claim.kind for claim in true]
        assert all(type(claim) is Truism for claim in said)
    assert all(holds(name, atom.claim, moment) for atom, moment in feedback(name, "placebo"))


@on_every_family
def test_placebo_speaks_as_long_as_the_oracle(name):
    lengths = {
        personality: [len(atom.text.split()) for atom, _ in feedback(name, personality)]
        for personality in ("placebo", "oracle")
    }
    assert len(lengths["placebo"]) == len(lengths["oracle"]) > length(name) / 2
    assert np.mean(lengths["placebo"]) == pytest.approx(np.mean(lengths["oracle"]), rel=0.1)
    assert len(set(texts(name, "placebo")[0])) > 10  # not the same sentence every turn


@sampled(lambda name, eps: {name, eps})
@on_every_family
@pytest.mark.parametrize("eps", [0.1, 0.5, 0.9])
def test_mistake_errs_at_its_rate(name, eps):
    personality = f"mistake(eps={eps})"
    claims = sum(len(true) for _, true in turns(name, "oracle"))
    right = sum(holds(name, atom.claim, moment) for atom, moment in feedback(name, personality))
    assert claims > 2 * length(name)
    assert fits(claims - right, claims, eps)
    for _, said, true in turns(name, personality, "oracle"):
        assert len(said) <= len(true)


def test_mistake_errs_in_each_claim_by_itself():
    stage, withheld = mistake(eps=0.5).start(np.random.default_rng(0)), SimpleNamespace(distort=lambda *_: None)
    kept = [len(stage.speak((TryAgain(),) * 8, withheld)) for _ in range(400)]
    assert np.var(kept) == pytest.approx(2, rel=0.3)  # binomial; 16 if all claims erred together


@on_every_family
def test_mistake_errs_in_every_claim_at_one_and_in_none_at_zero(name):
    assert texts(name, "mistake(eps=0)") == texts(name, "oracle")
    wrong = list(feedback(name, "mistake(eps=1)"))
    assert len(wrong) > 0.9 * sum(1 for _ in feedback(name, "oracle"))
    assert not [atom for atom, moment in wrong if holds(name, atom.claim, moment)]


@sampled(lambda name, late: {name, late})
@on_every_family
@pytest.mark.parametrize("late", [1, 3])
def test_delayed_says_what_would_have_been_said_earlier(name, late):
    personality = f"delayed(turns={late})"
    for utterances, honest in zip(heard(name, personality), heard(name, "oracle"), strict=True):
        true = [[atom for atom in said.atoms if atom.kind is not None] for said in honest]
        for turn, said in enumerate(utterances):
            atoms = [atom for atom in said.atoms if atom.kind is not None]
            earlier = true[turn - late] if turn >= late else []
            assert [atom.claim for atom in atoms] == [atom.claim for atom in earlier]
            assert all(atom.about_turn == turn - late for atom in atoms)
            assert all(f"turn {turn - late}" in atom.text for atom in atoms)


@sampled(lambda name, personality: {name, personality})
@on_every_family
@pytest.mark.parametrize("personality", ["mistake(eps=1) | delayed(turns=2)", "delayed(turns=2) | mistake(eps=1)"])
def test_mistakes_may_come_late_or_be_made_late(name, personality):
    atoms = list(feedback(name, personality))
    assert len(atoms) > length(name)
    assert not [atom for atom, moment in atoms if holds(name, atom.claim, moment)]


@pytest.mark.parametrize(
    ("personality", "said"),
    [
        ("silent | retry_only", {1: TryAgain(), 4: TryAgain()}),
        ("retry_only | silent", {}),
        ("retry_only | delayed(turns=2)", {3: TryAgain(), 6: TryAgain()}),
        ("delayed(turns=2) | retry_only", {1: TryAgain(), 4: TryAgain()}),
        ("retry_only | mistake(eps=1)", {1: Solved(), 4: Solved()}),
        ("mistake(eps=1) | retry_only", {1: TryAgain(), 4: TryAgain()}),
        ("only(kinds='r') | only(kinds='fp')", {}),
    ],
)
def test_stages_are_asked_from_left_to_right(personality, said):
    episode = next(i for i, e in enumerate(play("bandits")) if [m.success for m in e[1:6]] == [False] * 5)
    utterances = heard("bandits", personality)[episode]
    claims = {turn: atom.claim for turn in (1, 3, 4, 6) for atom in utterances[turn].atoms}
    assert {turn: claim for turn, claim in claims.items() if turn in said} == said
    assert said or not claims


@sampled(lambda name, personality, feedback_type: {name, personality, feedback_type})
@pytest.mark.parametrize("feedback_type", ["n", "r", "hp+fn", "m"])
@pytest.mark.parametrize(("name", "personality"), pairs("mistake(eps=1) | delayed(turns=1)", names=RICH, spec=lightest))
def test_the_feedback_type_bounds_what_any_personality_says(name, personality, feedback_type):
    allowed = set(KINDS) if feedback_type == "m" else {kind for kind in KINDS if kind in feedback_type.split("+")}
    for _, said in turns(name, personality, feedback_type=feedback_type, turns=FEWEST):
        assert {claim.kind for claim in said} <= allowed


@on_every_family
def test_the_bound_is_applied_after_the_last_stage(name):
    # The first stage asks for another try, which is hn; the second turns it into praise, which is hp.
    personality = "retry_only | mistake(eps=1)"
    for moment, blame, praise in turns(name, "retry_only", personality, feedback_type="hp", turns=FEW):
        assert blame == ()
        assert praise == (() if moment.success or moment.turn == 0 else (Solved(),))
    assert not [said for _, said in turns(name, personality, feedback_type="r+hn+fp+fn", turns=FEW) if said]


@sampled(lambda name, one, other: {name, (one, other)})
@on_every_family
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("oracle", "mistake(eps=0)"),
        ("oracle", "oracle | mistake(eps=0) | delayed(turns=0)"),
        ("mistake(eps=0.3) | delayed(turns=0)", "mistake(eps=0.3) | delayed(turns=0) | mistake(eps=0)"),
        # Today a stage alone has another stream than the same stage at the head of a pipeline.
        ("mistake(eps=0.3)", "mistake(eps=0.3) | delayed(turns=0)"),
        ("placebo", "placebo | mistake(eps=0)"),
    ],
)
def test_a_further_stage_does_not_change_the_draws_of_the_others(name, one, other):
    settings = {"instruction_type": "p", "turns": FEW}
    assert texts(name, one, **settings) == texts(name, other, **settings)


@on_every_family
def test_the_instruction_does_not_depend_on_the_personality(name):
    def openings(personality):
        teacher = pupil(name).make_teacher(pupil(name).make_world(), personality, instruction_type="p")
        rng = np.random.default_rng(0)
        for episode in play(name)[: amount(3, full=5)]:
            teacher.reset(rng.spawn(1)[0])
            said = [teacher.speak(moment) for moment in episode[:2]]
            yield tuple(atom.text for atom in said[0].atoms if atom.kind not in ("fp", "fn"))

    expected = list(openings("oracle"))
    assert len(set(expected)) > 1
    for _, personality in pairs(names=[name], spec=lightest):
        assert list(openings(personality)) == expected


@sampled(lambda name, after: {name, after})
@on_every_family
@pytest.mark.parametrize("after", ["worked_example", "hinter", "verification", "elaborator"])
def test_a_placebo_is_no_ground_for_others(name, after):
    """A stage behind it adds nothing that has to do with the task."""
    said = list(feedback(name, f"placebo | {after}"))
    assert said or after == "verification"
    assert all(atom.claim.placebo for atom, _ in said)


@sampled(lambda name, before: {name, before})
@on_every_family
@pytest.mark.parametrize("before", ["retry_only", "equal(eps=1)", "vague(q=1)"])
def test_a_further_verdict_contradicts_and_repeats_nothing(name, before):
    if not FAMILIES[name].serves(before):
        return
    for utterances in heard(name, f"{before} | elaborator", turns=FEW):
        for said in utterances:
            assert contradictions(said.atoms) == []
            verdicts = [atom.claim for atom in said.atoms if isinstance(atom.claim, Right | Wrong)]
            assert len(set(verdicts)) == len(verdicts)
