"""Answers of models, each with the action that a reader sees: nearly all are read as it, and none as another.

A line has the family, the answer, the action (null: a reader sees none) and, where readers may differ, what else they
may see (`also`). Those of `written` are in the manner of larger models, or adversarial. Five sets were labelled when
the rule stood. Of `attack.jsonl` 104 of 108 clear actions were read, and one story as an action, before a few words
were added. Of `third.jsonl` 61 of 68 were read, and two texts without an action as one, before general faults were
mended. Of `fourth.jsonl`, all of real models, 65 of 78 were read, and two texts without an action as one; poems may be
any text, so that two of them have got their reading. Of `fifth.jsonl`, all of real models, 75 of 86 were read, and two
texts without an action as one; six poems have got their reading. Of `sixth.jsonl`, answers of three real models to the
shipped prompts, labelled by two readers, 102 of 119 were read, and none as another; 19 poems have got their reading.
`traps.jsonl` was written against the rule: of 459 texts in which nothing is chosen 285 were misread at first, and 19
are still, which it leaves out.
"""

import json
from pathlib import Path

import pytest

from pz_envs.family import own_families
from pz_envs.text.action_parsing import names_any
from pz_envs.text.actions import NOTHING, parse_action
from teachers.atoms import ParseFailure

LEAST = {"labelled": 0.99, "attack": 0.99, "third": 0.98, "fourth": 0.98, "fifth": 0.98, "sixth": 0.94, "traps": 1}
"""Least share of the answers with one clear action that are read as it."""
FOLDER = Path(__file__).with_name("answers")
SETS = {path.stem: [*map(json.loads, path.read_text(encoding="utf-8").splitlines())] for path in FOLDER.glob("*.jsonl")}
WORLDS = {each.name: each.make_world(**each.environments[each.showcase[0]]) for each in own_families()}
for world in WORLDS.values():
    world.reset(seed=0)


def seen(row):
    """What a reader may see: actions in canonical form, or None."""
    world = WORLDS[row["family"]]
    return [None if each is None else world.legal(each) for each in (row["action"], *row.get("also", ()))]


def read(row):
    action = parse_action(row["answer"], WORLDS[row["family"]])
    return None if type(action) is ParseFailure else action


@pytest.mark.parametrize("name", SETS)
def test_what_a_reader_sees_is_read(name):
    clear = [row for row in SETS[name] if None not in seen(row)]
    missed = [row for row in clear if read(row) is None]
    print(f"{name}: {len(clear) - len(missed)} of {len(clear)} clear actions are read")
    assert len(clear) - len(missed) >= LEAST[name] * len(clear), missed


@pytest.mark.parametrize("name", SETS)
def test_nothing_is_read_as_another_action(name):
    assert [(row, read(row)) for row in SETS[name] if read(row) is not None and read(row) not in seen(row)] == []


@pytest.mark.parametrize("name", SETS)
def test_a_failure_quotes_a_short_line_of_the_answer(name):
    for row in SETS[name]:
        failure = parse_action(row["answer"], WORLDS[row["family"]])
        if type(failure) is ParseFailure:
            assert len(failure.got) <= 80
            assert failure.got.isprintable()
            assert (
                failure.why != NOTHING
                or not names_any(row["answer"][:300], WORLDS[row["family"]])
                or ":" in failure.got
            )
