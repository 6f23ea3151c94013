"""The exact best times to advise beside rules, and the cost of teaching beside a bound (Zhang et al. 2021)."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from llf_teacher.reproductions.drawing import line, name_lines
from llf_teacher.reproductions.optimum import Life, Rooms, Span, least, lived
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Expectation, Rule
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference
from worlds.gridworld import DIRECTIONS, NO_DOOR, Gridworld, Truth, distances_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Case(NamedTuple):
    """The parameters of lifetimes."""

    rooms: int
    far: int
    """Least number of moves to the treasure."""
    optimism: float
    episodes: int
    turns: int
    near: tuple[int, ...]
    """By budget, the distance within which the rule `near mistakes` corrects."""


CASES = {
    "6 rooms, undecided": Case(6, 3, 0.0, 10, 20, (0, 2, 2, 3, 3)),
    "10 rooms, undecided": Case(10, 4, 0.0, 20, 30, (0, 2, 2, 3)),
    "6 rooms, optimistic": Case(6, 3, 1.0, 10, 20, (0, 1, 2, 1)),
}


def house_of(truth: Truth) -> Rooms:
    """The house at the start of an episode; advice is, as the oracle's, the first of the shortest directions."""
    doors = truth.layout.doors
    distance = distances_from(truth.layout.treasure, doors)
    behind = [[room if to == NO_DOOR else to for to in sides] for room, sides in enumerate(doors)]
    advice = [min(range(len(DIRECTIONS)), key=[distance[to] for to in sides].__getitem__) for sides in behind]
    return Rooms(behind, distance, advice, truth.room)


def _mistaken(life: Life) -> bool:
    return life.left()[life.meant()] >= life.house.distance[life.room]


def _important(life: Life) -> bool:
    return max(life.left()) - min(life.left()) == 2


RULES: dict[str, Callable[[Life], bool]] = {
    "early": lambda life: not life.over,
    "importance": _important,
    "announced mistake": _mistaken,
}
BEST = "optimum"
TEACHERS = (*RULES, "near mistakes", BEST)
TAUGHT, WAY = "least moves until taught", "rooms on the way"
MOVES, ADVICE = (f"{what} when all mistakes are corrected" for what in ("moves until taught", "advice"))
BEYOND = "least moves until taught, less rooms on the way"
MEASURES = (*TEACHERS, TAUGHT, MOVES, ADVICE, WAY, BEYOND)


def measure(
    rooms: int, far: int, optimism: float, episodes: int, turns: int, near: int, budget: int, seed: int
) -> Sequence[float]:
    """Regret per episode by teacher, and the moves and advice until the student is taught."""
    world = Gridworld(num_rooms=rooms, min_goal_dist=far)
    world.reset(seed=seed)
    life = Life(house_of(world.truth), Span(episodes, turns, optimism))

    def nearby(life: Life) -> bool:
        return _mistaken(life) and life.house.distance[life.room] <= near

    ends = [lived(life, rule, budget) for rule in (*RULES.values(), nearby)]
    lost = least(life, lambda each: each.lost, budget, 1 + min(end.lost for end in ends))
    settled = least(life, lambda each: each.settled, budget, 1 + min(end.settled for end in ends))
    corrected = lived(life, _mistaken, math.inf)
    regrets = [cost / episodes for cost in (*(end.lost for end in ends), lost)]
    way = life.house.distance[life.house.start]
    return [*regrets, settled, corrected.settled, corrected.said, way, settled - way]


def _setting(case: Case, budget: int) -> dict[str, Any]:
    return {**case._asdict(), "near": case.near[budget], "budget": budget}


def _column(values: Values, case: Case, budget: int, measured: str) -> Any:
    return values(**_setting(case, budget))[:, MEASURES.index(measured)]


def _regrets(values: Values, case: Case, teacher: str) -> list[Estimate]:
    return [mean_interval(_column(values, case, budget, teacher)) for budget in range(len(case.near))]


