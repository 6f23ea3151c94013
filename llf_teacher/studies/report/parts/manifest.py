"""The facts for repeating the study."""

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

from llf_teacher.studies.definition.names import shown_spec
from llf_teacher.studies.definition.stored_specs import student_of, teacher_of
from llf_teacher.studies.definition.study import to_toml
from llf_teacher.studies.report.columns import Revision
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any]:
    full = {spec: shown_spec(spec, teacher_of(spec)) for spec in data.study.teachers}
    full |= {spec: shown_spec(spec, student_of(spec)) for spec in data.study.students}
    return {
        "toml": to_toml(data.study),
        "digest": _digest,
        "in_full": full.__getitem__,
        "revisions": list(_revisions(data)),
    }


def _revisions(data: Data) -> Iterator[tuple[int, str, Revision]]:
    """Each revision with episodes: its number, what differs from this study and the last software, its episodes.

    None if all episodes have one definition, which this report shows.
    """
    definitions, newest = data.store.definitions(), data.manifest.get("versions", {})
    if len(data.revisions) == 1 and all(each.shown == each.there for each in data.revisions.values()):
        return
    for number, count in data.revisions.items():
        facts = definitions.get(number)
        if facts is None:
            yield number, "unknown", count
            continue
        study, used = data.study.as_dict(), facts["versions"]
        differing = [name for name in study if facts["study"].get(name) != study[name]]
        differing += [f"{name} {used.get(name, 'missing')}" for name in newest if used.get(name) != newest[name]]
        yield number, ", ".join(differing), count


def _digest(spec: str) -> str:
    return hashlib.sha256(spec.encode()).hexdigest()[:8]


PART = Part("manifest", _values, "How to repeat it")
