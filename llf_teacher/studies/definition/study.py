"""A study: the students and teachers to combine in environments, as a value and as a TOML file."""

import itertools
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, cast

import llf_teacher
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX, entry, types_of
from llf_teacher.serialization import read_toml
from llf_teacher.speakers.parsing import PHRASES, needed_of, parse_teacher, reader_spec
from llf_teacher.students.student import Student
from llf_teacher.studies.definition.custom_specs import student_spec, teacher_spec
from llf_teacher.studies.definition.design import BASELINE, SUBSETS, Transfer, check_interim_analyses, check_transfer
from llf_teacher.studies.definition.names import check_names, short_names
from llf_teacher.studies.definition.options import check_options, options_of
from llf_teacher.studies.definition.primary import check_compare, check_primary
from llf_teacher.studies.definition.stored_specs import student_of, teacher_of, use_stored
from llf_teacher.studies.definition.transcript_filter import check_transcripts
from pz_envs.family import all_families
from pz_envs.settings import Settings
from pz_envs.subject import Subject
from teachers.feedback import format_kinds
from teachers.seeds import TREE
from teachers.spec import is_count, unknown

DRAWS = 256
"""Default number of worlds for measuring the information of claims."""
MOST, MOST_WORLDS, MOST_EPISODES = 1_000_000, 100_000, 100_000_000
"""Greatest numbers of seeds, samples, lessons and turns, of worlds for measuring claims, and of a study's episodes."""
MOST_SEED = 2**63 - 1
"""The greatest seed that a store can hold."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def _in_file(id: str, options: Mapping[str, Any]) -> str:
    """The end of a message: how a study's file sets these options of an environment."""
    lines = "".join(f"\n{name} = {json.dumps(value)}" for name, value in options.items())
    return f"; in the study's file:\n[options.{json.dumps(id)}]{lines}" if lines else ""


