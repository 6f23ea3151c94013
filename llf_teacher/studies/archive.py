"""Archives: a zip file with a whole copy of a store, and the files for reading and repeating its study."""

import json
import tempfile
import zipfile
from pathlib import Path

from llf_teacher.studies.definition.study import Study, to_toml
from llf_teacher.studies.report import render
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.targets import check_target


def write_archive(store: Path, path: Path) -> None:
    """Write the archive of a store; see `llf_teacher.studies.results.Results.archive`. An existing file is replaced.

    Raises:
        ValueError: the file is a store or a study's file.
    """
    check_target(path, "the archive", [store])
    draft = path.with_name(f".{path.name}.draft")
    try:
        with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as archive:
            whole = Path(folder, "study.db")
            with Store(store, read_only=True) as live:
                live.back_up(whole)
            archive.write(whole, whole.name)
            with Store(whole, read_only=True) as copy:
                for name, text in _texts(copy).items():
                    archive.writestr(name, text)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _texts(store: Store) -> dict[str, str]:
    """The files beside the store, by name."""
    manifest = store.manifest()
    texts = {"manifest.json": json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"}
    if "versions" in manifest:
        lines = [f"{name}=={version}\n" for name, version in manifest["versions"].items()]
        texts["requirements.txt"] = f"# Python {manifest['python']} on {manifest['platform']}\n" + "".join(lines)
    if "study" in manifest:
        study = Study.from_manifest(manifest, as_played=True)
        texts["study.toml"] = to_toml(study)
        if store.count:
            texts["report.html"] = render(store, study)
    return texts
