"""Simulators: metaworld's environments, shared by the worlds of a thread, which load their states into them."""

import threading
from functools import lru_cache
from typing import Any, Self

import numpy as np

from worlds.metaworld.fast_env import fast_env_class, probe_env
from worlds.metaworld.nearness import nearness_of
from worlds.metaworld.state import Episode, FloatArray, ImageArray, Truth

PIXELS = 240
"""Width and height of an image."""
_SPARE = 4  # number of simulators that a thread keeps
_PASSING = ("curr_path_length", "_prev_obs", "_target_to_obj_init")  # attributes that metaworld changes in a step
_SOLVER = ("model", "data", "mujoco_renderer", "_np_random", "_np_random_seed", "_views")
_CAMERA = "corner2"
_NONE = Episode((), b"", b"", ())  # the episode of a simulator before the first one


_FAILED: list[str] = []  # the first error of OpenGL in this process: another attempt would end the process


def _no_images(why: str) -> RuntimeError:
    return RuntimeError(
        f"images need off-screen OpenGL, which failed with {why}; set the environment variable MUJOCO_GL "
        f"to egl (Debian: libegl1) or to osmesa (Debian: libosmesa6) before Python starts, or do without images"
    )


class Simulator:
    """metaworld's environment of a task with faster steps, shared by the worlds of a thread."""

    def __init__(self, task: str) -> None:
        import mujoco
        from metaworld.env_dict import ALL_V3_ENVIRONMENTS

        self._mujoco = mujoco
        base = ALL_V3_ENVIRONMENTS[task]
        fast: Any = fast_env_class(base)
        env = self.env = fast.__new__(fast)  # with the attributes of metaworld's own constructor
        env.__dict__.update(base().__dict__)
        # As in metaworld's MT1: tasks are given, and the goal is observable.
        env._set_task_called, env._partially_observable = True, False
        env.__dict__.pop("sawyer_observation_space", None)
        env.prepare(mujoco)
        self.probe = probe_env(env, base, nearness_of(task))
        self._kind = mujoco.mjtState.mjSTATE_INTEGRATION
        self._size = mujoco.mj_stateSize(env.model, self._kind)
        self.objects = len(env._get_pos_objects()) // 3
        self._fresh = dict(env.__dict__)
        self._fresh_physics = self._physics(), env.model.body_pos.copy(), env.model.site_pos.copy()
        self._episode = _NONE
        self._renderers: dict[int, Any] = {}
        self._aliases: dict[str, FloatArray] = {}
        self._aliases = self._find_aliases()

    def reset(self, rng: np.random.Generator) -> Truth:
        """Begin an episode as in a new environment of metaworld, with a variation that metaworld draws."""
        env = self.env
        self._renew()
        env._freeze_rand_vec, env.seeded_rand_vec, env._np_random = False, True, rng
        env.reset_model()
        variation = env._last_rand_vec
        self._renew()
        env._freeze_rand_vec, env._last_rand_vec = True, variation
        observation, _ = env.reset()
        fresh = self._fresh
        attributes = tuple(
            (name, tuple(value.tolist()) if isinstance(value, np.ndarray) else value)
            for name, value in sorted(env.__dict__.items())
            if value is not fresh.get(name, self) and name not in (*_SOLVER, *_PASSING, *self._aliases)
        )
        model = env.model
        self._episode = Episode(
            tuple(variation.tolist()), model.body_pos.tobytes(), model.site_pos.tobytes(), attributes
        )
        return self.truth(tuple(observation.tolist()), False)

    def truth(self, observation: tuple[float, ...], solved: bool) -> Truth:
        """A snapshot of the state."""
        env = self.env.__dict__
        passing = (env[name] for name in _PASSING if name in env)
        kept = tuple(tuple(value.tolist()) if isinstance(value, np.ndarray) else value for value in passing)
        return Truth(observation, solved, self._physics().tobytes(), kept, self._episode)

    def load(self, truth: Truth) -> Self:
        """Load a snapshot, without quantities that MuJoCo derives: the next step computes them."""
        env, episode = self.env, truth.episode
        if episode is not self._episode:
            self._renew()
            env.model.body_pos[:] = np.frombuffer(episode.bodies).reshape(-1, 3)
            env.model.site_pos[:] = np.frombuffer(episode.sites).reshape(-1, 3)
            env.__dict__.update((name, _thawed(value)) for name, value in episode.attributes)
            env.__dict__.update(self._aliases)
            self._episode = episode
        names = (name for name in _PASSING if name in self._fresh)
        env.__dict__.update(zip(names, map(_thawed, truth.passing), strict=True))
        self._mujoco.mj_setState(env.model, env.data, np.frombuffer(truth.physics).copy(), self._kind)
        return self

    def image(self, pixels: int = PIXELS) -> ImageArray:
        """The camera image, uint8 (pixels, pixels, 3)."""
        mujoco, env = self._mujoco, self.env
        if _FAILED:
            raise _no_images(_FAILED[0])
        physics = self._physics()
        try:
            renderer = self._renderers.get(pixels)
            if renderer is None:
                renderer = self._renderers[pixels] = mujoco.Renderer(env.model, pixels, pixels)
            mujoco.mj_forward(env.model, env.data)  # a loaded state lacks derived quantities
            renderer.update_scene(env.data, camera=_CAMERA)
            image = renderer.render()
        except Exception as error:
            _FAILED.append(f"{error!r}")
            raise _no_images(_FAILED[0]) from error
        mujoco.mj_setState(env.model, env.data, physics, self._kind)
        upright: ImageArray = image[::-1, ::-1].copy()
        return upright  # this camera is mounted upside down

    def _physics(self) -> FloatArray:
        physics = np.empty(self._size)
        self._mujoco.mj_getState(self.env.model, self.env.data, physics, self._kind)
        return physics

    def _renew(self) -> None:
        """Reset the environment to its state after construction."""
        env = self.env
        physics, bodies, sites = self._fresh_physics
        env.__dict__.clear()
        env.__dict__.update(self._fresh)
        env.model.body_pos[:], env.model.site_pos[:] = bodies, sites
        self._mujoco.mj_resetData(env.model, env.data)
        self._mujoco.mj_setState(env.model, env.data, physics, self._kind)
        self._mujoco.mj_forward(env.model, env.data)

    def _find_aliases(self) -> dict[str, FloatArray]:
        """Attributes that metaworld's reset binds to MuJoCo's memory, so that they change with the simulation."""
        self.reset(np.random.default_rng(0))
        data = self.env.data
        arrays = [array for name in ("xpos", "xquat", "site_xpos", "geom_xpos") for array in (getattr(data, name),)]
        aliases = {
            name: value
            for name, value in self.env.__dict__.items()
            if isinstance(value, np.ndarray) and any(np.may_share_memory(value, array) for array in arrays)
        }
        self._episode = _NONE
        return aliases


def _thawed(value: Any) -> Any:
    return np.array(value) if isinstance(value, tuple) else value


class _Simulators(threading.local):
    """The most recently used simulators of a thread."""

    def __init__(self) -> None:
        self.of = lru_cache(maxsize=_SPARE)(Simulator)


_SIMULATORS = _Simulators()


def simulator_of(task: str) -> Simulator:
    """The simulator of a task in this thread."""
    return _SIMULATORS.of(task)
