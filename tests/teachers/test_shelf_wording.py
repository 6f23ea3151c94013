"""Personalities that say the same in another way: without reasons, in another order, vaguely, at length."""

from collections import Counter

import pytest
from lessons import CHEAP, fits, of, on_cheap_families, rows, taught, turns, without

from teachers.atoms import FP, HN, HP
from teachers.common import FACTS, Chance, Paid, PartlyRight, Right, Trap, Truism, Wrong


@pytest.mark.parametrize("name", ["bandits", "gridworld", "optimization", "poem"])
def test_verification_gives_no_reason_and_the_elaborator_does(name):
    for (_, moment, said, true), (_, _, elaborate, _) in zip(
        turns(name, "verification"), turns(name, "elaborator"), strict=True
    ):
        verdict = Wrong if of(true, HN) else Right if of(true, HP) else None
        assert [type(claim) for claim in said] == ([verdict] if verdict else [])
        assert [claim for claim in elaborate if type(claim) not in (Right, Wrong)] == true
        assert [type(claim) for claim in elaborate if claim not in true] == ([verdict] if verdict else [])
        assert all(claim.action == moment.action for claim in said)


@pytest.mark.parametrize("name", ["bandits", "gridworld", "optimization", "poem"])
def test_the_same_truth_in_another_order(name):
    sandwiches = 0
    for _, _, said, true in turns(name, "sandwich"):
        assert sorted(map(repr, said)) == sorted(map(repr, true))
        kinds = [claim.kind for claim in said if claim.kind in (HP, HN, FP)]
        if HP in kinds and HN in kinds:
            assert kinds[0] is HP
            assert kinds[-1] in (HP, FP) or len(of(true, HP)) == 1
            sandwiches += 1
    assert sandwiches > 20 or name in CHEAP
    for _, _, said, true in turns(name, "encouraging"):
        assert said == [*of(true, HP), *without(true, HP)]
    for _, _, said, true in turns(name, "harsh"):
        assert said == of(true, HN)


@pytest.mark.parametrize("name", ["bandits", "gridworld", "optimization", "poem"])
@pytest.mark.parametrize("q", [0.0, 0.3, 1.0])
def test_vague_drops_numbers_and_names_at_its_rate(name, q):
    vague = (Right, PartlyRight, Wrong, Paid, Chance, Trap)
    counts = Counter()
    for _, _, said, true in turns(name, f"vague(q={q})"):
        assert {claim.kind for claim in said} == {claim.kind for claim in true}
        if len({claim.kind for claim in true}) == len(true):  # nothing could be said twice
            counts["there"] += len(true)
            counts["vague"] += sum(type(claim) in vague for claim in said)
        assert all(claim in true or type(claim) in vague for claim in said)
        assert len(set(said)) == len(said)
    assert counts["there"] > 500
    assert fits(counts["vague"], counts["there"], q)


def test_what_is_vague_has_no_number_and_no_name():
    for episode in taught("gridworld", "vague(q=1)"):
        for _, atoms, _ in episode:
            words = {word.strip(".,:").lower() for atom in atoms for word in atom.text.split()}
            assert not words & {"north", "east", "west", "south"}
            assert not [word for word in words if any(c.isdigit() for c in word)]


@on_cheap_families
@pytest.mark.parametrize("k", [0, 1, 5])
def test_verbose_adds_its_number_of_truisms(name, k):
    for _, _, said, true in turns(name, f"verbose(k={k})"):
        assert [claim for claim in said if type(claim) is not Truism] == true
        padding = [claim for claim in said if type(claim) is Truism]
        assert len(padding) == (k if true else 0)
        assert {claim.kind for claim in padding} <= {claim.kind for claim in true}


@pytest.mark.parametrize("name", ["gridworld", "movies"])
def test_verbose_says_no_fact_twice_before_it_has_said_them_all(name):
    for _, episode in rows(name, "verbose(k=3)"):
        spoken = [[claim.fact for claim in said if type(claim) is Truism] for _, said, _ in episode]
        spoken = [facts for facts in spoken if facts]
        assert all(len(set(facts)) == 3 for facts in spoken)
        first = [fact for facts in spoken[: len(FACTS) // 3] for fact in facts]
        assert len(set(first)) == len(first)
