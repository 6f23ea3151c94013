"""Each format of an answer has an example that is read as an action, and a schema."""

import json
import re

import numpy as np
import pytest

from pz_envs.family import all_families
from pz_envs.text.actions import parse_action
from pz_envs.text.answer_formats import ANSWERS, THOUGHT, action_in, example, longest_answer, schema, written
from teachers.atoms import ParseFailure

FAMILIES = [family for family in all_families() if not family.missing()]


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
@pytest.mark.parametrize("answer", ANSWERS)
def test_an_example_is_read_as_an_action_in_each_family(family, answer):
    world = family.make_world()
    said = {written(world.scratch(), np.random.default_rng(seed)) for seed in range(5)}
    for action in said:
        shown = example(answer, action)
        assert shown.count("\n") <= 4
        text, thought = action_in(answer, shown)
        assert not isinstance(parse_action(text, world), ParseFailure), shown
        assert bool(thought) == (answer != "text")
    assert len(said) > 1


def test_a_schema_says_what_the_action_is():
    actions = {family.name: schema(family.make_world())["properties"]["action"] for family in FAMILIES}
    assert actions["gridworld"] == {"enum": ["north", "east", "west", "south"]}
    assert actions["bandits"] == {"type": "integer", "minimum": 0, "maximum": 9}
    assert (actions["poem"]["type"], actions["poem"]["minItems"], actions["poem"]["maxItems"]) == ("array", 3, 3)
    assert (actions["movies"]["type"], actions["movies"]["minItems"]) == ("array", 1)
    assert schema(None, thought=0)["required"] == ["action"]
    for family in FAMILIES:
        found = schema(family.make_world(), ["go to desk 1", "look"])
        assert found["properties"]["thought"]["maxLength"] == THOUGHT
        assert found["properties"]["action"] == {"enum": ["go to desk 1", "look"]}


@pytest.mark.parametrize(
    ("family", "taken", "refused"),
    [
        ("parking", ["[-1.0, -0.93]", "[1, 0]", "[0.25, -0.5]"], ["[5, 45]", "[1.01, 0]", "[1]", "[0, 0, 0]", "stay"]),
        ("optimization", ["[1.16773, -1.8257]", "stay"], ["[100, 0]", "[0, -11.5]", "x", "[1e3, 0]"]),
    ],
)
def test_the_pattern_of_a_box_has_its_bounds(family, taken, refused):
    world = next(each for each in FAMILIES if each.name == family).make_world()
    pattern = schema(world)["properties"]["action"]["pattern"]
    for action in taken:
        assert re.search(pattern, action), action
        if action not in world.answer_words:
            assert not isinstance(parse_action(action, world), ParseFailure)
    assert not any(re.search(pattern, action) for action in refused)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
@pytest.mark.parametrize("answer", ANSWERS)
def test_the_limit_leaves_room_for_each_action(family, answer):
    world = family.make_world()
    for seed in range(5):
        said = example(answer, written(world.scratch(), np.random.default_rng(seed)))
        assert longest_answer(world, answer) > len(said) / 2
    assert longest_answer(world, answer) <= 1300


def test_lists_are_lines_or_titles_and_what_is_cut_off_is_none():
    poem, movies = (next(each for each in FAMILIES if each.name == name).make_world() for name in ("poem", "movies"))
    said = json.dumps({"action": ["rain taps on the tin", "nobody answers the bell"]})
    assert action_in("json", said, poem)[0] == "rain taps on the tin\nnobody answers the bell"
    assert json.loads(action_in("json", said, movies)[0]) == ["rain taps on the tin", "nobody answers the bell"]
    assert action_in("json", said[:30], poem) == ("", "")
    assert action_in("json", "north", poem) == ("north", "")
