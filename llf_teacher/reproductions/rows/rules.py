"""Rules against advice, over the worlds of a town: where they cross."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from llf_teacher.reproductions.drawing import line, name_lines
from llf_teacher.reproductions.lessons import judged, seated, total
from llf_teacher.reproductions.row import OURS, Reading, Row, Values, describe
from llf_teacher.reproductions.rows.half import TURNS
from llf_teacher.reproductions.rule import TENTH, Expectation, Rule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORLDS: dict[str, tuple[str, dict[str, Any]]] = {
    "bandits": ("llf-bandits-BanditTenArmedGaussian-v0", {}),
    "gridworld": ("llf-gridworld-v0", {"map": True}),
}
"""An environment with towns, and its options."""
TEACHERS = ("silence", "rules", "advice, as many words", "advice, as many bits")
STUDENT = "reasoner(worlds=64, forget=False)"
AFTER = (1, 2, 4, 8, 16)
"""Numbers of worlds of a town after which regret is counted."""
MEASURES = tuple(f"regret after {n} {'world' if n == 1 else 'worlds'}" for n in AFTER)
FIRST, LAST = MEASURES[0], MEASURES[-1]


class _Told(NamedTuple):
    """An episode in a world of a town."""

    regret: float
    said: list[tuple[int, float]]
    """The words and the bits of each turn in which something was said, in order."""


def measure(family: str, says: str, seed: int) -> Sequence[float]:
    """The regret that has been lost after each number of `AFTER`."""
    lost = np.cumsum(list(_life(family, says, seed)))
    return [float(lost[n - 1]) for n in AFTER]


def _life(family: str, teacher: str, seed: int) -> Iterator[float]:
    """The regret in each world of a town, one after the other."""
    town = _Town(family, seed)
    if teacher in ("silence", "rules"):
        for world in range(AFTER[-1]):
            yield town.lesson(world, "ruler" if teacher == "rules" and not world else "silent").regret
        return
    unit = teacher == "advice, as many bits"
    left = total([float(said[unit]) for said in town.lesson(0, "ruler", bits=True).said])
    town = _Town(family, seed)  # with a student that has not heard the rules
    for world in range(AFTER[-1]):
        advice, turns = "only(kinds='fp')", 0
        if left > 0:
            for said in town.lesson(world, advice, bits=unit).said:
                if left <= 0:
                    break
                left, turns = left - said[unit], turns + 1
        yield town.lesson(world, f"{advice} | early(budget={turns})" if turns else "silent").regret


class _Town:
    """A student in the worlds of a town."""

    def __init__(self, family: str, seed: int) -> None:
        id, options = WORLDS[family]
        self._seated = partial(seated, id, STUDENT, turns=TURNS, town=seed, **options)
        self._first = AFTER[-1] * seed
        _, self._policy = self._seated(teacher="silent")

    def lesson(self, world: int, teacher: str, *, bits: bool = False) -> _Told:
        """A lesson in one of the worlds; what is said in how many bits is measured if it is asked for."""
        env, _ = self._seated(teacher=teacher)
        lost, said = 0.0, []
        for turn, regret, measured in judged(env, self._policy, self._first + world, 64 if bits else 0):
            lost += regret
            if words := len(turn.feedback.split()):
                said.append((words, total([each.bits or 0.0 for each in measured])))
        return _Told(lost, said)


def _setting(family: str, teacher: str) -> dict[str, str]:
    return {"family": family, "says": teacher}


def read(values: Values) -> Reading:
    """Regret by teacher and number of worlds."""
    table = [["family", "teacher", *MEASURES]]
    for family in WORLDS:
        for teacher in TEACHERS:
            table.append([family, teacher, *map(describe, values.means(**_setting(family, teacher)))])
    parts = []
    for family in WORLDS:
        found = {teacher: values(**_setting(family, teacher)).mean(axis=0) for teacher in TEACHERS}
        ahead = [
            n for n, rules, advice in zip(AFTER, found["rules"], found[TEACHERS[2]], strict=True) if rules < advice
        ]
        crossed = (
            f"rules are ahead of as many words of advice after {ahead[0]} worlds" if ahead else "advice stays ahead"
        )
        saved = 1 - found["rules"][-1] / found["silence"][-1]
        parts.append(f"in {family} {crossed}, and have then saved {saved:.0%} of the regret without words at the last")
    why = (
        "Rules are said in the first world only, and heard by a student that keeps them; advice is said until as many "
        "words, or bits, are used up, and helps in that world alone."
    )
    return Reading(f"{'; '.join(parts).capitalize()}.", why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by number of worlds."""
    for axes, family in zip(figure.subplots(1, len(WORLDS)), WORLDS, strict=True):
        for teacher in TEACHERS:
            line(axes, AFTER, values.means(**_setting(family, teacher)), teacher)
        axes.set(title=family, xlabel="worlds of the town", ylabel="regret so far")
        axes.set_xscale("log", base=2)
        axes.set_xticks(AFTER, list(map(str, AFTER)))
    name_lines(figure)


ROW = Row(
    claim="Advice saves more in the world where it is said, and rules save more over the worlds of a town",
    source=OURS,
    protocol=(
        f"Towns of ten-armed bandits whose looks tell what they pay, and of houses whose plan is known and whose "
        f"treasures lie in rooms of one kind; {AFTER[-1]} worlds of each town, {TURNS} turns in each. `{STUDENT}` "
        "keeps the rules that it hears. `ruler` teaches in the first world, and says what lasts; in the others nothing "
        "is said. Advice (fp) of what to do is said from the first world on until the words, or the bits, that the "
        "ruler has said are used up. A seed is a town."
    ),
    rule=Rule(
        seeds=16,
        comparisons=tuple(
            Expectation(
                expects=f"in {family} {expects.format(unit=unit)}",
                more=(_setting(family, f"advice, as many {unit}" if more == "advice" else "rules"),),
                less=(_setting(family, "rules" if more == "advice" else f"advice, as many {unit}"),),
                measure=measured,
                least=TENTH,
                share_of=_setting(family, "silence"),
            )
            for family in WORLDS
            for unit in ("words", "bits")
            for expects, more, measured in (
                ("as many {unit} of advice save more in the first world, by a tenth of the regret", "rules", FIRST),
                ("rules save more than as many {unit} of advice over all worlds, by a tenth", "advice", LAST),
            )
        ),
    ),
    settings=tuple(_setting(family, teacher) for family in WORLDS for teacher in TEACHERS),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
