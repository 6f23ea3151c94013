"""What is said about proposals, each made again in the simulator."""

from collections.abc import Sequence

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, Grounded, Moment, claim
from teachers.oracles.optimization.checks import (
    NAMES,
    between,
    contains,
    corners_of,
    directions,
    grid,
    minimiser_of,
    moved_inside,
    proposed,
    succeeds,
    with_coordinate,
    write,
)
from worlds.optimization import Point
from worlds.world import World

FARTHER = 1000
"""Points that are tried in the next quarter of a way."""


@claim
class Goal(Claim):
    """True if the task is solved by proposals whose loss is within `tolerance` of the least one, and by no others."""

    tolerance: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose points on a grid and near a point of least loss."""
        truth = moment.after
        points = list(grid(lab))
        best = minimiser_of(lab, truth)
        points += [between(best, point, share) for point in points for share in (0.0, 1e-3, 1e-2, 0.05)]
        lab.restore(truth)
        least = min(proposed(lab, truth, point) for point in points)
        return all(succeeds(lab, truth, p) == (proposed(lab, truth, p) - least <= self.tolerance) for p in points)


@claim
class Proposals(Claim):
    """True if every action proposes a point, whose loss is then seen."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose points on a grid and look at the observation."""
        for point in grid(lab):
            lab.restore(moment.after)
            observation = lab.advance(point)[0]
            if tuple(observation["x"].tolist()) != point or observation["y"].tolist() != [lab.truth.y]:
                return False
        return True


@claim
class Answer(Claim):
    """True if points are to be written so, and x1 and x2 have these bounds."""

    low1: float
    high1: float
    low2: float
    high2: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the world the corners, points outside, and texts."""
        lab.restore(moment.after)
        box = lab.action_space
        inside = [[self.low1, self.low2], [self.high1, self.high2]]
        outside = [[self.low1 - 1e-3, self.low2], [self.high1 + 1e-3, self.high2]]
        outside += [[self.low1, self.low2 - 1e-3], [self.high1, self.high2 + 1e-3]]
        return (
            all(box.contains(np.array(point)) for point in inside)
            and not any(box.contains(np.array(point)) for point in outside)
            and all(lab.read(f"x = [{x1!r}, {x2!r}]") == (x1, x2) for x1, x2 in inside)
            and lab.read("stay") == moment.after.x
        )


@claim
class TriedWell(Claim):
    """True if proposing `action` at the start takes the loss down from `before` to `after`."""

    kind = HP
    action: Point
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        return _tried(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, target=self.target, before=self.before, after=self.after),)


@claim
class TriedInVain(Claim):
    """True if proposing `action` at the start takes the loss up from `before` to `after`."""

    kind = HN
    action: Point
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        return _tried(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, target=self.target, before=self.before, after=self.after),)


@claim
class Solution(Claim):
    """True if no point has a smaller loss than `action`, which has `loss`."""

    action: Point
    target: str
    """The action as text."""
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it, and many points far from it and close to it."""
        truth, points = moment.after, list(grid(lab))
        points += [between(self.action, point, share) for point in points for share in (1e-4, 1e-2, 0.1)]
        y = proposed(lab, truth, self.action)
        slack = 1e-9 * (1 + abs(y))  # the minimiser of a user's loss is found by a search
        return _target(self) and y == self.loss and all(proposed(lab, truth, p) >= y - slack for p in points)


@claim
class Reached(Claim):
    """True if the proposal solved the task: its loss is within the tolerance of the least one."""

    kind = HP
    action: Point
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it again."""
        return (
            moment.before is not None
            and moment.action == self.action
            and succeeds(lab, moment.before, self.action)
            and lab.truth.y == self.loss
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Speak of a loss that rose."""
        return (Rose(action=self.action, before=self.loss, after=self.loss + abs(self.loss) + 1.0),)


@claim
class Fell(Claim):
    """True if the proposal took the loss down from `before` to `after`."""

    kind = HP
    action: Point
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make both proposals again."""
        return _moved(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Rose(action=self.action, before=self.after, after=self.before),)


@claim
class Rose(Claim):
    """True if the proposal took the loss up from `before` to `after`."""

    kind = HN
    action: Point
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make both proposals again."""
        return _moved(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Fell(action=self.action, before=self.after, after=self.before),)


@claim
class Helped(Claim):
    """True if the proposal changed this coordinate so, and that change alone takes the loss down as told."""

    kind = HP
    name: str
    """`x1` or `x2`."""
    start: float
    end: float
    before: float
    """The loss at the point that the proposal left."""
    after: float
    """The loss with only this coordinate changed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the old point with this coordinate changed."""
        return _changed(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Hurt(name=self.name, start=self.start, end=self.end, before=self.after, after=self.before),)


@claim
class Hurt(Claim):
    """True if the proposal changed this coordinate so, and that change alone takes the loss up as told."""

    kind = HN
    name: str
    """`x1` or `x2`."""
    start: float
    end: float
    before: float
    """The loss at the point that the proposal left."""
    after: float
    """The loss with only this coordinate changed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the old point with this coordinate changed."""
        return _changed(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Helped(name=self.name, start=self.start, end=self.end, before=self.after, after=self.before),)