def read(values: Values) -> Reading:
    """Rules beside the optimum, and the cost of teaching beside the bound."""
    heads = ["house and student", "budget", *TEACHERS, "best rule less optimum", "least moves until taught"]
    table, parts, needs = [heads], list[str](), list[str]()
    for name, case in CASES.items():
        way, shares, gaps = _column(values, case, 0, WAY), list[str](), list[Estimate]()
        alone = _column(values, case, 0, BEST).mean()
        for budget in range(len(case.near)):
            columns = {teacher: _column(values, case, budget, teacher) for teacher in TEACHERS}
            rule = min(TEACHERS[:-1], key=lambda teacher: columns[teacher].mean())
            gap = paired_difference(columns[rule], columns[BEST]).estimate
            taught = _column(values, case, budget, TAUGHT)
            cells = [describe(mean_interval(columns[teacher])) for teacher in TEACHERS]
            table.append([name, str(budget), *cells, f"{describe(gap)} ({rule})" if budget else "", _few(taught)])
            if budget:
                gaps.append(gap)
                shares.append(f"{(alone - columns[rule].mean()) / (alone - columns[BEST].mean()):.0%}")
        widest = max(gaps, key=lambda gap: gap.mean)
        parts.append(f"{', '.join(shares)} ({name}; it leaves at most {describe(widest)} moves an episode)")
        moves, advice = (_few(_column(values, case, 0, each)) for each in (MOVES, ADVICE))
        needs.append(f"{moves} moves and {advice} pieces for {_few(way)} rooms ({name})")
    ours = (
        f"Share of the optimum's savings that the best rule has, at budgets from 1 on: {'; '.join(parts)}. "
        f"Correcting all mistakes takes {'; '.join(needs)}."
    )
    why = (
        "A teacher of full power, which sets rewards, moves and actions, needs one sample per state; without control "
        "of actions it needs as many as there are wrong actions. Advice sets only the action. An undecided student "
        "propagates a value by one room per visit: led one way, it is taught after as many passes as the way has "
        "rooms, in at most the square of their number of moves. An optimistic student drops a wrong action only after "
        "trying it, so that advice saves turns and teaches little. The optimum knows the whole future of the student; "
        "a rule that sees only the present cannot close the gap."
    )
    return Reading(ours, why, table)


def _few(numbers: Any) -> str:
    return describe(mean_interval(numbers), 1)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by budget, one panel per case."""
    panels = figure.subplots(1, len(CASES))
    for axes, (name, case) in zip(panels, CASES.items(), strict=True):
        for teacher in TEACHERS:
            found = _regrets(values, case, teacher)
            budgets = range(len(found))
            style = {"color": "black"} if teacher == BEST else {}
            line(axes, budgets, found, teacher, markersize=4, **style)
        axes.set(title=name, xlabel="budget", xticks=budgets, ylim=(0, None))
    panels[0].set_ylabel("regret per episode")
    name_lines(figure)


ROW = Row(
    claim=(
        "A teacher of full power teaches Q-learning in as many samples as there are states, and one that only advises "
        "needs more, even at the best times"
    ),
    source="Zhang et al. 2021 (arXiv 2006.09324)",
    protocol=(
        "Houses of 6 rooms, 10 episodes of at most 20 moves, the treasure at least 3 moves away, and of 10 rooms, 20 "
        "episodes of at most 30 moves, at least 4 away; always from the same room. The student is Q-learning, greedy, "
        "and deterministic: it breaks ties in turn, visit by visit. Undecided: all initial values are 0; optimistic: "
        "1. It takes the advised action for the turn. The optimum is exact: the least regret of any choice of turns "
        "for the advice, by branch and bound through all of them; the least number of moves after which the student "
        "neither errs nor is advised until the end (taught) likewise. Early advises from the first turn on, importance "
        "where 2 moves are at stake, announced mistake before any mistake, near mistakes before those near the "
        "treasure, within a number of moves that was chosen by budget on other seeds. The paper has theorems on the "
        "worst case; its teachers set rewards. The smallest effect that counts is one move."
    ),
    rule=Rule(
        seeds=30,
        comparisons=tuple(
            Expectation(
                expects=f"at the best times for {budget} pieces, moves until taught exceed rooms on the way ({name})",
                more=(_setting(case, budget),),
                measure=BEYOND,
                least=1.0,
            )
            for name, case in CASES.items()
            for budget in range(len(case.near))
        ),
    ),
    settings=tuple(_setting(case, budget) for case in CASES.values() for budget in range(len(case.near))),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
