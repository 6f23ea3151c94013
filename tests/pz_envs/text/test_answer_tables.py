"""The tables of forms in which chat models answer: each is understood as it should be, or refused with a reason."""

import json
import tomllib
from pathlib import Path

import pytest

from pz_envs.family import own_families
from pz_envs.text.actions import (
    BACK,
    EMPTY,
    MORE,
    NOTHING,
    UNENDED,
    UNFIT,
    UNMARKED,
    WRAPPED,
    parse_action,
)
from teachers.atoms import ParseFailure

TABLES = Path(__file__).with_name("answers")
COMMON = tomllib.loads((TABLES / "common.toml").read_text(encoding="utf-8"))
UNDERSTOOD_IN = ("understood", "first", "later", "last", "wrapped")
REFUSED_IN = ("two", "empty", "unended", "negated", "withdrawn")
TWO = "it names different actions"
REASONS = {
    "two": (TWO, MORE),
    "empty": (EMPTY,),
    "unended": (UNENDED,),
    "negated": (MORE, NOTHING, WRAPPED),
    "withdrawn": (BACK, TWO, MORE),
    "code": (MORE, NOTHING),
    "more": (MORE, NOTHING, WRAPPED),
    "order": (MORE,),
    "nothing": (NOTHING, WRAPPED, MORE),
    "fences": ("its fences hold different texts",),
    "thought": (UNMARKED,),
    "json": (WRAPPED,),
    "unfit": (UNFIT,),
}
"""Why the texts of a table's row are refused: one of these, each of which is true of them."""


def _table(name):
    table = tomllib.loads((TABLES / f"{name}.toml").read_text(encoding="utf-8"))
    refused = [(why, text) for why, texts in table.get("refused", {}).items() for text in texts]
    if "B" in table:
        table["S"] = json.dumps(f'{{"action": {table["J"]}}}')
        understood = [text for key in UNDERSTOOD_IN for text in COMMON[key]] + table["understood"]
        refused += [(why, text) for why in REFUSED_IN for text in COMMON[why]]
    else:
        understood = table["understood"]
    return table, [_filled(text, table) for text in understood], [(why, _filled(text, table)) for why, text in refused]


def _filled(text, table):
    for key in "ABJS":
        text = text.replace(f"{{{key}}}", table.get(key, ""))
    return text


FAMILIES = {family.name: family for family in own_families()}
READ = {path.stem: _table(path.stem) for path in sorted(TABLES.glob("*.toml")) if path.stem != "common"}
WORLDS = {name: FAMILIES[name].make_world(**FAMILIES[name].environments[FAMILIES[name].showcase[0]]) for name in READ}
for world in WORLDS.values():
    world.reset(seed=0)
UNDERSTOOD = [
    *((name, text, READ[name][0]["value"]) for name, (_, understood, _) in READ.items() for text in understood),
    *((name, *row) for name, (table, _, _) in READ.items() for row in table.get("read", ())),
]
REFUSED = [(name, why, text) for name, (_, _, refused) in READ.items() for why, text in refused]
SAME = [(name, text) for name, (table, _, _) in READ.items() for text in table.get("same", ())]


def _plain(action):
    return list(action) if isinstance(action, tuple) else action


def _rows(table, family):
    return [row for name, *row in table if name == family]


@pytest.mark.parametrize("name", READ)
def test_it_is_understood(name):
    read = [(text, action, parse_action(text, WORLDS[name])) for text, action in _rows(UNDERSTOOD, name)]
    assert read
    assert [each for each in read if type(each[-1]) is ParseFailure or _plain(each[-1]) != each[1]] == []


@pytest.mark.parametrize(("name", "text"), SAME)
def test_what_is_taken_word_for_word_stays_as_it_is(name, text):
    assert parse_action(text, WORLDS[name]) == text


@pytest.mark.parametrize("name", READ)
def test_it_is_refused_for_a_reason(name):
    refused = _rows(REFUSED, name)
    assert refused
    for why, text in refused:
        read = parse_action(text, WORLDS[name])
        assert type(read) is ParseFailure, f"{text!r} is understood as {read}"
        assert read.why.startswith(REASONS[why]), text
        assert read.expected == WORLDS[name].action_syntax


def test_each_table_has_sixty_forms():
    counts = {name: len({*a, *(text for _, text in b)}) for name, (_, a, b) in READ.items()}
    assert len(counts) >= 8
    assert {name: count for name, count in counts.items() if count < 60} == {}
