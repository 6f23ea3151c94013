"""What a policy says as claims: each is made, checked and labelled, and nothing that it says ends an episode."""

import copy
import json
import pickle

import numpy as np
import pytest
from playing import Fixed, episode
from sampling import ENTRIES

import llf_teacher
from llf_teacher.episodes.record import pack_turns, unpack_turns
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.registry import entry
from llf_teacher.tools.audit import audit
from pz_envs.seats import STUDENT, TEACHER
from teachers.atoms import FP, HP, KINDS, ActionClaim, Atom, Label, Utterance
from teachers.oracles.gridworld.claims import Found, Go, NotInRoom
from teachers.schema import MOST_CLAIMS, Message, sentences_of
from worlds.gridworld import Direction

ID = "llf-gridworld-v0"


class Says:
    """Says what a function makes of the info; the instruction is the oracle's."""

    honest = True

    def __init__(self, message):
        self.message = message

    def reset(self, rng):
        self.rng = rng

    def act(self, observation, info):
        return self.message(info) if info["moment"].turn else info["suggestion"]


def claims_of(info):
    """The claims of the session's teacher as JSON."""
    vocabulary = info["vocabulary"]
    said = [atom.claim for atom in info["suggestion"].atoms]
    return [vocabulary.data_of(claim) for claim in said if type(claim) in vocabulary.classes.values()]


def recorded(policy, id=ID, turns=12, seed=0, **settings):
    """The rows of an episode with random actions."""
    env = llf_teacher.make(id, teacher=policy, max_turns=turns, **settings)
    recorder = Recorder("x", env.student_view, policy)
    rng = np.random.default_rng(seed)
    env.reset(seed=seed)
    recorder.note()
    while not env.session.over:
        env.step(env.session.world.sample_action(rng))
        recorder.note()
    return recorder.rows


@pytest.mark.parametrize("entry", ENTRIES)
def test_what_the_oracle_says_is_said_as_claims_too(entry):
    """In every family: the same claims with the same labels, worded by the voice."""
    through = recorded(Says(lambda info: {"claims": json.loads(json.dumps(claims_of(info)))}), entry.id, turns=3)
    direct = recorded("oracle", entry.id, turns=3)
    keys = ("claim", "fields", "kind", "label", "about_turn")
    for mine, its in zip(through, direct, strict=True):
        said, wanted = ([[atom[key] for key in keys] for atom in row.atoms] for row in (mine, its))
        assert said == wanted
        assert mine.feedback == " ".join(atom["text"] for atom in mine.atoms if atom["kind"]) or not mine.turn
        assert (mine.unbuilt, mine.unchecked) == (None, None)


def test_a_false_claim_is_said_and_counted_as_false():
    def message(info):
        return {"claims": [{"type": "Go", "action": str(way)} for way in Direction]}

    labels = [(atom["label"], atom["holds"]) for row in recorded(Says(message))[1:] for atom in row.atoms]
    assert set(labels) == {("truthful", True), ("distorted", False)}
    found = audit(ID, Says(message), turns=200)
    assert found.caught
    advice = {label: found.claims[FP, label] for label in (Label.TRUTHFUL, Label.DISTORTED)}
    assert sum(advice.values()) == 4 * found.turns + found.episodes  # whose openings are the oracle's
    assert min(advice.values()) > 100


@pytest.mark.parametrize(
    ("message", "unbuilt"),
    [
        ({"claims": [{"type": "Go", "action": "up"}, {"type": "Pull", "action": 1}]}, 2),
        ({"claims": "Go north"}, 1),
        ({"claims": [{"type": "Solved"}] * (MOST_CLAIMS + 1)}, 1),
        ({"claim": []}, 1),
        ({"claims": [{"type": "Either", "ways": []}]}, 1),  # no words for it
        ({}, 0),
        ({"claims": [], "text": None}, 0),
    ],
)
def test_what_cannot_be_made_is_counted_apart(message, unbuilt):
    for row in recorded(Says(lambda info: message))[1:]:
        assert (row.unbuilt, row.feedback, row.atoms) == (unbuilt or None, "", [])


