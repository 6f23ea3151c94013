"""Twenty studies whose answer is known, with regrets given directly: effects either way, none, too few seeds, units.

A regret is its arm's mean times the difficulty of the seed's world, which all arms share, with noise of its own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, TurnRow, pack_regrets
from llf_teacher.registry import entry
from llf_teacher.studies.definition.study import Study
from teachers.personality import Personality, personality

GRID, BANDIT, LOSS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0", "llf-optimization-Booth-v0"
YES, NO, OPEN = "yes", "no", "not decided"


@personality()
def Grudge(claims, view, rng, *, after: int = 2):  # noqa: N802 (a class)
    """A teacher of the tests' own."""
    return claims


assert issubclass(Grudge, Personality)
OWN = "planted:Grudge"


@dataclass(frozen=True)
class Label:
    """What is true of one comparison."""

    pair: tuple[str, str]
    student: str
    evidence: str
    """`YES`, `NO` or `OPEN`."""
    costlier: str = ""
    """The teacher with the greater regret; empty if that is not known."""
    mixed: bool = False
    """Whether families differ in opposite ways."""
    ratio: bool = True
    """Whether a share of regret means something: the second teacher's regret is not about 0."""


@dataclass(frozen=True)
class Planted:
    """A study with its regrets and labels; the first label is the first sentence's."""

    name: str
    means: Mapping[Any, float]
    """Mean regret by teacher, by teacher and id, or by teacher and student; the most specific key counts."""
    labels: tuple[Label, ...]
    study: Mapping[str, Any] = field(default_factory=dict)
    noise: float = 0.05
    """Standard deviation of an arm's own noise, as a share of its mean."""
    played: Callable[[EpisodeSpec], bool] = lambda spec: True
    regret: Callable[[EpisodeSpec], float] | None = None
    """In place of means."""

    def made(self) -> Study:
        """The study."""
        teachers = dict.fromkeys(key if isinstance(key, str) else key[0] for key in self.means)
        fields = {"ids": [GRID], "teachers": list(teachers), "students": ["obedient"], "seeds": 20}
        fields["compare"] = [list(label.pair) for label in self.labels[:1]]
        return Study(**{name: value for name, value in (fields | dict(self.study)).items() if value is not None})

    def records(self, study: Study) -> list[Record]:
        """The episodes that were played."""
        rng = np.random.default_rng(48)
        difficulty = rng.uniform(0.8, 1.2, 1000)
        found = []
        for spec in study.episodes():
            if self.regret:
                regret = self.regret(spec)
            else:
                keys = ((spec.teacher, spec.student), (spec.teacher, spec.id), spec.teacher)
                mean = next(self.means[key] for key in keys if key in self.means)
                regret = mean * difficulty[spec.seed] * max(0.0, 1 + self.noise * rng.normal())
            if self.played(spec):
                found.append(record(spec, float(regret)))
        return found


def record(spec: EpisodeSpec, regret: float) -> Record:
    """An episode of one turn with a regret; its teacher has said something that has no claim."""
    counts = dict.fromkeys(EpisodeRow._fields[7:24], 0) | dict.fromkeys(EpisodeRow._fields[24:30]) | {"unchecked": 1}
    row = EpisodeRow(
        entry(spec.id).family.name, "claims", 1, False, None, 0.0, regret, **counts, regrets=pack_regrets([regret])
    )
    turns = [TurnRow(turn, "", None, None, 0.0, turn * regret, False, None, None, "", []) for turn in (0, 1)]
    return Record(spec, row, tuple(turns))


def one(*pair: str, **rest: Any) -> tuple[Label, ...]:
    """The label of a study with one comparison."""
    return (Label(pair, rest.pop("student", "obedient"), **rest),)


