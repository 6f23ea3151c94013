"""Archives: a zip file with a whole copy of a store, and the files for reading and repeating its study.

Users' own code is among them, as far as it is found where the archive is written: all files of its fingerprint.
"""

import json
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from llf_teacher.studies.definition.fingerprints import fingerprints
from llf_teacher.studies.definition.own_code import alike, since, unseen
from llf_teacher.studies.definition.study import Study, to_toml
from llf_teacher.studies.report import render
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.targets import check_target
from teachers.words import listed

_CODE = "code"
"""The folder of users' own code."""
_README = """An archive of a feedback study, written by `llf study archive`.

study.db: the whole store; report.html: the report.
study.toml: the study; manifest.json: its facts; requirements.txt: the versions of its software.
code: teachers, students and environments of the study's own, as far as they were found.

To repeat the study, install requirements.txt, and run in the folder code: llf study run ../study.toml
"""


def write_archive(store: Path, path: Path) -> list[str]:
    """Write the archive of a store; see `llf_teacher.studies.results.Results.archive`. An existing file is replaced.

    Returns:
        What the archive lacks of users' own code, and what of it is newer than the last run, in words.

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
                code = copy.manifest().get("code", {})
            files, said = _own_code(code)
            for place, file in files.items():
                archive.write(file, f"{_CODE}/{place}")
            archive.writestr("README.txt", "\n".join([_README, *said, ""]))
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)
    return said


def _own_code(code: Mapping[str, Mapping[str, str]]) -> tuple[dict[str, Path], list[str]]:
    """The files of users' own code by their places, and what is to be said about them.

    Args:
        code: the entry `code` of the manifest.
    """
    files: dict[str, Path] = {}
    lacking: dict[str, str] = {}
    found = fingerprints(code)
    for name, before in code.items():
        here = found[name].files if name in found else {}
        outside = {module for module, (_, place) in here.items() if place.startswith("..")}
        files |= {place: file for module, (file, place) in here.items() if module not in outside}
        if missing := [module for module in before if module not in here or module in outside]:
            lacking[name] = ", ".join(missing)
    said = [
        f"The archive lacks code of {listed(names, 'and')}: {modules}. It is not found from this folder, or is no file "
        "below that of its module; archive from the folder of the study, or add it by hand."
        for modules, names in alike(lacking).items()
    ]
    return dict(sorted(files.items())), [*said, *since(code), *unseen(code)]


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
