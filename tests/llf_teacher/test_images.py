"""Images beside texts: what a student sees, what a model is sent, and environment options in studies."""

import base64
import contextlib
import io
import json
import sqlite3

import numpy as np
import pytest
from opengl import with_opengl
from PIL import Image

import llf_teacher
from llf_teacher.models.images import PIXELS, data_url
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies import run
from llf_teacher.studies.definition.study import Study, load_study, to_toml
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from pz_envs.family import all_families

GRIDWORLD = "llf-gridworld-v0"
VISUAL = {"llf-grid*": {"visual": True}}
pytestmark = pytest.mark.usefixtures("no_settings")
DRAWN = [family for family in all_families() if family.picture and not family.visual and not family.missing()]


def decoded(url):
    head, _, data = url.partition(",")
    assert head == "data:image/png;base64"
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data, validate=True))))


def shown(request):
    """The images of each message that has any."""
    parts = [message["content"] for message in request["messages"] if isinstance(message["content"], list)]
    return [[decoded(part["image_url"]["url"]) for part in each if part["type"] == "image_url"] for each in parts]


@pytest.mark.parametrize("family", DRAWN, ids=lambda family: family.name)
def test_a_text_has_a_picture_beside_it_of_what_the_student_may_know(family):
    id = f"llf-{family.showcase[0]}"
    seen = []
    for privileged in (False, True):
        env = llf_teacher.make(id, text=True, visual=True, privileged_info=privileged, max_turns=2)
        observation, _ = env.reset(seed=3)
        assert env.observation_space.contains(observation)
        words = llf_teacher.make(id, text=True, max_turns=2).reset(seed=3)[0]
        assert {name: observation[name] for name in words} == words
        seen.append(observation["image"])
        observation, *_ = env.step("no action")
        assert env.observation_space.contains(observation)
        assert observation["image"].std() > 0
    assert np.array_equal(*seen)


def test_what_is_seen_changes():
    env = llf_teacher.make(GRIDWORLD, text=True, visual=True)
    first = env.reset(seed=7)[0]["image"]
    assert not np.array_equal(first, env.step("west")[0]["image"])


SEE = """
import numpy as np, llf_teacher
env = llf_teacher.make("llf-metaworld-reach-v3", text=True, visual=True)
observation, _ = env.reset(seed=3)
assert env.observation_space.contains(observation)
assert observation["image"].shape == (240, 240, 3) and "image" not in observation["observation"]
assert np.array_equal(observation["image"], env.unwrapped.session.world.image())
print("seen")
"""


