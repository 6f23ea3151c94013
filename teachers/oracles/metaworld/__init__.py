"""Meta-World's oracle: what metaworld's scripted policies aim at, and what a copy of the simulator shows."""

import math
from collections.abc import Sequence, Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim
from teachers.common import Syntax, TryAgain
from teachers.oracle import Oracle
from worlds.metaworld import REACH, Aim, Pose, Truth
from worlds.world import World

Place = tuple[float, float, float]


@claim
class Goal(Claim):
    """True if `purpose` says what solves the task."""

    task: str
    purpose: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the task up."""
        return self.task == lab.task and self.purpose == PURPOSES[self.task]


@claim
class Driving(Claim):
    """True if an action drives the hand towards its target for at most `most` small steps, z counts upwards, and the
    gripper opens at -1 and closes at 1.
    """  # noqa: D205

    origin: str
    """From where x, y and z count."""
    most: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Go up with an open and with a closed gripper."""
        x, y, z = _hand(moment.after)
        heights, openings = [], []
        for grip in (-1.0, 1.0):
            lab.restore(moment.after)
            for _ in range(3):
                lab.advance((0.0, 0.0, 0.05, grip) if lab.relative else (x, y, z + 0.05, grip))
                heights.append(lab.truth.observation[2] - z)
            openings.append(lab.truth.observation[3])
        return (
            min(heights) > 0 and openings[0] > openings[1] and self.origin == _origin(lab) and self.most == lab.longest
        )


@claim
class TriedWell(Claim):
    """True if `action` at the start takes the hand from `before` to `after` centimetres from where it is wanted, and
    that is nearer by at least 1 cm.
    """  # noqa: D205

    kind = HP
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it."""
        return _tried(self, moment.after, lab) and self.before - self.after >= _NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, target=self.target, before=self.after, after=self.before),)


@claim
class TriedInVain(Claim):
    """True if `action` at the start takes the hand from `before` to `after` centimetres from where it is wanted, and
    that is farther away by at least 1 cm.
    """  # noqa: D205

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it."""
        return _tried(self, moment.after, lab) and self.after - self.before >= _NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, target=self.target, before=self.after, after=self.before),)


@claim
class Solution(Claim):
    """True if these actions, in order, solve the task with the last one and not before."""

    actions: tuple[Pose, ...]
    listing: str
    count: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Play them."""
        lab.restore(moment.after)
        success = [lab.advance(action)[4]["success"] for action in self.actions]
        return success.index(True) + 1 == len(success) == self.count and self.listing == ", ".join(
            map(_compact, self.actions)
        )


@claim
class Done(Claim):
    """True if this action solved the task, which was not solved before."""

    kind = HP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again."""
        if not _judged(self, moment):
            return False
        lab.restore(moment.before)
        return lab.advance(self.action)[4]["success"]

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny it."""
        return (TryAgain(),)


@claim
class WellAimed(Claim):
    """True if the target was within 3 cm along each axis of the place where the hand was wanted, and the grip within
    0.3 of the one that was wanted, when the action was chosen.
    """  # noqa: D205

    kind = HP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and not _faults(self.action, moment.before, lab) and not _slip(moment, lab)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        return (Off(action=self.action, target=self.target, faults=f"{_AXES[0]} was 10 cm too large"),)


@claim
class RightPlace(Claim):
    """True if the target's place was within 3 cm along each axis of the one that was wanted; nothing on the grip."""

    kind = HP
    place: str
    """The target's place as text, relative to the hand where actions are."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return (
            _open(moment) and self.place == _write(moment.action[:3]) and not _faults(moment.action, moment.before, lab)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        action = moment.action
        return (Off(action=action, target=_write(action), faults=f"{_AXES[2]} was 10 cm too small"),)


@claim
class RightGrip(Claim):
    """True if the grip was within 0.3 of the one that was wanted; nothing on the place."""

    kind = HP
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _open(moment) and self.grip == round(moment.action[3], 2) and not _slip(moment, lab)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        action = moment.action
        return (_SLIPS[1](action=action, target=_write(action), grip=self.grip),)


@claim
class Neared(Claim):
    """True if the action took the hand from `before` to `after` centimetres from where it was wanted, and that is at
    least 1 cm nearer.
    """  # noqa: D205

    kind = HP
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again and measure."""
        return _moved(self, moment, lab) and self.before - self.after >= _NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Turn it round."""
        return (Strayed(before=self.after, after=self.before),)


@claim
class Strayed(Claim):
    """True if the action took the hand from `before` to `after` centimetres from where it was wanted, and that is at
    least 1 cm farther away.
    """  # noqa: D205

    kind = HN
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again and measure."""
        return _moved(self, moment, lab) and self.after - self.before >= _NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Turn it round."""
        return (Neared(before=self.after, after=self.before),)


@claim
class Off(Claim):
    """True if the target's place was off by more than 3 cm along the named axes, by so many centimetres, and along no
    others.
    """  # noqa: D205

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    faults: str
    """Per axis how much too large or too small."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.faults == _faults(self.action, moment.before, lab) != ""

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (WellAimed(action=self.action, target=self.target), RightPlace(place=_write(self.action[:3])))


