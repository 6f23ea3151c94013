"""Environments of the old Gym, taught."""

import random
import sys
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from playing import episode

import llf_teacher
from worlds import testing as world_kit
from worlds.wrapped.gym_world import GymWorld
from worlds.wrapped.old_gym import OldGym, convert_space


class OldDiscrete:
    def __init__(self, n):
        self.n = n
        self.shape = ()


class OldBox:
    def __init__(self, low, high, shape, dtype=np.float32):
        self.low, self.high, self.shape, self.dtype = np.full(shape, low), np.full(shape, high), shape, np.dtype(dtype)


class OldCorridor:
    """An environment as they were written before Gym 0.21."""

    metadata = {"render.modes": ["human", "ansi"]}  # noqa: RUF012
    reward_range = (-0.5, 1.0)

    def __init__(self, length=6):
        self.length = length
        self.action_space = OldDiscrete(2)
        self.observation_space = SimpleNamespace(
            spaces={"place": OldBox(0, length, (1,)), "wind": OldDiscrete(2)}, shape=None
        )
        self.random = random.Random()

    def seed(self, seed=None):
        self.random.seed(seed)
        return [seed]

    def reset(self):
        self.place, self.turns = 0, 0
        return self._see()

    def step(self, action):
        self.turns += 1
        if self.random.random() > 0.2:
            self.place = min(max(self.place + (1 if action else -1), 0), self.length)
        there, late = self.place == self.length, self.turns >= 20
        info = {"TimeLimit.truncated": not there} if late else {}
        return self._see(), 1 if there else -0.5, there or late, info

    def render(self, mode="human"):
        return f"{mode}: {self.place}"

    def _see(self):
        return {"place": [self.place], "wind": np.int64(self.random.random() > 0.5)}


def test_an_old_environment_passes_gymnasiums_check_and_ours():
    check_env(OldGym(OldCorridor()), skip_render_check=True)
    check_env(llf_teacher.teach(llf_teacher.OldGym(OldCorridor())), skip_render_check=True)
    check_env(llf_teacher.teach(OldGym(OldCorridor()), text=True), skip_render_check=True)
    for check in world_kit.CHECKS:
        for snapshot in ("copy", "replay"):
            check(lambda snapshot=snapshot: GymWorld(OldGym(OldCorridor()), snapshot=snapshot))
    assert "gym" not in sys.modules


def test_the_old_interface_becomes_the_new_one():
    env = OldGym(OldCorridor())
    assert env.observation_space == spaces.Dict({"place": spaces.Box(0, 6, (1,)), "wind": spaces.Discrete(2)})
    observation, info = env.reset(seed=1)
    assert observation in env.observation_space
    assert info == {}
    for _ in range(19):
        assert env.step(0)[2:4] == (False, False)
    assert env.step(0)[1:4] == (-0.5, False, True)  # for want of time
    env.reset()
    *_, terminated, truncated, _ = next(step for step in iter(lambda: env.step(1), None) if step[2] or step[3])
    assert (terminated, truncated) == (True, False)
    first = [plain_step(env, i % 2) for i in range(-1, 9)]
    assert [plain_step(env, i % 2) for i in range(-1, 9)] == first


def plain_step(env, action):
    if not hasattr(env, "turn") or env.turn == 9:
        env.turn = -1
        env.reset(seed=7)
    env.turn += 1
    return world_kit.plain(env.step(action))


def test_it_is_taught():
    env = llf_teacher.teach(llf_teacher.OldGym(OldCorridor()), privileged_info=True, look=lambda env: env.old.place)
    assert env.reward_range == (-0.5, 1.0)
    for observation, reward, _, _, info in episode(env, 1):
        assert info["atoms"][0].claim.reward == reward
        assert observation["feedback"]
    assert info["success"]
    assert info["moment"].after.seen == 6
    lab = env.session.world.scratch()
    lab.restore(info["moment"].before)
    assert lab.step(1)[1] == 1.0


def test_render_and_close():
    assert OldGym(OldCorridor(), render_mode="ansi").reset()[1] == {}
    env = OldGym(OldCorridor(), render_mode="ansi")
    env.reset()
    assert env.render() == "ansi: 0"
    assert OldGym(OldCorridor()).render() is None
    env.close()
    closed = []
    old = OldCorridor()
    old.close = lambda: closed.append(1)
    OldGym(old).close()
    assert closed
    with pytest.raises(ValueError, match="render_mode 'rgb_array' is unknown; allowed: None, human, ansi"):
        OldGym(OldCorridor(), render_mode="rgb_array")


class InBetween(OldCorridor):
    """As Gym was from 0.26 on."""

    def reset(self):
        return super().reset(), {"fresh": True}

    def step(self, action):
        observation, reward, done, info = super().step(action)
        return observation, reward, done, False, info


def test_what_came_between_is_understood():
    env = OldGym(InBetween())
    observation, info = env.reset(seed=0)
    assert info == {"fresh": True}
    assert observation in env.observation_space
    assert env.step(1)[2:4] == (False, False)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (OldDiscrete(3), spaces.Discrete(3)),
        (SimpleNamespace(n=3, start=1), spaces.Discrete(3, start=1)),
        (SimpleNamespace(n=3, shape=(3,)), spaces.MultiBinary(3)),
        (SimpleNamespace(nvec=np.array([2, 3]), shape=(2,)), spaces.MultiDiscrete([2, 3])),
        (OldBox(-1, 1, (2, 2)), spaces.Box(-1, 1, (2, 2))),
        (OldBox(0, 255, (2,), np.uint8), spaces.Box(0, 255, (2,), np.uint8)),
        (SimpleNamespace(low=-1.0, high=[1.0, 2.0], shape=(2,)), spaces.Box(np.array([-1, -1]), np.array([1, 2]))),
        (SimpleNamespace(spaces=[OldDiscrete(2)]), spaces.Tuple([spaces.Discrete(2)])),
        (spaces.Discrete(4), spaces.Discrete(4)),
    ],
    ids=range(9),
)
def test_spaces(old, new):
    assert convert_space(old) == (new if new.dtype != np.float64 else convert_space(new))


def test_tuples_of_observations_are_not_taken_for_an_info():
    class Pair(OldCorridor):
        def __init__(self):
            super().__init__()
            self.observation_space = SimpleNamespace(
                spaces=[OldDiscrete(2), SimpleNamespace(spaces={"wind": OldDiscrete(2)})]
            )

        def _see(self):
            return 0, {"wind": 1}

    env = OldGym(Pair())
    assert env.reset() == ((0, {"wind": 1}), {})


def test_what_is_no_environment():
    with pytest.raises(ValueError, match=r"has no method reset\(\)"):
        OldGym(object())
    old = OldCorridor()
    old.action_space = object()
    with pytest.raises(ValueError, match=r"cannot convert the space <object.*allowed: spaces with n"):
        OldGym(old)
    assert isinstance(OldGym(OldCorridor()), gymnasium.Env)
