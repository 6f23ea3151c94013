"""Each format of an answer has an example that is read as an action, and a schema."""

import numpy as np
import pytest

from pz_envs.family import all_families
from pz_envs.text.actions import parse_action
from pz_envs.text.answer_formats import ANSWERS, action_in, example, schema, written
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
    assert actions["bandits"]["type"] == "integer"
    assert actions["poem"] == {"type": "string"}
    assert actions["parking"] == {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
