"""Bits or worth: what tells how much regret a kind of feedback saves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.lessons import judged, seated
from llf_teacher.reproductions.row import OURS, Reading, Row, Values, describe
from llf_teacher.reproductions.rows.half import BOTH, EPISODES, TURNS, WORLDS
from llf_teacher.reproductions.rule import Expectation, Rule
from teachers.information import Gain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHERS = {
    "rewards": "only(kinds='r')",
    "praise": "only(kinds='hp')",
    "blame": "only(kinds='hn')",
    "verdicts": "only(kinds='hp+hn')",
    "advice": "only(kinds='fp')",
    "warnings": "only(kinds='fn')",
    "hints": "hinter",
}
STUDENT = "reasoner(worlds=64)"
WORTH, BITS, LEAD = MEASURES = "by worth", "by bits", "worth beside bits"
CHOICES = (["gridworld"], ["bandits"], ["bandits", "gridworld"])


def measure(families: Sequence[str], seed: int) -> Sequence[float]:
    """Rank correlations over kinds of the share of regret saved: with worth, with bits, and their difference."""
    saved, worth, bits = np.concatenate([_kinds(family, seed) for family in families], axis=1)
    by_worth, by_bits = _agreement(worth, saved), _agreement(bits, saved)
    return [by_worth, by_bits, by_worth - by_bits]


def _kinds(family: str, seed: int) -> NDArray[np.float64]:
    """Per kind: saved and worth as shares of what is lost in silence, and bits; shape (3, kinds)."""
    id, options = WORLDS[family]

    def play(teacher: str) -> NDArray[np.float64]:
        found = []
        for each in range(EPISODES * seed, EPISODES * (seed + 1)):
            lost, gain = 0.0, Gain()
            for turn, regret, measured in judged(*seated(id, STUDENT, teacher, TURNS, **options), each, worlds=64):
                lost += regret
                gain = sum(map(Gain.of, (atom.text for atom in turn.atoms), measured), gain)
            found.append((lost, gain.saved, gain.bits))
        means: NDArray[np.float64] = np.mean(found, axis=0)
        return means

    silent = max(play("silent")[0], 1e-9)
    lost, worth, bits = np.array([play(teacher) for teacher in TEACHERS.values()]).T
    return np.array([1 - lost / silent, worth / silent, bits])


def _agreement(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Spearman's rank correlation; 0 if either does not vary."""
    return 0.0 if np.ptp(one) == 0 or np.ptp(other) == 0 else float(spearmanr(one, other).statistic)


def read(values: Values) -> Reading:
    """The correlations, by family."""
    table = [["families", "saved and worth", "saved and bits", "difference"]]
    for families in CHOICES:
        table.append([" and ".join(families), *map(describe, values.means(families=families))])
    both = values.means(families=CHOICES[-1])
    ours = (
        "Over kinds of feedback in both families, the share of regret saved has a rank correlation of "
        f"{describe(both[0])} with what the sentences are worth, and of {describe(both[1])} with their bits."
    )
    why = (
        "Bits count all that a sentence rules out, worth only what changes the next action. Worth looks one action "
        "ahead, and so counts nothing that pays later. Other families have no posterior, or no values of actions."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """The two correlations, by family."""
    axes = figure.subplots()
    found = {
        name: [values.means(families=families)[column] for families in CHOICES]
        for column, name in enumerate(("worth", "bits"))
    }
    bars(axes, [" and ".join(families) for families in CHOICES], found)
    axes.set_ylabel("rank correlation with regret saved")
    figure.legend(loc="outside lower center", ncols=3)


ROW = Row(
    claim="What a sentence is worth to the next action tells how much regret it saves, better than its bits do",
    source=OURS,
    protocol=(
        f"{BOTH}. `{STUDENT}` hears one kind of feedback: "
        "rewards, praise, blame, both verdicts, advice, warnings, or hints. The bits of a "
        "sentence and its worth are measured by 64 worlds that the student cannot distinguish from its own, given all "
        f"that it heard before. A seed has {EPISODES} worlds for each kind: from their means come the share of the "
        "regret without words that the kind saves, its worth as a share of that regret, and its bits. The measures "
        "are Spearman's rank correlations over the seven kinds, and over the fourteen pairs of kind and family."
    ),
    rule=Rule(
        seeds=12,
        comparisons=(
            *(
                Expectation(
                    expects=f"in {families[0]} kinds of feedback that are worth more save more",
                    more=({"families": families},),
                    measure=WORTH,
                    least=0.5,
                )
                for families in CHOICES[:2]
            ),
            *(
                Expectation(
                    expects=f"in {' and '.join(families)} worth tells it better than bits",
                    more=({"families": families},),
                    measure=LEAD,
                    least=0.1,
                )
                for families in CHOICES
            ),
        ),
    ),
    settings=tuple({"families": families} for families in CHOICES),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
