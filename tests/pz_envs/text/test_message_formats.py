"""The schema of a message of claims: what can be said of a moment, and how long an answer can be."""

import json
from itertools import islice

import numpy as np
import pytest
from playing import episode
from sampling import ENTRIES

import llf_teacher
from pz_envs.text.message_formats import WORDS, longest, message_schema
from teachers.atoms import FN, FP, HN, HP, R
from teachers.schema import Vocabulary, may_lack


class Hearing:
    """Says what the oracle says, and keeps what a policy is given."""

    def reset(self, rng):
        self.infos = []

    def act(self, observation, info):
        self.infos.append(info)
        return info["suggestion"]


def moments(id, turns=4, seed=0, **settings):
    """The infos after some random actions, and the claims of each as JSON values without what the moment gives."""
    teacher = Hearing()
    env = llf_teacher.make(id, teacher=teacher, max_turns=turns + 1, **settings)
    rng = np.random.default_rng(seed)
    world = env.unwrapped.session.world
    list(islice(episode(env, lambda *_: world.sample_action(rng), seed), turns))
    for info in teacher.infos[1:]:
        words = info["vocabulary"]
        said = [atom.claim for atom in info["suggestion"].atoms if type(atom.claim) in words.classes.values()]
        datas = [
            {field: value for field, value in words.data_of(claim).items() if not may_lack(type(claim), field)}
            for claim in said
        ]
        yield info, datas


def fits(value, schema):
    """Whether a value is of a schema, by the few keywords that are used."""
    if "anyOf" in schema:
        return any(fits(value, each) for each in schema["anyOf"])
    if "const" in schema or "enum" in schema:
        return value in schema.get("enum", [schema.get("const")])
    kind = schema.get("type")
    if kind == "object":
        properties = schema["properties"]
        return set(value) == set(schema["required"]) and all(fits(value[name], properties[name]) for name in value)
    if kind == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})] * len(value)
        sized = schema.get("minItems", 0) <= len(value) <= schema["maxItems"]
        return sized and all(map(fits, value, items))
    if kind == "string":
        return isinstance(value, str) and len(value) <= schema["maxLength"]
    if kind in ("integer", "number"):
        return schema["minimum"] <= value <= schema["maximum"]
    return not schema


@pytest.mark.parametrize("entry", ENTRIES)
def test_the_oracles_claims_can_be_said(entry):
    """Each of them is of the schema, alone, and what is of it alone is read; so is all of it within its length."""
    heard = 0
    for info, datas in moments(entry.id, 2 if entry.family.slow else 4):
        schema = message_schema(info["vocabulary"], info["moment"], known=datas)
        for data in datas:
            message = {"claims": [data]}
            assert fits(message, schema), data
            assert len(json.dumps(message)) <= longest(schema)
            heard += 1
    assert heard


def test_kinds_and_moments_bound_the_claims():
    def kinds(info, **changes):
        schema = message_schema(info["vocabulary"], info["moment"]._replace(**changes))
        names = [form["properties"]["type"]["const"] for form in schema["properties"]["claims"]["items"]["anyOf"]]
        return {info["vocabulary"].classes[name].kind for name in names}

    (info, _), *_ = moments("llf-gridworld-v0")
    assert kinds(info) == {R, HP, HN, FP, FN}
    assert kinds(info, over=True) == {R, HP, HN}
    assert kinds(info, before=None) == {FP, FN}
    (info, _), *_ = moments("llf-gridworld-v0", feedback_type="fp")
    assert kinds(info) == {FP}


def test_texts_are_those_at_hand():
    """Rooms that the student sees; commands that can be carried out, and the things in them; titles of its list."""

    def field(info, name, field):
        schema = message_schema(info["vocabulary"], info["moment"])
        forms = {form["properties"]["type"]["const"]: form for form in schema["properties"]["claims"]["items"]["anyOf"]}
        return forms[name]["properties"][field]

    (info, _), *_ = moments("llf-gridworld-v0")
    layout, room = info["moment"].after.layout, info["moment"].before.room
    assert layout.names[room] in field(info, "Nearer", "room")["enum"]
    assert len(field(info, "Nearer", "room")["enum"]) < len(layout.names)
    assert set(field(info, "InRoom", "room")["enum"]) == {name.rpartition("-")[0] for name in layout.names}
    (info, _), *_ = moments("llf-alfworld-v0")
    commands = field(info, "Do", "action")["enum"]
    world = info["vocabulary"].world
    world.restore(info["moment"].after)
    assert commands == world.commands()
    assert field(info, "DoVerb", "verb")["enum"] == [*dict.fromkeys(each.split()[0] for each in commands)]
    (info, _), *_ = moments("llf-reco-movie-v0")
    assert field(info, "AvoidTitle", "title")["enum"] == json.loads(info["moment"].after.answer)


def test_few_claims_and_few_words():
    (info, _), *_ = moments("llf-gridworld-v0")
    words, moment = info["vocabulary"], info["moment"]
    one, three = (message_schema(words, moment, most) for most in (1, 3))
    assert [each["properties"]["claims"]["maxItems"] for each in (one, three)] == [1, 3]
    assert longest(one) < longest(three) < 500
    with_words = message_schema(words, moment, 3, words=True)
    assert longest(with_words) - longest(three) >= WORDS
    silent = message_schema(Vocabulary((), words.oracle, ()), moment)
    assert silent["properties"]["claims"]["maxItems"] == 0
    assert fits({"claims": []}, silent)
