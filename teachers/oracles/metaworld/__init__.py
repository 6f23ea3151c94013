"""Meta-World's oracle: it judges by metaworld's scripted policies, and tries actions in a copy of the simulator."""

import math
import warnings
from collections.abc import Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.oracles.metaworld.claims import (
    AXES,
    NOTABLE,
    Aiming,
    Avoid,
    Distance,
    Done,
    Driving,
    Goal,
    Grips,
    Neared,
    NoGrip,
    Off,
    RightGrip,
    RightPlace,
    Solution,
    Strayed,
    TooLoose,
    TooTight,
    Toward,
    TriedInVain,
    TriedWell,
    WellAimed,
    action_for,
    apart,
    hand_of,
    off_by,
    origin_of,
    rounded,
    slip_of,
)
from teachers.oracles.metaworld.corrections import aim_of
from teachers.oracles.metaworld.purposes import HOLDING, OPEN, SHUT
from worlds.metaworld import Aim, MetaWorld, Pose, Truth

_TRIES = 3
_TURNS = 30
_STRIDES = (0.03, 0.025, 0.04, 0.05)  # metres, tried for a solution where the advice finds none
_ASIDE = 0.15  # metres by which warnings lead away


class MetaWorldOracle(Oracle[Truth, MetaWorld]):
    """Advises the aim of metaworld's scripted policy, corrected for turns; judges actions by the aim before them."""

    max_importance = 4.0

    def start(self, truth: Truth) -> None:
        """Forget the last episode."""
        self._aims: list[tuple[Truth, Aim]] = []
        self._warned: tuple[Truth | None, tuple[Avoid, ...]] = (None, ())

    def _aim(self, truth: Truth) -> Aim:
        """The aim of the policy; the last two are cached, since the next turn is judged by this turn's advice."""
        for known, aim in self._aims:
            if known is truth:
                return aim
        aim = aim_of(self.lab, truth)
        self._aims = [*self._aims[-1:], (truth, aim)]
        return aim

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        lab = self.lab
        return (
            Goal(task=lab.task),
            Driving(origin=origin_of(lab), most=lab.longest),
            Syntax(expected=lab.action_syntax),
        )

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """The advised action and a few random ones, tried at the start."""
        lab = self.lab
        tries = [action_for(self._aim(truth), truth, lab)]
        tries += [rounded(lab.sample_action(rng).tolist()) for _ in range(_TRIES)]
        claims: list[Claim] = []
        for action in tries:
            before, after, _ = self._trial(truth, action)
            if abs(after - before) >= NOTABLE:
                cls = TriedWell if after < before else TriedInVain
                claims.append(cls(action=action, before=before, after=after))
        return tuple(claims)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        """A whole roll-out of the advice, or where that fails of longer strides; empty, with a warning, if all fail."""
        for stride in (None, *_STRIDES):
            actions, solved = self._followed(truth, _TURNS, stride)
            if solved:
                return (Solution(actions=actions),)
        warnings.warn(
            f"the advice for {self.lab.task} does not solve it in this episode within {_TURNS} turns, so that the "
            "instruction c has no solution; take another seed",
            stacklevel=2,
        )
        return ()

    def _trial(self, truth: Truth, action: Pose) -> tuple[float, float, bool]:
        """The hand's distance from the aim before and after an action, and whether the action solves the task."""
        place = self._aim(truth).target
        hand, solved = self.lab.foresee(truth, action)
        return apart(hand_of(truth), place), apart(hand, place), solved

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        before, action = moment.past, moment.action
        if before.solved or not (HP in kinds or HN in kinds):
            return
        good: list[Claim] = []
        bad: list[Claim] = []
        if moment.after.solved:
            good.append(Done(action=action))
        else:
            aim = self._aim(before)
            errors = off_by(self.lab.target(before, action), aim.target)
            slip = slip_of(action[3] - aim.grip)
            if not any(errors) and not slip:
                good.append(WellAimed(action=action))
            elif not any(errors):
                good.append(RightPlace(at=action[:3]))
            elif not slip:
                good.append(RightGrip(value=action[3]))
            if any(errors):
                bad.append(Off(action=action, errors=errors))
                start, end = apart(hand_of(before), aim.target), apart(hand_of(moment.after), aim.target)
                # The hand's way is judged only if the target was wrong: obstacles are not the student's fault.
                if start - end >= NOTABLE:
                    good.append(Neared(before=start, after=end))
                elif end - start >= NOTABLE:
                    bad.append(Strayed(before=start, after=end))
            if slip:
                bad.append((TooTight if slip > 0 else TooLoose)(action=action))
        if HP in kinds:
            claims += good
        if HN in kinds:
            claims += bad

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        if truth.solved or not (FP in kinds or FN in kinds):
            return
        if FP in kinds:
            action = action_for(self._aim(truth), truth, self.lab)
            claims.append(Aiming(action=action))
        if FN in kinds:
            if truth is not self._warned[0]:
                self._warned = truth, self._warnings(truth)
            claims += self._warned[1]

    def _warnings(self, truth: Truth) -> tuple[Avoid, ...]:
        """A pose away from the aim, which takes the hand farther from it in the simulator."""
        aim, hand = self._aim(truth), hand_of(truth)
        far = math.dist(hand, aim.target)
        away = [(h - t) / far for h, t in zip(hand, aim.target, strict=True)] if far > 1e-3 else [0.0, 0.0, 1.0]
        for way in (away, [0.0, 0.0, 1.0]):
            x, y, z = (h + _ASIDE * w for h, w in zip(hand, way, strict=True))
            action = action_for(aim._replace(target=(x, y, z)), truth, self.lab)
            before, after, solved = self._trial(truth, action)
            if after - before >= NOTABLE and not solved:
                return (Avoid(action=action, before=before, after=after),)
        return ()

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """The use of the gripper; a side towards the aim; the distance of the aim."""
        if truth.solved:
            return ()
        task, hand, place = self.lab.task, hand_of(truth), self._aim(truth).target
        clues: list[Claim] = [NoGrip()] if task in OPEN else []
        clues += [Grips(use=use) for use, tasks in (("hold", HOLDING), ("shut", SHUT)) if task in tasks]
        offset, axis = max(
            ((b - a, axis) for axis, a, b in zip(AXES, hand, place, strict=True)), key=lambda o: abs(o[0])
        )
        if abs(offset) > 0.02:
            clues.append(Toward(axis=f"{'+' if offset > 0 else '-'}{axis}"))
        return (*clues, Distance(centimetres=round(100 * math.dist(hand, place))))

    def importance(self, truth: Truth) -> float:
        """The regret of the mirrored aim with the wrong grip; 0 once the task is solved."""
        if truth.solved:
            return 0.0
        place = self.lab.target(truth, action_for(self._aim(truth), truth, self.lab))
        return min(2 * math.dist(hand_of(truth), place) + 0.2, self.max_importance)

    def plan(self, truth: Truth, n: int) -> tuple[Pose, ...]:
        """The advice of the next turns, until the task is solved, if the student follows it."""
        if n == 1 and not truth.solved:
            return (action_for(self._aim(truth), truth, self.lab),)
        return self._followed(truth, n)[0]

    def _followed(self, truth: Truth, n: int, stride: float | None = None) -> tuple[tuple[Pose, ...], bool]:
        """At most `n` pieces of advice, each followed in the lab, and whether the last solves the task.

        With a `stride`, the hand moves at most so far in a turn, instead of as far as the task's correction says.
        """
        lab = self.lab
        actions: list[Pose] = []
        lab.restore(truth)
        while not truth.solved and len(actions) < n:
            actions.append(action_for(aim_of(lab, truth, stride), truth, lab))
            lab.advance(actions[-1])
            truth = lab.truth
        return tuple(actions), truth.solved

    def idle(self, truth: Truth) -> float:
        """Distance of the advised target from the resting hand, in metres, plus a tenth of the error of a grip of 0."""
        if truth.solved:
            return 0.0
        advised = action_for(self._aim(truth), truth, self.lab)
        return math.dist(hand_of(truth), self.lab.target(truth, advised)) + float(abs(advised[3])) / 10

    def regret(self, moment: Moment[Truth]) -> float:
        """Distance of the target from the advised one, in metres, plus a tenth of the error of the grip."""
        truth = moment.before
        if truth is None:
            return self.idle(moment.after)
        if truth.solved:
            return 0.0
        advised = action_for(self._aim(truth), truth, self.lab)
        return math.dist(moment.action[:3], advised[:3]) + float(abs(moment.action[3] - advised[3])) / 10
