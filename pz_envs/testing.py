"""A conformance kit for seats. For your own family, run `check_seats(my_env)` with its `env` or `raw_env`.

PettingZoo's own checkers come first, then ours. Each check takes a factory of AEC environments that accepts the
arguments of `pz_envs.subject.Subject.raw_env`. `check_family(FAMILY)` checks a declaration.
"""

import importlib
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import metadata
from itertools import pairwise, product
from typing import Any

import numpy as np
from pettingzoo import AECEnv
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test
from pettingzoo.utils.conversions import turn_based_aec_to_parallel

from pz_envs.family import Family
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import SPEECHES
from pz_envs.text.actions import read_exactly
from teachers.atoms import ActionClaim, Atom, EditClaim, PlanClaim
from teachers.feedback import SUBSETS
from teachers.oracle import Oracle
from worlds.testing import plain, require
from worlds.world import World

Make = Callable[..., AECEnv]
_ALLOWED = (  # warnings of PettingZoo's checkers about text observations
    "Observation is not a NumPy array",
    "(Observation|Action) space for each agent probably should be gymnasium.spaces.box or gymnasium.spaces.discrete",
    "Agents have different observation space sizes",
)


def check_seats(make: Make) -> None:
    """Run every check."""
    for check in CHECKS:
        check(make)


@contextmanager
def expected_warnings() -> Iterator[None]:
    """Ignore PettingZoo's three warnings about text observations; any other warning is an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for message in _ALLOWED:
            warnings.filterwarnings("ignore", message=message)
        yield


def check_pettingzoo(make: Make) -> None:
    """PettingZoo's four checkers pass with each form of speech, with and without text."""
    for speech, text in product(SPEECHES, (False, True)):

        def aec(speech: str = speech, text: bool = text) -> AECEnv:
            return make(speech=speech, text=text)

        def parallel(aec: Make = aec) -> Any:
            return turn_based_aec_to_parallel(aec())

        require_aec(aec)
        require_parallel(parallel)


def require_aec(make: Make) -> None:
    """PettingZoo's checkers of AEC environments."""
    with expected_warnings():
        api_test(make(), num_cycles=60, verbose_progress=False)
        seed_test(make, num_cycles=40)


def require_parallel(make: Callable[..., Any]) -> None:
    """PettingZoo's checkers of parallel environments."""
    with expected_warnings():
        parallel_api_test(make(), num_cycles=40)
        parallel_seed_test(make, num_cycles=40)


def check_turns(make: Make) -> None:
    """The teacher opens and has the last word; the horizon counts the student's turns; both seats end together."""
    env = make(speech="kinds", max_cycles=3)
    env.reset(seed=0)
    order = []
    for agent in env.agent_iter():
        _, _, terminated, truncated, _ = env.last()
        order.append((agent, terminated or truncated))
        env.step(None if terminated or truncated else _act(env, agent))
    alive = [agent for agent, dead in order if not dead]
    require(alive[0] == alive[-1] == TEACHER, f"the teacher does not have the first and the last word: {alive}")
    require(alive.count(STUDENT) <= 3, f"the student had {alive.count(STUDENT)} turns of 3")
    require(all(a != b for a, b in pairwise(alive)), f"the seats do not alternate: {alive}")
    require([agent for agent, dead in order if dead] == [STUDENT, TEACHER], f"the seats do not end together: {order}")


def check_silence(make: Make) -> None:
    """Saying nothing is always legal and gives the student no feedback; a true kind is said if asked for."""
    env = make(speech="kinds", cost=0.5)
    env.reset(seed=0)
    for turn in range(12):
        observation, _, terminated, truncated, _ = env.last()
        if terminated or truncated:
            break
        if env.agent_selection == TEACHER:
            mask, available = observation["action_mask"], observation["available"]
            require(mask[0] == 1, "silence is not legal")
            kinds = int(sum(int(bit) << i for i, bit in enumerate(available)))
            require(mask[kinds] == 1, "saying all that is true is not legal")
            said = kinds if turn % 4 == 0 else 0
            env.step(said)
            feedback = env.observe(STUDENT)["feedback"]
            require(bool(feedback) == bool(said), f"asked to say {said:05b}, the teacher said {feedback!r}")
            spoken = [atom for atom in getattr(feedback, "atoms", ()) if atom.kind is not None]
            require(env.rewards[TEACHER] == -0.5 * len(spoken), "the teacher does not pay the cost of each atom")
        else:
            env.step(_act(env, STUDENT))


