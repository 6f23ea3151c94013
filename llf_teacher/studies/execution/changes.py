"""Stored episodes that today's code would play otherwise, found before a study is played.

An episode's key has the spec of each teacher, student and environment, but not their code. So a run compares the
fingerprints of users' own code with those that each stored episode was played with, and the versions of this package
and of each family's rules with those of stored episodes that only differ in them.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import entry
from llf_teacher.studies.definition.fingerprints import Fingerprint, differing, fingerprints
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.store import Store, StoreError

STOP, REPLAY, KEEP = "stop", "replay", "keep"
CHOICES = (STOP, REPLAY, KEEP)
"""What becomes of such episodes: the run stops before it plays, plays them again, or keeps them."""
_ALLOWED = (
    "Allowed: `--replay-changed` removes these episodes and plays them again; `--keep-old` keeps them, {kept}; or give "
    "another store by --store. In Python: RunOptions(changed='replay'), or 'keep'"
)
_MIXED = "and the report says so"
_APART = "outside of the report, and plays the study's own"


class Changes(NamedTuple):
    """Stored episodes that today's code would play otherwise."""

    code: Mapping[tuple[str, str], int]
    """Number of episodes by what has changed: a spec or an id, and the difference in words."""
    rules: Mapping[tuple[str, str], int]
    """The same for families, by their names, whose rules or version are others."""
    keys: frozenset[str]
    """Keys of all these episodes."""

    def __str__(self) -> str:
        """What has changed, and what can be done."""
        said = [
            f"{name} has changed since {_episodes(number)} of this study, which the store has ({difference}); one "
            "result must not mix both."
            for (name, difference), number in self.code.items()
        ]
        said += [
            f"The family {family} plays otherwise than in {_episodes(number)} that the store has ({difference}); "
            "episodes of different rules cannot be compared."
            for (family, difference), number in self.rules.items()
        ]
        return f"{' '.join(said)} {_ALLOWED.format(kept=_MIXED if self.code else _APART)}"


def _episodes(number: int) -> str:
    return f"{number} episode{'s' * (number != 1)}"


def used_code(study: Study) -> dict[str, Fingerprint]:
    """The fingerprints of users' own code in a study, by spec or id."""
    return fingerprints(specs_of(study))


def specs_of(study: Study) -> tuple[str, ...]:
    """The specs and ids of a study that may name users' own code."""
    tests = (each for name in ("teachers", "students", "taught") for each in study.transfer.get(name, ()))
    return (*study.teachers, *study.students, study.reader, *study.ids, *tests)


def changes(study: Study, store: Store, specs: Callable[[], Iterator[EpisodeSpec]]) -> Changes:
    """The stored episodes of a study that today's code would play otherwise.

    Args:
        study: the study.
        store: the store.
        specs: gives the study's episodes; called only if the store may have such episodes.
    """
    code: Counter[tuple[str, str]] = Counter()
    rules: Counter[tuple[str, str]] = Counter()
    keys: set[str] = set()
    differences = _differences({name: each.modules for name, each in used_code(study).items()}, store)
    others = _other_versions(study, store)
    for spec in specs() if differences or others else ():
        if (revision := store.revision_of(spec.key)) is not None:
            differs = differences.get(revision, {})
            for name in {spec.teacher, spec.student, spec.reader, spec.id, spec.taught} & differs.keys():
                code[name, differs[name]] += 1
                keys.add(spec.key)
            continue
        family = entry(spec.id).family.name
        for version, of_rules in others.get(family, ()):
            before = spec._replace(version=version, rules=of_rules).key
            if store.has(before):
                same = of_rules == spec.rules
                was, now = (version, spec.version) if same else (of_rules, spec.rules)
                rules[family, f"{'version' if same else 'rules'} {was}, now {now}"] += 1
                keys.add(before)
    return Changes(dict(sorted(code.items())), dict(sorted(rules.items())), frozenset(keys))


def _differences(now: Mapping[str, Mapping[str, str]], store: Store) -> dict[int, dict[str, str]]:
    """For each revision with other code, what differs in words, by spec or id."""
    known: dict[int, Mapping[str, Any]] = {0: {}, **store.definitions()}
    found = {
        revision: {
            name: words
            for name, modules in now.items()
            if (words := differing(modules, facts.get("code", {}).get(name)))
        }
        for revision, facts in known.items()
    }
    return {revision: differs for revision, differs in found.items() if differs}


def _other_versions(study: Study, store: Store) -> dict[str, list[tuple[str, str]]]:
    """Other versions and rules in the store, by family."""
    found: dict[str, list[tuple[str, str]]] = {}
    ids = {id: entry(id).family.name for id in study.ids}
    for id, version, rules in store.versions():
        if id in ids and (version, rules) != study.versions[ids[id]]:
            found.setdefault(ids[id], []).append((version, rules))
    return {family: list(dict.fromkeys(each)) for family, each in found.items()}


def choice_of(replay: bool, keep: bool) -> str:
    """The choice of two flags.

    Raises:
        ValueError: both are given.
    """
    if replay and keep:
        raise ValueError("--replay-changed and --keep-old exclude each other; give one of them")
    return REPLAY if replay else KEEP if keep else STOP


def settle(study: Study, store: Store, specs: Callable[[], Iterator[EpisodeSpec]], choice: str) -> None:
    """Do with the stored episodes that today's code would play otherwise what was chosen, one of `CHOICES`.

    Raises:
        ValueError: no such choice.
        StoreError: there are such episodes, and the choice is to stop.
    """
    if choice not in CHOICES:
        raise ValueError(f"changed must be one of {', '.join(CHOICES)}, got {choice!r}")
    if choice == KEEP or store.empty:
        return
    found = changes(study, store, specs)
    if found.keys and choice == STOP:
        raise StoreError(f"{store.path}: {found}")
    if found.keys:
        store.remove(found.keys)
