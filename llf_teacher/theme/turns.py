"""The turns of an episode, prepared for display."""

import json
from collections.abc import Mapping
from typing import Any

from teachers.atoms import KINDS, Label


def bits_words(information: Mapping[str, Any]) -> str:
    """The stored information of an atom, in words."""
    from teachers.information import Bits

    return Bits._make(map(information.get, Bits._fields)).described


def prepare_turns(turns: list[dict[str, Any]], family: str) -> list[dict[str, Any]]:
    """Add fields for the display to turns of a store.

    `said` has the atoms by kind, each with its claim as `code` and, if measured, its information as `bits`;
    `spelled_out`, whether the atoms make up all of the text; `own`, the sentences in the teacher's own words; `did`,
    the action in words.

    Args:
        turns: the turns; they are changed.
        family: the family name to leave out of the names of claims.
    """
    for turn in turns:
        atoms = turn["atoms"]
        for atom in atoms:
            atom["code"] = claim_code(atom, family)
            if "elsewhere" in atom:
                atom["code"] += f" of another world, {'true' if atom['elsewhere'] else 'false'} there"
            if "information" in atom:
                atom["bits"] = bits_words(atom["information"])
        text = " ".join(filter(None, (turn["instruction"], turn["feedback"])))
        turn["said"] = {kind: said for kind in (None, *KINDS) if (said := [a for a in atoms if a["kind"] == kind])}
        turn["spelled_out"] = text == " ".join(atom["text"] for atom in atoms)
        turn["own"] = [read_sentence(each, turn["turn"], family) for each in turn.get("readings") or ()]
        turn["did"] = turn["action_words"] or turn["action"]
    return turns


def read_sentence(reading: Mapping[str, Any], turn: int, family: str) -> dict[str, Any]:
    """A sentence in the teacher's own words for display: `kind`, `text`, `label`, its claim as `code`, and a `note`."""
    said = {name: reading[name] for name in ("kind", "text")}
    if reading["claim"] is None:
        label = Label.HEDGED if reading["outcome"] == "hedged" else Label.UNCHECKED
        why = ", ".join(reading["candidates"])
        what = {"unbuilt": "is no single claim", "hedged": "hedges"}.get(reading["outcome"], "not read")
        return said | {"label": label, "code": "", "note": f"{what}: {why}" if why else what}
    late = reading["about_turn"] != turn
    label = Label.DISTORTED if reading["holds"] is False else Label.LATE if late else Label.TRUTHFUL
    code = claim_code(reading, family) + (f" of turn {reading['about_turn']}" if late else "")
    note = "read by a model" if reading["layer"] == "model" else "read word for word"
    return said | {"label": label, "code": code, "note": note}


def claim_code(claim: Mapping[str, Any], family: str) -> str:
    """A claim with its fields, one of which may be a claim, too."""
    fields = ", ".join(
        f"{name}={claim_code(value, family) if isinstance(value, dict) else _plain(value)}"
        for name, value in claim["fields"].items()
    )
    return f"{claim['claim'].removeprefix(f'{family}.')}({fields})"


def _plain(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