def check_privilege(make: Make) -> None:
    """Only the teacher's info has the moment; the student gets neither the moment nor the reward."""
    env = make(speech="kinds")
    env.reset(seed=0)
    for _ in range(6):
        _, _, terminated, truncated, info = env.last()
        if terminated or truncated:
            break
        if env.agent_selection == STUDENT:
            require("moment" not in info and "reward" not in info, f"the student's info has {sorted(info)}")
            require(set(env.observe(STUDENT)) == {"state", "instruction", "feedback"}, "the student observes too much")
        else:
            require("moment" in info, "the teacher's info lacks the moment")
        env.step(_act(env, env.agent_selection))


def check_parse_failure(make: Make) -> None:
    """A text that is not an action costs a turn, gets feedback, and does not change the world."""
    env = make(speech="kinds", text=True, max_cycles=2)
    env.reset(seed=0)
    env.step(0)
    world = env.unwrapped.session.world
    before = plain(world.save())
    env.step("\x00 __import__('os') \x07")
    require(plain(world.save()) == before, "the world changed")
    require(env.observe(STUDENT)["feedback"] == "", "the teacher spoke before its turn")
    env.step(0)
    require("parse_failure" in env.infos[STUDENT], "the info has no `parse_failure`")
    require(env.observe(STUDENT)["feedback"] != "", "the feedback does not say what was expected")
    env.step("\x00")
    env.step(0)
    require(env.truncations[STUDENT], "turns that do not parse do not count")


def check_budget(make: Make) -> None:
    """A budget is kept exactly: 5 atoms, or one atom less than an episode has."""
    free = _said(make(speech="kinds", max_cycles=10))
    budget = max(min(5, free - 1), 1)
    spent = _said(make(speech="kinds", budget=budget, max_cycles=10))
    require(spent == budget, f"the teacher said {spent} atoms with a budget of {budget}, and {free} without one")


def _said(env: AECEnv) -> int:
    """The number of atoms in an episode with a teacher that says everything."""
    env.reset(seed=1)
    said = 0
    while env.agents:
        _, _, terminated, truncated, _ = env.last()
        if terminated or truncated:
            env.step(None)
        elif env.agent_selection == TEACHER:
            env.step(SUBSETS - 1)
            said += sum(atom.kind is not None for atom in env.observe(STUDENT)["feedback"].atoms)
        else:
            env.step(_act(env, STUDENT))
    return said


def check_lifetime(make: Make) -> None:
    """A lifetime passes PettingZoo's checkers; episodes begin alike; infos have the last step of the previous one."""

    def lifetime() -> AECEnv:
        return make(speech="kinds", episodes=3, max_cycles=2)

    require_aec(lifetime)
    env = lifetime()
    env.reset(seed=3)
    starts, endings = [], 0
    for agent in env.agent_iter():
        _, _, terminated, truncated, info = env.last()
        dead = terminated or truncated
        if agent == TEACHER and not dead and not info["moment"].turn:
            starts.append(plain(info["moment"].after))
        endings += "final_obs" in info
        env.step(None if dead else _act(env, agent))
    require(len(starts) == 3, f"a lifetime of 3 episodes had {len(starts)}")
    require(all(start == starts[0] for start in starts), "the episodes of a lifetime do not begin alike")
    require(endings == 2, f"the student's info had {endings} last steps of episodes, of 2")


