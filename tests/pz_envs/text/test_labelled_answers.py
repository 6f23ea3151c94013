"""Answers of models, each with the action that a reader sees: nearly all are read as it, and none as another.

A line has the family, the answer, the action (null: a reader sees none) and, where readers may differ, what else they
may see (`also`). Those of `written` are in the manner of larger models, or adversarial. The other sets were labelled
when the rule stood, and general faults were mended afterwards. Of the clear actions the rule read at first:

- `attack`: 104 of 108, and one story as an action;
- `third`: 61 of 68, and two texts without an action as one;
- `fourth`, real models, other prompts: 65 of 78, and two texts without an action as one;
- `fifth`, real models, other prompts: 75 of 86, and two texts without an action as one;
- `sixth`, three real models, the shipped prompts, two readers of one mind: 102 of 119, and none as another;
- `seventh`, one of them at temperature 0, the same two readers: 30 of 36, and none as another;
- `eighth`, the same model in other environments, the same readers: 30 of 34, and the word `stay`, which they did not
  know, as an action;
- `ninth`, the same in others again: 31 of 33, and none as another;
- `tenth`, `eleventh`, `twelfth` and `thirteenth`, two models, the shipped prompts and shorter ones, in others again,
  each after the faults that the one before showed were mended: 68 of 81, 59 of 63, 63 of 65 and 63 of 72, and none as
  another. Points outside the bounds of the world here were left out.

A poem may be any text, so that 30 of them have got their reading. `traps.jsonl` was written against the rule in three
rounds: of 877 texts in which nothing is chosen 72 are still misread, and left out, as are those clear ones that are
not read.
"""

import json
from pathlib import Path

import pytest

from pz_envs.family import own_families
from pz_envs.text.action_parsing import names_any
from pz_envs.text.actions import NOTHING, parse_action
from teachers.atoms import ParseFailure

LEAST = dict.fromkeys(("third", "fifth", "twelfth"), 0.98) | {"sixth": 0.94, "thirteenth": 0.97, "tenth": 1, "traps": 1}
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
    assert len(clear) - len(missed) >= LEAST.get(name, 0.99) * len(clear), missed


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


@pytest.mark.parametrize("shape", ["{}: ", "{} - ", "{0}:{0}:", "Action: {} ", '\\"'])
def test_an_action_that_is_repeated_is_read_once_at_each_place(shape):
    """Each further one would double the time otherwise, so that these texts would not end."""
    for family, action in {"gridworld": "north", "bandits": "3", "alfworld": "look", "movies": '["Heat"]'}.items():
        for count in (40, 2000):
            parse_action(shape.format(action) * count, WORLDS[family])
