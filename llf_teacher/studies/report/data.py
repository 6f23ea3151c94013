"""The data of a report: a study, and its episodes in a store."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import groupby, product
from typing import Any

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import entry
from llf_teacher.studies.analysis.contrasts import Test, least_p, test_of
from llf_teacher.studies.analysis.outcomes import Outcomes
from llf_teacher.studies.analysis.primary import Primary, of_study
from llf_teacher.studies.analysis.statistics import Difference, holm
from llf_teacher.studies.definition.design import main_types
from llf_teacher.studies.definition.fingerprints import mixed
from llf_teacher.studies.definition.stored_specs import is_own
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.definition.transcript_filter import PATTERNS
from llf_teacher.studies.report.columns import Columns, Curves, Plan, Revision, Sums, columns, plan
from llf_teacher.studies.report.section import Cell, Section, cell
from llf_teacher.studies.store import Store
from pz_envs.subject import Subject


@dataclass(frozen=True, kw_only=True)
class Data:
    """The data that the parts of a report show."""

    study: Study
    store: Store
    """The store, for the turns of single episodes and the manifest."""
    planned: Plan
    sums: Mapping[EpisodeSpec, Sums]
    """Sums over the played episodes, by setting."""
    revisions: Mapping[int, Revision]
    """Numbers of episodes by the revision of their definition."""
    mixed: Mapping[str, Sequence[int]]
    """Specs and ids whose code changed between the episodes shown, or since: the number of episodes of each version."""
    failures: Mapping[tuple[str, str], int]
    """Number of failed episodes that were not played later, by student and reason."""
    sections: tuple[Section, ...]
    """Sections in the order of families, types and grids, without empty ones."""
    test: Test | None
    """How to test comparisons; None before the first test."""

    @cached_property
    def named(self) -> dict[str, str]:
        """The name of each teacher and student, by spec."""
        return self.study.named

    def called(self, spec: str) -> str:
        """The name of a teacher or a student; other texts are returned unchanged."""
        return self.named.get(spec, spec)

    @property
    def expected(self) -> int:
        """Number of episodes of the study."""
        return sum(map(len, self.planned.values()))

    @property
    def present(self) -> int:
        """Number of episodes in the store."""
        return sum(each.episodes for each in self.sums.values())

    @cached_property
    def compared(self) -> list[Primary]:
        """The comparisons over all families: those of `Study.compare`, and those with the baseline."""
        return of_study(self.taught, self.study, self.test)

    @property
    def primary(self) -> list[Primary]:
        """The primary comparisons."""
        return [each for each in self.compared if each.declared]

    @property
    def significant(self) -> list[Primary]:
        """The significant primary comparisons."""
        return [each for each in self.primary if self.test and each.score.p <= self.test.level]

    @cached_property
    def secondary(self) -> Mapping[str, Mapping[tuple[str, str], Difference]]:
        """The differences of each section, by its anchor; p-values are adjusted by Holm's method over all sections."""
        every = [(section.anchor, *each) for section in self.sections for each in section.differences.items()]
        found: dict[str, dict[tuple[str, str], Difference]] = {section.anchor: {} for section in self.sections}
        for (anchor, pair, each), p in zip(every, holm([each.p for *_, each in every]), strict=True):
            found[anchor][pair] = each._replace(p=p)
        return found

    @property
    def least_secondary(self) -> float:
        """The smallest possible adjusted p-value for this number of secondary comparisons and seeds."""
        every = [each for mine in self.secondary.values() for each in mine.values()]
        p = least_p(max((each.estimate.n for each in every), default=1))
        return min(1.0, len(every) * (self.test.adjusted(p) if self.test else p))

    @property
    def stopped(self) -> bool:
        """Whether the study ended before its last interim analysis, since every primary comparison was significant."""
        design = self.study.interim_analyses
        if self.test is None or not design.get("stop") or self.test.analysis == len(design["at"]):
            return False
        seeds = self.test.seeds
        played = self.present == sum(len(seeds.intersection(each)) for each in self.planned.values())
        return played and len(self.significant) == len(self.primary) > 0

    @property
    def final(self) -> bool:
        """Whether no episode remains to be played."""
        return self.present == self.expected or self.stopped

    @property
    def unreadable(self) -> tuple[str, ...]:
        """Students without a single action among their answers, so that their figures have little meaning."""
        answers: dict[str, list[float]] = {}
        for setting, each in self.sums.items():
            counts = answers.setdefault(setting.student, [0.0, 0.0])
            for i, name in enumerate(("parse_failures", "turns")):
                counts[i] += each.sums[name]
        return tuple(student for student, (failed, turns) in answers.items() if failed == turns > 0)

    @cached_property
    def units(self) -> dict[str, str]:
        """The unit of regret of each family."""
        return {family.name: family.regret_unit for family in _families(self.study)}

    @cached_property
    def outcomes(self) -> Outcomes:
        """The outcomes of all episodes, for parts that span sections."""
        with columns(self.store, self.planned) as there:
            return there.outcomes(self.study)

    @cached_property
    def taught(self) -> Outcomes:
        """The outcomes of the episodes in sections: with a teacher, and not only for an ablation."""
        types = main_types(self.study.feedback_types)
        return {g: cells for g, cells in self.outcomes.items() if not g.lessons and g.feedback_type in types}

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """The study's definition, and the versions of its software."""
        return self.store.manifest()


