"""What can be said as JSON: schemas, claims that come back from it, and what is refused."""

import dataclasses
import json
import math
import time
from typing import Annotated, Any

import numpy as np
import pytest
from commands import llf
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sampling import ENTRIES, fewer

from llf_teacher.registry import entries, family
from pz_envs.family import all_families
from teachers import schema
from teachers.atoms import FP, HP, KINDS, Atom, Claim, Grounded, Label, Moment, PlanClaim, Utterance, claim
from teachers.common import Reward, Right, Wrong
from teachers.oracles.gridworld.claims import Found, Go
from teachers.oracles.parking.claims import Push
from teachers.schema import Vocabulary, holds, storable
from teachers.spec import Range
from teachers.testing import Pupil
from worlds.gridworld import Direction

FAMILIES = {each.name: each for each in all_families()}
GRID = family("gridworld").vocabulary()


def pupil(entry, turns):
    make = lambda: entry.family.make_world(**entry.options)  # noqa: E731
    return Pupil(make, entry.family.make_teacher, max_turns=entry.family.max_turns, turns=fewer(entry.family, turns))


@pytest.mark.parametrize("entry", ENTRIES)
def test_every_claim_of_an_oracle_comes_back_from_json(entry):
    """Of moments that no other run has seen, and with the coarser claims, whose ground is not written."""
    taught = pupil(entry, 40)
    world = taught.make_world()
    vocabulary = entry.family.vocabulary(world)
    seen = set()
    for moment in taught.moments(world, seed=time.time_ns()):
        teacher = taught.make_teacher(world)
        teacher.oracle.start(moment.after)
        claims = teacher.oracle.judge(moment)
        for each in (*claims, *(c for one in claims for c in one.coarser(moment, teacher.oracle.lab))):
            data = json.loads(json.dumps(vocabulary.data_of(each)))
            again = vocabulary.claim_of(data, moment)
            assert (type(again), again) == (type(each), each)
            assert set(data) == set(vocabulary.schema_of(data["type"])["properties"])
            assert vocabulary.claim_of(each) == each
            seen.add(each.kind)
        if len(seen) == len(KINDS) and moment.turn > 10:
            break
    assert len(seen) >= 3


@pytest.mark.parametrize("name", FAMILIES)
def test_the_schema_names_every_claim_of_feedback(name):
    vocabulary = FAMILIES[name].vocabulary()
    items = vocabulary.schema()["properties"]["claims"]["items"]["anyOf"]
    named = {item["properties"]["type"]["const"]: item for item in items}
    assert named.keys() == vocabulary.classes.keys()
    for type_, item in named.items():
        cls = vocabulary.classes[type_]
        assert item["description"].startswith(f"{cls.kind}: True if")
        assert set(item["properties"]) - {"type"} == {field.name for field in dataclasses.fields(cls)}
        assert not cls.tried
        assert not cls.placebo
    only = vocabulary.schema([FP])["properties"]["claims"]["items"]["anyOf"]
    assert {vocabulary.classes[item["properties"]["type"]["const"]].kind for item in only} == {FP}
    assert (
        not {"Goal", "Answer", "TriedWell", "NotUnderstood", "Truism", "Late", "MayAsk", "Probably", "BetterTurn"}
        & vocabulary.classes.keys()
    )


def test_the_schema_has_enumerations_ranges_and_the_words_of_the_world():
    assert GRID.schema_of("Go") == {
        "type": "object",
        "description": "fp: True if `action` begins a shortest path to a treasure not yet found; every tied path "
        "counts.",
        "properties": {
            "type": {"const": "Go"},
            "action": {
                "enum": ["north", "east", "west", "south"],
                "description": "one of north, east, west, south, or its number (0, 1, 2, 3)",
            },
        },
        "required": ["type", "action"],
        "additionalProperties": False,
    }
    assert GRID.schema_of("Found")["required"] == ["type", "room"]  # the action is that of the moment
    assert GRID.schema_of("Paid")["properties"]["sign"] == {"enum": ["positive", "negative", "zero"]}
    assert FAMILIES["poem"].vocabulary().schema_of("Work")["properties"]["line"] == {
        "type": "integer",
        "minimum": 1,
        "maximum": 99,
    }
    assert "common.Trap" in FAMILIES["parking"].vocabulary().classes
    assert FAMILIES["parking"].vocabulary().classes["Trap"].__module__.endswith("parking.claims")
    assert "Go(action: one of north, east, west, south): True if `action` begins" in GRID.listing([FP])


def test_the_command_prints_it():
    assert json.loads(llf("list", "gridworld", "--schema").stdout) == GRID.schema()
    assert json.loads(llf("list", "llf-gridworld-v0", "--schema").stdout) == GRID.schema()
    assert "did you mean gridworld" in llf("list", "gridwold", "--schema").stderr