def test_meta_world_gives_what_its_camera_sees():
    assert with_opengl(SEE) == "seen\n"


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({}, "not supported by gridworld without text=True: its numbers have no image; set text=True"),
        ({"text": True, "visual": "yes"}, "visual must be True or False, got 'yes'"),
    ],
)
def test_where_there_is_no_image(options, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.make(GRIDWORLD, **({"visual": True} | options))


def test_an_image_is_sent_small_and_whole():
    pixels = np.random.default_rng(0).integers(0, 256, (40, 50, 3), np.uint8)
    assert np.array_equal(decoded(data_url(pixels)), pixels)
    assert decoded(data_url(np.zeros((3000, 1500, 3), np.uint8))).shape == (PIXELS, PIXELS // 2, 3)
    for wrong in (pixels[..., 0], pixels.astype(float), "image"):
        with pytest.raises(ValueError, match=r"an image must be an array of uint8 \(height, width, 3\), got "):
            data_url(wrong)


@pytest.mark.parametrize(("images", "sent"), [(1, [1, 1, 1]), (2, [1, 2, 2]), (0, [0, 0, 0])])
def test_a_model_is_sent_the_latest(tmp_path, images, sent):
    """In the last question, and in none before those that are wanted; what is kept has no image."""
    with ScriptedEndpoint(lambda request: "Response: west") as server:
        student = f"llm(model='m', base_url='{server.url}', answer='text', images={images})"
        study = Study(ids=[GRIDWORLD], teachers=["silent"], students=[student], seeds=1, max_turns=3, options=VISUAL)
        results = run(study, tmp_path / "s.db", options=RunOptions("here"))
    assert [len(shown(request)) for request in server.requests] == sent
    env = llf_teacher.make(GRIDWORLD, teacher="silent", text=True, visual=True, max_turns=3)
    seen = [env.reset(seed=0)[0]["image"], *(env.step("west")[0]["image"] for _ in range(2))]
    for turn, request in enumerate(server.requests):
        found = [image for each in shown(request) for image in each]
        assert all(np.array_equal(a, b) for a, b in zip(reversed(found), reversed(seen[: turn + 1]), strict=False))
        assert "Your action?" in json.dumps(request["messages"][-1]["content"])
    assert not [row for turn in results.all_turns() for row in turn if "image" in row]
    for path in tmp_path.glob("*.db"):
        assert b"base64" not in path.read_bytes()
    with contextlib.closing(sqlite3.connect(tmp_path / "s.llm.db")) as db, db:
        kept = [row[0] for row in db.execute("SELECT request FROM answer")]
    db.close()
    assert len(kept) == 3
    assert sum(text.count("sha256:") for text in kept) == sum(sent)


def test_a_result_of_a_tool_has_its_image_behind_it():
    env = llf_teacher.make(GRIDWORLD, text=True, visual=True, max_turns=3)
    talk = llf_teacher.Conversation(env, answer="tool")
    observation, _ = env.reset(seed=0)
    talk.ask(observation)
    talk.answer('{"action": "west"}', call="c1")
    messages = talk.ask(env.step("west")[0])
    assert [message["role"] for message in messages] == ["system", "user", "assistant", "tool", "user"]
    assert isinstance(messages[3]["content"], str)
    assert [part["type"] for part in messages[4]["content"]] == ["image_url"]


def test_a_function_of_messages_gets_the_image_and_one_of_a_text_does_not():
    heard = []

    def reads(messages):
        heard.append(messages[-1]["content"])
        return "Response: west"

    def listens(prompt):
        heard.append(prompt)
        return "Response: west"

    students = [llf_teacher.chat_student(each) for each in (reads, listens)]
    study = Study(ids=[GRIDWORLD], teachers=["silent"], students=students, seeds=1, max_turns=1, options=VISUAL)
    for spec in study.episodes():
        play(spec)
    assert [part["type"] for part in heard[0]] == ["text", "image_url"]
    assert decoded(heard[0][1]["image_url"]["url"]).shape == (442, 384, 3)
    assert isinstance(heard[1], str)
    assert "base64" not in heard[1]


def test_a_picture_is_no_text_that_has_to_fit():
    env = llf_teacher.make(GRIDWORLD, text=True, visual=True)
    talk = llf_teacher.Conversation(env, max_prompt_tokens=2000)
    observation, _ = env.reset(seed=0)
    for _ in range(4):
        messages = talk.ask(observation)
        talk.answer("Response: west")
        observation, *_ = env.step("west")
    assert len(messages) == 8


def test_options_are_part_of_an_episode(tmp_path):
    settings = {"teachers": ["oracle"], "students": ["random"], "seeds": 1}
    ids = [GRIDWORLD, "llf-optimization-Booth-v0"]
    plain = Study(ids=ids, **settings)
    study = Study(ids=ids, options={"llf-grid*": {"num_rooms": 6}, "llf-*": {"failure_reward": -1}}, **settings)
    with pytest.raises(ValueError, match=r"failure_reward must be a number from 0\.0 to 1\.0, got -1"):
        Study(ids=ids, options={"llf-grid*": {"failure_reward": -1}}, **settings)
    keys = [[spec.key for spec in each.episodes()] for each in (plain, study)]
    assert not {*keys[0]} & {*keys[1]}
    assert [spec.options for spec in study.episodes()] == ['{"num_rooms": 6}', '{"failure_reward": -1}']
    (tmp_path / "s.toml").write_text(to_toml(study))
    assert load_study(tmp_path / "s.toml") == study
    results = run(study, tmp_path / "s.db", options=RunOptions("here"))
    assert {row["options"] for row in results.rows()} == {'{"num_rooms": 6}', '{"failure_reward": -1}'}
    assert results.study == study


def test_students_of_numbers_do_without_pictures_of_texts(tmp_path):
    both = {"ids": [GRIDWORLD], "teachers": ["oracle"], "students": ["obedient"], "seeds": 2}
    plain = run(Study(**both), tmp_path / "a.db", options=RunOptions("here"))
    seen = run(Study(options=VISUAL, **both), tmp_path / "b.db", options=RunOptions("here"))
    one, other = ([row["regret"] for row in each.rows()] for each in (plain, seen))
    assert one == other


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"llf-poem*": {}}, r'options."llf-poem\*" matches none of the ids'),
        ({"llf-*": {"num_romos": 3}}, "llf-gridworld-v0: unknown option 'num_romos'; did you mean"),
        ({"llf-*": {"num_rooms": 0}}, "num_rooms must be"),
        ({"llf-*": {"visual": 1}}, "visual must be true or false, got 1"),
        ({"llf-*": {"teacher": "silent"}}, "unknown option 'teacher'"),
        ({"llf-*": {"render_mode": "human"}}, "unknown option 'render_mode'"),
        ({"llf-*": {"num_rooms": object()}}, "must hold texts, numbers"),
        ({"llf-*": 3}, "options must be a table of tables"),
    ],
)
def test_options_that_are_none(options, match):
    with pytest.raises(ValueError, match=match):
        Study(ids=[GRIDWORLD], teachers=["oracle"], students=["random"], seeds=1, options=options)
