"""When to spend a small budget of advice (Torrey & Taylor 2013), also by an importance that does not saturate."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from llf_teacher.reproductions.classes import LIFETIMES, Glance, accompanied
from llf_teacher.reproductions.classes import Rule as AdviceRule
from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference
from worlds.batches import Bools

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = {(20, 10): 4, (20, 30): 8}
"""Threshold of discounted importance, as moves to the treasure, by rooms and pieces of advice."""
EPISODES, MOVES, GREATEST = 60, 3, 2.0
"""Episodes of a lifetime; greatest number of moves per room in each; greatest importance."""
RULES: dict[str, AdviceRule] = {
    "announced mistake": lambda seen: seen.mistake & (seen.importance >= GREATEST),
    "correcting": lambda seen: seen.erred & (seen.before >= GREATEST),
    "importance": lambda seen: seen.importance >= GREATEST,
    "early": lambda seen: seen.importance >= 0,
    "random": lambda seen: seen.rng.random(len(seen.importance)) < 0.1,
    "no advice": lambda seen: seen.importance < 0,
}
DISCOUNTED = "discounted importance"
TAUGHT = (*RULES, DISCOUNTED)
REGRET = "regret per episode"
EXPECTED = (("announced mistake", "early"), (DISCOUNTED, "early"), ("early", "random"))
"""Pairs of rules of which the first is expected to waste less; importance is the paper's, of discounted values."""


def measure(rooms: int, budget: int, rule: str, near: int, seed: int) -> Sequence[float]:
    """Regret per episode, pieces of advice, and the share of turns with greatest importance."""

    def discounted(seen: Glance) -> Bools:
        return (seen.importance >= GREATEST) & (seen.way <= near)

    return accompanied(
        "llf-gridworld-v0",
        RULES.get(rule, discounted),
        seed=seed,
        episodes=EPISODES,
        turns=MOVES * rooms,
        budget=budget,
        num_rooms=rooms,
    )


def _setting(case: tuple[int, int], rule: str) -> dict[str, int | str]:
    return {"rooms": case[0], "budget": case[1], "rule": rule, "near": CASES[case]}


def _regrets(values: Values, rule: str) -> list[Estimate]:
    return [values.means(**_setting(case, rule))[0] for case in CASES]


def _less(values: Values, case: tuple[int, int], rule: str, than: str) -> Estimate:
    """How much less regret a rule gives than another."""
    other, mine = (values(**_setting(case, each))[:, 0] for each in (than, rule))
    return paired_difference(other, mine).estimate


def read(values: Values) -> Reading:
    """The order of rules, and the paper's importance beside one that saturates."""
    names = [f"{rooms} rooms, {budget} pieces" for rooms, budget in CASES]
    table = [["teacher", *names]]
    table += [[rule, *(describe(each) for each in _regrets(values, rule))] for rule in TAUGHT]
    plain = [_less(values, case, "importance", "early") for case in CASES]
    fine = [_less(values, case, DISCOUNTED, "early") for case in CASES]
    announced = [_less(values, case, "announced mistake", "early") for case in CASES]
    share = mean_interval(values(**_setting(next(iter(CASES)), "no advice"))[:, 2])
    listed = [
        ", ".join(f"{describe(each)} ({name})" for each, name in zip(one, names, strict=True))
        for one in (plain, fine, announced)
    ]
    ours = (
        f"Beside early advising discounted importance saves {listed[1]} moves an episode, importance that is not "
        f"discounted {listed[0]}, and correcting announced mistakes {listed[2]}."
    )
    why = (
        "Importance saturates: a door changes the distance by one, so that at most 2 moves are at stake, and they are "
        f"in {describe(share)} of the turns of a student without advice. It can save advice in the other turns only. "
        "In the paper importance comes from discounted values, which tell states near the goal from those far away. "
        "Such an importance keeps advice for the end of the way, which matters where the budget is small; where it is "
        "enough for the whole way, there is little to keep it for."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret, one group of bars per case."""
    axes = figure.subplots()
    groups = [f"{rooms} rooms,\n{budget} pieces" for rooms, budget in CASES]
    bars(axes, groups, {rule: _regrets(values, rule) for rule in TAUGHT})
    axes.set(ylabel="regret per episode", yscale="log")
    figure.legend(loc="outside right center", fontsize="small")


ROW = Row(
    claim="Advice on important states and before mistakes is worth more than early advice, and that more than random",
    source="Torrey & Taylor 2013",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most {MOVES} moves per room from the same room, and 10 or 30 "
        "pieces of advice in all. The student is Q-learning, and takes the advised action for the turn; a seed is a "
        f"class of {LIFETIMES} lifetimes in houses of their own. Early advises from the first turn on, random in a "
        "tenth of the turns, importance where 2 moves are at stake, correcting after a mistake in such a state, "
        "announced mistake before it. Discounted importance is the difference of discounted values, as in the paper, "
        "with a threshold that was chosen on other seeds: it is reached where 2 moves are at stake at most "
        f"{' and '.join(map(str, sorted(set(CASES.values()))))} moves from the treasure, by rooms and budget. Figures "
        "are moves wasted per episode. The paper has Pac-Man and StarCraft."
    ),
    rule=Rule(
        seeds=12,
        comparisons=tuple(
            saves(
                f"{rule} wastes less than {than} with {case[1]} pieces",
                _setting(case, rule),
                _setting(case, than),
                REGRET,
            )
            for case in CASES
            for rule, than in EXPECTED
        ),
    ),
    settings=tuple(_setting(case, rule) for case in CASES for rule in TAUGHT),
    measure=measure,
    measures=(REGRET, "pieces of advice", "share of turns with greatest importance"),
    read=read,
    draw=draw,
)