MOMENT = Moment(None, Direction.EAST, 0.0, None, False, 1, False)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"type": "Go", "action": "up"}, "Go.action must be one of north, east, west, south, got 'up'"),
        ({"type": "Go", "action": True}, "got True"),
        ({"type": "Go", "action": 7}, "got 7"),
        ({"type": "Go", "action": ["north"]}, "got a list of 1"),
        ({"type": "Go"}, "Go lacks the field 'action'; its fields: action"),
        ({"type": "Go", "action": "north", "room": "hall"}, "Go has no field 'room'; its fields: action"),
        ({"type": "Pull", "action": 1}, "unknown claim 'Pull'"),
        ({"type": "Goe", "action": 1}, "did you mean Go"),
        ({"action": 1}, "unknown claim None"),
        ({"type": ["Go"]}, "unknown claim a list of 1"),
        ("Go north", "must be an object with the key 'type', got 'Go north'"),
        ({"type": "Reward", "reward": math.nan}, "Reward.reward must be a number from -1e"),
        ({"type": "Reward", "reward": math.inf}, "got inf"),
        ({"type": "Reward", "reward": False}, "got False"),
        ({"type": "Reward", "reward": 10**400}, "got a int"),
        ({"type": "Reward", "reward": 10**9999}, "got a int"),
        ({"type": "Either", "ways": ["north"] * 65}, "a list of at most 64"),
        ({"type": "Found", "action": 1, "room": "x" * 9000}, "8950 characters more"),
        ({"type": "Right", "action": "up"}, "Right.action must be one of north"),
        ({"type": "Example", "actions": []}, "Example.actions must be at least one action"),
        ({"type": "Example", "actions": ["up"]}, "Example.actions must be one of north"),
        ({"type": "Better", "this": "north", "that": "up"}, "Better.that must be one of north"),
        ({"type": "Right", "action": [[[[[[]]]]]]}, "Right.action must be an action"),
    ],
)
def test_what_is_refused_says_field_got_and_allowed(data, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (each message is compared)
        GRID.claim_of(data, None if data == {"type": "Go"} else MOMENT)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_claims_of_other_families_are_refused():
    other = Push(pedal="push forwards", way=((1.0, 0.0),))
    with pytest.raises(ValueError, match="unknown claim 'Push'"):
        GRID.claim_of(other)
    assert GRID.read({"claims": [other, Go(action=Direction.WEST)]}).claims == (Go(action=Direction.WEST),)


def test_a_verdict_is_on_the_last_action():
    acted = MOMENT._replace(before=())
    assert GRID.claim_of({"type": "Found", "room": "hall"}, acted) == Found(action=Direction.EAST, room="hall")
    assert GRID.claim_of({"type": "Right"}, acted) == Right(action=Direction.EAST)
    with pytest.raises(ValueError, match="Right lacks the field 'action'"):
        GRID.claim_of({"type": "Right"}, MOMENT)


def test_a_field_without_a_form_is_an_error():
    @claim
    class Strange(Claim[Any]):
        kind = FP
        what: dict[str, int]

    with pytest.raises(TypeError, match="a field of a claim must be a number"):
        Vocabulary([Strange]).schema()

    @claim
    class Typed(Claim[Any]):
        kind = FP
        type: Annotated[int, Range(0, 1)]

    with pytest.raises(TypeError, match="must not have a field 'type', got Typed"):
        Vocabulary([Typed]).schema()


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=6), inner, max_size=5),
    max_leaves=20,
)
DEEP: Any = []
for _ in range(100_000):
    DEEP = [DEEP]


def some_claims(vocabulary):
    """Objects with the name of a class and most of its fields, which hold anything."""
    one = st.sampled_from(sorted(vocabulary.classes))
    return one.flatmap(
        lambda name: st.fixed_dictionaries(
            {"type": st.just(name)}, optional=dict.fromkeys(schema._forms(vocabulary.classes[name]), VALUES)
        )
    )


@settings(max_examples=60)
@given(st.data())
@example(None)
def test_no_message_raises_whatever_it_holds(data):
    if data is None:
        for message in (
            DEEP,
            10**5000,
            {"claims": [10**5000]},
            {"claims": DEEP},
            {"claims": [{"type": "Right", "action": DEEP}]},
            {"text": DEEP},
        ):
            assert GRID.read(message, MOMENT).problems
        return
    claims = st.lists(some_claims(GRID) | VALUES, max_size=5)
    message = data.draw(
        st.fixed_dictionaries({}, optional={"claims": claims | VALUES, "text": VALUES, "x": VALUES}) | VALUES
    )
    found = GRID.read(message, MOMENT)
    listed = message.get("claims") if isinstance(message, dict) else None
    count = len(listed) if isinstance(listed, list) else 0
    assert len(found.claims) + len(found.problems) >= count
    assert all(len(problem) < 1000 for problem in found.problems)


def test_the_claims_of_a_message_are_bounded_in_number():
    (problem,) = GRID.read({"claims": [{"type": "Solved"}] * 33}).problems
    assert problem.startswith("claims must be a list of at most 32")


def test_an_integer_may_be_written_as_a_number():
    bandits = FAMILIES["bandits"].vocabulary()
    assert repr(bandits.claim_of({"type": "Pull", "action": 3.0})) == "Pull(action=3)"
    with pytest.raises(ValueError, match=r"Pull\.action must be an integer"):
        bandits.claim_of({"type": "Pull", "action": 3.5})


