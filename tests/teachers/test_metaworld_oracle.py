"""Meta-World's oracle: advice that solves tasks, hindsight that never scolds who obeyed, warnings that were tried."""

import tomllib
from importlib import resources

import numpy as np
import pytest

from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from teachers.atoms import FN, FP, HN, HP, KINDS, Moment
from teachers.oracles.metaworld import MetaWorldOracle
from teachers.oracles.metaworld.claims import (
    Aiming,
    Avoid,
    Distance,
    Done,
    Heading,
    Neared,
    Off,
    RightGrip,
    RightPlace,
    Solution,
    Strayed,
    TooLoose,
    TooTight,
    WellAimed,
    action_for,
)
from teachers.oracles.metaworld.corrections import CORRECTIONS, aim_of
from teachers.oracles.metaworld.purposes import PURPOSES
from teachers.testing import Pupil, check_honesty
from worlds.metaworld import CONTROLS, TASKS, MetaWorld

SAMPLE = ("door-lock-v3", "drawer-open-v3", "pick-place-v3", "reach-v3", "stick-push-v3")
EVERY_TASK = [pytest.param(task, marks=() if task in SAMPLE else pytest.mark.full) for task in TASKS]


def engaged(world, seed=0):
    world.reset(seed=seed)
    oracle = MetaWorldOracle(world.scratch)
    oracle.start(world.truth)
    return oracle, Moment.opening(world.truth)


def played(world, action, turn=1):
    before, action = world.truth, world.legal(action)
    _, reward, _, _, info = world.advance(action)
    return Moment(before, action, reward, world.truth, info["success"], turn, False)


def advice(oracle, moment):
    (claim,) = oracle.judge(moment, {FP})
    return claim


def test_every_task_has_a_purpose():
    assert tuple(PURPOSES) == TASKS


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("task", EVERY_TASK)
def test_who_obeys_is_never_scolded(task, control):
    world = MetaWorld(task, control)
    lab = world.scratch()
    oracle, moment = engaged(world)
    for turn in range(1, 31):
        claim = advice(oracle, moment)
        assert type(claim) is Aiming
        assert claim.holds(moment, lab)
        assert all(round(number, 2) == number for number in claim.action)
        moment = played(world, claim.action, turn)
        assert oracle.judge(moment, {HN}) == ()
        (praise,) = oracle.judge(moment, {HP})
        assert type(praise) is (Done if moment.success else WellAimed)
        assert praise.holds(moment, lab)
        if moment.success:
            break
    assert oracle.regret(moment) == 0
    if moment.success:
        assert oracle.judge(moment, {HP, HN, FP, FN}) != ()
        silent = played(world, claim.action, turn + 1)
        assert oracle.judge(silent, set(KINDS[1:])) == ()
        assert oracle.plan(silent.after, 5) == ()
        assert oracle.importance(silent.after) == 0


@pytest.mark.parametrize("task", EVERY_TASK)
@pytest.mark.parametrize("control", CONTROLS)
def test_a_complete_instruction_is_a_rollout_that_solves_the_task(task, control):
    world = MetaWorld(task, control)
    oracle, moment = engaged(world, 1)
    for claim in oracle.brief(world.truth, "c"):
        assert claim.holds(moment, world.scratch())
        if type(claim) is Solution:
            assert [played(world, action).success for action in claim.actions].index(True) + 1 == claim.count


def turns_to_solve(world, seed, aim):
    """How many turns it takes who aims so, or None."""
    world.reset(seed=seed)
    for turn in range(1, 31):
        if world.advance(action_for(aim(world, world.truth), world.truth, world))[4]["success"]:
            return turn
    return None


def uncorrected(world, truth):
    """What the scripted policy aims at."""
    return world.script.aim(truth.observation)


@pytest.mark.parametrize(
    ("task", "seed"),
    [
        ("basketball-v3", 105),
        ("box-close-v3", 102),
        ("button-press-wall-v3", 7003),
        ("coffee-pull-v3", 7005),
        ("handle-pull-side-v3", 0),
        ("lever-pull-v3", 101),
        ("pick-place-wall-v3", 7),
        ("push-back-v3", 1),
        ("stick-pull-v3", 112),
        ("stick-pull-v3", 7034),
    ],
)
def test_corrected_aims_solve_what_the_policy_loses(task, seed):
    world = MetaWorld(task)
    assert turns_to_solve(world, seed, uncorrected) is None
    assert turns_to_solve(world, seed, aim_of) is not None


