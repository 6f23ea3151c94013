"""Conformance kits: for oracles with their phrases, `check_oracle(Pupil(...))`; for personalities, `check_personality`.

Each check takes a `Pupil`, which plays under the oracle's eyes, and raises an AssertionError that says what is wrong.
"""

import dataclasses
import itertools
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from teachers.atoms import KINDS, ActionClaim, Atom, Claim, EditClaim, Moment, PlanClaim
from teachers.oracle import ABILITIES, Oracle, RefusalError
from teachers.personalities.delayed import Delayed
from teachers.personality import Personality, parse_personality, stages_of
from teachers.spec import read_call, read_expression
from teachers.teacher import Teacher
from worlds.testing import plain, require
from worlds.world import World

_JSON = (str, int, float, bool, type(None))


class Heard(NamedTuple):
    """What was said in a turn."""

    moment: Moment
    atoms: tuple[Atom, ...]
    """The feedback."""
    true: tuple[Claim, ...]
    """What the oracle would have said."""


@dataclass(frozen=True)
class Pupil:
    """A world with the means to teach it."""

    make_world: Callable[[], World]
    make_teacher: Callable[..., Teacher]
    """Takes a world and the keyword arguments of `Teacher`."""
    max_turns: int = 20
    turns: int = 100
    """Turns that a check plays."""

    def moments(self, world: World, seed: int = 0) -> Iterator[Moment]:
        """Random play, episode after episode; each opens with an opening moment."""
        rng = np.random.default_rng(seed)
        played = 0
        while played < self.turns:
            world.reset(seed=int(rng.integers(2**31)))
            moment = Moment.opening(world.truth)
            yield moment
            for turn in range(1, self.max_turns + 1):
                before, action = world.truth, world.legal(world.sample_action(rng))
                _, reward, terminated, truncated, info = world.advance(action)
                over = terminated or truncated or turn == self.max_turns
                yield Moment(before, action, reward, world.truth, info["success"], turn, over)
                played += 1
                if over or played == self.turns:
                    break

    def episodes(self, turns: int) -> list[list[Moment]]:
        """Episodes, at least so many turns in all, of a student who follows a plan, tries something, or insists."""
        world = self.make_world()
        oracle = self.make_teacher(world).oracle
        rng = np.random.default_rng(0)
        played: list[list[Moment]] = []
        while sum(map(len, played)) - len(played) < turns:
            world.reset(seed=int(rng.integers(2**31)))
            oracle.start(world.truth)
            moments = [Moment.opening(world.truth)]
            for turn in range(1, self.max_turns + 1):
                draw, plan = rng.random(), oracle.plan(world.truth, 1)
                if draw < 0.4 and plan:
                    action = plan[0]
                elif draw < 0.7 and turn > 1:
                    action = moments[-1].action
                else:
                    action = world.sample_action(rng)
                before, action = world.truth, world.legal(action)
                _, reward, terminated, truncated, info = world.advance(action)
                over = terminated or truncated or turn == self.max_turns
                moments.append(Moment(before, action, reward, world.truth, info["success"], turn, over))
                if over:
                    break
            played.append(moments)
        return played

    def taught(self, personality: str | Personality, turns: int) -> list[list[Heard]]:
        """What a teacher says in these episodes, turn by turn."""
        teacher = self.make_teacher(self.make_world(), personality)
        rng = np.random.default_rng(0)
        heard: list[list[Heard]] = []
        for moments in self.episodes(turns):
            teacher.reset(rng.spawn(1)[0])
            heard.append([])
            for moment in moments:
                atoms = tuple(atom for atom in teacher.speak(moment).atoms if atom.kind is not None)
                heard[-1].append(Heard(moment, atoms, teacher.oracle.judge(moment)))
        return heard

    def atoms(self, seed: int = 0, **settings: Any) -> Iterator[tuple[Atom, Moment, World]]:
        """All that a teacher says of random play, each atom with the moment that it is about and a lab."""
        for said in self.said(settings, seed=seed):
            yield from said

    def said(self, *teachers: Mapping[str, Any], seed: int = 0) -> Iterator[list[tuple[Atom, Moment, World]]]:
        """The same, turn by turn, of teachers with different settings who watch the same play."""
        world = self.make_world()
        lab = world.scratch()
        watching = [self.make_teacher(world, **settings) for settings in teachers]
        rng = np.random.default_rng(seed)
        history: list[Moment] = []
        for moment in self.moments(world, seed):
            if moment.turn == 0:
                for teacher in watching:
                    teacher.reset(rng.spawn(1)[0])
                history = []
            history.append(moment)
            yield [(atom, history[atom.about_turn], lab) for each in watching for atom in each.speak(moment).atoms]

    def judged(self, seed: int = 0) -> Iterator[tuple[Oracle, Moment]]:
        """An oracle that has started its episode, and a moment of it."""
        world = self.make_world()
        oracle = self.make_teacher(world).oracle
        for moment in self.moments(world, seed):
            if moment.turn == 0:
                oracle.start(moment.after)
            yield oracle, moment


