"""The poem's oracle: line by line, whatever was written."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from moments import started, turn

from teachers.atoms import FP, HN, HP
from teachers.oracles.poem import PoemOracle
from teachers.oracles.poem.claims import AllRight, Empty, LinesRight, WrongLine, WrongNumber
from worlds.poem import Poem
from worlds.poem import Truth as Form


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", [Empty]),
        ("snow", [WrongNumber]),
        ("snow\nrain\nash\nmoss", [WrongNumber]),
        ("snow\ncold rain", [AllRight]),
        ("snow\nrain", [LinesRight, WrongLine]),
        ("cold rain\nrain", [WrongLine, WrongLine]),
        ("fire\nfire", [AllRight]),
    ],
)
def test_poems_are_judged_line_by_line(text, said):
    world = Poem("LineSyllableConstrainedPoem")
    truth = Form((1, 2), False, "")
    oracle, lab = started(PoemOracle, world, truth), world.scratch()
    moment = turn(world, truth, text)
    claims = oracle.judge(moment)
    assert [type(claim) for claim in claims if claim.kind in (HP, HN)] == said
    assert [claim for claim in claims if not claim.holds(moment, lab)] == []
    advice = next(claim for claim in claims if claim.kind == FP)
    assert turn(world, moment.after, advice.action).reward > moment.reward or moment.success


PIECES = [
    "fire",
    "snow",
    "every",
    "glimmerfoam",
    "19",
    " ",
    " ",
    "-",
    "'",
    "\n",
    "\n",
    "\u2028",
    "\t",
    "%s {0}",
    "\u0301",
    "...",
]
patterns = st.builds(
    Form, st.lists(st.integers(1, 40), min_size=1, max_size=40).map(tuple), st.just(False), st.just("")
)
free = st.builds(Form, st.tuples(st.integers(1, 40)), st.just(True), st.just(""))


@given(
    pieces=st.lists(st.sampled_from(PIECES), max_size=40),
    times=st.sampled_from([1, 1, 1, 5, 400]),
    truth=patterns | free,
    number=st.integers(1, 50),
)
@settings(deadline=None)
def test_what_is_said_of_any_poem_holds_and_its_advice_helps(pieces, times, truth, number):
    world = Poem("SyllableConstrainedPoem" if truth.free else "LineSyllableConstrainedPoem")
    oracle, lab = started(PoemOracle, world, truth), world.scratch()
    moment = turn(world, truth, ("".join(pieces) * times)[: world.action_space.max_length], number)
    claims = oracle.judge(moment)
    assert [claim for claim in claims if not claim.holds(moment, lab)] == []
    (advice,) = (claim for claim in claims if claim.kind == FP)
    assert turn(world, moment.after, advice.action).reward > moment.reward or moment.success


def test_following_the_advice_leads_to_a_right_poem():
    world = Poem("LineSyllableConstrainedPoem")
    truth = Form((5, 7, 5, 17, 40), False, "")
    oracle = started(PoemOracle, world, truth)
    moment = turn(world, truth, "snow")
    for _ in range(6):
        (advice,) = oracle.judge(moment, frozenset((FP,)))
        moment = turn(world, moment.after, advice.action)
    assert moment.success