def test_the_hand_goes_down_then_closes_then_carries():
    world = MetaWorld("pick-place-wall-v3")
    world.reset(seed=7)
    phases = []
    while not world.truth.solved:
        hand, gripper = world.truth.observation[:3], world.truth.observation[3]
        aim = aim_of(world, world.truth)
        if aim.grip == -1:
            phases.append("go")
        elif gripper > 0.9:
            assert aim.target[:2] == hand[:2]
            assert hand[2] - 0.04 <= aim.target[2] <= hand[2]
            phases.append("close")
        else:
            phases.append("carry")
        world.advance(action_for(aim, world.truth, world))
    assert sorted(set(phases), key=phases.index) == ["go", "close", "carry"]
    assert phases == sorted(phases, key=["go", "close", "carry"].index)


@pytest.mark.parametrize("task", [task for task, correction in CORRECTIONS.items() if correction.stride])
def test_a_stride_is_never_longer(task):
    world = MetaWorld(task)
    world.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(10):
        aim = aim_of(world, world.truth)
        apart = np.subtract(aim.target, world.truth.observation[:3])
        assert np.abs(apart).max() <= CORRECTIONS[task].stride + 1e-12
        world.step(world.sample_action(rng))


def test_with_the_teachers_event_the_policy_is_not_corrected():
    own, event = MetaWorld("handle-pull-side-v3"), MetaWorld("handle-pull-side-v3", "teacher_event")
    for world in (own, event):
        world.reset(seed=0)
    assert aim_of(event, event.truth) == uncorrected(event, event.truth)
    assert aim_of(own, own.truth) != uncorrected(own, own.truth)


def test_verdicts_on_a_target_say_whose_measure_they_are():
    """That another target would not do is not known; success is, and is said as such."""
    phrases = tomllib.loads(resources.files("teachers.phrases").joinpath("metaworld.toml").read_text())["plain"]
    verdicts = {cls.__name__ for cls in MetaWorldOracle.claims() if cls.kind in (HP, HN)} - {"Done"}
    assert len(verdicts) == 10
    for name in verdicts:
        for phrase in phrases[name]:
            assert "script" in phrase
            assert not {"should", "wrong", "mistake"} & set(phrase.split())


def test_hindsight_is_about_place_and_grip():
    world = MetaWorld("drawer-open-v3")
    lab = world.scratch()
    oracle, moment = engaged(world)
    x, y, z, grip = advice(oracle, moment).action
    assert grip == -1
    start = world.save()

    def verdicts(action):
        world.restore(start)
        moment = played(world, action)
        claims = oracle.judge(moment, {HP, HN})
        assert all(claim.holds(moment, lab) for claim in claims)
        return claims

    assert [type(claim) for claim in verdicts([x, y, z, -0.9])] == [WellAimed]
    assert [type(claim) for claim in verdicts([x, y, z, 0.5])] == [RightPlace, TooTight]
    assert [type(claim) for claim in verdicts([x + 0.1, y, z, -1])] == [RightGrip, Neared, Off]
    assert verdicts([x + 0.1, y, z, -1])[-1].faults == "x was 10 cm too large"
    hand = start.truth.observation[:3]
    away = [2 * h - t for h, t in zip(hand, (x, y, z), strict=True)]
    assert {Off, Strayed, TooTight} <= {type(claim) for claim in verdicts([*away, 1])}


@pytest.mark.parametrize("control", CONTROLS)
def test_verdicts_on_poses_of_two_decimals_hold(control):
    """The place that is wanted often has two decimals, too: half a centimetre is then rounded up or down."""
    world = MetaWorld("button-press-v3", control)
    lab = world.scratch()
    rng = np.random.default_rng(0)
    oracle, moment = engaged(world)
    faults = []
    for turn in range(1, 16):
        about = np.zeros(3) if world.relative else np.array(moment.after.observation[:3])
        moment = played(world, np.round(np.append(about, 0.0) + rng.uniform(-0.3, 0.3, 4), 2), turn)
        claims = oracle.judge(moment, {HP, HN})
        assert all(claim.holds(moment, lab) for claim in claims)
        faults += [(claim, moment) for claim in claims if type(claim) is Off]
    assert len(faults) >= 10
    for claim, moment in faults:
        for axis in range(3):
            for wrong in (-2, 2):
                errors = tuple(error + wrong * (i == axis) for i, error in enumerate(claim.errors))
                assert not Off(action=claim.action, errors=errors).holds(moment, lab)