def test_the_policy_hears_what_could_not_be_made():
    """In its next info; the student in its own, if it is privileged."""
    told = []

    def message(info):
        told.append(len(info["unbuilt"]))
        return {"claims": [{"type": "Nope"}] * (2 - info["moment"].turn)} if info["moment"].turn < 3 else "Hm."

    for privileged in (True, False):
        env = llf_teacher.make(ID, teacher=Says(message), privileged_info=privileged)
        infos = [env.reset(seed=1)[1], *(env.step(0)[-1] for _ in range(4))]
        assert [len(info.get("unbuilt", ())) for info in infos] == ([0, 1, 0, 0, 0] if privileged else [0] * 5)
    assert told == [0, 1, 0, 0] * 2


def test_its_own_words_are_said_in_place_of_the_voices():
    right, go = "Yes,  that was good!", "NOW HEAD NORTH"

    def message(info):
        return {
            "claims": [{"type": "Go", "action": "north"}, {"type": "Right"}, {"type": "Solved"}],
            "text": f"{right} Bravo! {go}.",
        }

    row = recorded(Says(message))[1]
    assert row.feedback == message(None)["text"]
    texts = [(atom["claim"], atom["text"]) for atom in row.atoms]
    assert texts == [("common.Right", right), ("x.Go", f"{go}."), ("common.Solved", "")]
    assert row.unchecked == 1, "Bravo!"
    more = recorded(Says(lambda info: {**message(info), "claims": [{"type": "Go", "action": "north"}]}))[1]
    assert (more.unchecked, [atom["text"] for atom in more.atoms]) == (2, [f"{go}."])
    fewer = recorded(Says(lambda info: {**message(info), "text": go}))[1]
    assert (fewer.feedback, [atom["text"] for atom in fewer.atoms]) == (go, [go, "", ""])
    bare = recorded(Says(lambda info: {"text": "Hm. Well."}))[1]
    assert (bare.feedback, bare.atoms, bare.unchecked) == ("Hm. Well.", [], 2)


def test_a_sentence_that_says_something_else_is_unchecked():
    """However alike it is: it is read as all words that no claim stands behind."""
    said = {"claims": [{"type": "Go", "action": "north"}, {"type": "Found", "room": "attic-1"}]}
    found = entry(ID).family.phrasebook().sentences(Found(action=Direction.EAST, room="attic-1"))
    whole = next(each for each in found if len(sentences_of(each)) == 2)
    for text, unchecked, texts in (
        ("Go south next.", 1, ["", ""]),
        ("Go north next. Go south next.", 1, ["Go north next.", ""]),
        ("Go north next. Go north next.", 1, ["Go north next.", ""]),
        ("Go north next?", 1, ["", ""]),
        ("Never go north next.", 1, ["", ""]),
        (f"Hm. {whole} Go north next.", 1, [whole, "Go north next."]),
        (whole.partition("!")[0] + "!", 1, ["", ""]),
    ):
        env = llf_teacher.make(ID, teacher=Says(lambda info, text=text: {**said, "text": text}))
        recorder = Recorder("x", env.student_view, None)
        env.reset(seed=0)
        recorder.note()
        env.step(Direction.EAST)
        row = recorder.note()
        assert (row.unchecked, [atom["text"] for atom in row.atoms]) == (unchecked, texts), text
        assert row.feedback == text


def test_feedback_type_and_budget_bound_the_claims_and_then_the_voice_words_them():
    claims = [{"type": "Go", "action": "north"}, {"type": "Wrong"}, {"type": "Avoid", "action": "west"}]
    says = Says(lambda info: {"claims": claims, "text": "Do this and that."})
    for row in recorded(says, feedback_type="fp")[1:]:
        assert [atom["kind"] for atom in row.atoms] == ["fp"]
        assert "this and that" not in row.feedback
    assert not any(row.feedback or row.atoms for row in recorded(says, feedback_type="n")[1:])
    env = entry(ID).family.raw_env(speech="message", budget=4)
    env.reset(seed=0)
    env.step({"claims": claims})
    for spoken in (2, 0):
        env.step(0)
        env.step({"claims": claims})
        assert len(env.infos[STUDENT]["atoms"]) == spoken
    env.close()