class Grid(NamedTuple):
    """The lists that a study crosses for an id."""

    teachers: tuple[str, ...]
    students: tuple[str, ...]
    seeds: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class Study:
    """The full cross of its lists, shorter for ids in `fewer`. Lists are stored as tuples, in canonical form.

    Raises:
        ValueError: a field is not allowed; one error lists all problems.
    """

    ids: Sequence[str]
    teachers: Sequence[Any]
    """Spec strings, or objects, which are stored as such: personalities, also with a voice, as in
    `oracle | voice(tone='curt')`; `llm_teacher(...)`; `module:factory` for your own.
    """
    students: Sequence[Any]
    """Spec strings, or factories of your own agents, which are stored as `module:factory`."""
    instruction_types: Sequence[str] = ("b",)
    feedback_types: Sequence[str] = ("a",)
    """The kinds that teachers may use; `"subsets"` means every subset of the five kinds, for an ablation."""
    seeds: int | Sequence[int] = 10
    """The seeds, each from 0 to `MOST_SEED`; a number n means 0 to n - 1. At most `MOST`."""
    max_turns: int | None = None
    """Turns after which episodes are truncated; None: the number of each family."""
    samples: int = 1
    """Repetitions of each episode, in the same world with the same teacher, by students with different random streams.
    The report averages samples within a seed; see `llf_teacher.studies.analysis.pass_at_k`. Tests after lessons are
    played once.
    """
    fewer: Mapping[str, Mapping[str, Sequence[str] | Sequence[int] | int]] = field(default_factory=dict)
    """Per pattern of ids, as in `llf-some-*`, shorter lists of `teachers`, `students` and `seeds`, for slow simulators.
    If several patterns match an id, the first counts.
    """
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Per pattern of ids, as in `llf-metaworld-*`, options of the environment: its world's options, `visual` and
    `failure_reward`. If several patterns match an id, the first counts. They are part of an episode's identity.
    """
    question: str = ""
    """What the study asks, in words, which the report repeats before its answer."""
    compare: Sequence[Sequence[str]] = ()
    """The pairs of teachers, both of `teachers`, that answer the question: the report compares the first of each pair
    with the second, for every student that teachers can reach, and says so first. They are the primary comparisons.
    """
    baseline: str = BASELINE
    """The teacher that the report compares the others with, one of `teachers`. If the default is not one of them, there
    is no comparison.
    """
    primary: Sequence[Mapping[str, str]] = ()
    """The primary comparisons, which share the study's error rate: tables with patterns of `teacher`,
    `student`, `instruction_type` and `feedback_type`. Without tables and `compare`: every teacher against the baseline,
    for every student that teachers can reach, over all families.
    """
    interim_analyses: Mapping[str, Any] = field(default_factory=dict)
    """A sequential design: the numbers of seeds at which the study is tested (`at`), the alpha-spending function
    (`spending`), and whether the study ends when every primary comparison is significant (`stop`). See
    `llf_teacher.studies.definition.design.InterimAnalyses`. Episodes are played in that order.
    """
    transfer: Mapping[str, Any] = field(default_factory=dict)
    """Tests without a teacher after numbers of `lessons`, beside the other episodes. See
    `llf_teacher.studies.definition.design.Transfer`. Teachers and students that `fewer` leaves out of an environment
    are left out of its tests, too.
    """
    bits: bool | int = False
    """Whether to measure the information of each claim and the regret that it saves, with 256 worlds or this number. It
    does not change the lessons. For families without a posterior the report gives the reason.
    """
    reader: str = PHRASES
    """What reads the words of teachers that speak in their own (models, people, policies, voices that rewrite), so that
    they can be checked: `exact`, our phrases word for word; `llm_reader(model=...)` or `module:function`, which is
    asked for what is no phrase; or `none`. The lessons are the same.
    """
    names: Mapping[str, str] = field(default_factory=dict)
    """Names of teachers and students in the report, by their specs. Without one, those that ask a model are called
    `llm(model)`, and others by their specs.
    """
    transcripts: Sequence[Mapping[str, Any]] = ()
    """The episodes that the report shows turn by turn: tables with patterns of `id`, `teacher` and `student`, and with
    a list of `seeds`, by default the first one. Without tables, a few of each family.
    """

    def __post_init__(self) -> None:
        problems: list[str] = []
        set_ = object.__setattr__
        if self.feedback_types == "subsets":
            set_(self, "feedback_types", SUBSETS)
        for name, check in _CHECKS.items():
            set_(self, name, _listed(name, getattr(self, name), check, problems))
        if self.max_turns is not None and not is_count(self.max_turns, MOST):
            problems.append(f"max_turns must be an integer from 1 to {MOST}, got {self.max_turns!r}")
        if not is_count(self.samples, MOST):
            problems.append(f"samples must be an integer from 1 to {MOST}, got {self.samples!r}")
        if not (isinstance(self.bits, bool) or is_count(self.bits, MOST_WORLDS)):
            problems.append(f"bits must be true, false or a number of worlds, 1 to {MOST_WORLDS}, got {self.bits!r}")
        for name in ("max_turns", "samples", "bits"):  # an integer of NumPy has no place in a key, which is JSON
            if is_count(value := getattr(self, name)):
                set_(self, name, int(value))
        try:
            set_(self, "reader", reader_spec(self.reader))
        except ValueError as error:
            problems.append(f"{error}")
        set_(self, "fewer", self._shortened(problems))
        set_(self, "options", check_options(self.options, self.ids, problems))
        set_(self, "baseline", self._compared(problems))
        if not problems:
            set_(self, "primary", check_primary(self.primary, self, problems))
            set_(self, "compare", check_compare(self.compare, self, problems))
            if self.primary and self.compare:
                problems.append("primary and compare both say which comparisons are primary; leave out one of them")
        if not isinstance(self.question, str):
            problems.append(f"question must be a text, got {self.question!r}")
        elif self.question and not problems and not self._answered:
            pair, first = json.dumps(list(self.teachers[:2])), json.dumps(self.teachers[0])
            problems.append(
                f"question: no comparison answers it, since there is no teacher {self.baseline!r} to compare with; "
                f"name pairs of teachers, as in compare = [{pair}], or another for all, as in baseline = {first}"
            )
        design = check_interim_analyses(self.interim_analyses, len(self._seeds), problems)
        set_(self, "interim_analyses", design._asdict() if design else {})
        if not problems:
            set_(self, "transfer", check_transfer(self.transfer, self, problems))
        if not problems and (number := sum(map(self._number, self.ids))) > MOST_EPISODES:
            problems.append(
                f"a study must have at most {MOST_EPISODES} episodes, got {number}; give fewer seeds or samples"
            )
        set_(self, "names", check_names(self.names, self._specs("teachers") + self._specs("students"), problems))
        set_(self, "transcripts", check_transcripts(self.transcripts, problems))
        if not problems:
            unsupported: dict[tuple[str, tuple[str, ...]], list[str]] = {}
            subjects = self._subjects(problems)
            for id, type_ in itertools.product(subjects, self.instruction_types):
                if type_ not in (allowed := types_of(subjects[id])[0]):
                    unsupported.setdefault((type_, allowed), []).append(id)
            problems += [
                f"instruction_types: {', '.join(unable)} cannot have {type_!r}; allowed: {', '.join(allowed)}"
                for (type_, allowed), unable in unsupported.items()
            ]
            heard = {id: {*self.grid(id).teachers, *self.tests(id).teachers} for id in self.ids}
            for spec in self._specs("teachers"):
                asked = {id: each for id, each in subjects.items() if spec in heard[id]}
                needed = needed_of(parse_teacher(spec))
                served = {id: family.serves(needed, **self._all_options(id)) for id, family in asked.items()}
                if unable := [id for id in asked if not served[id]]:
                    given = {id: dict(asked[id].posterior_needs) for id in unable}
                    mended = [id for id in unable if asked[id].serves(needed, **self._all_options(id) | given[id])]
                    problems.append(
                        f"teachers: {', '.join(unable)} cannot have {spec!r}: the oracle lacks what it needs; "
                        "see docs/personalities.md, or leave it out there by `fewer`"
                        + "".join(_in_file(id, given[id]) for id in mended)
                    )
            problems += self._unseated(subjects)
        if problems:
            raise ValueError("; ".join(dict.fromkeys(problems)))

    @property
    def named(self) -> dict[str, str]:
        """The name of each teacher and student in the report, by spec."""
        asks: dict[str, Any] = {spec: teacher_of(spec) for spec in self._specs("teachers")}
        return short_names(asks | {spec: student_of(spec) for spec in self._specs("students")}, self.names)

    def _specs(self, name: str) -> tuple[str, ...]:
        """All `teachers` or all `students`, also those of tests."""
        return tuple(dict.fromkeys((*getattr(self, name), *self.transfer.get(name, ()))))

    @property
    def draws(self) -> int:
        """Number of worlds for measuring claims; 0: no measurement."""
        return DRAWS if self.bits is True else int(self.bits)

    @property
    def _seeds(self) -> Sequence[int]:
        return cast(Sequence[int], self.seeds)

    @property
    def _answered(self) -> bool:
        """Whether teachers are compared. A single one may be there for its kinds of feedback, or for tests after it."""
        return bool(self.compare or self.transfer) or len(self.teachers) < 2 or self.baseline in self.teachers

    def _compared(self, problems: list[str]) -> str:
        """`baseline` in canonical form; adds to `problems`."""
        try:
            baseline = teacher_spec(self.baseline)
        except ValueError as error:
            named = isinstance(self.baseline, str) and self.baseline not in self.teachers and "(" not in self.baseline
            problems.append(f"baseline: {unknown('teacher', self.baseline, self.teachers) if named else error}")
            return BASELINE
        if baseline not in self.teachers and baseline != BASELINE:
            problems.append(f"baseline: {unknown('teacher', baseline, self.teachers)}")
        return baseline

    def world_options(self, id: str) -> dict[str, Any]:
        """The study's options of an environment's world."""
        given: dict[str, Any] = json.loads(options_of(self.options, id) or "{}")
        return {name: value for name, value in given.items() if name in entry(id).family.options()}

    def _all_options(self, id: str) -> dict[str, Any]:
        """The options of an environment's world."""
        return {**entry(id).options, **self.world_options(id)}

    def _subjects(self, problems: list[str]) -> dict[str, Subject]:
        """The subject of each environment; adds to `problems` the reasons why it cannot be taught."""
        subjects = {}
        for id in self.ids:
            found = entry(id)
            options = self._all_options(id)
            try:
                subjects[id] = found.family.for_lesson(Settings(max_turns=self.max_turns, options=options))
            except ValueError as error:
                problems.append(f"ids: {id}: {error}")
        return subjects

    def _unseated(self, subjects: Mapping[str, Subject]) -> Iterator[str]:
        """The reasons why students that draw worlds or need discrete actions cannot play in some environments."""
        for id, subject in subjects.items():
            for spec in dict.fromkeys((*self.grid(id).students, *self.tests(id).students)):
                student = student_of(spec)
                if isinstance(student, Student) and (student.draws_worlds or student.needs_discrete):
                    try:
                        student.seat(subject, subject.make_world(**self._all_options(id)))
                    except ValueError as error:
                        mended = _in_file(id, subject.posterior_needs) if student.draws_worlds else ""
                        others = [each for each in self.grid(id).students if each != spec]
                        if not mended and others:
                            mended = (
                                f"; in the study's file:\n[fewer.{json.dumps(id)}]\nstudents = {json.dumps(others)}"
                            )
                        yield f"students: {id}: {error}{mended}"

    def _shortened(self, problems: list[str]) -> dict[str, dict[str, tuple[Any, ...]]]:
        """`fewer` in canonical form; adds to `problems`."""
        if not isinstance(self.fewer, Mapping) or not all(isinstance(v, Mapping) for v in self.fewer.values()):
            problems.append(f"fewer must be a table of tables, got {self.fewer!r}")
            return {}
        shortened = {}
        for pattern, lists in self.fewer.items():
            where = f"fewer.{json.dumps(pattern)}"
            if not any(fnmatchcase(id, pattern) for id in self.ids):
                problems.append(f"{where} matches none of the ids")
            problems += [f"{where}: {unknown('key', name, Grid._fields)}" for name in lists if name not in Grid._fields]
            shortened[pattern] = {
                name: _listed(f"{where}: {name}", lists[name], _CHECKS[name], problems)
                for name in Grid._fields
                if name in lists
            }
            for name, values in shortened[pattern].items():
                extra = [value for value in values if value not in getattr(self, name)]
                if extra:
                    problems.append(f"{where}: {name} must be among the study's, got {extra}")
        return shortened

    def grid(self, id: str) -> "Grid":
        """The lists that the study crosses for an id."""
        lists = next((lists for pattern, lists in self.fewer.items() if fnmatchcase(id, pattern)), {})
        return Grid(**{name: lists.get(name, getattr(self, name)) for name in Grid._fields})

    def tests(self, id: str) -> Transfer:
        """The combinations, without seeds, of the tests in an environment; empty without tests."""
        if not self.transfer:
            return Transfer((), (), (), ())
        plan, grid, family = Transfer(**self.transfer), self.grid(id), entry(id).family
        return plan._replace(
            taught=tuple(each for each in plan.taught if entry(each).family is family) if plan.taught else (id,),
            teachers=tuple(each for each in plan.teachers if each in grid.teachers or each not in self.teachers),
            students=tuple(each for each in plan.students if each in grid.students or each not in self.students),
        )

    def _number(self, id: str) -> int:
        """The number of episodes in an environment."""
        grid, plan = self.grid(id), self.tests(id)
        tests = plan.taught, plan.worlds, plan.lessons, plan.feedback_types, plan.teachers, plan.students
        own = self.samples * len(self.feedback_types) * len(grid.teachers) * len(grid.students)
        return len(self.instruction_types) * len(grid.seeds) * (own + math.prod(map(len, tests)))

    def episodes(self) -> Iterator[EpisodeSpec]:
        """Every episode, seeds innermost, in the order of interim analyses; tests come after the others."""
        bounds = [0, *self.interim_analyses["at"]] if self.interim_analyses else [0, len(self._seeds)]
        for first, last in itertools.pairwise(bounds):
            wave = frozenset(self._seeds[first:last])
            for id, instruction_type in itertools.product(self.ids, self.instruction_types):
                grid = self.grid(id)
                grid = grid._replace(seeds=tuple(seed for seed in grid.seeds if seed in wave))
                yield from self._of(id, instruction_type, grid)

    def _of(self, id: str, instruction_type: str, grid: "Grid") -> Iterator[EpisodeSpec]:
        """The episodes of an environment."""
        family = entry(id).family
        max_turns = family.turns(self.max_turns, **self._all_options(id))
        version, rules = self.versions[family.name]
        options = options_of(self.options, id)
        for sample, feedback_type, teacher, student, seed in itertools.product(
            range(self.samples), self.feedback_types, *grid
        ):
            spec = EpisodeSpec(id, teacher, student, instruction_type, feedback_type, max_turns, seed, version, rules)
            yield spec._replace(sample=sample, options=options, draws=self.draws, reader=self.reader)
        plan = self.tests(id)
        for taught, worlds, number, feedback_type, teacher, student, seed in itertools.product(
            plan.taught, plan.worlds, plan.lessons, plan.feedback_types, plan.teachers, plan.students, grid.seeds
        ):
            yield EpisodeSpec(
                id,
                teacher,
                student,
                instruction_type,
                feedback_type,
                max_turns,
                seed,
                version,
                rules,
                number,
                taught,
                worlds,
                options=options,
            )

    @cached_property
    def versions(self) -> Mapping[str, tuple[str, str]]:
        """`version` and `rules` of the episodes of each family."""
        found = {}
        for family in {entry(id).family.name: entry(id).family for id in self.ids}.values():
            of_world = f"+{family.distribution}-{family.version}" if family.version else ""
            found[family.name] = (f"{llf_teacher.__version__}{of_world}", f"{TREE}.{family.rules}")
        return found

    def as_dict(self) -> dict[str, Any]:
        """The study as JSON values."""
        values: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return values

    @classmethod
    def from_manifest(cls, manifest: Mapping[str, Any], *, as_played: bool = False) -> "Study":
        """The study of a store, without checks; the modules of users' own agents may be missing.

        Args:
            manifest: the store's manifest.
            as_played: whether its episodes have the versions of the stored ones, for a report, instead of this
                release's, for playing it again.

        Raises:
            ValueError: the manifest is damaged.
        """
        use_stored(manifest.get("own", {}))
        values = manifest["study"]
        if lacking := [name for name in ("ids", "teachers", "students") if name not in values]:
            raise ValueError(f"the study of the store lacks {', '.join(lacking)}; run `llf study check` for details")
        study = object.__new__(cls)
        for each in fields(cls):
            default = each.default_factory() if callable(each.default_factory) else each.default
            object.__setattr__(study, each.name, _frozen(values.get(each.name, default)))
        if as_played:
            vars(study)["versions"] = {**study.versions, **_frozen(manifest.get("played", {}))}
        return study