def test_a_grip_is_told_as_the_pose_tells_it():
    world = MetaWorld("drawer-open-v3")
    oracle, moment = engaged(world)
    x, y, z, _ = advice(oracle, moment).action
    (slip,) = oracle.judge(played(world, [x, y, z, 0.625]), {HN})
    assert (slip.grip, slip.target.endswith("0.625]")) == ("0.625", True)


def test_a_gripper_that_should_be_closed():
    world = MetaWorld("door-open-v3")
    oracle, moment = engaged(world)
    x, y, z, grip = advice(oracle, moment).action
    assert grip == 1
    assert [type(claim) for claim in oracle.judge(played(world, [x, y, z, -1]), {HN})] == [TooLoose]


def test_advice_is_for_the_control():
    absolute, relative = MetaWorld("reach-v3"), MetaWorld("reach-v3", "relative")
    first, second = (advice(*engaged(world)).action for world in (absolute, relative))
    hand = absolute.truth.observation[:3]
    assert np.allclose(np.array(second[:3]) + hand, first[:3], atol=0.011)


def test_hints_are_implied_by_the_advice():
    world = MetaWorld("pick-place-v3")
    lab = world.scratch()
    oracle, moment = engaged(world)
    for turn in range(1, 12):
        claim = advice(oracle, moment)
        hints = claim.coarser(moment, lab)
        assert [type(hint) for hint in hints] in ([Distance, Heading], [Distance])
        for hint in hints:
            assert hint.holds(moment, lab)
            assert not any(other.holds(moment, lab) for other in hint.counterparts(moment, lab))
        moment = played(world, claim.action, turn)
        if moment.success:
            break


@pytest.mark.parametrize("task", SAMPLE)
def test_warnings_lose_ground(task):
    world = MetaWorld(task)
    oracle, moment = engaged(world, 2)
    warnings = 0
    for turn in range(1, 9):
        for claim in oracle.judge(moment, {FN}):
            assert type(claim) is Avoid
            lab = world.scratch()
            lab.restore(moment.after)
            after = played(lab, claim.action).after
            place = lab.script.aim(moment.after.observation).target
            apart = [np.linalg.norm(np.subtract(t.observation[:3], place)) for t in (moment.after, after)]
            assert apart[1] > apart[0] + 0.009
            warnings += 1
        moment = played(world, advice(oracle, moment).action, turn)
        if moment.success:
            break
    assert warnings >= 2


@pytest.mark.parametrize(
    "options",
    [
        {"control": "relative"},
        {"control": "teacher_event"},
        {"gain": 10.0},
        {"task": "handle-pull-side-v3", "control": "relative"},
        *(pytest.param({"task": task}, marks=pytest.mark.full) for task in CORRECTIONS),
    ],
    ids=str,
)
def test_honesty_with_other_options(options):
    from pz_envs.families.metaworld import FAMILY

    check_honesty(Pupil(lambda: FAMILY.make_world(**options), FAMILY.make_teacher, max_turns=12, turns=12))


@pytest.mark.full
@pytest.mark.parametrize(("control", "least", "each"), [("absolute", 0.985, 8), ("teacher_event", 0.96, 5)])
def test_obedient_students_succeed(control, least, each):
    """All tasks, ten seeds; docs/internals/metaworld.md has the table."""
    won = []
    for task in TASKS:
        env = make(f"llf-metaworld-{task}", feedback_type="fp", control=control)
        student = parse_student("obedient").seat(env.family, env.session.world)
        for seed in range(10):
            student.reset(np.random.default_rng(seed))
            env.reset(seed=seed)
            while not env.session.moment.success and not env.session.moment.over:
                env.step(student.act(env.student_view.observe(), env.student_view.info_for(student)))
            won.append(env.session.moment.success)
        assert sum(won[-10:]) >= each, task
    assert np.mean(won) >= least