def test_notices_are_always_said():
    env = llf_teacher.make(ID, teacher=Fixed({"claims": [{"type": "Go", "action": "north"}]}), text=True)
    observation, info = env.reset(seed=0)
    assert "treasure" in observation["instruction"]
    assert [atom.kind for atom in info["atoms"]][-1] is FP
    observation, *_ = env.step("I do not know.")
    assert "I do not know." in observation["feedback"]
    assert {atom.kind for atom in env.session.atoms} == {None, FP}


def test_seats_take_messages_and_can_be_copied_and_taken_back():
    family = entry(ID).family
    env = family.raw_env(speech="message")
    env.reset(seed=1)
    vocabulary = env.infos[TEACHER]["vocabulary"]
    assert vocabulary == family.vocabulary()
    assert {cls.kind for cls in vocabulary.classes.values()} == set(KINDS)
    env.step({"claims": [{"type": "Go", "action": 2}]})
    for twin in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert twin.infos[STUDENT]["atoms"][-1].claim.action is Direction.WEST
        twin.step(2)
        twin.step({"claims": [{"type": "Right"}]})
        (atom,) = twin.infos[STUDENT]["atoms"]
        assert atom.kind is HP
        assert isinstance(atom.claim, ActionClaim)


def test_a_hostile_policy_plays_to_the_end():
    deep = []
    for _ in range(50_000):
        deep = [deep]
    long = "! " * 30_000
    for message in ({"claims": deep}, {"claims": [deep]}, {"text": deep}, {"claims": [], "text": long}, {"x": deep}):
        env = llf_teacher.make(ID, teacher=Says(lambda info, message=message: message), max_turns=3)
        assert len(list(episode(env, 1))) <= 3
        assert len(env.session.teacher_turns[0].unbuilt) == 1
        assert max(map(len, env.session.teacher_turns[0].unbuilt)) < 1000
    crowd = {"claims": [{"type": "Right"}] * MOST_CLAIMS, "text": "So. " * 2000}
    assert recorded(Says(lambda info: crowd), turns=2)[1].unchecked == 2000


def test_too_many_words_are_counted_and_not_said():
    long = [*[NotInRoom(room="x" * 7000)] * 8, Go(action=Direction.NORTH)]
    for said in ({"claims": long}, Message(tuple(long), "", ())):
        row = recorded(Says(lambda info, said=said: said), turns=2)[1]
        assert (row.unbuilt, len(row.atoms)) == (4, 5)
    for said in ("a" * 70_000, {"claims": [], "text": "a" * 70_000}):
        (opening, *rows) = recorded(Says(lambda info, said=said: said), turns=2)
        assert opening.unbuilt is None
        assert [(row.unbuilt, row.feedback) for row in rows] == [(1, "")] * len(rows)


@pytest.mark.parametrize(
    "said",
    [
        "\ud800 hi",
        Utterance("\ud800 hi", (Atom(NotInRoom(room="\ud800"), "\ud800 hi", 1),)),
        {"claims": [{"type": "NotInRoom", "room": "\ud800"}], "text": "\ud800 hi"},
    ],
)
def test_a_lone_surrogate_loses_no_episode(said):
    rows = recorded(Says(lambda info: said), turns=3)
    assert rows[1].feedback == "? hi"
    (*_, last) = unpack_turns(pack_turns(rows))
    assert last["feedback"] == "? hi"


def test_sentences_are_those_that_people_see():
    text = 'He said "go!" Then (why?) I went.\nNo end\n\n... 3.5 is a number. "Really?") Yes!'
    assert sentences_of(text) == [
        'He said "go!"',
        "Then (why?)",
        "I went.",
        "No end",
        "3.5 is a number.",
        '"Really?")',
        "Yes!",
    ]
    text = 'Take "Dr. No". "Go!", she said. The lines "one.\ntwo" are it. An "open one. Then more'
    assert sentences_of(text) == [
        'Take "Dr. No".',
        '"Go!", she said.',
        'The lines "one.\ntwo" are it.',
        'An "open one.',
        "Then more",
    ]