def _frozen(value: Any) -> Any:
    """A JSON value with tuples for lists."""
    if isinstance(value, list):
        return tuple(map(_frozen, value))
    return {name: _frozen(each) for name, each in value.items()} if isinstance(value, dict) else value


def _seed(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= MOST_SEED:
        raise ValueError(f"a seed must be an integer from 0 to {MOST_SEED}, got {value!r}")
    return value


def _type(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"an instruction type must be a string, got {value!r}")
    return value


_CHECKS: dict[str, Callable[[Any], Any]] = {
    "ids": lambda id: entry(id).id,
    "teachers": teacher_spec,
    "students": student_spec,
    "feedback_types": format_kinds,
    "instruction_types": _type,
    "seeds": _seed,
}


def _listed(name: str, values: Any, check: Callable[[Any], Any], problems: list[str]) -> tuple[Any, ...]:
    """The different values in canonical form; adds to `problems`."""
    given = values
    if check is _seed and is_count(values, MOST):
        values = range(values)
    if not isinstance(values, Sequence) or isinstance(values, str | bytes) or not values or values[MOST:]:
        number = f", or a number from 1 to {MOST}" if check is _seed else ""
        problems.append(f"{name} must be a list of 1 to {MOST} values{number}, got {given!r:.80}")
        return ()
    canonical = []
    for value in values:
        try:
            canonical.append(check(value))
        except ValueError as error:
            problems.append(f"{name}: {error}")
    return tuple(dict.fromkeys(canonical))


def load_study(path: Path) -> Study:
    """The study in a TOML file, whose keys are the fields of `Study`.

    Raises:
        ValueError: the file cannot be read, or is not a study; the message names the file.
    """
    table = read_toml(path)
    allowed = {field.name: field for field in fields(Study)}
    problems = [unknown("key", key, allowed) for key in table if key not in allowed]
    problems += [f"{key} is missing" for key in ("ids", "teachers", "students") if key not in table]
    if problems:
        raise ValueError(f"{path}: {'; '.join(problems)}")
    try:
        return Study(**table)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def to_toml(study: Study) -> str:
    """The study as the text of a TOML file, which `load_study` reads."""
    values = study.as_dict()
    patterns = {name: values.pop(name) for name in ("fewer", "options")}
    tables = {name: table for name in ("interim_analyses", "transfer", "names") if (table := values.pop(name))}
    for name in ("transcripts", "primary", "bits", "question", "compare"):
        values[name] = values[name] or None
    if study.reader == PHRASES:
        del values["reader"]
    lines = _assignments(values)
    for name, table in tables.items():
        lines += ["", f"[{name}]", *_assignments(table)]
    for name, tables_ in patterns.items():
        for pattern, lists in tables_.items():
            lines += ["", f"[{name}.{json.dumps(pattern)}]", *_assignments(lists)]
    return "\n".join(lines) + "\n"


def _assignments(values: Mapping[str, Any]) -> list[str]:
    lines = []
    for key, value in values.items():
        name = key if _BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False)
        if name == "seeds" and value == list(range(len(value))):
            lines.append(f"{name} = {len(value)}")
        elif isinstance(value, list) and len(value) > 1:
            items = "".join(f"    {_value(item)},\n" for item in value)
            lines.append(f"{name} = [\n{items}]")
        elif value is not None:
            lines.append(f"{name} = {_value(value)}")
    return lines


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{name} = {_value(each)}" for name, each in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)


def quickstart() -> Study:
    """The built-in study. It asks whether late or wrong words cost a student more.

    The late teacher is two turns late, the other is wrong in three of ten claims. The study has every installed family,
    students with different inputs, these two teachers, others and controls.
    """
    families = [family for family in all_families() if not family.missing()]
    return Study(
        ids=tuple(PREFIX + name for family in families for name in family.showcase),
        teachers=(
            "oracle",
            "only(kinds='r+hp+hn')",
            "mix",
            "mistake(eps=0.3)",
            "delayed(turns=2)",
            "placebo",
            "retry_only",
            "silent",
        ),
        students=("random", "reward_only", "text_only", "obedient", "oracle"),
        question="Do late words cost a student more, or wrong ones?",
        compare=(("delayed(turns=2)", "mistake(eps=0.3)"),),
        seeds=tuple(range(10)),
        fewer={
            PREFIX + name: {
                "teachers": ("oracle", "mistake(eps=0.3)", "delayed(turns=2)"),
                "students": ("random", "obedient"),
                "seeds": tuple(range(3)),
            }
            for family in families
            if family.slow
            for name in family.showcase
        },
    )
