"""The turns of an episode, prepared for display."""

import json
from collections.abc import Mapping
from typing import Any

from teachers.atoms import KINDS


def bits_words(information: Mapping[str, Any]) -> str:
    """How much an atom says, as a record has it, in words."""
    from teachers.information import Bits

    return Bits._make(map(information.get, Bits._fields)).described


def prepare_turns(turns: list[dict[str, Any]], family: str) -> list[dict[str, Any]]:
    """Add what the display needs to turns of a store.

    It is `said`, the atoms by kind, each with its claim as `code` and, if it is measured, how much it says as `bits`;
    `spelled_out`, whether they make up all of the text; and `did`, the action in words.

    Args:
        turns: is changed.
        family: the name that is left out of the names of claims.
    """
    for turn in turns:
        atoms = turn["atoms"]
        for atom in atoms:
            atom["code"] = _code(atom, family)
            if "information" in atom:
                atom["bits"] = bits_words(atom["information"])
        text = " ".join(filter(None, (turn["instruction"], turn["feedback"])))
        turn["said"] = {kind: said for kind in (None, *KINDS) if (said := [a for a in atoms if a["kind"] == kind])}
        turn["spelled_out"] = text == " ".join(atom["text"] for atom in atoms)
        turn["did"] = turn["action_words"] or turn["action"]
    return turns


def _code(claim: dict[str, Any], family: str) -> str:
    """A claim with its fields, one of which may be a claim, too."""
    fields = ", ".join(
        f"{name}={_code(value, family) if isinstance(value, dict) else _plain(value)}"
        for name, value in claim["fields"].items()
    )
    return f"{claim['claim'].removeprefix(f'{family}.')}({fields})"


def _plain(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