@claim
class Step(Claim):
    """True if proposing `action` takes the loss down from `now` to `loss`, and `ways` are the directions of it."""

    kind = FP
    action: Point
    target: str
    """The action as text."""
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the step."""
        truth = moment.after
        return (
            _target(self)
            and self.ways == directions(truth.x, self.action)
            and proposed(lab, truth, truth.x) == self.now
            and proposed(lab, truth, self.action) == self.loss < self.now
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Promise the same of the opposite direction and of the corners."""
        x = moment.after.x
        points = (moved_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1])), *corners_of(lab))
        return tuple(_step_to(point, x, self.now, self.loss) for point in points if point != x)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The quarter of the domain in which the point lies, then the directions."""
        spans = zip(self.action, lab.lows, lab.highs, strict=True)
        (low1, high1), (low2, high2) = (
            ((low + high) / 2, high) if x > (low + high) / 2 else (low, (low + high) / 2) for x, low, high in spans
        )
        area = Area.on(self, low1=low1, high1=high1, low2=low2, high2=high2, now=self.now)
        return area, Way.on(self, ways=self.ways, now=self.now)


@claim
class Area(Grounded):
    """True if a point within these bounds has a loss below `now`, which is that of the last proposal."""

    kind = FP
    low1: float
    high1: float
    low2: float
    high2: float
    now: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the point that the ground knows."""
        x1, x2 = self._ground.action
        inside = self.low1 <= x1 <= self.high1 and self.low2 <= x2 <= self.high2
        return inside and self.now == moment.after.y and self.stands(moment, lab)


@claim
class Way(Grounded):
    """True if a point in these directions has a loss below `now`, which is that of the last proposal."""

    kind = FP
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the point that the ground knows."""
        directed = self.ways == directions(moment.after.x, self._ground.action)
        return directed and self.now == moment.after.y and self.stands(moment, lab)


@claim
class Cross(Claim):
    """True if proposing `action` does not take the loss down from `now`, but going farther that way would.

    Farther means up to a quarter of the way more. `ways` are the directions, `loss` is what the proposal gives.
    """

    kind = FP
    action: Point
    target: str
    """The action as text."""
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the step, and longer ones."""
        truth = moment.after
        farther = (between(truth.x, self.action, 1 + i / FARTHER / 4) for i in range(1, FARTHER + 1))
        return (
            _target(self)
            and self.ways == directions(truth.x, self.action)
            and proposed(lab, truth, truth.x) == self.now
            and proposed(lab, truth, self.action) == self.loss >= self.now
            and any(proposed(lab, truth, p) < self.now for p in farther if contains(lab, p))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the student to a corner."""
        x, y = moment.after.x, moment.after.y
        return tuple(_step_to(point, x, y, y - 1.0) for point in corners_of(lab) if point != x)


@claim
class Stay(Claim):
    """True if the last proposal, `action`, solves the task, and so would the same once more."""

    kind = FP
    action: Point
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it once more."""
        return _target(self) and self.action == moment.after.x and succeeds(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the student to a corner."""
        x, y = moment.after.x, moment.after.y
        return tuple(_step_to(point, x, y, y - 1.0) for point in corners_of(lab) if point != x)


@claim
class Avoid(Claim):
    """True if proposing `action` takes the loss up from `now` to `loss`."""

    kind = FN
    action: Point
    target: str
    """The action as text."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        truth = moment.after
        return (
            _target(self)
            and proposed(lab, truth, truth.x) == self.now
            and proposed(lab, truth, self.action) == self.loss > self.now
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the opposite direction and of the middle of the domain."""
        x = moment.after.x
        low, high = corners_of(lab)[0], corners_of(lab)[-1]
        points = [moved_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1])), between(low, high, 0.5)]
        return tuple(avoid(point, self.now, self.loss) for point in points if point != self.action)


def _tried(said: TriedWell | TriedInVain, moment: Moment, lab: World) -> bool:
    truth = moment.after
    return (
        _target(said)
        and proposed(lab, truth, truth.x) == said.before
        and proposed(lab, truth, said.action) == said.after
    )


def _moved(said: Fell | Rose, moment: Moment, lab: World) -> bool:
    before = moment.before
    return (
        before is not None
        and moment.action == said.action
        and proposed(lab, before, before.x) == said.before
        and proposed(lab, before, said.action) == said.after
    )


def _changed(said: Helped | Hurt, moment: Moment, lab: World) -> bool:
    before = moment.before
    if before is None:
        return False
    i = NAMES.index(said.name)
    return (
        (before.x[i], moment.action[i]) == (said.start, said.end)
        and proposed(lab, before, before.x) == said.before
        and proposed(lab, before, with_coordinate(before.x, i, said.end)) == said.after
    )


def _target(said: TriedWell | TriedInVain | Solution | Step | Cross | Stay | Avoid) -> bool:
    """Whether the text of a claim's action is that action."""
    return tuple(map(float, said.target.strip("[]").split(", "))) == said.action


def _step_to(point: Point, x: Point, now: float, loss: float) -> Step:
    return Step(action=point, target=write(point), ways=directions(x, point), now=now, loss=loss)


def avoid(point: Point, now: float, loss: float) -> Avoid:
    """A warning of a point."""
    return Avoid(action=point, target=write(point), now=now, loss=loss)
