"""pass@k of several samples of the same episodes."""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.analysis.pass_at_k import Sampled, pass_at
from llf_teacher.studies.report.columns import columns
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any] | None:
    most = data.study.samples
    if most == 1:
        return None
    worlds: dict[tuple[Sampled, int], list[dict[str, Any]]] = defaultdict(list)
    with columns(data.store, data.planned) as there:
        for row in there.sampled():
            if not row["lessons"]:
                worlds[Sampled(*(row[name] for name in Sampled._fields)), row["seed"]].append(row)
    whole = [row for rows in worlds.values() if len(rows) == most for row in rows]
    tries = [2**i for i in range(most.bit_length())]
    tries = [*tries, most] if most not in tries else tries
    chances = [pass_at(k, whole) for k in tries]
    found = {cell: [each[cell] for each in chances] for cell in chances[0]}
    counts = {cell: sum(one == cell and len(rows) == most for (one, _), rows in worlds.items()) for cell in found}
    return {"found": found, "tries": tries, "counts": counts, "most": most} if found else None


PART = Part("samples", _values, "Samples")