def check_roles(make: Make) -> None:
    """Sentences contain the slots that claims declare, in a form that a student can use as its action."""
    for type_ in make().unwrapped.session.teacher.oracle.instruction_types:
        env = make(speech="kinds", instruction_type=type_, max_cycles=12)
        env.reset(seed=0)
        for agent in env.agent_iter():
            _, _, terminated, truncated, _ = env.last()
            env.step(None if terminated or truncated else _act(env, agent))
            if agent == TEACHER and env.agents:
                heard = env.observe(STUDENT)
                for said in (heard["instruction"], heard["feedback"]):
                    for atom in getattr(said, "atoms", ()):
                        require_role(atom, env.unwrapped.session.world)


def require_role(atom: Atom, world: World[Any]) -> None:
    """The action, the plan or the edit of a claim is in its sentence, if its class declares a slot, and can be read."""
    claim = atom.claim
    written: list[tuple[str, tuple[Any, ...], str]] = []
    if isinstance(claim, ActionClaim) and claim.action_slot:
        written.append((claim.action_slot, (claim.action,), ""))
    if isinstance(claim, PlanClaim) and claim.plan_slot:
        written.append((claim.plan_slot, claim.actions, claim.separator))
    for slot, actions, separator in written:
        text = f"{getattr(claim, slot)}"
        where = f"the slot {slot!r} of {type(claim).__name__} is {text!r}, in {atom.text!r}"
        require(
            text in atom.text, f"{where}: it is not in the sentence; add it to the phrase, or declare an empty slot"
        )
        parts = text.split(separator) if separator else [text]
        read = [read_exactly(part.strip('"'), world) for part in parts]
        require(plain(read) == plain(list(actions)), f"{where}: a student reads {read}, not {list(actions)}")
    if isinstance(claim, EditClaim):
        edit: list[tuple[str, Any]] = [(claim.line_slot, claim.line)]
        if not claim.cuts:
            edit.append((claim.words_slot, claim.words))
        for slot, value in edit:
            text = f"{getattr(claim, slot)}"
            right = text == f"{value}" and text in atom.text
            require(right, f"the slot {slot!r} of {type(claim).__name__} is {text!r}, not {value!r} in {atom.text!r}")


def _act(env: AECEnv, agent: str) -> Any:
    if agent == TEACHER:
        return SUBSETS - 1
    return env.unwrapped.session.world.sample_action(np.random.default_rng(0))


CHECKS: tuple[Callable[[Make], None], ...] = tuple(
    value for name, value in list(globals().items()) if name.startswith("check_") and name != "check_seats"
)
"""Every check of the seats."""


def check_family(family: Family) -> None:
    """Everything that a declaration names exists: classes, phrases, options, environments, the extra, the seats.

    Raises:
        AssertionError: something is missing; the message names it.
    """
    require(bool(family.environments and family.showcase), f"{family.name} has no environments, or no showcase")
    oracle = _named(family, "oracle", family.oracle_class)
    require(isinstance(oracle, type) and issubclass(oracle, Oracle), f"{family.oracle} is no Oracle")
    _named(family, "phrases", family.phrasebook)
    for environment, options in family.environments.items():
        world = _named(family, environment, partial(family.make_world, **options))
        require(isinstance(world, World), f"{family.world} is no World")
        world.close()
    named = {*family.showcase, *family.sampled, *family.aliases.values()}
    unknown = sorted(named - family.environments.keys())
    require(not unknown, f"{family.name} names environments that it does not have: {', '.join(unknown)}")
    taken = sorted(family.aliases.keys() & family.environments.keys())
    require(not taken, f"{family.name} has environments with the names of aliases: {', '.join(taken)}")
    extras = metadata.metadata(family.distribution).get_all("Provides-Extra") or [] if family.extra else [""]
    require(family.extra in extras, f"{family.distribution} has no extra {family.extra!r}; it has {', '.join(extras)}")
    module = importlib.import_module(family.module or f"pz_envs.families.{family.name}")
    missing = [name for name in ("env", "raw_env", "parallel_env") if not hasattr(module, name)]
    require(not missing, f"{module.__name__} lacks {', '.join(missing)}")


def _named(family: Family, what: str, load: Callable[[], Any]) -> Any:
    """The object that a declaration names."""
    try:
        return load()
    except Exception as error:
        raise AssertionError(f"{family.name} declares {what}, which fails to load: {error!r}") from error
