"""How much claims of each class say: a table for each family with a posterior."""

from collections.abc import Iterable, Iterator

from llf_teacher.registry import PREFIX
from llf_teacher.tools.audit import audit
from llf_teacher.tools.markdown import table
from pz_envs.family import Family, all_families
from teachers.information import Gain
from teachers.spec import unknown

__all__ = ["families", "measured"]

_STUDENTS = ("random", "obedient")


def families(names: Iterable[str] | None = None) -> dict[str, Family]:
    """The families of these names; None: all that have a posterior and are installed.

    Raises:
        ValueError: one of them is none of those.
    """
    able = {each.name: each for each in all_families() if each.posterior and not each.missing()}
    for name in names or ():
        if name not in able:
            raise ValueError(unknown("family with a posterior", name, able))
    return {name: able[name] for name in names or able}


def measured(family: Family, teachers: Iterable[str], turns: int, worlds: int) -> str:
    """A Markdown table with a row for each class of claims that was heard.

    Args:
        family: has a posterior; its first environment is played, with a basic instruction.
        teachers: specs of personalities.
        turns: turns with each of them, half of a student that acts at random, half of one that obeys.
        worlds: number of worlds by which a claim is measured.
    """
    gains: dict[str, Gain] = {}
    for teacher in teachers:
        found = audit(f"{PREFIX}{family.showcase[0]}", teacher, turns=turns, students=_STUDENTS, worlds=worlds)
        for name, gain in found.gains.items():
            gains[name] = gains.get(name, Gain()) + gain
    head = ("claim", "measured", "not measured", "bits", "true in no world", "bits a word", "regret saved")
    return table(head, _rows(gains))


def _rows(gains: dict[str, Gain]) -> Iterator[tuple[str, ...]]:
    for name, gain in sorted(gains.items(), key=lambda each: -each[1].bits / max(each[1].claims, 1)):
        bound = "at least " if gain.at_least else ""
        yield (
            f"`{name.rpartition('.')[2]}`",
            f"{gain.claims:,}",
            f"{gain.unknown:,}",
            f"{bound}{gain.bits / gain.claims:.2f}" if gain.claims else "",
            f"{gain.at_least / gain.claims:.0%}" if gain.claims else "",
            "" if gain.bits_per_word is None else f"{bound}{gain.bits_per_word:.3f}",
            f"{gain.saved / gain.valued:.3f}" if gain.valued else "",
        )