STUDIES = (
    Planted("worse", {OWN: 9.2, "oracle": 2.0}, one(OWN, "oracle", evidence=YES, costlier=OWN)),
    Planted("better", {OWN: 4.0, "silent": 8.0}, one(OWN, "silent", evidence=YES, costlier="silent")),
    Planted(
        "small but clear",
        {OWN: 5.5, "mix": 5.0},
        one(OWN, "mix", evidence=YES, costlier=OWN),
        {"seeds": 40},
    ),
    Planted("none, many seeds", {OWN: 5.0, "mix": 5.0}, one(OWN, "mix", evidence=NO), {"seeds": 40}),
    Planted("the same in every seed", {OWN: 5.0, "mix": 5.0}, one(OWN, "mix", evidence=NO), noise=0.0),
    Planted(
        "four seeds, a huge effect",
        {OWN: 20.0, "oracle": 2.0},
        one(OWN, "oracle", evidence=OPEN),
        {"seeds": 4},
    ),
    Planted(
        "five seeds, all alike",
        {OWN: 20.0, "oracle": 2.0},
        one(OWN, "oracle", evidence=OPEN),
        {"seeds": 5},
        noise=0.01,
    ),
    Planted("noise", {OWN: 5.0, "mix": 5.0}, one(OWN, "mix", evidence=OPEN), {"seeds": 8}, noise=0.8),
    Planted(
        "baseline without regret",
        {OWN: 0.5, "oracle": 0.0, "mistake": 2.0, "silent": 19.8},
        one(OWN, "oracle", evidence=YES, costlier=OWN, ratio=False),
        {"baseline": "oracle"},
    ),
    Planted(
        "baseline almost without regret",
        {OWN: 9.2, "oracle": 0.02, "mistake": 2.0, "silent": 19.8},
        one(OWN, "oracle", evidence=YES, costlier=OWN, ratio=False),
        {"baseline": "oracle"},
    ),
    Planted(
        "units: the effect is in the small one",
        {(OWN, BANDIT): 2.0, ("mix", BANDIT): 1.0, (OWN, LOSS): 1000.0, ("mix", LOSS): 1000.0},
        one(OWN, "mix", evidence=YES, costlier=OWN),
        {"ids": [BANDIT, LOSS]},
    ),
    Planted(
        "units: the great one goes a little the other way",
        {
            **{(OWN, id): 2.0 for id in (BANDIT, GRID)},
            **{("mix", id): 1.0 for id in (BANDIT, GRID)},
            (OWN, LOSS): 900.0,
            ("mix", LOSS): 1000.0,
        },
        one(OWN, "mix", evidence=YES, costlier=OWN, mixed=True),
        {"ids": [BANDIT, GRID, LOSS]},
    ),
    Planted(
        "families that cancel",
        {(OWN, GRID): 6.0, ("mix", GRID): 3.0, (OWN, BANDIT): 3.0, ("mix", BANDIT): 6.0},
        one(OWN, "mix", evidence=NO, mixed=True),
        {"ids": [GRID, BANDIT]},
        noise=0.02,
    ),
    Planted(
        "a student that it harms and one that it does not reach",
        {(OWN, "obedient"): 6.0, ("mix", "obedient"): 3.0, (OWN, "text_only"): 3.0, ("mix", "text_only"): 3.0},
        (Label((OWN, "mix"), "obedient", YES, OWN), Label((OWN, "mix"), "text_only", NO)),
        {"students": ["obedient", "text_only"]},
        noise=0.03,
    ),
    Planted(
        "students in opposite ways",
        {(OWN, "obedient"): 6.0, ("mix", "obedient"): 3.0, (OWN, "text_only"): 3.0, ("mix", "text_only"): 6.0},
        (Label((OWN, "mix"), "obedient", YES, OWN), Label((OWN, "mix"), "text_only", YES, "mix")),
        {"students": ["obedient", "text_only"]},
    ),
    Planted(
        "two questions",
        {OWN: 6.0, "mix": 3.0, "oracle": 3.0},
        (Label((OWN, "oracle"), "obedient", YES, OWN), Label(("mix", "oracle"), "obedient", NO)),
        {"compare": [[OWN, "oracle"], ["mix", "oracle"]]},
        noise=0.03,
    ),
    Planted(
        "no question is stated: her own teacher comes first",
        {"oracle": 1.0, "mistake": 4.0, OWN: 3.0, "silent": 9.0},
        one(OWN, "silent", evidence=YES, costlier="silent"),
        {"compare": None},
    ),
    Planted(
        "half of it is played",
        {OWN: 9.2, "oracle": 2.0},
        one(OWN, "oracle", evidence=OPEN),
        played=lambda spec: spec.seed < 10,
    ),
    Planted(
        "two rare failures",
        {OWN: 0.0, "mix": 0.0},
        one(OWN, "mix", evidence=OPEN, ratio=False),
        regret=lambda spec: 30.0 * (spec.teacher == OWN and spec.seed in (3, 11)),
    ),
    Planted(
        "neither is the baseline, and an early analysis finds it",
        {"oracle": 2.0, OWN: 6.0, "silent": 9.0},
        one("oracle", OWN, evidence=YES, costlier=OWN),
        {"interim_analyses": {"at": [10, 20], "stop": True}, "compare": [["oracle", OWN]]},
        played=lambda spec: spec.seed < 10,
    ),
)
