"""The conformance kit for personalities.

Each check takes a personality and the `Pupil` that it teaches, and raises an AssertionError that says what is wrong.
"""

import copy
import itertools
import pickle
import sys
from collections.abc import Callable, Iterable

import numpy as np

from teachers.atoms import (
    FP,
    ActionClaim,
    Atom,
    EditClaim,
    Grounded,
    HedgedClaim,
    Moment,
    PlanClaim,
    contradictions,
    unhedged,
)
from teachers.common import hedge
from teachers.information import DrawnWorld
from teachers.oracle import ABILITIES
from teachers.personalities.delayed import Delayed
from teachers.personality import Claims, Personality, Pipeline, View, parse_personality, stages_of
from teachers.personality import personality as make_personality
from teachers.session import Session
from teachers.spec import parse_call
from teachers.testing.pupil import Pupil
from worlds.testing import plain, require
from worlds.world import WorldTurn


def check_personality(personality: str | Personality, pupil: Pupil) -> None:
    """Run every check of a personality.

    Args:
        personality: a personality, or its spec.
        pupil: of a family whose oracle has the abilities that the personality needs.
    """
    for check in PERSONALITY_CHECKS:
        check(parse_personality(personality), pupil)


def check_spec(personality: Personality, pupil: Pupil) -> None:
    """It is a frozen value with defaults, its spec string round-trips, and it states its source."""
    for stage in stages_of(personality):
        cls = type(stage)
        require(cls.__doc__ and stage.source, f"{stage} has no docstring of its own, or no source")
        require(cls() and hash(stage) is not None, f"{stage} needs a default for each parameter")
        call = parse_call("personality", str(stage), "`name` or `name(key=value)`", prefixes=1)
        require(cls(**call.arguments) == stage, f"the spec {stage} does not give back its value")
        require(stage.needs <= set(ABILITIES), f"{stage} needs {set(stage.needs)}, not of {ABILITIES}")
        definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")[2]
        require(definition, f"the module of {stage} must begin with a docstring such as 'name: what it does.'")


def check_promise(personality: Personality, pupil: Pupil) -> None:
    """If it is honest, all its flat claims are true; if not, it adds false claims to the oracle's, or bends hedges.

    If it does not reveal what to do, it gives no advice with an action. For claims of other moments see
    `check_elsewhere`.
    """
    lab = pupil.make_world().scratch()
    invented = 0
    for episode in pupil.taught(personality, pupil.turns):
        for _, atoms, true in episode:
            for atom in atoms:
                moment = episode[atom.about_turn].moment
                advises = atom.kind is FP and isinstance(unhedged(atom.claim), ActionClaim | PlanClaim | EditClaim)
                require(personality.reveals or not advises, f"{personality} does not reveal, but says {atom.claim}")
                if isinstance(atom.claim, HedgedClaim):
                    continue  # neither true nor false
                if personality.honest:
                    require(atom.claim.holds(moment, lab), f"{personality}: {atom.claim} does not hold of {moment}")
                elif atom.claim not in true and not personality.elsewhere:
                    require(not atom.claim.holds(moment, lab), f"{personality}: {atom.claim} holds of {moment}")
                    invented += 1
    told = personality.honest or personality.elsewhere or invented or _bends(personality, pupil)
    require(told, f"{personality} is not honest, but says nothing false in {pupil.turns} turns")


def _bends(personality: Personality, pupil: Pupil) -> bool:
    """Whether it changes the probability of hedges, and so misleads without a false claim."""
    hedges = Pipeline((_unsure(), personality))
    said = [atom.claim for episode in pupil.taught(hedges, pupil.turns) for _, atoms, _ in episode for atom in atoms]
    return any(isinstance(claim, HedgedClaim) and claim.p != _SURE for claim in said)


_SURE = 0.8


@make_personality(source="ours")
def _unsure(claims: Claims, view: View) -> Claims:
    """Hedges every claim, as a teacher without the truth."""
    return [hedge(claim, _SURE) for claim in claims]


def check_elsewhere(personality: Personality, pupil: Pupil) -> None:
    """If its claims are those of other moments, each is true of the moment that it is from, and some are not here."""
    if not personality.elsewhere:
        return
    world = pupil.make_world()
    lab = world.scratch()
    session = pupil.session(world, pupil.make_teacher(world, personality))
    false = 0
    for seed, episode in enumerate(pupil.episodes(pupil.turns)):
        session.open(seed)
        for moment, atoms in zip(episode, _watch(session, episode), strict=True):
            for atom in (each for each in atoms if each.kind is not None):
                there = session.origin(atom)
                require(there is not None, f"{personality} says {atom.claim} of no other moment, at {moment}")
                assert there is not None  # noqa: S101  # or that was an error
                require(
                    atom.claim.holds(there, lab), f"{personality}: {atom.claim} does not hold elsewhere, of {there}"
                )
                false += not atom.claim.holds(episode[atom.about_turn], lab)
    require(false, f"{personality} says of other moments only what is true here, in {pupil.turns} turns")


