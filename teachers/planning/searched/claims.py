"""What the oracles of the searched tier say; plans are checked by playing them, and what none can do layer by layer."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, PlanClaim, Verdict, claim, opposed, slot
from teachers.planning.searched.scout import KeptPlan
from teachers.planning.searched.search import SearchTask, reaches, refuted
from worlds.actions import format_value
from worlds.wrapped.gym_world import GymWorld, Position
from worlds.wrapped.snapshots import draws, shake

_LUCK = 2_000_000  # the seed of the random numbers with which plans are played once more
_TIMES = 8  # that an action which draws some is taken with others


def in_actions(number: int) -> str:
    """A number of actions."""
    return f"{number} action{'s' * (number != 1)}"


@claim
class _Task(Claim[Position, GymWorld]):
    """Base of tasks."""

    goal: str
    turns: int

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare with what is searched for."""
        return bool((lab.model.goal, lab.model.horizon) == (self.goal, self.turns))


@claim
class Solve(_Task):
    """True if the task is to reach `goal`, the sooner the better, within an episode of at most `turns` actions."""


@claim
class KeepGoing(_Task):
    """True if the task is `goal`, for as long as an episode of at most `turns` actions lasts."""


@claim
class Considered(Claim[Position, GymWorld]):
    """True if the teacher considers these actions only."""

    listing: str

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare with what is tried in a search."""
        return listed(lab.model.task.choices, lab) == self.listing


@claim
class Way(PlanClaim[Position, GymWorld]):
    """True if these actions from the start solve the task."""

    actions: tuple[Any, ...]
    listing: str
    count: int

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play them."""
        return self.count == len(self.actions) and played(self.actions, moment.after, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The same actions backwards."""
        return (way(self.actions[::-1], lab),)


@claim
class Next(ActionClaim[Position, GymWorld]):
    """True if the teacher's plan of `left` actions, which solves the task, begins with `action`."""

    kind = FP
    action_slot = "answer"
    action: Any
    answer: str
    left: int
    time = slot(in_actions, "left")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan."""
        return follows(self.left, moment.after, moment, lab, self.action)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return _with_others(self, lab)

    def coarser(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The number of actions, and the same with the action."""
        return ActionsLeft(left=self.left), self


@claim
class ActionsLeft(Claim[Position, GymWorld]):
    """True if the teacher's plan, which solves the task, has `left` actions."""

    kind = FP
    left: int
    time = slot(in_actions, "left")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan."""
        return follows(self.left, moment.after, moment, lab)


@claim
class _Step(Verdict[Position, GymWorld], ActionClaim[Position, GymWorld]):
    """A step, judged by the teacher's plan before it."""

    action_slot = "answer"
    action: Any
    answer: str
    before: int
    """The number of actions of the plan before the step."""
    left: int
    """The number of actions of the plan after it, 0 if the task is solved; in blame no fewer can do."""
    then = slot(in_actions, "before")
    time = slot(in_actions, "left")

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether there was such a plan."""
        acted = moment.before is not None and moment.action == self.action
        return acted and follows(self.before, moment.past, moment, lab)


@claim
class Nearer(_Step):
    """True if the teacher's plan had `before` actions before the step, and has `left`, which are fewer, after it."""

    kind = HP

    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan after the step."""
        done = moment.success if self.left == 0 else not moment.over and follows(self.left, moment.after, moment, lab)
        return self.left < self.before and done

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Blame."""
        return (self.opposing(left=self.before),)


@claim
class Astray(_Step):
    """True if the teacher's plan had `before` actions before the step, and after it at least `left` are needed, which
    are not fewer.
    """  # noqa: D205

    kind = HN

    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Search for fewer."""
        if self.left < self.before or moment.success or moment.over:
            return True
        lab.restore(moment.after)
        return not impossible(lab, self.left - 1, lab.model.room(moment.after))

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Praise."""
        return (self.opposing(left=self.before - 1),)


opposed(Nearer, Astray)


@claim
class OutOfReach(ActionClaim[Position, GymWorld]):
    """True if the teacher's plan before the step had `before` actions, and nothing solves the task after it."""

    kind = HN
    action_slot = "answer"
    action: Any
    answer: str
    before: int
    then = slot(in_actions, "before")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan, and search all that can be reached now."""
        acted = moment.before is not None and moment.action == self.action and not moment.success
        return acted and follows(self.before, moment.past, moment, lab) and hopeless(moment.past, self.action, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Praise."""
        return (Nearer(action=self.action, answer=self.answer, before=self.before, left=self.before - 1),)

    def excludes(self, other: Claim) -> bool:
        """Praise."""
        return isinstance(other, Nearer)


@claim
class Detour(ActionClaim[Position, GymWorld]):
    """True if the teacher's plan from here has `plan` actions, and after `action` at least `left` are needed, which are
    not fewer.
    """  # noqa: D205

    kind = FN
    action_slot = "answer"
    action: Any
    answer: str
    plan: int
    left: int
    time = slot(in_actions, "left")
    mine = slot(in_actions, "plan")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan, and search for fewer after the action."""
        if self.left < self.plan or not follows(self.plan, moment.after, moment, lab):
            return False
        lab.restore(moment.after)
        _, _, terminated, _, info = lab.advance(self.action)
        if terminated:
            return not info["success"]
        return impossible(lab, self.left - 1, lab.model.room(lab.truth))

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return _with_others(self, lab)


@claim
class Ruin(ActionClaim[Position, GymWorld]):
    """True if nothing solves the task after `action`, which can be solved from here."""

    kind = FN
    action_slot = "answer"
    action: Any
    answer: str

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan, and take the action."""
        plan = planned(moment.after, moment, lab)
        solvable = plan is not None and played(plan.actions, moment.after, lab)
        return solvable and hopeless(moment.after, self.action, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return _with_others(self, lab)


@claim
class Hold(ActionClaim[Position, GymWorld]):
    """True if the teacher's plan begins with `action`, and keeps the episode going for `left` actions."""

    kind = FP
    action_slot = "answer"
    action: Any
    answer: str
    left: int
    time = slot(in_actions, "left")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan."""
        return follows(self.left, moment.after, moment, lab, self.action)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return _with_others(self, lab)


@claim
class _Lasting(Verdict[Position, GymWorld], ActionClaim[Position, GymWorld]):
    """A step, judged by what can be kept going after it."""

    action_slot = "answer"
    action: Any
    answer: str
    left: int
    time = slot(in_actions, "left")

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether this was the action."""
        return moment.before is not None and moment.action == self.action


@claim
class Safe(_Lasting):
    """True if after the step the teacher has a plan that keeps the episode going for `left` actions."""

    kind = HP

    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play it."""
        return not moment.over and follows(self.left, moment.after, moment, lab)


@claim
class Doomed(_Lasting):
    """True if after the step nothing keeps the episode going for `left` actions, as the plan before it did."""

    kind = HN

    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan before, and search all that can be reached now."""
        plan = planned(moment.past, moment, lab)
        could = plan is not None and len(plan.actions) > self.left and played(plan.actions, moment.past, lab)
        return not (could and hopeless(moment.past, self.action, lab, self.left))


opposed(Safe, Doomed)


@claim
class Fatal(ActionClaim[Position, GymWorld]):
    """True if after `action` nothing keeps the episode going for `left` actions, as the teacher's plan does."""

    kind = FN
    action_slot = "answer"
    action: Any
    answer: str
    left: int
    time = slot(in_actions, "left")

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Play the plan, and search all that can be reached after the action."""
        could = follows(self.left + 1, moment.after, moment, lab)
        return could and hopeless(moment.after, self.action, lab, self.left)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return _with_others(self, lab)


def way(actions: Sequence[Any], lab: GymWorld) -> Way:
    """A claim of these actions."""
    return Way(actions=tuple(actions), listing=listed(actions, lab), count=len(actions))


def answer_of(action: Any, lab: GymWorld) -> str:
    """An action as a student writes it."""
    return lab.names.get(action) or format_value(action)


def listed(actions: Sequence[Any], lab: GymWorld) -> str:
    """Actions as a student writes them."""
    return Way.separator.join(answer_of(action, lab) for action in actions)


def planned(truth: Position, moment: Moment[Position], lab: GymWorld) -> KeptPlan | None:
    """The plan in a state of a moment; None if there is none, or too few turns are left for it."""
    plan: KeptPlan = lab.model.plan(truth, lab)
    left = lab.model.room(truth) - max(0, moment.turn - moment.after.turn)  # texts that were no actions took turns
    return plan if 0 < len(plan.actions) <= left else None


def follows(count: int, truth: Position, moment: Moment[Position], lab: GymWorld, first: Any = None) -> bool:
    """Whether the plan in a state has so many actions, begins with `first` if given, and reaches the aim."""
    plan = planned(truth, moment, lab)
    if plan is None or len(plan.actions) != count or first not in (None, plan.actions[0]):
        return False
    return played(plan.actions, truth, lab)


def played(actions: Sequence[Any], truth: Position, lab: GymWorld) -> bool:
    """Whether actions from a truth do what they should: in the lab, and with other random numbers."""
    task: SearchTask = lab.model.task
    room = lab.model.room(truth) if task.lasts is None else len(actions)
    return all(reaches(task, lab, truth, actions, room, luck) for luck in (None, _LUCK))


def ended(truth: Position, action: Any, lab: GymWorld) -> bool:
    """Whether an action ends the episode other than by time, and in vain, whatever is drawn."""
    return all(
        terminated and not (lab.model.task.lasts is None and success)
        for _, terminated, success in _results(truth, action, lab)
    )


def steady(truth: Position, action: Any, lab: GymWorld) -> bool:
    """Whether an action leads to the same state whatever is drawn."""
    first, *others = _results(truth, action, lab)
    return all(other == first for other in others)


def _results(truth: Position, action: Any, lab: GymWorld) -> Iterator[tuple[Any, bool, bool]]:
    """The states to which an action leads, whether it ends the episode, and solves the task.

    First by the random numbers that come, and if it draws any by others; in the end the lab has taken it by the first.
    """
    lab.restore(truth)
    before = draws(lab.env)
    yield _after(action, lab)
    if draws(lab.env) == before:
        return
    for luck in range(_LUCK, _LUCK + _TIMES):
        lab.restore(truth)
        shake(lab.env, luck)
        yield _after(action, lab)
    lab.restore(truth)
    lab.advance(action)


def _after(action: Any, lab: GymWorld) -> tuple[Any, bool, bool]:
    """What an action leads to."""
    _, _, terminated, _, info = lab.advance(action)
    return lab.model.task.state(lab.env), terminated, info["success"]


def hopeless(truth: Position, action: Any, lab: GymWorld, left: int = 0) -> bool:
    """Whether nothing reaches the aim after an action: to solve the task, or to keep going for `left` actions."""
    if ended(truth, action, lab):
        return True
    lab.restore(truth)
    return not lab.advance(action)[2] and impossible(lab, math.inf, left or lab.model.room(lab.truth))


def impossible(lab: GymWorld, most: float, room: int) -> bool:
    """Whether no actions, at most so many, reach the aim from where the lab is, as if `room` actions were left."""
    truth = lab.truth
    found = lab.model.search(truth, lab, room)
    if found.actions is not None and len(found.actions) <= most:
        return False
    lab.restore(truth)
    return refuted(lab.model.task, lab, most, room)


def _with_others(said: Any, lab: GymWorld) -> list[Claim]:
    """The same claim of each other action that is considered."""
    others = (action for action in lab.model.task.choices if action != said.action)
    return [replace(said, action=action, answer=answer_of(action, lab)) for action in others]