def check_oracle(pupil: Pupil) -> None:
    """Run every check."""
    for check in CHECKS:
        check(pupil)


def check_honesty(pupil: Pupil) -> None:
    """All that is said without a distorting personality holds, whatever the type of the instruction."""
    types = _teaching(pupil).instruction_types
    for said in pupil.said(*({"instruction_type": type_} for type_ in types)):
        # Most is said with every instruction, and some of it takes long to check.
        for (claim, _), (moment, lab) in {(atom.claim, atom.about_turn): about for atom, *about in said}.items():
            require(claim.holds(moment, lab), f"{claim} does not hold of {moment}")


def check_distortion(pupil: Pupil) -> None:
    """A distorted claim is false, and there is one for every kind of feedback that the oracle gives."""
    rng = np.random.default_rng(0)
    lab = pupil.make_world().scratch()
    distorted = set()
    for oracle, moment in pupil.judged():
        for claim in oracle.judge(moment):
            false = oracle.distort(claim, moment, rng)
            if false is not None:
                require(not false.holds(moment, lab), f"{false}, distorted from {claim}, holds of {moment}")
                distorted.add(claim.kind)
    missing = set(_teaching(pupil).feedback_types) - distorted
    require(not missing, f"no false counterpart was found for {missing}")


def check_hints(pupil: Pupil) -> None:
    """What a claim says coarser is of its kind, can be worded, and holds, too."""
    lab = pupil.make_world().scratch()
    voice = pupil.make_teacher(pupil.make_world()).voice
    for oracle, moment in pupil.judged():
        for claim in oracle.judge(moment):
            for hint in claim.coarser(moment, lab) if claim.holds(moment, lab) else ():
                require(hint.kind is claim.kind, f"{hint}, coarser than {claim}, is of kind {hint.kind}")
                require(hint.holds(moment, lab), f"{hint}, coarser than {claim}, does not hold of {moment}")
                voice.words(hint)


def check_kinds(pupil: Pupil) -> None:
    """All kinds that the oracle gives occur, in speaking order; asking for fewer gives just those of these claims."""
    seen = set()
    order = list(KINDS).index
    for oracle, moment in pupil.judged():
        claims = oracle.judge(moment)
        kinds = [claim.kind for claim in claims]
        require(kinds == sorted(kinds, key=order), f"kinds {kinds} are not in speaking order")
        seen.update(kinds)
        for kind in KINDS:
            wanted = tuple(claim for claim in claims if claim.kind == kind)
            got = oracle.judge(moment, frozenset((kind,)))
            require(got == wanted, f"asked for {kind}, the oracle says {got} instead of {wanted}")
    given = set(_teaching(pupil).feedback_types)
    require(not given - seen, f"{given - seen} never occur in {pupil.turns} random turns")
    require(not seen - given, f"{seen - given} occur, but are not among the oracle's feedback_types")


