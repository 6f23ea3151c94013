"""Regret by the size of a world: learning from feedback and from rewards (HELiX: Xu et al. 2025)."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from llf_teacher.reproductions.drawing import name_lines
from llf_teacher.reproductions.lessons import regrets, total
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import TENTH, Expectation, Rule
from llf_teacher.studies.analysis.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZES = {"bandits": (4, 8, 16, 32, 64, 128), "gridworld": (5, 10, 20, 40, 80)}
"""Numbers of arms and of rooms."""
TEACHERS = {
    "rewards": "silent",
    "what to do": "only(kinds='fp')",
    "what to avoid": "only(kinds='fn')",
    "verdicts": "only(kinds='hp+hn')",
}
"""The teacher by what is learned from."""
STUDENTS = {
    ("bandits", "rewards"): "ucb",
    ("gridworld", "rewards"): "q_learning(forget=False, optimism=0.0, epsilon=0.1)",
    ("gridworld", "verdicts"): "sabl(forget=False)",
}
"""Learners by family and what they learn from; `obedient` for all others."""
PULLS, EPISODES, MOVES, WORLDS = 8, 30, 4, 4
"""Pulls per arm; episodes in a house, and greatest number of moves per room in each; worlds of a seed."""
REGRET, LOGARITHM = MEASURES = "total regret", "its logarithm"
_NAMES = {"verdicts": "verdicts", "what to avoid": "warnings"}
"""The feedback that the rule is about."""
_RESAMPLES = 9999
_LEAST = 1e-3  # regret below which the logarithm is not taken, where nothing is lost


def measure(family: str, size: int, student: str, teacher: str, seed: int) -> Sequence[float]:
    """Mean over worlds of this size of the total regret, and its logarithm."""
    first = WORLDS * seed
    regret = total([_lost(family, size, student, teacher, seed) for seed in range(first, first + WORLDS)]) / WORLDS
    return [regret, math.log(max(regret, _LEAST))]


def _lost(family: str, size: int, student: str, teacher: str, seed: int) -> float:
    """Total regret in a world."""
    if family == "bandits":
        id, turns = "llf-bandits-BanditTenArmedRandomFixed-v0", PULLS * size
        lost, _ = regrets(id, student=student, teacher=teacher, seed=seed, turns=turns, arms=size)
    else:
        *lost, _ = live(
            "llf-gridworld-v0",
            student=student,
            teacher=teacher,
            episodes=EPISODES,
            turns=MOVES * size,
            seed=seed,
            num_rooms=size,
            min_goal_dist=2,
        )
    return total(lost)


def _setting(family: str, size: int, learns: str) -> dict[str, str | int]:
    student = STUDENTS.get((family, learns), "obedient")
    return {"family": family, "size": size, "student": student, "teacher": TEACHERS[learns]}


def _means(values: Values, family: str, learns: str) -> NDArray[np.float64]:
    return np.array([values(**_setting(family, size, learns))[:, 0].mean() for size in SIZES[family]])


def exponent(sizes: Sequence[int], regrets: Sequence[NDArray[np.float64]]) -> Estimate | None:
    """The b of mean regret = a * size ** b, by least squares of the logarithms; None if a size has no regret.

    Args:
        sizes: different ones.
        regrets: per size an array of the seeds' regrets, of equal lengths.
    """
    if not min(each.mean() for each in regrets):
        return None
    least = min(each[each > 0].min() / len(each) for each in regrets)  # smallest positive mean
    away = np.log(sizes) - np.log(sizes).mean()

    def slope(*samples: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        means = [each.mean(axis=axis) for each in samples]
        return np.asarray(np.tensordot(away, np.log(np.maximum(means, least)), 1) / (away @ away))

    found = stats.bootstrap(regrets, slope, n_resamples=_RESAMPLES, method="percentile", random_state=0)
    low, high = found.confidence_interval
    return Estimate(float(slope(*regrets, axis=0)), float(low), float(high), len(regrets[0]))


def read(values: Values) -> Reading:
    """Regret at the smallest and the greatest size, and the exponent of its growth."""
    table = [["family", "learns from", "regret, least size", "greatest size", "grows as size to the power of"]]
    powers = {}
    for family, sizes in SIZES.items():
        for learns in TEACHERS:
            ends = [describe(values.means(**_setting(family, n, learns))[0], 1) for n in (sizes[0], sizes[-1])]
            power = exponent(sizes, [values(**_setting(family, size, learns))[:, 0] for size in sizes])
            powers[family, learns] = "no regret, by definition" if power is None else describe(power)
            table.append([family, learns, *ends, powers[family, learns]])
    beside = [
        f"in {family} {powers[family, 'rewards']} from rewards, {powers[family, 'verdicts']} from verdicts, "
        f"{powers[family, 'what to avoid']} from warnings"
        for family in SIZES
    ]
    last = {(family, learns): _means(values, family, learns)[-1] for family in SIZES for learns in TEACHERS}
    less = [last[family, "rewards"] / last[family, "verdicts"] for family in SIZES]
    ours = (
        f"Exponents of growth: {'; '.join(beside)}. At the greatest sizes the regret with rewards is {less[0]:.1f} and "
        f"{less[1]:.1f} times that with verdicts."
    )
    why = (
        "The paper's gap is exponential where one sentence rules out a share of all that may be true. Verdicts and "
        "warnings rule out one action at a time, so regret grows with the number of actions or rooms as it does from "
        "rewards, by another factor. A student that hears warnings alone takes any action that it was not warned of: "
        "among many arms that costs more than learning from rewards. Advice that names the best action is in the table "
        "and not in the rule: a student that does what it is told has no regret at any size, by definition, which says "
        "nothing about learning. The paper's learners hear rewards beside feedback; ours hear one or the other."
    )
    return Reading(ours, why, table)


def _ahead(family: str, feedback: str) -> Expectation:
    """Less regret than from rewards, at the greatest size, by a tenth."""
    size = SIZES[family][-1]
    return Expectation(
        expects=f"in {family} of size {size} regret is less from {_NAMES[feedback]} than from rewards",
        more=(_setting(family, size, "rewards"),),
        less=(_setting(family, size, feedback),),
        measure=LOGARITHM,
        least=-math.log(1 - TENTH),
    )


def _widening(family: str, feedback: str) -> Expectation:
    """A ratio of regrets that is greater by a tenth at the greatest size than at the least."""
    least, greatest = SIZES[family][0], SIZES[family][-1]
    return Expectation(
        expects=f"in {family} the lead of {_NAMES[feedback]} is greater at size {greatest} than at {least}, as a ratio",
        more=(_setting(family, greatest, "rewards"), _setting(family, least, feedback)),
        less=(_setting(family, greatest, feedback), _setting(family, least, "rewards")),
        measure=LOGARITHM,
        least=-math.log(1 - TENTH),
    )


def draw(values: Values, figure: "Figure") -> None:
    """Regret by size, both axes logarithmic."""
    for axes, (family, sizes) in zip(figure.subplots(1, 2), SIZES.items(), strict=True):
        for learns in TEACHERS:
            axes.plot(sizes, _means(values, family, learns), label=learns)
        axes.set(title=family, xlabel="arms" if family == "bandits" else "rooms", ylabel="total regret")
        axes.set_xscale("log", base=2)
        axes.set_yscale("symlog", linthresh=1.0)
        axes.set_ylim(bottom=-0.1)
    name_lines(figure)


ROW = Row(
    claim="Learning from feedback needs less experience than learning from rewards, the more so the larger the world",
    source="Xu et al. 2025 (HELiX, arXiv 2506.10341)",
    protocol=(
        f"Bandits of 4 to 128 arms that pay 1 with chances drawn uniformly, {PULLS} pulls per arm; houses of 5 to 80 "
        f"rooms, {EPISODES} episodes of at most {MOVES} moves per room from the same room. From rewards learn UCB1 and "
        "Q-learning; the others hear one kind of feedback and no rewards: advice (fp), warnings (fn), verdicts (hp "
        "and hn, in houses by `sabl`, which remembers them over episodes). Regret is in expected reward and in moves, "
        f"the mean of {WORLDS} worlds for each seed. The rule is about verdicts and warnings, and compares logarithms, "
        "so that a difference is a ratio."
    ),
    settings=tuple(_setting(family, size, learns) for family in SIZES for size in SIZES[family] for learns in TEACHERS),
    rule=Rule(
        seeds=16,
        comparisons=tuple(
            expected(family, feedback) for expected in (_ahead, _widening) for family in SIZES for feedback in _NAMES
        ),
    ),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
