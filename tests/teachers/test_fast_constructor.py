import pickle
from dataclasses import FrozenInstanceError, fields

import pytest

from pz_envs.family import all_families
from teachers import common
from teachers.atoms import Claim, fast_constructor
from teachers.common import Reward
from teachers.oracle import claims_of

CLASSES = {family.name: family.oracle_class().claims() for family in all_families()}
CLASSES["common"] = claims_of(common.__name__)

CHECKED = {common.Probably: {"claim": Reward(reward=1.0), "p": 0.8}}
"""Fields of claims that refuse others."""


@pytest.mark.parametrize("home", CLASSES)
def test_claims_are_those_that_the_class_makes(home):
    assert CLASSES[home]
    for cls in CLASSES[home]:
        values = CHECKED.get(cls) or {field.name: f"the {field.name}" for field in fields(cls)}
        made, called = fast_constructor(cls)(*values.values()), cls(**values)
        assert type(made) is cls
        assert made == called
        assert hash(made) == hash(called)
        assert repr(made) == repr(called)
        assert pickle.loads(pickle.dumps(made)) == called


def test_claims_are_frozen():
    made = fast_constructor(Reward)(0.5)
    with pytest.raises(FrozenInstanceError):
        made.reward = 4.0
    with pytest.raises(FrozenInstanceError):
        del made.reward


def test_the_decorator_is_needed():
    class Bare(Claim):
        number: int

    with pytest.raises(TypeError, match=r"Bare lacks the decorator @claim; write @claim before the class"):
        fast_constructor(Bare)


def test_each_field_is_needed():
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'reward'"):
        fast_constructor(Reward)()
    with pytest.raises(TypeError, match="takes 2 positional arguments but 3 were given"):
        fast_constructor(Reward)(1.0, 2.0)
