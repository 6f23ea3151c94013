"""Lessons: any Gymnasium environment as a subject, with an oracle of the user's own or with rewards alone."""

import contextlib
import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from pz_envs.learning import Learning, StateValues, check_learning
from pz_envs.subject import Subject
from teachers.oracle import Oracle
from teachers.phrasebook import Phrasebook, Phrases, make_phrasebook
from teachers.planning import TIERS, Auto, Planned, Planner, PlanningError, parse_planner
from teachers.planning.known import Known, known
from teachers.planning.planner import UnfitError, check_steps, guarded
from teachers.reward_oracle import RewardOracle
from teachers.voice import Voice
from worlds.pictures import Picture
from worlds.world import World
from worlds.wrapped.gym_world import GymWorld, another
from worlds.wrapped.layers import layers
from worlds.wrapped.rendered import RenderedPicture

_MAX_TURNS = 100  # turns, for an environment without a limit
_LIMITS = ("_max_episode_steps", "max_episode_steps", "max_steps")  # the names of Gymnasium's TimeLimit and of others
_COUNTS = (int, np.int32, np.int64)


class Lesson(Subject):
    """One environment as a subject, in the role of a `Family`.

    It has the methods of a family (`make_world`, `make_teacher`, `raw_env`, `env`, `parallel_env`) and works with the
    same students and conformance kits. The first environment that it makes uses the given environment itself; later
    environments and `make_world` make new ones like it.

    Args:
        env: an environment, or a function without arguments that makes one.
        oracle: a subclass of `Oracle`, or a function that makes an oracle, given a function that makes scratch worlds.
            Truths are `worlds.wrapped.gym_world.Position`s. Or a planner of `teachers.planning`, or its name with
            arguments, as in `exact(gamma=0.95)`: `exact` where all transitions can be known, `expert` where an expert
            is known, or `auto` for the first of these that suits the environment, and rewards alone, with a warning, if
            neither does. A planner brings its phrases, `look` and action words. None: `RewardOracle`.
        phrases: the oracle's phrases: a dict of lists by claim class or by its name, or the path of a TOML file.
        look, snapshot, success, describe, action_words, reward_range: see `worlds.wrapped.gym_world.GymWorld`.
        name: the lesson's name; None: the environment's.
        max_turns: turns after which an episode is truncated; None: the environment's own limit (of its
            spec, of a `TimeLimit`, or an attribute `max_steps` or `max_episode_steps`), or else 100.
        repeated: whether success ends no episode.
        regret_unit: the unit of regret.
        learning: what can be learned from rewards alone, one of `pz_envs.learning`.

    Raises:
        ValueError: an argument is not allowed, or the phrases are incomplete.
    """

    def __init__(
        self,
        env: gymnasium.Env | Callable[[], gymnasium.Env],
        oracle: Callable[..., Oracle] | Planner | str | None = None,
        *,
        phrases: Phrases | None = None,
        look: Callable[[gymnasium.Env], Any] | None = None,
        snapshot: str = "auto",
        success: Callable[..., Any] | None = None,
        describe: Callable[[Any], str] | None = None,
        action_words: Mapping[str, Any] | None = None,
        reward_range: tuple[float, float] | None = None,
        name: str | None = None,
        max_turns: int | None = None,
        repeated: bool = False,
        regret_unit: str = "value lost",
        learning: Learning = StateValues(),  # noqa: B008 (a frozen value)
    ) -> None:
        self.planned: Planned | None = None
        """The result of the planner; None without a planner."""
        if isinstance(oracle, Planner | str):
            if look is not None or phrases is not None:
                raise ValueError("a planner brings its own look and phrases; leave out look=... and phrases=...")
            planner = parse_planner(oracle) if isinstance(oracle, str) else oracle
            self.planned = _planned(env, planner, max_turns, success)
            success = success or self.planned.success
            oracle, phrases, look = self.planned.oracle, self.planned.phrases, self.planned.look
            describe = describe or self.planned.describe
            action_words = action_words or self.planned.action_words
        self._oracle = RewardOracle if oracle is None else _checked(oracle)
        # An oracle that does not read truths needs no copies of the environment.
        goes = getattr(self._oracle, "needs_truth", True) if self.planned is None else self.planned.copies
        if snapshot == "auto" and not goes:
            snapshot = "replay"
        self._world: GymWorld | None = GymWorld(
            env,
            look=look,
            snapshot=snapshot,
            success=success,
            describe=describe,
            action_words=action_words,
            reward_range=reward_range,
        )
        if self.planned is None and goes:
            _check_apart(self._world.env)
        if self.planned is not None:
            self._world.model = self.planned.model
            self._world.notes = {"objective": self.planned.objective} if self.planned.objective else {}
            if self.planned.privileged:
                self._world.notes |= {"privileged": True}
        self._scratch = self._world.scratch
        self._phrases = {} if phrases is None else phrases
        self.phrasebook()
        spec = self._world.env.spec
        self.name = name or (spec.name if spec else type(self._world.env.unwrapped).__name__)
        self._limits = limits_of(self._world.env)
        self.max_turns = least(self._limits) if max_turns is None else max_turns
        check_learning(learning)
        self.repeated, self.regret_unit, self.learning = repeated, regret_unit, learning

    def __repr__(self) -> str:
        return f"<Lesson {self.name}>"

    def make_world(self, /, **options: Any) -> GymWorld:
        """A world over another environment like the given one; there are no options."""
        if options:
            raise ValueError(f"{self.name} does not take these options: {', '.join(options)}")
        return self._scratch()

    def taught_world(self, **options: Any) -> GymWorld:
        """A world over the given environment at the first call; later calls use new environments like it."""
        other = self.make_world(**options)
        world, self._world = self._world, None
        return world or other

    def turns(self, given: int | None = None, **options: Any) -> int:
        """The turns of an episode for a given number: with a plan, limited by the environment's own limits."""
        horizon = None if self.planned is None else self.planned.horizon
        if given is not None and horizon not in (None, least([*self._limits, given])):
            raise ValueError(
                f"the teacher has planned for episodes of {horizon} turns, got max_turns {given}; "
                "give max_turns to Lesson or teach, where it plans"
            )
        return self.max_turns if given is None else least([*self._limits, given]) if horizon else given

    def make_picture(self, world: World[Any]) -> Picture[Any]:
        """The picture: the environment's own rendering, if it was made with a render mode."""
        return RenderedPicture(world) if isinstance(world, GymWorld) else super().make_picture(world)

    def oracle_class(self) -> Callable[[Callable[[], World[Any]]], Oracle]:
        """A function that makes oracles."""
        return self._oracle

    def phrasebook(self, voice: Voice = "plain") -> Phrasebook:
        """The given phrases and the phrases that all subjects share."""
        claims = self._oracle.claims() if isinstance(self._oracle, type) and issubclass(self._oracle, Oracle) else ()
        return make_phrasebook(self._phrases, claims, voice)


