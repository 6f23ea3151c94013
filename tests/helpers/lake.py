"""A user's own oracle, for FrozenLake, slippery or not: shortest safe ways by networkx, of where a step is aimed."""

from collections import deque

import networkx as nx

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, PlanClaim, claim
from teachers.common import Syntax
from teachers.oracle import Oracle

MOVES = ("left", "down", "right", "up")
WORDS = dict(zip(MOVES, range(4), strict=True))


def aim(lab, square, action):
    """Where a step leads if it does not slip."""
    outcomes = lab.env.unwrapped.P[square][action]
    return outcomes[len(outcomes) // 2][1]


def steps(lab, square):
    """Steps to the goal over safe squares, by breadth-first search in the environment's table of transitions."""
    letters = b"".join(lab.env.unwrapped.desc.ravel()).decode()
    seen, queue = {square: 0}, deque([square])
    while queue:
        here = queue.popleft()
        if letters[here] == "G":
            return seen[here]
        if letters[here] != "H":
            for action in range(4):
                there = aim(lab, here, action)
                if there not in seen:
                    seen[there] = seen[here] + 1
                    queue.append(there)
    return len(letters)


def gains(lab, truth, action):
    lab.restore(truth)
    return steps(lab, aim(lab, truth.seen, action)) < steps(lab, truth.seen)


@claim
class Reach(Claim):
    """True if stepping onto the goal, and only that, is paid."""

    def holds(self, moment, lab):
        lab.restore(moment.after)
        letters = b"".join(lab.env.unwrapped.desc.ravel()).decode()
        table = lab.env.unwrapped.P
        ends = [each for row in table.values() for outcomes in row.values() for each in outcomes]
        return all((reward > 0) == (letters[s] == "G") for _, s, reward, _ in ends if s in table) or all(
            letters[s] == "G" for _, s, reward, _ in ends if reward > 0
        )


@claim
class _Step(ActionClaim):
    action_slot = "move"
    action: int
    move: str

    def counterparts(self, moment, lab):
        return tuple(type(self)(action=i, move=move) for i, move in enumerate(MOVES) if i != self.action)


@claim
class Nearer(_Step):
    """True if the step ended nearer to the goal."""

    kind = HP

    def holds(self, moment, lab):
        """Take the step again: the lab slips alike."""
        if moment.before is None or moment.action != self.action or MOVES[self.action] != self.move:
            return False
        lab.restore(moment.before)
        before = steps(lab, lab.truth.seen)
        lab.step(self.action)
        return steps(lab, lab.truth.seen) < before

    def counterparts(self, moment, lab):
        return (Strayed(action=self.action, move=self.move),)


@claim
class Strayed(_Step):
    """True if the step did not end nearer to the goal."""

    kind = HN

    def holds(self, moment, lab):
        opposite = Nearer(action=self.action, move=self.move)
        return moment.before is not None and moment.action == self.action and not opposite.holds(moment, lab)

    def counterparts(self, moment, lab):
        return (Nearer(action=self.action, move=self.move),)


@claim
class Head(_Step):
    """True if the square in this direction is safe and nearer to the goal."""

    kind = FP

    def holds(self, moment, lab):
        return gains(lab, moment.after, self.action)


@claim
class Avoid(_Step):
    """True if the square in this direction is a hole, or no nearer to the goal."""

    kind = FN

    def holds(self, moment, lab):
        return not gains(lab, moment.after, self.action)


@claim
class Tried(_Step):
    """True if aiming in this direction at the start is a step to a square that is no nearer to the goal."""

    kind = HN
    tried = True

    def holds(self, moment, lab):
        return not gains(lab, moment.after, self.action)


@claim
class Route(PlanClaim):
    """True if steps in these directions, none of which slips, lead to the goal the shortest way."""

    actions: tuple[int, ...]
    listing: str

    def holds(self, moment, lab):
        lab.restore(moment.after)
        square = moment.after.seen
        left = [steps(lab, square)]
        for action in self.actions:
            square = aim(lab, square, action)
            left.append(steps(lab, square))
        return left == list(range(len(self.actions), -1, -1))


class LakeOracle(Oracle):
    max_importance = 64.0

    def start(self, truth):
        self.lab.restore(truth)
        desc = self.lab.env.unwrapped.desc.astype(str)
        rows, columns = desc.shape
        offsets = ((0, -1), (1, 0), (0, 1), (-1, 0))
        self._aims = {}
        graph = nx.DiGraph()
        for row in range(rows):
            for column in range(columns):
                there = (
                    (min(max(row + down, 0), rows - 1), min(max(column + right, 0), columns - 1))
                    for down, right in offsets
                )
                aims = self._aims[row * columns + column] = [r * columns + c for r, c in there]
                if desc[row, column] in "SF":
                    graph.add_edges_from((row * columns + column, square) for square in aims)
        goal = int((desc == "G").ravel().argmax())
        self._far = desc.size
        self._steps = nx.single_target_shortest_path_length(graph, goal)
        self._over = {i for i, letter in enumerate(desc.ravel()) if letter in "GH"}

    def _basics(self, truth):
        return Reach(), Syntax(expected=self.lab.action_syntax)

    def _practice(self, truth, rng):
        poor = [action for action in range(4) if not self._gains(truth.seen, action)]
        action = poor[rng.integers(len(poor))]
        return (Tried(action=action, move=MOVES[action]),)

    def _solution(self, truth):
        square, actions = truth.seen, []
        while square not in self._over:
            actions.append(next(action for action in range(4) if self._gains(square, action)))
            square = self._aims[square][actions[-1]]
        return (Route(actions=tuple(actions), listing=", ".join(MOVES[action] for action in actions)),)

    def _hindsight(self, claims, moment, kinds):
        cls = Nearer if self._distance(moment.after.seen) < self._distance(moment.before.seen) else Strayed
        if cls.kind in kinds:
            claims.append(cls(action=moment.action, move=MOVES[moment.action]))

    def _advice(self, claims, moment, kinds):
        square = moment.after.seen
        if square in self._over:
            return
        good = [action for action in range(4) if self._gains(square, action)]
        poor = [action for action in range(4) if action not in good]
        if FP in kinds:
            claims.append(Head(action=good[0], move=MOVES[good[0]]))
        if FN in kinds:
            worst = poor[moment.turn % len(poor)]
            claims.append(Avoid(action=worst, move=MOVES[worst]))

    def values(self, truth):
        if truth.seen in self._over:
            return (0.0,) * 4
        return tuple(-float(self._distance(square)) for square in self._aims[truth.seen])

    def _distance(self, square):
        return self._steps.get(square, self._far)

    def _gains(self, square, action):
        return self._distance(self._aims[square][action]) < self._distance(square)


PHRASES = {
    "Reach": [f"{lead} reach the goal on the far side of the frozen lake." for lead in ("Try to", "Please", "Go and")]
    + ["Your task is to get to the goal across the ice."],
    "Nearer": [f"{{move}} {said}." for said in ("was good", "brought you nearer", "helped", "paid off")],
    "Strayed": [f"{{move}} {said}." for said in ("was bad", "brought you no nearer", "did not help", "was in vain")],
    "Head": [f"{said} {{move}} next." for said in ("Go", "Head", "Move", "Step")],
    "Avoid": [f"{said} go {{move}} next." for said in ("Do not", "Never", "You should not", "Better not")],
    "Tried": [f"{who} went {{move}} at the start, in vain." for who in ("Somebody", "Ann", "A friend", "Another")],
    "Route": [f"{said}: {{listing}}." for said in ("The way is", "Go so", "A shortest way", "Aim in this order")],
}