def check_no_meddling(pupil: Pupil) -> None:
    """Judging leaves the taught world as it is."""
    world = pupil.make_world()
    oracle = pupil.make_teacher(world).oracle
    for moment in pupil.moments(world):
        before = plain(world.save())
        if moment.turn == 0:
            oracle.start(moment.after)
            for instruction_type in oracle.instruction_types:
                oracle.brief(moment.after, instruction_type, np.random.default_rng(0))
        oracle.judge(moment)
        oracle.importance(moment.after)
        oracle.plan(moment.after, 3)
        require(plain(world.save()) == before, f"the oracle changed the world while judging {moment}")


def check_claims(pupil: Pupil) -> None:
    """Claims are hashable values of JSON's types; the actions that they name are legal and canonical."""
    world = pupil.make_world()
    for instruction_type in _teaching(pupil).instruction_types:
        for atom, _, _ in pupil.atoms(instruction_type=instruction_type):
            claim: Claim = atom.claim
            for field in dataclasses.fields(claim):  # type: ignore[arg-type]  # a dataclass
                _require_json(claim, field.name, getattr(claim, field.name))
            hash(claim)
            actions = (claim.action,) if isinstance(claim, ActionClaim) else ()
            if isinstance(claim, PlanClaim):
                require(claim.actions, f"{claim} is a plan of no action")
                actions += claim.actions
            for action in actions:
                require(
                    plain(world.legal(action)) == plain(action), f"the action {action!r} in {claim} is not canonical"
                )
            if isinstance(claim, EditClaim):
                require(claim.line >= 1, f"the line of {claim} is not counted from 1")


def _require_json(claim: Claim, name: str, value: Any) -> None:
    """A number of NumPy's is written in another way than Python's, or not at all."""
    if isinstance(value, tuple):
        for item in value:
            _require_json(claim, name, item)
    else:
        require(
            type(value) in _JSON or isinstance(value, Enum),
            f"the field {name!r} of the claim {type(claim).__name__} holds {value!r} of type {type(value).__name__}; "
            "allowed: str, int, float, bool, None, enumerations, and tuples of these; convert it, as in x.item()",
        )


def check_plans(pupil: Pupil) -> None:
    """Following the plan has no regret; importance lies between 0 and `max_importance`; regret is never negative.

    An oracle that plans nothing may refuse to tell regrets.
    """
    world = pupil.make_world()
    oracle = pupil.make_teacher(world).oracle
    planned = False
    for seed in range(10):
        world.reset(seed=seed)
        oracle.start(world.truth)
        for turn, action in enumerate(oracle.plan(world.truth, pupil.max_turns), 1):
            before = world.truth
            _, reward, _, _, info = world.advance(world.legal(action))
            planned = True
            moment = Moment(before, action, reward, world.truth, info["success"], turn, False)
            require(
                abs(oracle.regret(moment)) < 1e-9, f"the plan's action has regret {oracle.regret(moment)}: {moment}"
            )
    for oracle, moment in pupil.judged():
        importance = oracle.importance(moment.after)
        require(0 <= importance <= oracle.max_importance, f"importance {importance} exceeds {oracle.max_importance}")
        if moment.before is not None:
            try:
                regret = oracle.regret(moment)
            except RefusalError:
                require(not planned, "the oracle plans, but refuses to tell regrets")
                return
            require(regret >= 0, f"negative regret {regret}: {moment}")


def check_determinism(pupil: Pupil) -> None:
    """The same seeds give the same words."""
    for instruction_type in _teaching(pupil).instruction_types:
        first, again = ([atom.text for atom, _, _ in pupil.atoms(instruction_type=instruction_type)] for _ in range(2))
        require(first == again, "two teachers with the same seed say different things")


def _teaching(pupil: Pupil) -> Oracle:
    return pupil.make_teacher(pupil.make_world()).oracle


CHECKS: tuple[Callable[[Pupil], None], ...] = (
    check_honesty,
    check_distortion,
    check_hints,
    check_kinds,
    check_no_meddling,
    check_claims,
    check_plans,
    check_determinism,
)
"""Every check of an oracle."""