@claim
class TooLoose(Claim):
    """True if the gripper should have been closed more: the grip was too small by more than 0.3."""

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.grip == round(self.action[3], 2) and _slip(moment, lab) < 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (RightGrip(grip=self.grip),)


@claim
class TooTight(Claim):
    """True if the gripper should have been opened more: the grip was too large by more than 0.3."""

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.grip == round(self.action[3], 2) and _slip(moment, lab) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (RightGrip(grip=self.grip),)


@claim
class Aiming(Claim):
    """True if `action` is, to two decimals, the pose that metaworld's scripted policy aims at in this state."""

    kind = FP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the pose from the policy's command and gain; a target that is out of reach is brought into it."""
        truth = moment.after
        place, grip = _commanded(truth, lab)
        at = lab.target(truth, self.action)
        wanted = [min(max(w, a), b) for w, a, b in zip(place, *_reach(truth, lab), strict=True)]
        return (
            not truth.solved
            and self.target == _write(self.action)
            and all(abs(a - w) <= _ROUNDING for a, w in zip(at, wanted, strict=True))
            and abs(self.action[3] - grip) <= _ROUNDING
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the hand the other way, or elsewhere, with the other grip."""
        truth, (x, y, z, grip) = moment.after, self.action
        hand = (0.0, 0.0, 0.0) if lab.relative else _hand(truth)
        mirrored = _rounded((2 * hand[0] - x, 2 * hand[1] - y, 2 * hand[2] - z, -grip))
        elsewhere = _rounded((x + 0.2, y, z, grip))
        return tuple(Aiming(action=action, target=_write(action)) for action in (mirrored, elsewhere))

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """How far it is, and then in which direction."""
        hand, at = _hand(moment.after), lab.target(moment.after, self.action)
        far = Distance(centimetres=round(100 * math.dist(hand, at)))
        ways = _ways(hand, at)
        return (far, Heading(ways=ways)) if ways else (far,)


@claim
class Distance(Claim):
    """True if the place where the hand is wanted now is so far from it, to a centimetre or so."""

    kind = FP
    centimetres: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the place from the policy's command and gain."""
        truth = moment.after
        place, _ = _commanded(truth, lab)
        return not truth.solved and abs(100 * math.dist(_hand(truth), place) - self.centimetres) <= 2

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim another distance."""
        return (Distance(centimetres=self.centimetres + 15),)


@claim
class Heading(Claim):
    """True if the hand is wanted in this direction: along each named axis by more than 2 cm, give or take 1 cm."""

    kind = FP
    ways: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the place from the policy's command and gain."""
        truth = moment.after
        place, _ = _commanded(truth, lab)
        named = set(self.ways.split(" and "))
        sure, possible = (set(_ways(_hand(truth), place, slack).split(" and ")) for slack in (0.01, -0.01))
        return not truth.solved and named <= possible and sure - {""} <= named

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite direction."""
        return (Heading(ways=self.ways.translate(_OPPOSITE)),)


@claim
class Avoid(Claim):
    """True if `action` would take the hand from `before` to `after` centimetres from where it is wanted now, and that
    is at least 1 cm farther away.
    """  # noqa: D205

    kind = FN
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action in a copy of the simulator."""
        truth = moment.after
        return not truth.solved and _tried(self, truth, lab) and self.after - self.before >= _NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the pose that is wanted, as if it led away."""
        action = _advised(lab.script.aim(moment.after.observation), moment.after, lab)
        return (Avoid(action=action, target=_write(action), before=self.before, after=self.after),)


_NOTABLE = 1.0  # centimetres
_PLACE, _GRIP = 0.03, 0.3  # how far from what is wanted is right enough
_ROUNDING = 0.005 + 1e-5  # of advice; commands are float32
_AXES = ("x", "y", "z")
_OPPOSITE = str.maketrans({"+": "-", "-": "+"})
_SLIPS = (TooLoose, TooTight)
_TRIES = 3
_TURNS = 30
_ASIDE = 0.15  # metres by which warnings lead away


def _hand(truth: Truth) -> Place:
    x, y, z = truth.observation[:3]
    return x, y, z


def _origin(world: World) -> str:
    return "from where the hand is" if world.relative else "from a fixed point of the table"


def _reach(truth: Truth, world: World) -> tuple[Place, Place]:
    """The smallest and the largest place that an action can name."""
    low, high = (world.target(truth, (bound, bound, bound, 0.0)) for bound in (-REACH, REACH))
    return low, high


def _rounded(pose: Sequence[float]) -> Pose:
    """To two decimals, within the action space."""
    x, y, z, grip = (round(number, 2) + 0.0 for number in pose)
    x, y, z = (min(max(number, -REACH), REACH) for number in (x, y, z))
    return x, y, z, min(max(grip, -1.0), 1.0)


def _write(pose: Sequence[float]) -> str:
    """Coordinates to a millimetre; advice has no more than two decimals."""
    return f"[{', '.join(f'{round(number, 3) + 0.0:g}' for number in pose)}]"


def _compact(pose: Pose) -> str:
    return _write(pose).replace(" ", "")


def _advised(aim: Aim, truth: Truth, world: World) -> Pose:
    """The action that aims as the policy does."""
    place = aim.target
    if world.relative:
        x, y, z = _hand(truth)
        place = place[0] - x, place[1] - y, place[2] - z
    return _rounded((*place, aim.grip))


def _commanded(truth: Truth, lab: World) -> tuple[Place, float]:
    """What is wanted, from the command that the policy itself would send: the hand, and the command over the gain."""
    x, y, z, grip = lab.script.command(truth.observation).tolist()
    gain, hand = lab.script.aim(truth.observation).gain, _hand(truth)
    return (hand[0] + x / gain, hand[1] + y / gain, hand[2] + z / gain), grip


def _off(place: Place, wanted: Place) -> str:
    """Per axis how much too large or too small."""
    return " and ".join(
        f"{axis} was {100 * abs(a - w):.0f} cm too {'large' if a > w else 'small'}"
        for axis, a, w in zip(_AXES, place, wanted, strict=True)
        if abs(a - w) > _PLACE
    )


def _ways(hand: Place, place: Place, slack: float = 0.0) -> str:
    """The axes along which there are more than 2 cm, and which way."""
    return " and ".join(
        f"{'+' if b > a else '-'}{axis}"
        for axis, a, b in zip(_AXES, hand, place, strict=True)
        if abs(a - b) > 0.02 + slack
    )


def _faults(action: Pose, truth: Truth, lab: World) -> str:
    return _off(lab.target(truth, action), _commanded(truth, lab)[0])


def _slip(moment: Moment, lab: World) -> int:
    """-1 if the grip of the action was too small, 1 if it was too large, else 0."""
    return _side(moment.action[3] - _commanded(moment.before, lab)[1])


def _side(excess: float) -> int:
    return (excess > _GRIP) - (excess < -_GRIP)


def _apart(hand: Place, place: Place) -> float:
    """Centimetres, to a millimetre."""
    return round(100 * math.dist(hand, place), 1)


def _open(moment: Moment) -> bool:
    return moment.before is not None and not moment.before.solved


def _judged(said: WellAimed | Off | TooLoose | TooTight | Done, moment: Moment) -> bool:
    return _open(moment) and moment.action == said.action and said.target == _write(said.action)


def _tried(said: TriedWell | TriedInVain | Avoid, truth: Truth, lab: World) -> bool:
    """Whether its action goes as it says."""
    place, _ = _commanded(truth, lab)
    lab.restore(truth)
    lab.advance(said.action)
    ends = _apart(_hand(truth), place), _apart(_hand(lab.truth), place)
    return said.target == _write(said.action) and _close((said.before, said.after), ends)


def _moved(said: Neared | Strayed, moment: Moment, lab: World) -> bool:
    if not _open(moment):
        return False
    place, _ = _commanded(moment.before, lab)
    lab.restore(moment.before)
    lab.advance(moment.action)
    ends = _apart(_hand(moment.before), place), _apart(_hand(lab.truth), place)
    return _close((said.before, said.after), ends)


def _close(said: tuple[float, float], measured: tuple[float, float]) -> bool:
    """Equal, but for a last digit that the rounding of a command may have changed."""
    return all(abs(a - b) < 0.15 for a, b in zip(said, measured, strict=True))


class MetaWorldOracle(Oracle):
    """Advises what metaworld's scripted policy aims at now, and judges an action by what it aimed at before."""

    def start(self, truth: Truth, rng: np.random.Generator) -> None:
        """Forget the last episode."""
        super().start(truth, rng)
        self._aims: list[tuple[Truth, Aim]] = []
        self._warned: tuple[Truth | None, tuple[Avoid, ...]] = (None, ())

    def _aim(self, truth: Truth) -> Aim:
        """What the policy aims at; the advice of one turn is the measure of the next, so two are remembered."""
        for known, aim in self._aims:
            if known is truth:
                return aim
        aim = self.lab.script.aim(truth.observation)
        self._aims = [*self._aims[-1:], (truth, aim)]
        return aim

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        lab = self.lab
        return (
            Goal(task=lab.task, purpose=PURPOSES[lab.task]),
            Driving(origin=_origin(lab), most=lab.longest),
            Syntax(expected=lab.action_syntax),
        )

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """The advised action and a few random ones, tried at the start."""
        lab = self.lab
        tries = [_advised(self._aim(truth), truth, lab)]
        tries += [_rounded(lab.sample_action(self.rng).tolist()) for _ in range(_TRIES)]
        told: list[Claim] = []
        for action in tries:
            before, after = self._trial(truth, action)
            if abs(after - before) >= _NOTABLE:
                cls = TriedWell if after < before else TriedInVain
                told.append(cls(action=action, target=_write(action), before=before, after=after))
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        """A whole roll-out of the advice; nothing where that does not solve the task."""
        actions, solved = self._followed(truth, _TURNS)
        if not solved:
            return ()
        return (Solution(actions=actions, listing=", ".join(map(_compact, actions)), count=len(actions)),)

    def _trial(self, truth: Truth, action: Pose) -> tuple[float, float]:
        """How far the hand is from where it is wanted, before and after an action."""
        lab, place = self.lab, self._aim(truth).target
        lab.restore(truth)
        lab.advance(action)
        return _apart(_hand(truth), place), _apart(_hand(lab.truth), place)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        before, action = moment.before, moment.action
        if before.solved or not (HP in kinds or HN in kinds):
            return
        target = _write(action)
        good: list[Claim] = []
        bad: list[Claim] = []
        if moment.after.solved:
            good.append(Done(action=action, target=target))
        else:
            aim = self._aim(before)
            faults = _off(self.lab.target(before, action), aim.target)
            slip = _side(action[3] - aim.grip)
            grip = round(action[3], 2)
            if not faults and not slip:
                good.append(WellAimed(action=action, target=target))
            elif not faults:
                good.append(RightPlace(place=_write(action[:3])))
            elif not slip:
                good.append(RightGrip(grip=grip))
            if faults:
                bad.append(Off(action=action, target=target, faults=faults))
                start, end = _apart(_hand(before), aim.target), _apart(_hand(moment.after), aim.target)
                # How the hand moved is news only of who aimed elsewhere: obstacles are not the student's fault.
                if start - end >= _NOTABLE:
                    good.append(Neared(before=start, after=end))
                elif end - start >= _NOTABLE:
                    bad.append(Strayed(before=start, after=end))
            if slip:
                bad.append(_SLIPS[slip > 0](action=action, target=target, grip=grip))
        if HP in kinds:
            claims += good
        if HN in kinds:
            claims += bad

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        if truth.solved or not (FP in kinds or FN in kinds):
            return
        if FP in kinds:
            action = _advised(self._aim(truth), truth, self.lab)
            claims.append(Aiming(action=action, target=_write(action)))
        if FN in kinds:
            if truth is not self._warned[0]:
                self._warned = truth, self._warnings(truth)
            claims += self._warned[1]

    def _warnings(self, truth: Truth) -> tuple[Avoid, ...]:
        """A pose away from where the hand is wanted, which the simulator shows to lose ground."""
        aim, hand = self._aim(truth), _hand(truth)
        far = math.dist(hand, aim.target)
        away = [(h - t) / far for h, t in zip(hand, aim.target, strict=True)] if far > 1e-3 else [0.0, 0.0, 1.0]
        for way in (away, [0.0, 0.0, 1.0]):
            place = [h + _ASIDE * w for h, w in zip(hand, way, strict=True)]
            action = _advised(aim._replace(target=tuple(place)), truth, self.lab)
            before, after = self._trial(truth, action)
            if after - before >= _NOTABLE and not self.lab.truth.solved:
                return (Avoid(action=action, target=_write(action), before=before, after=after),)
        return ()

    def importance(self, truth: Truth) -> float:
        """How far the hand is from where it is wanted, in metres, at most 1; 0 once the task is solved."""
        return 0.0 if truth.solved else min(math.dist(_hand(truth), self._aim(truth).target), 1.0)

    def plan(self, truth: Truth, n: int) -> tuple[Pose, ...]:
        """The advice of the next turns, if each is followed, until the task is solved."""
        if n == 1 and not truth.solved:
            return (_advised(self._aim(truth), truth, self.lab),)
        return self._followed(truth, n)[0]

    def _followed(self, truth: Truth, n: int) -> tuple[tuple[Pose, ...], bool]:
        """At most `n` pieces of advice, each followed in a copy of the simulator; whether the last solves the task."""
        lab, actions = self.lab, []
        lab.restore(truth)
        while not truth.solved and len(actions) < n:
            actions.append(_advised(lab.script.aim(truth.observation), truth, lab))
            lab.advance(actions[-1])
            truth = lab.truth
        return tuple(actions), truth.solved

    def regret(self, moment: Moment) -> float:
        """How far the target was from the advised one, in metres, and a tenth of how much the grip was off.

        A turn without an action loses as if it had sent the hand to the other side of where it is, the gripper wrong.
        """
        truth = moment.after if moment.before is None else moment.before
        if truth.solved:
            return 0.0
        advised = _advised(self._aim(truth), truth, self.lab)
        if moment.before is None:
            return 2 * math.dist(_hand(truth), self.lab.target(truth, advised)) + 0.2
        return math.dist(moment.action[:3], advised[:3]) + abs(moment.action[3] - advised[3]) / 10


PURPOSES = {
    "assembly-v3": "pick up the wrench and put its ring over the peg",
    "basketball-v3": "put the ball into the basket",
    "bin-picking-v3": "take the block out of its bin and put it into the other bin",
    "box-close-v3": "pick up the lid and put it on the box",
    "button-press-topdown-v3": "press the button down from above",
    "button-press-topdown-wall-v3": "press the button down from above, past the wall",
    "button-press-v3": "push the button in from the front",
    "button-press-wall-v3": "push the button in from the front, past the wall",
    "coffee-button-v3": "push the button of the coffee machine",
    "coffee-pull-v3": "pull the mug away from the coffee machine to the goal",
    "coffee-push-v3": "push the mug under the coffee machine, to the goal",
    "dial-turn-v3": "turn the dial",
    "disassemble-v3": "lift the wrench off the peg",
    "door-close-v3": "close the door",
    "door-lock-v3": "lock the door by turning its bolt",
    "door-open-v3": "open the door",
    "door-unlock-v3": "unlock the door by turning its bolt",
    "drawer-close-v3": "push the drawer shut",
    "drawer-open-v3": "pull the drawer open",
    "faucet-close-v3": "turn the faucet's handle so that it closes",
    "faucet-open-v3": "turn the faucet's handle so that it opens",
    "hammer-v3": "pick up the hammer and drive the nail into the board",
    "hand-insert-v3": "put the block into the hole, hand and all",
    "handle-press-side-v3": "press the handle down, from its side",
    "handle-press-v3": "press the handle down",
    "handle-pull-side-v3": "pull the handle up, from its side",
    "handle-pull-v3": "pull the handle up",
    "lever-pull-v3": "pull the lever up",
    "peg-insert-side-v3": "pick up the peg and put it into the hole from the side",
    "peg-unplug-side-v3": "pull the peg out of the hole, sideways",
    "pick-out-of-hole-v3": "take the puck out of the hole and bring it to the goal",
    "pick-place-v3": "pick up the puck and bring it to the goal",
    "pick-place-wall-v3": "pick up the puck and bring it over the wall to the goal",
    "plate-slide-back-side-v3": "slide the plate out of the cabinet, sideways, to the goal",
    "plate-slide-back-v3": "slide the plate back out of the cabinet, to the goal",
    "plate-slide-side-v3": "slide the plate sideways into the cabinet",
    "plate-slide-v3": "slide the plate into the cabinet",
    "push-back-v3": "pull the puck back to the goal",
    "push-v3": "push the puck to the goal",
    "push-wall-v3": "push the puck around the wall to the goal",
    "reach-v3": "bring the hand to the goal",
    "reach-wall-v3": "bring the hand to the goal, past the wall",
    "shelf-place-v3": "pick up the block and put it on the shelf",
    "soccer-v3": "push the ball into the goal",
    "stick-pull-v3": "pick up the stick and pull the box to the goal with it",
    "stick-push-v3": "pick up the stick and push the box to the goal with it",
    "sweep-into-v3": "sweep the block into the hole in the table",
    "sweep-v3": "sweep the block off the table",
    "window-close-v3": "slide the window shut",
    "window-open-v3": "slide the window open",
}
"""What solves each task, to complete "your task is to ..."."""
