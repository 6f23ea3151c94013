"""Merging of the stores of a study's shards."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.store_lock import lock_store


def merge(into: Path, parts: Sequence[Path], progress: Callable[[int, int], object] | None = None) -> int:
    """Copy several stores into one. If several stores have an episode, that of the first one counts.

    Args:
        into: the target; it is created, or completed after an interrupted merge.
        parts: the stores; they are only read.
        progress: called with the number of episodes that are done, and the total.

    Returns:
        The number of episodes in the target.

    Raises:
        StoreError: a part is no store, is damaged, or is the target; nothing of it is copied.
    """
    for path in parts:
        if not path.is_file():
            raise StoreError(f"there is no file {path}; give stores that `llf study run` made")
        if into.exists() and into.samefile(path):
            raise StoreError(f"the target {into} cannot be a part; give it as the first file only")
    with lock_store(into), Store(into) as whole:
        done, total = 0, 0
        spent: dict[str, dict[str, Any]] = {}
        for path in parts:
            with Store(path) as part:
                for number, problem in part.damage(thorough=True):
                    raise StoreError(
                        f"{path}, row {number}: {problem}; play the episode again, or leave this store out"
                    )
                total += part.count
                for spec, episode, turns in part.packed():
                    whole.add_packed(spec, episode, turns)
                    done += 1
                    if progress:
                        progress(done, total)
                for spec, failure in part.failed():
                    if not whole.has(spec.key):
                        whole.add_failure(spec, failure)
                manifest = part.manifest()
                for row in manifest.get("llm", ()):
                    known = spent.setdefault(row["model"], {"model": row["model"]})
                    known |= {name: known.get(name, 0) + value for name, value in row.items() if name != "model"}
            if not whole.manifest():
                whole.write_manifest(manifest)
        if spent:
            whole.write_manifest({"llm": list(spent.values())})
        return whole.count