def check_personality(personality: str | Personality, pupil: Pupil) -> None:
    """Run every check of a personality.

    Args:
        personality: one, or its spec.
        pupil: whom it teaches; of a family that has what the personality needs.
    """
    for check in PERSONALITY_CHECKS:
        check(parse_personality(personality), pupil)


def check_spec(personality: Personality, pupil: Pupil) -> None:
    """It is a frozen value with defaults that its spec string gives back, and it says where it comes from."""
    for stage in stages_of(personality):
        cls = type(stage)
        require(cls.__doc__ and stage.source, f"{stage} has no docstring of its own, or no source")
        require(cls() and hash(stage) is not None, f"{stage} needs a default for each parameter")
        call = read_call(read_expression(str(stage)))
        require(call is not None and cls(**call[1]) == stage, f"the spec {stage} does not give back its value")
        require(stage.needs <= set(ABILITIES), f"{stage} needs {set(stage.needs)}, not of {ABILITIES}")
        definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")[2]
        require(definition, f"the module of {stage} must begin with a docstring such as 'name: what it does.'")


def check_promise(personality: Personality, pupil: Pupil) -> None:
    """An honest one says nothing false; of another one all that the oracle would not have said is false, and occurs."""
    lab = pupil.make_world().scratch()
    invented = 0
    for episode in pupil.taught(personality, pupil.turns):
        for _, atoms, true in episode:
            for atom in atoms:
                moment = episode[atom.about_turn].moment
                if personality.honest:
                    require(atom.claim.holds(moment, lab), f"{personality}: {atom.claim} does not hold of {moment}")
                elif atom.claim not in true:
                    require(not atom.claim.holds(moment, lab), f"{personality}: {atom.claim} holds of {moment}")
                    invented += 1
    require(
        personality.honest or invented, f"{personality} is not honest, but says nothing false in {pupil.turns} turns"
    )


def check_draws(personality: Personality, pupil: Pupil) -> None:
    """The same seeds give the same words."""
    first, again = (
        [[heard.atoms for heard in episode] for episode in pupil.taught(personality, pupil.turns)] for _ in range(2)
    )
    require(first == again, f"with the same seed {personality} says different things")


def check_hands_off(personality: Personality, pupil: Pupil) -> None:
    """Speaking leaves the taught world as it is."""
    world = pupil.make_world()
    teacher = pupil.make_teacher(world, personality)
    for moment in pupil.moments(world):
        if moment.turn == 0:
            teacher.reset(np.random.default_rng(0))
        before = plain(world.save())
        teacher.speak(moment)
        require(plain(world.save()) == before, f"{personality} changed the world")


def check_words(personality: Personality, pupil: Pupil) -> None:
    """What is said has words, and means the same in another process."""
    lab = pupil.make_world().scratch()
    for episode in pupil.taught(personality, pupil.turns):
        for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
            twin, moment = pickle.loads(pickle.dumps(atom)), episode[atom.about_turn].moment  # noqa: S301  # its own
            require(atom.text.strip(), f"{personality} has no words for {atom.claim}")
            require(
                twin == atom and twin.claim.holds(moment, lab) == atom.claim.holds(moment, lab),
                f"{atom.claim} of {personality} is another claim after pickling",
            )


def check_stages(personality: Personality, pupil: Pupil) -> None:
    """It works after and before others: what it is given late is said late, and what it says can come late."""
    for pipeline in (Delayed() | personality, personality | Delayed()):
        lab = pupil.make_world().scratch()
        for episode in pupil.taught(pipeline, pupil.turns):
            for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
                moment = episode[atom.about_turn].moment
                holds = atom.claim.holds(moment, lab)
                require(holds or not personality.honest, f"{pipeline}: {atom.claim} does not hold of {moment}")


PERSONALITY_CHECKS: tuple[Callable[[Personality, Pupil], None], ...] = (
    check_spec,
    check_promise,
    check_draws,
    check_hands_off,
    check_words,
    check_stages,
)
"""Every check of a personality."""
