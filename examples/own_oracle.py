"""An oracle of your own for FrozenLake, slippery or not, with all five kinds of feedback.

It measures ways by networkx (`pip install networkx`). Its claims are checked by another way: against the environment's
own table of transitions, and by taking the step again.
"""

from collections.abc import Sequence, Set

import gymnasium
import networkx as nx

import llf_teacher
from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, FeedbackType, Moment, claim
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.testing import Pupil, check_oracle
from worlds.wrapped.gym_world import GymWorld, Position

MOVES = ("left", "down", "right", "up")


def aim(lab: GymWorld, square: int, action: int) -> int:
    """Where a step leads if it does not slip."""
    outcomes = lab.env.get_wrapper_attr("P")[square][action]
    return int(outcomes[len(outcomes) // 2][1])


def steps(lab: GymWorld, square: int) -> int:
    """Steps from a square to the goal, by widening the circle; more than there are squares if there is no way."""
    squares = b"".join(lab.env.get_wrapper_attr("desc").ravel()).decode()
    circle, count = {square}, 0
    while not any(squares[each] == "G" for each in circle) and count <= len(squares):
        circle = {aim(lab, each, action) for each in circle if squares[each] in "SF" for action in range(4)}
        count += 1
    return count


def good(lab: GymWorld, truth: Position, action: int) -> bool:
    """Whether a step is aimed at a square that is nearer to the goal."""
    lab.restore(truth)
    return steps(lab, aim(lab, truth.seen, action)) < steps(lab, truth.seen)


@claim
class Reach(Claim):
    """True if nothing but the goal is paid."""

    def holds(self, moment: Moment, lab: GymWorld) -> bool:
        """Look for other squares that pay."""
        lab.restore(moment.after)
        table = lab.env.get_wrapper_attr("P")
        ends = [end for row in table.values() for outcomes in row.values() for end in outcomes]
        return {square for _, square, reward, _ in ends if reward > 0} == {len(table) - 1}


@claim
class Nearer(ActionClaim):
    """True if the step ended nearer to the goal."""

    kind = HP
    action_slot = "move"
    action: int
    move: str

    def holds(self, moment: Moment, lab: GymWorld) -> bool:
        """Take the step again."""
        lab.restore(moment.past)
        lab.step(self.action)  # it slips as it did in the episode
        return moment.action == self.action and steps(lab, lab.truth.seen) < steps(lab, moment.past.seen)

    def counterparts(self, moment: Moment, lab: GymWorld) -> Sequence[Claim]:
        """What a teacher that errs says instead."""
        return (Strayed(action=self.action, move=self.move),)


@claim
class Strayed(ActionClaim):
    """True if the step did not end nearer to the goal."""

    kind = HN
    action_slot = "move"
    action: int
    move: str

    def holds(self, moment: Moment, lab: GymWorld) -> bool:
        """The opposite."""
        return not Nearer(action=self.action, move=self.move).holds(moment, lab)

    def counterparts(self, moment: Moment, lab: GymWorld) -> Sequence[Claim]:
        """What a teacher that errs says instead."""
        return (Nearer(action=self.action, move=self.move),)


@claim
class Head(ActionClaim):
    """True if the square in this direction is safe and nearer to the goal."""

    kind = FP
    action_slot = "move"
    action: int
    move: str

    def holds(self, moment: Moment, lab: GymWorld) -> bool:
        """By the table."""
        return good(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: GymWorld) -> Sequence[Claim]:
        """What a teacher that errs says instead."""
        return tuple(Head(action=action, move=move) for action, move in enumerate(MOVES) if action != self.action)


@claim
class Avoid(ActionClaim):
    """True if the square in this direction is a hole, or no nearer to the goal."""

    kind = FN
    action_slot = "move"
    action: int
    move: str

    def holds(self, moment: Moment, lab: GymWorld) -> bool:
        """By the table."""
        return not good(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: GymWorld) -> Sequence[Claim]:
        """What a teacher that errs says instead."""
        return tuple(Avoid(action=action, move=move) for action, move in enumerate(MOVES) if action != self.action)


PHRASES = {  # 4 to 20 for each claim, all of which say the same
    Reach: ["Get to the goal.", "Your task is to get to the goal.", "Cross the ice to the goal.", "Find the goal."],
    Nearer: ["{move} was good.", "{move} helped.", "It was right to go {move}.", "{move} brought you nearer."],
    Strayed: ["{move} was bad.", "{move} was in vain.", "It was wrong to go {move}.", "{move} did not help."],
    Head: ["Go {move}.", "Now go {move}.", "Your next step should be {move}.", "Head {move}."],
    Avoid: ["Do not go {move}.", "Not {move} now.", "Your next step should not be {move}.", "Keep away from {move}."],
}


class LakeOracle(Oracle[Position, GymWorld]):
    """Judges steps by the distance to the goal over safe squares."""

    instruction_types = ("b",)  # with "p" and "c" it would have to implement `_practice` and `_solution`
    max_importance = 64.0

    def start(self, truth: Position) -> None:
        """Measure all ways."""
        self.lab.restore(truth)
        desc = self.lab.env.get_wrapper_attr("desc").astype(str)
        (rows, columns), letters = desc.shape, desc.ravel()
        beside = {
            row * columns + column: [
                row * columns + max(column - 1, 0),
                min(row + 1, rows - 1) * columns + column,
                row * columns + min(column + 1, columns - 1),
                max(row - 1, 0) * columns + column,
            ]
            for row in range(rows)
            for column in range(columns)
        }
        safe = {square for square in beside if letters[square] in "SF"}
        ways = nx.DiGraph((square, other) for square in safe for other in beside[square])
        (goal,) = (square for square in beside if letters[square] == "G")
        far = nx.single_target_shortest_path_length(ways, goal)
        self.distance = {square: far.get(square, desc.size) for square in beside}
        self.beside, self.safe = beside, safe

    def values(self, truth: Position) -> tuple[float, ...]:  # gives importance, plan and regret, too
        """Minus the steps that are left after each action."""
        if truth.seen not in self.safe:
            return (0.0,) * 4
        return tuple(-float(self.distance[square]) for square in self.beside[truth.seen])

    def _basics(self, truth: Position) -> tuple[Claim, ...]:
        return Reach(), Syntax(expected=self.lab.action_syntax)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        nearer = self.distance[moment.after.seen] < self.distance[moment.past.seen]
        cls = Nearer if nearer else Strayed
        if cls.kind in kinds:
            claims.append(cls(action=moment.action, move=MOVES[moment.action]))

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        square = moment.after.seen
        if square in self.safe:
            nearer = [self.distance[other] < self.distance[square] for other in self.beside[square]]
            if FP in kinds:
                claims.append(Head(action=nearer.index(True), move=MOVES[nearer.index(True)]))
            if FN in kinds:
                claims.append(Avoid(action=nearer.index(False), move=MOVES[nearer.index(False)]))


def lesson(slippery: bool) -> llf_teacher.Lesson:
    """The lesson."""
    return llf_teacher.Lesson(
        lambda: gymnasium.make("FrozenLake-v1", is_slippery=slippery),
        LakeOracle,
        phrases=PHRASES,
        look=lambda env: int(env.get_wrapper_attr("s")),  # what a truth shall show as `seen`
        action_words={move: action for action, move in enumerate(MOVES)},
    )


def main() -> None:
    """Check the oracle, and play both seats."""
    # The kit checks that every claim holds, that its counterparts do not, that plans have no regret, ...
    for slippery in (False, True):
        pupil = lesson(slippery)
        check_oracle(Pupil(pupil.make_world, pupil.make_teacher, max_turns=pupil.max_turns, turns=200))

    # The student's side: `teach(env, oracle, ...)` is `StudentEnv(Lesson(env, oracle, ...))`.
    env = llf_teacher.StudentEnv(lesson(False), teacher="mistake(eps=0.2)", text=True)
    env.reset(seed=7)
    observation, *_ = env.step("down")
    print(observation["feedback"])

    # The teacher's side, with a student that obeys.
    teaching = llf_teacher.TeacherEnv(lesson(False), student="obedient")
    teaching.reset(seed=7)
    terminated = False
    while not terminated:
        _, _, terminated, _, info = teaching.step(0b01000)  # say what to do next
    print(info["moment"].success)

    # And both seats for PettingZoo.
    seats = lesson(True).env(speech="kinds")
    seats.reset(seed=7)


if __name__ == "__main__":
    main()
