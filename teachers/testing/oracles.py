"""The conformance kit for oracles and their phrases.

Each check takes a `Pupil`, which plays random actions for the oracle to judge, and raises an AssertionError that says
what is wrong.
"""

import dataclasses
from collections.abc import Callable
from enum import Enum
from itertools import combinations
from typing import Any

import numpy as np

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    KINDS,
    ActionClaim,
    Claim,
    EditClaim,
    FeedbackType,
    Moment,
    ParseFailure,
    PlanClaim,
    action_of,
    path_of,
)
from teachers.oracle import Oracle, RefusalError
from teachers.testing.habits import HABITS
from teachers.testing.pupil import Pupil
from teachers.testing.wording import check_wording
from worlds.testing import plain, require

_CLUES, _SCOPE = 1, 2  # seeds of play
_SCOPE_SHARE = 4  # the check of scopes, which is slow, plays a fourth of the turns
_SHORT = 20  # times as many turns of random play as of each habit
_EPISODES = 10  # of a student that acts by the values
_NEAR = 1e-9  # differences of values below this are rounding
_JSON = (str, int, float, bool, type(None))


def check_oracle(pupil: Pupil) -> None:
    """Run every check."""
    for check in CHECKS:
        check(pupil)


def check_honesty(pupil: Pupil) -> None:
    """All claims of an honest teacher hold, whatever the type of the instruction and the student.

    Students with each of the `HABITS` play some of the turns.
    """
    teachers = [{"instruction_type": type_} for type_ in _teaching(pupil).instruction_types]
    short = dataclasses.replace(pupil, turns=-(-pupil.turns // _SHORT))
    for habit in ("", *HABITS):
        for said in (short if habit else pupil).said(*teachers, habit=habit):
            # Most claims are made with every instruction, and some take long to check.
            once = {(atom.claim, atom.about_turn): (moment, lab) for atom, moment, lab in said}
            for (claim, _), (moment, lab) in once.items():
                require(claim.holds(moment, lab), f"{claim} does not hold of {moment} ({habit or 'random'} play)")


def check_contradictions(pupil: Pupil) -> None:
    """No two claims about a moment exclude each other."""
    for oracle, moment in pupil.judged():
        for one, other in combinations(oracle.judge(moment), 2):
            clash = one.excludes(other) or other.excludes(one)
            require(not clash, f"{one} and {other} contradict each other (`Claim.excludes`), and are said of {moment}")


def check_distortion(pupil: Pupil) -> None:
    """Distorted claims are false, and every kind of feedback that the oracle gives can be distorted."""
    rng = np.random.default_rng(0)
    lab = pupil.make_world().scratch()
    distorted = set()
    for oracle, moment in pupil.judged():
        for claim in oracle.judge(moment):
            false = oracle.distort(claim, moment, rng)
            if false is not None:
                require(not false.holds(moment, lab), f"{false}, distorted from {claim}, holds of {moment}")
                distorted.add(claim.kind)
    for kind in _teaching(pupil).feedback_types:
        require(
            kind in distorted,
            f"no claim of the kind {kind} had a false counterpart in {pupil.turns} random turns; the `counterparts` of "
            "some claim of this kind must have one that does not hold",
        )


def check_hints(pupil: Pupil) -> None:
    """The coarser claims of a true claim have its kind, have phrases, and hold."""
    lab = pupil.make_world().scratch()
    voice = pupil.make_teacher(pupil.make_world()).voice
    for oracle, moment in pupil.judged():
        for claim in oracle.judge(moment):
            for hint in claim.coarser(moment, lab) if claim.holds(moment, lab) else ():
                require(hint.kind is claim.kind, f"{hint}, coarser than {claim}, is of kind {hint.kind}")
                require(hint.holds(moment, lab), f"{hint}, coarser than {claim}, does not hold of {moment}")
                voice.words(hint)


def check_clues(pupil: Pupil) -> None:
    """Clues are true, also after a text that did not parse, and by their fields alone; they help with the next action.

    They are of the kinds fp and fn and name no action. None repeats or excludes another, and some can be made false.
    """
    lab = pupil.make_world().scratch()
    voice = pupil.make_teacher(pupil.make_world()).voice
    allowed = {FP, FN} & set(_teaching(pupil).feedback_types)
    given = distorted = False
    short = dataclasses.replace(pupil, turns=-(-pupil.turns // _SHORT))
    for habit in ("", "garbling"):
        for oracle, moment in (short if habit else pupil).judged(_CLUES, habit):
            clues = oracle.clues(moment.after)
            require(clues == oracle.clues(moment.after), f"asked again, the oracle gives other clues of {moment}")
            require(len(set(clues)) == len(clues), f"a clue is given twice: {clues}")
            for one, other in combinations(clues, 2):
                clash = one.excludes(other) or other.excludes(one)
                require(not clash, f"{one} and {other} contradict each other (`Claim.excludes`), and are clues")
            for clue in clues:
                require(clue.kind in allowed, f"the clue {clue} is of kind {clue.kind}; allowed: {sorted(allowed)}")
                names = isinstance(clue, ActionClaim | PlanClaim | EditClaim)
                require(not names, f"the clue {clue} names an action; `judge` gives advice")
                require(not clue.placebo, f"the clue {clue} says nothing of the task")
                require(clue.holds(moment, lab), f"the clue {clue} does not hold of {moment}")
                require(clue.means(moment, oracle), f"the clue {clue} holds, but not by its fields alone, of {moment}")
                voice.words(clue)
                given, distorted = True, distorted or bool(oracle.falsehoods(clue, moment))
    able = "clues" in _teaching(pupil).abilities()
    require(
        given == able, f"the oracle {'gives no clue' if able else 'gives clues'} in random play; see `Oracle.clues`"
    )
    require(distorted or not given, "no clue has a false counterpart in random play; see `Claim.counterparts`")


def check_scope(pupil: Pupil) -> None:
    """A claim whose scope is the world or the family stays true for the whole episode."""
    lab = pupil.make_world().scratch()
    lasting: dict[Claim, None] = {}
    for oracle, moment in dataclasses.replace(pupil, turns=-(-pupil.turns // _SCOPE_SHARE)).judged(_SCOPE):
        claims = oracle.judge(moment) + oracle.clues(moment.after)
        if moment.turn == 0:
            lasting = {}
            claims += oracle.brief(moment.after, oracle.instruction_types[-1], np.random.default_rng(0))
        for claim in lasting:
            require(
                claim.holds(moment, lab), f"{claim}, of the scope {claim.scope}, was true before, but not of {moment}"
            )
        lasting |= {each: None for each in claims if each.scope.lasts and each.holds(moment, lab)}


def check_kinds(pupil: Pupil) -> None:
    """All kinds of the oracle occur, in speaking order; `judge` with fewer kinds gives exactly their claims."""
    seen = set()
    order: list[FeedbackType | None] = list(KINDS)
    for oracle, moment in pupil.judged():
        claims = oracle.judge(moment)
        kinds = [claim.kind for claim in claims]
        for claim in claims:
            require(
                claim.kind in order,
                f"{path_of(type(claim))} is feedback, but has no kind; set `kind` of the class to R, HP, HN, FP or FN",
            )
        require(kinds == sorted(kinds, key=order.index), f"kinds {kinds} are not in speaking order")
        seen.update(kinds)
        for kind in KINDS:
            wanted = tuple(claim for claim in claims if claim.kind == kind)
            got = oracle.judge(moment, frozenset((kind,)))
            require(got == wanted, f"judge with the kind {kind} gives {got} instead of {wanted}")
    given = set(_teaching(pupil).feedback_types)
    unsaid = ", ".join(kind for kind in KINDS if kind in given - seen)
    more = ", ".join(kind for kind in KINDS if kind in seen - given)
    require(
        not unsaid, f"the oracle's feedback_types have {unsaid}, of which it says nothing in {pupil.turns} random turns"
    )
    require(not more, f"the oracle says {more}, which its feedback_types lack")


def check_judging_changes_nothing(pupil: Pupil) -> None:
    """Judging does not change the taught world."""
    world = pupil.make_world()
    oracle = pupil.make_teacher(world).oracle
    for moment in pupil.moments(world):
        before = plain(world.save())
        if moment.turn == 0:
            oracle.start(moment.after)
            for instruction_type in oracle.instruction_types:
                oracle.brief(moment.after, instruction_type, np.random.default_rng(0))
        oracle.judge(moment)
        oracle.clues(moment.after)
        oracle.importance(moment.after)
        oracle.plan(moment.after, 3)
        require(plain(world.save()) == before, f"the oracle changed the world while judging {moment}")


def check_claims(pupil: Pupil) -> None:
    """Claims are hashable values of JSON types; their actions are legal and canonical."""
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
    """Refuse NumPy's numbers: JSON writes them differently, or not at all."""
    if isinstance(value, tuple):
        for item in value:
            _require_json(claim, name, item)
    else:
        require(
            type(value) in _JSON or isinstance(value, Enum),
            f"the field {name!r} of the claim {type(claim).__name__} holds {value!r} of type {type(value).__name__}; "
            "allowed: str, int, float, bool, None, enumerations, and tuples of these; convert it, as in x.item()",
        )


def check_instructions(pupil: Pupil) -> None:
    """Instructions have no claim twice; there is always `b`, to which `p` adds hindsight and `c` parts of no kind."""
    types = _teaching(pupil).instruction_types
    require(
        types == tuple(t for t in "bpc" if t in types) and "b" in types, f"instruction_types {types} are not b, p, c"
    )
    world = pupil.make_world()
    for seed in range(5):
        world.reset(seed=seed)
        oracle = pupil.make_teacher(world).oracle
        oracle.start(world.truth)
        basic = oracle.brief(world.truth, "b")
        for type_ in types:
            claims = oracle.brief(world.truth, type_, np.random.default_rng(seed))
            require(
                len(set(claims)) == len(claims) > 0, f"the instruction {type_} is empty, or repeats itself: {claims}"
            )
            more = claims[len(basic) :]
            require(
                claims[: len(basic)] == basic, f"the instruction {type_} does not begin with that of type b: {claims}"
            )
            require(more or type_ == "b", f"the instruction {type_} adds nothing to that of type b")
            kinds = {claim.kind for claim in more}
            allowed = {HP, HN} if type_ == "p" else {None}
            require(kinds <= allowed, f"the instruction {type_} adds claims of kinds {kinds}; allowed: {allowed}")
            own = {type(claim).__name__ for claim in more if type_ == "p" and not claim.tried}
            require(not own, f"the instruction p adds {own}, which are worded as the student's own; set tried = True")


def check_plans(pupil: Pupil) -> None:
    """Following the plan has no regret; importance lies between 0 and `max_importance`; regret is never negative.

    The values that a verdict finds for actions are the oracle's values. An oracle without plans may raise RefusalError
    for regrets.
    """
    world = pupil.make_world()
    oracle = pupil.make_teacher(world).oracle
    lab, planned = world.scratch(), False
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
        values = None if moment.before is None else oracle.values(moment.before)
        for claim in oracle.judge(moment, {HP, HN}) if values else ():
            for action, value in enumerate(values or ()):
                worth = claim.worth(moment, lab, lab.legal(action))
                agrees = worth is None or abs(worth - value) < 1e-9
                require(
                    agrees, f"{claim} finds a worth of {worth} for {action}, the oracle a value of {value}: {moment}"
                )
        importance = oracle.importance(moment.after)
        require(0 <= importance <= oracle.max_importance, f"importance {importance} exceeds {oracle.max_importance}")
        unread = Moment.unread(moment.after, ParseFailure("?", ""), 0.0, False, moment.turn, False)
        try:
            regret, idle = oracle.regret(moment), oracle.regret(unread)
        except RefusalError:
            require(not planned, "the oracle has plans, but no regret(moment)")
            return
        require(regret >= 0, f"negative regret {regret}: {moment}")
        require(idle > 0 or not importance, f"a text that is no action has regret {idle}, and {importance} is at stake")


def check_values(pupil: Pupil) -> None:
    """If actions have values, all that the oracle says about an action agrees with them.

    Advised and planned actions have the greatest value, and actions of warnings have not. Praised actions lose no more
    on average than blamed ones: a single verdict may be about a random outcome. Regret is the greatest value minus the
    action's, importance the greatest value minus the least.
    """
    lost: dict[FeedbackType | None, list[float]] = {HP: [], HN: []}
    for oracle, moment in pupil.judged():
        space = oracle.lab.action_space
        values = None if moment.over else oracle.values(moment.after)
        if values is not None:
            require(len(values) == getattr(space, "n", None), f"there are {len(values)} values for {space}: {values}")
            _require_near(oracle.importance(moment.after), max(values) - min(values), "the importance", values)
            plan = oracle.plan(moment.after, 1)
            require(not plan or _best(values, plan[0]), f"the plan is {plan}, but the values are {values}")
        past = None if moment.before is None else oracle.values(moment.before)
        if past is not None:
            loss = max(past) - past[moment.action]
            _require_near(oracle.regret(moment), loss, "the regret", (moment.action, past))
        for claim in oracle.judge(moment):
            action = action_of(claim)
            if past is not None and claim.kind in lost and action == moment.action:
                lost[claim.kind].append(loss)
            elif values is not None and claim.kind in (FP, FN) and space.contains(action):
                right = max(values) == min(values) or _best(values, action) == (claim.kind is FP)
                require(right, f"{claim} ({claim.kind}) contradicts the values {values}")
    if all(lost.values()):
        praised, blamed = np.mean(lost[HP]), np.mean(lost[HN])
        require(praised <= blamed, f"by the values praised actions lose {praised:.3g}, and blamed ones {blamed:.3g}")


def _best(values: tuple[float, ...], action: Any) -> bool:
    return bool(max(values) - values[action] < _NEAR)


def _require_near(got: float, expected: float, what: str, given: Any) -> None:
    require(abs(got - expected) < _NEAR, f"{what} is {got}, but by the values {expected}: {given}")


def check_returns(pupil: Pupil) -> None:
    """If actions have values, the best actions succeed and earn at least as much as the worst.

    Success counts first: after it, an episode earns no more.
    """
    played = {choose: _played(pupil, choose) for choose in (max, min)}
    require(
        played[max] >= played[min],
        "actions of the greatest value have {0} successes and a return of {1} in {4} episodes, those of the least "
        "value {2} and {3}; greater values must be better".format(*played[max], *played[min], _EPISODES),
    )


def _played(pupil: Pupil, choose: Callable[[Any], float]) -> tuple[int, float]:
    """Successes and return of a student that chooses actions by their values."""
    session = pupil.session(pupil.make_world(), instructs=True)
    successes, total = 0, 0.0
    for seed in range(_EPISODES):
        moment = session.open(seed)
        while not session.over and (values := session.teacher.oracle.values(moment.after)) is not None:
            moment = session.act(values.index(choose(values)))
            successes += moment.success
            total += moment.reward
    return successes, round(total, 6)


def check_determinism(pupil: Pupil) -> None:
    """The same seeds give the same words."""
    for instruction_type in _teaching(pupil).instruction_types:
        first, again = ([atom.text for atom, _, _ in pupil.atoms(instruction_type=instruction_type)] for _ in range(2))
        require(first == again, "two teachers with the same seed say different things")


def _teaching(pupil: Pupil) -> Oracle:
    return pupil.make_teacher(pupil.make_world()).oracle


CHECKS: tuple[Callable[[Pupil], None], ...] = (
    check_honesty,
    check_kinds,
    check_contradictions,
    check_distortion,
    check_hints,
    check_clues,
    check_scope,
    check_judging_changes_nothing,
    check_claims,
    check_instructions,
    check_values,
    check_plans,
    check_returns,
    check_determinism,
    check_wording,
)
"""Every check of an oracle."""
