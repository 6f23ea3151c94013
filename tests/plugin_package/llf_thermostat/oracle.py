"""What can be said of a thermostat: the oracle goes by the sign, the claims' checks by the lab's steps."""

from llf_thermostat.world import KNOBS
from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, PlanClaim, claim
from teachers.oracle import Oracle


def degrees_left(lab, truth, action):
    """How far the room is from what is wanted after the knob, tried out."""
    lab.restore(truth)
    lab.step(action)
    return abs(lab.truth.wanted - lab.truth.now)


def helps(lab, truth, action):
    """Whether the knob brings the room nearer to what is wanted."""
    return degrees_left(lab, truth, action) < abs(truth.wanted - truth.now)


@claim
class Goal(Claim):
    """True if the turn of the knob that ends on the wanted temperature is the one that succeeds."""

    def holds(self, moment, lab):
        wanted = moment.after.wanted
        lab.restore(moment.after._replace(now=wanted - 1))
        return lab.step(1)[4]["success"] is False and lab.step(2)[4]["success"]


@claim
class Answer(Claim):
    """True if these are the knobs, numbered from 0."""

    listing: str

    def holds(self, moment, lab):
        return [lab.action_words.get(word) for word in self.listing.split(", ")] == [0, 1, 2]


@claim
class _Turned(ActionClaim):
    action_slot = "knob"
    action: int
    knob: str

    def counterparts(self, moment, lab):
        return tuple(type(self)(action=i, knob=knob) for i, knob in enumerate(KNOBS) if i != self.action)


@claim
class Helped(_Turned):
    """True if the knob brought the room nearer to the wanted temperature."""

    kind = HP

    def holds(self, moment, lab):
        return moment.before is not None and moment.action == self.action and helps(lab, moment.before, self.action)

    def counterparts(self, moment, lab):
        return (DidNotHelp(action=self.action, knob=self.knob),)

    def worth(self, moment, lab, action):
        return -float(degrees_left(lab, moment.before, action))


@claim
class DidNotHelp(_Turned):
    """True if the knob did not bring the room nearer to the wanted temperature."""

    kind = HN

    def holds(self, moment, lab):
        return moment.before is not None and moment.action == self.action and not helps(lab, moment.before, self.action)

    def counterparts(self, moment, lab):
        return (Helped(action=self.action, knob=self.knob),)

    def worth(self, moment, lab, action):
        return -float(degrees_left(lab, moment.before, action))


@claim
class Turn(_Turned):
    """True if this knob brings the room nearer to the wanted temperature."""

    kind = FP

    def holds(self, moment, lab):
        return helps(lab, moment.after, self.action)


@claim
class Leave(_Turned):
    """True if this knob does not bring the room nearer to the wanted temperature."""

    kind = FN

    def holds(self, moment, lab):
        return not helps(lab, moment.after, self.action)


@claim
class Tried(_Turned):
    """True if this knob, turned at the start, does not bring the room nearer to the wanted temperature."""

    kind = HN
    tried = True

    def holds(self, moment, lab):
        return not helps(lab, moment.after, self.action)


@claim
class Recipe(PlanClaim):
    """True if these knobs, in order, bring the room to the wanted temperature, and nothing is faster."""

    actions: tuple[int, ...]
    listing: str

    def holds(self, moment, lab):
        lab.restore(moment.after)
        succeeded = [lab.step(action)[4]["success"] for action in self.actions]
        return succeeded == [False] * (abs(moment.after.wanted - moment.after.now) - 1) + [True]


class ThermostatOracle(Oracle):
    """A value is the negated number of degrees that are left."""

    max_importance = 2.0

    def _basics(self, truth):
        return Goal(), Answer(listing=", ".join(KNOBS))

    def _practice(self, truth, rng):
        poor = [action for action in range(3) if action != self._best(truth)]
        action = poor[rng.integers(2)]
        return (Tried(action=action, knob=KNOBS[action]),)

    def _solution(self, truth):
        actions = self.plan(truth, 1000)
        return (Recipe(actions=actions, listing=", ".join(KNOBS[action] for action in actions)),)

    def _hindsight(self, claims, moment, kinds):
        cls = Helped if moment.action == self._best(moment.before) else DidNotHelp
        if cls.kind in kinds:
            claims.append(cls(action=moment.action, knob=KNOBS[moment.action]))

    def _advice(self, claims, moment, kinds):
        best = self._best(moment.after)
        if FP in kinds and best != 1:
            claims.append(Turn(action=best, knob=KNOBS[best]))
        if FN in kinds:
            worst = (best + 1 + moment.turn % 2) % 3
            claims.append(Leave(action=worst, knob=KNOBS[worst]))

    def values(self, truth):
        return tuple(-float(abs(truth.wanted - (truth.now + action - 1))) for action in range(3))

    def plan(self, truth, n):
        return (self._best(truth),) * min(abs(truth.wanted - truth.now), n)

    @staticmethod
    def _best(truth):
        return 1 + (truth.wanted > truth.now) - (truth.wanted < truth.now)