@pytest.mark.parametrize("name", FAMILIES)
def test_a_plan_has_an_action_by_schema_and_builder(name):
    vocabulary = FAMILIES[name].vocabulary()
    plans = [each for each, cls in vocabulary.classes.items() if issubclass(cls, PlanClaim)]
    assert plans
    for each in plans:
        assert vocabulary.schema_of(each)["properties"]["actions"]["minItems"] == 1
        with pytest.raises(ValueError, match=r"\.actions must be at least one action, got none"):
            vocabulary.claim_of({"type": each, "actions": []})


def test_what_cannot_be_checked_is_named_without_internals(monkeypatch):
    parking = FAMILIES["parking"]
    teacher = parking.make_teacher(parking.make_world())
    empty = Push(pedal="push forwards", way=())
    assert not holds(empty, MOMENT, teacher.oracle, teacher.voice)
    monkeypatch.setattr(Push, "holds", lambda claim, moment, lab: len(None))
    with pytest.raises(
        ValueError, match=r"^Push\(.*way=\(\)\) cannot be checked: the world has no such thing, nor words"
    ):
        holds(empty, MOMENT, teacher.oracle, teacher.voice)


def test_the_claims_of_a_message_are_bounded_together():
    rooms = {"type": "TreasuresIn", "rooms": ["x" * 8192] * 3}
    began = time.process_time()
    found = GRID.read({"claims": [rooms] * 32})
    assert time.process_time() - began < 5
    assert len(found.claims) == 1
    assert len(found.problems) == 31
    assert "claims must have at most 32768 characters, got TreasuresIn(" in found.problems[0]


def test_no_text_from_outside_keeps_a_lone_surrogate():
    found = GRID.read({"claims": [{"type": "NotInRoom", "room": "\ud800"}], "text": "\ud800 hi"})
    assert (found.claims[0].room, found.text) == ("?", "? hi")
    assert storable("é\udfff") == "é?"


def extremes(form, rng):
    """A value of a form, near a bound or in between."""
    if "enum" in form:
        return form["enum"][rng.integers(len(form["enum"]))]
    kind = form.get("type")
    if kind == "array":
        most = int(rng.choice([form["minItems"], form["maxItems"], max(form["minItems"], 1)]))
        return [extremes(form["items"], rng) for _ in range(most)]
    if kind in ("integer", "number"):
        value = rng.choice([form["minimum"], form["maximum"], max(form["minimum"], 0), max(form["minimum"], 1)])
        return int(value) if kind == "integer" else float(value)
    return ["", "north", "x" * 8192, "\n" * 100, '["x"]'][rng.integers(5)] if kind == "string" else 0


@pytest.mark.parametrize("name", FAMILIES)
def test_no_claim_within_bounds_can_stop_a_lesson(name):
    """It holds or not, or cannot be checked, in little time: one of each class in a moment of play."""
    entry = next(each for each in entries().values() if each.family.name == name)
    taught = pupil(entry, 2)
    world = taught.make_world()
    vocabulary = entry.family.vocabulary(world)
    *_, moment = taught.moments(world, seed=1)
    oracle = taught.make_teacher(world).oracle
    oracle.start(moment.before)
    rng, found = np.random.default_rng(0), set()
    for type_ in vocabulary.classes:
        for _ in range(4):
            properties = vocabulary.schema_of(type_)["properties"]
            data = {field: extremes(form, rng) for field, form in properties.items() if field != "type"}
            data |= dict.fromkeys(data.keys() & {"action", "this", "that"}, moment.action)
            data |= {"actions": [moment.action] * 3} if "actions" in data else {}
            made = vocabulary.claim_of({"type": type_, **data}, moment)
            began = time.perf_counter()
            try:
                found.add(holds(made, moment, oracle))
            except ValueError as error:
                found.add("cannot" if "cannot be checked" in f"{error}" else f"{error}")
            assert time.perf_counter() - began < 5, made
    assert found <= {True, False, "cannot"}
    assert {True, False} <= found


def test_claims_without_a_ground_are_checked_by_what_they_mean():
    taught = pupil(entries()["llf-gridworld-v0"], 40)
    world = taught.make_world()
    oracle = taught.make_teacher(world).oracle
    verdicts = set()
    for moment in taught.moments(world, seed=5):
        if moment.before is None:
            oracle.start(moment.after)
            continue
        blamed = any(each.kind is not HP for each in oracle.judge(moment, {HP, "hn"}))
        for cls, right in ((Right, not blamed), (Wrong, blamed)):
            said = Atom(cls(action=moment.action), "So.", moment.turn)
            moments = [moment] * (moment.turn + 1)
            label = said.label(moments, world.scratch(), oracle)
            verdicts.add(label)
            assert (label is Label.TRUTHFUL) == right or moment.success
            assert said.label(moments, world.scratch()) is Label.UNCHECKED
            assert not said.claim.grounded
    assert verdicts == {Label.TRUTHFUL, Label.DISTORTED}
    assert Right.on((), action=1).grounded
    assert issubclass(Right, Grounded)
    assert Utterance.of([Atom(Reward(reward=0.0), "Nil.", 0)]) == "Nil."
