import pickle
from dataclasses import FrozenInstanceError, fields

import pytest

from pz_envs.family import all_families
from teachers import common
from teachers.common import Reward
from teachers.making import maker
from teachers.oracle import claims_of

CLASSES = [*claims_of(common.__name__), *(cls for family in all_families() for cls in family.oracle_class().claims())]


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: f"{cls.__module__}.{cls.__name__}")
def test_what_is_made_is_as_if_the_class_had_been_called(cls):
    values = {field.name: f"the {field.name}" for field in fields(cls)}
    made, called = maker(cls)(*values.values()), cls(**values)
    assert type(made) is cls
    assert made == called
    assert hash(made) == hash(called)
    assert repr(made) == repr(called)
    assert pickle.loads(pickle.dumps(made)) == called


def test_what_is_made_is_frozen():
    made = maker(Reward)(0.5)
    with pytest.raises(FrozenInstanceError):
        made.reward = 4.0
    with pytest.raises(FrozenInstanceError):
        del made.reward


def test_each_field_is_needed():
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'reward'"):
        maker(Reward)()
    with pytest.raises(TypeError, match="takes 2 positional arguments but 3 were given"):
        maker(Reward)(1.0, 2.0)