def read(store: Store, study: Study) -> Data:
    """Read the data of a report from a store, without the turns of episodes.

    Raises:
        ValueError: no episode of the study has been played.
    """
    planned = plan(study)
    with columns(store, planned) as there:
        sums = there.sums()
        if not sums and (failed := there.failures()):
            first = next(store.failures())
            raise ValueError(
                f"{store.path} holds no played episode of this study: {sum(failed.values())} failed, the first "
                f"because of {first['error']}; mend this, and run the study with --retry-failed"
            )
        if not sums:
            raise ValueError(
                f"{store.path} holds no episode of this study; run it first. The store has {store.count} others; to "
                "report on the study that was run with it, leave out the study"
            )
        test = test_of(
            study,
            lambda seeds: there.count(seeds) == sum(len(seeds.intersection(each)) for each in planned.values()),
        )
        return Data(
            study=study,
            store=store,
            planned=planned,
            sums=sums,
            revisions=there.revisions(),
            mixed=mixed(store.definitions(), there.coded(), store.manifest().get("code", {})),
            failures=there.failures(),
            sections=tuple(_sections(study, there, sums, test)),
            test=test,
        )


def _sections(study: Study, there: Columns, sums: Mapping[EpisodeSpec, Sums], test: Test | None) -> Iterator[Section]:
    outlines = list(_outlines(study, sums))
    order = {
        setting: (number, setting.teacher, setting.student)
        for number, outline in enumerate(outlines)
        for setting in sorted(outline["sums"], key=lambda each: (each.teacher, each.student, each.id))
    }
    cells: list[dict[tuple[str, str], Cell]] = [{} for _ in outlines]
    for (number, *pair), curves in groupby(there.curves(order), lambda each: order[each.setting]):
        if (made := _cell(list(curves), len(outlines[number]["ids"]) * study.samples)) is not None:
            cells[number][pair[0], pair[1]] = made
    for outline, mine in zip(outlines, cells, strict=True):
        pairs = product(outline["grid"].teachers, outline["grid"].students)
        chosen = _chosen(study, there, outline["sums"]) if study.transcripts else None
        there_ = {pair: mine[pair] for pair in pairs if pair in mine}
        yield Section(**outline, cells=there_, chosen=chosen, test=test, named=study.named, asked=asked(study))


def asked(study: Study) -> tuple[str, ...]:
    """The teachers that a study asks about, then a user's own."""
    compared = (teacher for pair in study.compare for teacher in pair)
    return tuple(dict.fromkeys((*compared, *filter(is_own, study.teachers))))


def _chosen(study: Study, there: Columns, sums: Mapping[EpisodeSpec, Sums]) -> tuple[EpisodeSpec, ...]:
    """The played episodes that a study wants to show."""
    wanted = (
        setting._replace(seed=seed)
        for pattern, (setting, each) in product(study.transcripts, sums.items())
        if all(fnmatchcase(getattr(setting, name), pattern.get(name, "*")) for name in PATTERNS)
        for seed in pattern.get("seeds", [each.first])
    )
    return tuple(spec for spec in dict.fromkeys(wanted) if there.has(spec))


def _cell(curves: list[Curves], needed: int) -> Cell | None:
    """A cell of all environments and samples; None if one is missing."""
    return cell(curves) if len(curves) == needed else None


def _families(study: Study) -> list[Subject]:
    """The subjects of a study, sorted by name."""
    found = {(family := entry(id).family).name: family for id in study.ids}
    return [found[name] for name in sorted(found)]


def _outlines(study: Study, sums: Mapping[EpisodeSpec, Sums]) -> Iterator[dict[str, Any]]:
    """The fields of each section without its cells."""
    groups: dict[tuple[str, str, str], dict[EpisodeSpec, Sums]] = {}
    for setting, each in sums.items():
        if setting.lessons:  # tests without a teacher have their own part
            continue
        name = entry(setting.id).family.name
        groups.setdefault((name, setting.instruction_type, setting.feedback_type), {})[setting] = each
    for family, *types in product(_families(study), study.instruction_types, main_types(study.feedback_types)):
        mine = groups.get((family.name, types[0], types[1]), {})
        there = {setting.id for setting in mine}
        ids = [id for id in study.ids if id in there]
        for part, grid in enumerate(dict.fromkeys(map(study.grid, ids))):
            alike = tuple(id for id in ids if study.grid(id) == grid)
            yield {
                "family": family,
                "instruction_type": types[0],
                "feedback_type": types[1],
                "part": part,
                "ids": alike,
                "grid": grid,
                "reference": study.baseline,
                "sums": {setting: each for setting, each in mine.items() if setting.id in alike},
            }
