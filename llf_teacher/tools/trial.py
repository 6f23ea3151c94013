"""A trial of an environment: what teachers can teach in it, by which kind of oracle, and what is missing for more."""

import contextlib
import warnings
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import gymnasium
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import types_of
from llf_teacher.students.parsing import parse_student
from pz_envs.frames import format_action
from pz_envs.lesson import limits_of
from pz_envs.registered import Registered
from pz_envs.settings import Settings
from pz_envs.subject import Subject
from teachers.planning import Planned, PlanningError, parse_planner, survey
from teachers.planning.known import Known, known, words_of
from teachers.planning.planner import REWARDS, RewardsOnlyWarning
from teachers.words import coded_words
from worlds.actions import describe_space
from worlds.wrapped.gym_world import check_complete, faithful

__all__ = ["Line", "facts", "trial"]

_SEEN = {True: "more than the student sees", False: "what the student sees", None: "perhaps more than the student sees"}
_SHOWN = 6  # greatest number of turns of the episode


class Line(NamedTuple):
    """A line of the result."""

    about: str
    text: str
    good: bool | None = None
    """Whether it is as it should be; None: neutral."""


def facts(subject: Registered, **options: Any) -> Iterator[Line]:
    """The knowledge of planned teachers about an environment: the tier, or why there is none, and their claims.

    Args:
        subject: the environment.
        options: options of its world, and `oracle`, a planner or its spec; without it, all tiers are tried.
    """
    oracle = options.get("oracle", "auto")
    if oracle == REWARDS:
        yield Line("teacher", "says what was paid, in words")
        return
    with contextlib.closing(subject.make(options)) as env:
        asked = parse_planner(oracle) if isinstance(oracle, str) else oracle
        found = survey(env, subject.turns(**options), asked)
        own = known(env) or Known()
    plan = next((plan for plan in found.values() if isinstance(plan, Planned)), None)
    for tier, said in found.items():
        if not isinstance(said, Planned):
            yield Line(tier, f"no: {said}", False)
        else:
            yield Line(tier, said.why if said.size in said.why else f"{said.why}; {said.size}", True)
    if own.unlike:
        yield Line("rules", own.unlike, False)
    if plan is None:
        yield Line("rewards", f"with oracle={REWARDS!r} what was paid is said in words")
        return
    lesson = subject.for_lesson(Settings(options={"oracle": plan.tier, **options}))
    instructions, kinds = map(coded_words, types_of(lesson))
    yield Line("teacher", f"instructions {instructions}; feedback {kinds}; {subject.turns(**options):,} turns")
    yield Line("objective", plan.objective)
    yield Line("actions", ", ".join(plan.action_words) or ", ".join(words_of(env, own)) or "numbers")
    yield Line("observations", "in words" if plan.describe else "plain numbers")
    yield Line("knows", _SEEN[plan.privileged])


def trial(subject: Registered, options: Mapping[str, Any], seed: int = 0, teacher: Any = "oracle") -> Iterator[Line]:
    """The results of a trial of an environment, step by step.

    Args:
        subject: the environment.
        options: options of its world.
        seed: the seed of the episode.
        teacher: the teacher of the episode, as in `llf_teacher.make`.

    Raises:
        ValueError: the environment cannot be made, or there is no such teacher.
    """
    own = {name: value for name, value in options.items() if name != "oracle"}
    with contextlib.closing(subject.make(own)) as env:
        yield Line("environment", f"{env}")
        try:
            check_complete(env)
        except ValueError as error:
            yield Line("interface", f"{error}; mend this first", False)
            return
        yield Line("observations", describe_space(env.observation_space))
        yield Line("actions", describe_space(env.action_space))
        limits = [each for each in limits_of(env) if each is not None]
        yield Line("turns", f"{subject.turns(**own):,}" + ("" if limits else ", as the environment has no limit"))
        if (fault := _broken(env)) is not None:
            yield Line("interface", fault, False)
            return
        yield Line("interface", "as Gymnasium demands", True)
        copies = faithful(env)
        yield Line("copies", f"{'continue' if copies else 'do not continue'} like the original", copies)
        again = copies or _repeats(subject, own)
        if not copies:
            yield Line("replay", f"the same seed and actions give {'the same' if again else 'another'} episode", again)
    yield from facts(subject, **options)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RewardsOnlyWarning)  # the reasons are listed already
            lesson = subject.for_lesson(Settings(options=options))
    except PlanningError:
        lesson = subject.for_lesson(Settings(options={**own, "oracle": REWARDS}))
    yield from _episode(lesson, seed, teacher)
    yield from _missing(lesson.planned, isinstance(env.action_space, spaces.Discrete), bool(limits))


def _broken(env: gymnasium.Env[Any, Any]) -> str | None:
    """The violation of Gymnasium's interface by an environment; None without one."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            check_env(env.unwrapped, skip_render_check=True)
    except Exception as error:  # its checks are assertions, and environments may raise anything
        return f"{type(error).__name__}: {error}; mend this first: gymnasium.utils.env_checker.check_env shows it"
    return None


def _repeats(subject: Registered, options: Mapping[str, Any]) -> bool:
    """Whether two environments give the same episode."""
    rewards = []
    for _ in range(2):
        with contextlib.closing(subject.make(options)) as env:
            env.reset(seed=0)
            env.action_space.seed(0)
            steps = (env.step(env.action_space.sample()) for _ in range(_SHOWN))
            rewards.append([(float(reward), terminated) for _, reward, terminated, _, _ in steps])
    return rewards[0] == rewards[1]


def _episode(lesson: Subject, seed: int, teacher: Any) -> Iterator[Line]:
    """One taught episode of an obedient student, or the first turns of a long one."""
    student = parse_student("obedient")
    with contextlib.closing(StudentEnv(lesson, teacher=teacher)) as env:
        world = env.session.world
        policy = student.seat(env.family, world)
        for turn in play_turns(env, policy, seed):
            moment = turn.moment
            if moment.turn == 0:
                yield Line("episode", f"{turn.instruction} {env.student_view.description()} {turn.feedback}")
            elif moment.turn <= _SHOWN:
                yield Line(f"turn {moment.turn}", f"{format_action(moment.action, world)}. {turn.feedback}")
        solved = "solved" if env.session.moment.success else "not solved"
        yield Line("end", f"{solved} after {env.session.moment.turn} turns")


def _missing(plan: Planned | None, counted: bool, limited: bool) -> Iterator[Line]:
    """Possible improvements of the lesson, with the argument of `teach` and `Lesson` for each.

    Args:
        plan: the teacher's plan.
        counted: whether actions are numbered, so that each can have a word.
        limited: whether the environment has a limit of turns.
    """
    if plan is None or plan.tier == REWARDS:
        yield Line(
            "missing", "a teacher that plans: the lines exact and expert say what they need; or an oracle of your own"
        )
    elif plan.privileged is None:
        yield Line("missing", "whether the teacher plans from more than observations show: compare its state with them")
    if counted and (plan is None or not plan.action_words):
        yield Line("missing", "action_words={'left': 0, ...}: words for actions, which are numbers now")
    if plan is None or plan.describe is None:
        yield Line("missing", "describe=f, where f(observation) is a text: observations in words")
    if not limited:
        yield Line("missing", "max_turns=...: the environment has no limit")