def check_meaning(personality: Personality, pupil: Pupil) -> None:
    """If it is honest, it never contradicts itself in a turn; its grounded claims are true by their fields alone."""
    world = pupil.make_world()
    session = pupil.session(world, pupil.make_teacher(world, personality))
    for seed, episode in enumerate(pupil.episodes(pupil.turns)):
        session.open(seed)
        for moment in episode:
            session.follow(moment)
            session.speak()
            said = [atom for atom in session.atoms if atom.kind is not None]
            clashes = contradictions(said) if personality.honest else []
            require(not clashes, f"{personality} contradicts itself of {moment}: {clashes}")
            for atom in said:
                claim, about = atom.claim, episode[atom.about_turn]
                if isinstance(claim, Grounded) and claim.holds(about, session.teacher.oracle.lab):
                    means = claim.means(about, session.teacher.oracle)
                    require(
                        means, f"{personality}: {claim} holds by its ground, but not by its fields alone, of {about}"
                    )


def check_draws(personality: Personality, pupil: Pupil) -> None:
    """The same seeds give the same words."""
    first, again = (
        [[heard.atoms for heard in episode] for episode in pupil.taught(personality, pupil.turns)] for _ in range(2)
    )
    require(first == again, f"with the same seed {personality} says different things")


def check_speaking_changes_nothing(personality: Personality, pupil: Pupil) -> None:
    """Speaking does not change the taught world."""
    world = pupil.make_world()
    session = pupil.session(world, pupil.make_teacher(world, personality))
    for _ in pupil.play(session):
        before = plain(world.save())
        session.speak()
        require(plain(world.save()) == before, f"{personality} changed the world")


def check_words(personality: Personality, pupil: Pupil) -> None:
    """Each claim has words, and pickling does not change whether it holds."""
    lab = pupil.make_world().scratch()
    for episode in pupil.taught(personality, pupil.turns):
        for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
            twin, moment = pickle.loads(pickle.dumps(atom)), episode[atom.about_turn].moment  # noqa: S301  # its own
            require(atom.text.strip(), f"{personality} has no words for {atom.claim}")
            require(
                twin == atom and twin.claim.holds(moment, lab) == atom.claim.holds(moment, lab),
                f"{atom.claim} of {personality} is another claim after pickling",
            )


def check_copies(personality: Personality, pupil: Pupil) -> None:
    """Copies of a teacher within an episode, by `deepcopy` or pickle, continue like the original."""
    world = pupil.make_world()
    teacher = pupil.make_teacher(world, personality)
    session = pupil.session(world, teacher)
    for number, episode in enumerate(pupil.episodes(min(pupil.turns, 4 * pupil.max_turns))):
        session.open(number)
        half = len(episode) // 2
        _watch(session, episode[:half])
        twins = [copy.deepcopy(teacher), pickle.loads(pickle.dumps(teacher))]  # noqa: S301  # its own
        expected = _watch(session, episode[half:])
        for twin in twins:
            same = _watch(pupil.session(world, twin), episode[half:]) == expected
            require(same, f"a copy of a teacher that is {personality} does not continue like the original")


def _watch(session: Session, moments: Iterable[Moment]) -> list[tuple[Atom, ...]]:
    """The atoms about given moments, turn by turn."""
    said = []
    for moment in moments:
        session.follow(moment)
        session.speak()
        said.append(session.atoms)
    return said


def check_stages(personality: Personality, pupil: Pupil) -> None:
    """It works after and before other stages: late claims stay late, and its own claims can be delayed."""
    for pipeline in (Delayed() | personality, personality | Delayed()):
        lab = pupil.make_world().scratch()
        for episode in pupil.taught(pipeline, pupil.turns):
            for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
                moment = episode[atom.about_turn].moment
                holds = isinstance(atom.claim, HedgedClaim) or atom.claim.holds(moment, lab)
                require(holds or not personality.honest, f"{pipeline}: {atom.claim} does not hold of {moment}")


def check_evidence(personality: Personality, pupil: Pupil) -> None:
    """If it does not see the truth, it says the same in every world with the same evidence.

    A personality with a random walk of its own is not checked: its evidence is unknown.
    """
    if personality.evidence not in ("student", "rewards"):
        return
    world = pupil.make_world()
    teacher = pupil.make_teacher(world, personality)
    session = pupil.session(world, teacher)
    context = pupil.make_teacher(world, personality).posterior_context
    require(context, f"{personality} does not see the truth, so that it needs a posterior")
    assert context is not None  # noqa: S101  # or that was an error
    for number, episode in enumerate(pupil.episodes(min(pupil.turns, 4 * pupil.max_turns))):
        turns = [
            WorldTurn(None if moment.before is None else moment.action, moment.reward, moment.after, moment.success)
            for moment in episode
        ]
        if personality.evidence == "rewards":
            turns = [turn._replace(reward_known=turn.action is not None) for turn in turns]
        draw = next(context.posterior.draws(turns, np.random.default_rng(number)))
        other = DrawnWorld(draw, episode)
        said = []
        for moments in (episode, [other.moment(turn) for turn in range(len(episode))]):
            session.open(number)
            said.append(_watch(session, moments))
        require(
            said[0] == said[1],
            f"{personality} says other things in a world that it cannot distinguish by its evidence, "
            f"{personality.evidence!r}: it knows more",
        )


PERSONALITY_CHECKS: tuple[Callable[[Personality, Pupil], None], ...] = (
    check_spec,
    check_promise,
    check_elsewhere,
    check_meaning,
    check_draws,
    check_speaking_changes_nothing,
    check_words,
    check_copies,
    check_stages,
    check_evidence,
)
"""Every check of a personality."""
