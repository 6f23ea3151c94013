"""Merging of the stores of a study's shards, and rescue of a damaged store."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from llf_teacher.studies.definition.fingerprints import differing
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.store_lock import lock_store


def merge(into: Path, parts: Sequence[Path], progress: Callable[[int, int], object] | None = None) -> int:
    """Copy several stores of one study into one. If several stores have an episode, the first store counts.

    Args:
        into: the target; it is created, or completed after an interrupted merge.
        parts: the stores; they are only read.
        progress: called with the number of copied episodes, and the total.

    Returns:
        The number of episodes in the target.

    Raises:
        StoreError: a part is not a store, is damaged, has another study, or is the target; nothing is copied.
    """
    for path in parts:
        if not path.is_file():
            raise StoreError(f"there is no file {path}; give stores that `llf study run` made")
        if into.exists() and into.samefile(path):
            raise StoreError(f"the target {into} cannot be a part; give it as the first file only")
    with contextlib.ExitStack() as opened:
        opened.enter_context(lock_store(into))
        stores = [opened.enter_context(Store(path, read_only=True)) for path in parts]
        for store in stores:
            for table, row, problem in store.damage():
                raise StoreError(
                    f"{store.path}, {table}, row {row}: {problem}; play the episode again, or leave this store out"
                )
        with Store(into, read_only=True) if into.exists() else contextlib.nullcontext() as target:
            _check_same_study([target, *stores] if target else stores)
        with Store(into) as whole:
            total, done = sum(store.count for store in stores), 0
            for store in stores:
                for _ in _copied(store, whole):
                    done += 1
                    if progress:
                        progress(done, total)
            if spent := _spent(stores):
                whole.write_manifest({"llm": spent})
            return whole.count


def rescue(damaged: Path, into: Path) -> tuple[int, int | None]:
    """Copy the episodes of a damaged store that agree with their digests, and its definitions, to a new store.

    Args:
        damaged: the store; it is only read.
        into: the new store, which must not exist.

    Returns:
        The number of copied episodes, and of those that were written; None if that cannot be read.

    Raises:
        StoreError: the target exists, or nothing can be read.
    """
    if into.exists():
        raise StoreError(f"{into} exists; give a file that does not exist")
    with Store(damaged, read_only=True) as store, Store(into) as whole:
        facts = store.whole_facts("definition")
        revisions = {revision: whole.define(each) for revision, each in sorted(facts.items())}
        if manifest := store.whole_facts("manifest"):
            whole.write_manifest(manifest)
        with whole.together():
            for revision, spec, episode, turns in store.whole():
                whole.revision = revisions.get(revision, 0)
                whole.add_packed(spec, episode, turns)
        if not whole.count:
            raise StoreError(f"no episode of {damaged} is whole; play the study again")
        return whole.count, store.sealed()


def _check_same_study(stores: Sequence[Store]) -> None:
    """Check that the newest definitions of stores have the same study."""
    stores = [store for store in stores if "study" in store.manifest()]
    studies = [store.manifest()["study"] for store in stores]
    for store, study in zip(stores, studies, strict=True):
        if fields := [name for name in {**studies[0], **study} if study.get(name) != studies[0].get(name)]:
            raise StoreError(
                f"{store.path} is of another study than {stores[0].path}: they differ in {', '.join(fields)}; merge "
                "the shards of one study only"
            )
        for name, modules in store.manifest().get("code", {}).items():
            known = stores[0].manifest().get("code", {})
            if name in known and (changed := differing(modules, known[name])):
                raise StoreError(
                    f"{store.path} has other code of {name} than {stores[0].path} ({changed}); play one of them again, "
                    "by `llf study run` with --replay-changed"
                )


def _copied(part: Store, whole: Store) -> Iterator[None]:
    """Copy a store; stops after each episode."""
    revisions = {revision: whole.define(facts) for revision, facts in part.definitions().items()}
    for revision, spec, episode, turns in part.packed():
        whole.revision = revisions.get(revision, 0)
        whole.add_packed(spec, episode, turns)
        yield
    for spec, failure in part.failed():
        if not whole.has(spec.key):
            whole.add_failure(spec, failure)
    known = {**whole.manifest(), "name": ""}  # the name is that of the study's file as seen from the part
    whole.write_manifest({name: value for name, value in part.manifest().items() if name not in known})


def _spent(stores: Sequence[Store]) -> list[dict[str, Any]]:
    """The costs of the models of all stores, by model."""
    spent: dict[str, dict[str, Any]] = {}
    for store in stores:
        for row in store.manifest().get("llm", ()):
            known = spent.setdefault(row["model"], {"model": row["model"]})
            known |= {name: known.get(name, 0) + value for name, value in row.items() if name != "model"}
    return list(spent.values())