def _check_apart(env: gymnasium.Env) -> None:
    """Warn if an environment shares state with its copies, whose steps by an oracle would change it."""
    try:
        twin = another(env)
    except ValueError:  # the world says so where an oracle needs one
        return
    try:
        guarded(twin, lambda: check_steps(twin), env)
    except UnfitError as error:
        warnings.warn(
            f"an oracle that restores truths of {env} may change its student's world, or speak of another: {error}; "
            "if your oracle never does, set needs_truth = False in its class",
            SharedStateWarning,
            stacklevel=4,
        )
    except PlanningError:  # it cannot be stepped, which a lesson says
        return


class SharedStateWarning(UserWarning):
    """An environment shares state with its copies, which a user's own oracle may step."""


def _planned(
    env: gymnasium.Env | Callable[[], gymnasium.Env],
    planner: Planner,
    turns: int | None,
    success: Callable[..., Any] | None,
) -> Planned:
    """Plan with an environment like the given one, which is neither reset nor stepped nor seeded."""
    with contextlib.ExitStack() as stack:
        if isinstance(env, gymnasium.Env):
            other = env
            try:
                twin = another(env)
            except ValueError as error:
                if isinstance(planner, Auto):
                    return planner.rewards_only(env, success, dict.fromkeys(TIERS, f"{error}"))
                raise UnfitError(f"{error}") from error
        else:
            twin, other = (stack.enter_context(contextlib.closing(env())) for _ in range(2))
            if twin.unwrapped is other.unwrapped:
                raise ValueError(
                    f"the function must make a new environment each time, got {twin} twice; a teacher that plans would "
                    "step the student's; pass the environment itself, or a function that makes one"
                )
        try:
            return planner.plan(twin, least([*limits_of(twin), turns]), success, other)
        except PlanningError as error:
            if unlike := (known(twin) or Known()).unlike:
                error.args = (f"{error}\nNote: {unlike}",)
            raise


def _checked(oracle: Any) -> Callable[[Callable[[], World[Any]]], Oracle]:
    """A function that makes oracles."""
    if inspect.isabstract(oracle):
        lacks = ", ".join(sorted(oracle.__abstractmethods__))
        raise ValueError(f"oracle {oracle.__name__} is abstract: it lacks {lacks}")
    if not callable(oracle) or (isinstance(oracle, type) and not issubclass(oracle, Oracle)):
        raise ValueError(
            "oracle must be a subclass of teachers.oracle.Oracle, or a function that makes an oracle, given a function "
            f"that makes scratch worlds, or a planner such as 'auto' or Exact(), got {oracle!r}"
        )
    made: Callable[[Callable[[], World[Any]]], Oracle] = oracle
    return made


def limits_of(env: gymnasium.Env[Any, Any]) -> list[Any]:
    """The environment's time limits: in its spec, wrappers and attributes."""
    limits: list[Any] = [env.spec.max_episode_steps] if env.spec else []
    return [*limits, *(getattr(layer, name) for layer in layers(env) for name in _LIMITS if hasattr(layer, name))]


def least(limits: Sequence[Any]) -> int:
    """The smallest limit, ignoring None; 100 without any."""
    return min((int(each) for each in limits if type(each) in _COUNTS and each > 0), default=_MAX_TURNS)
