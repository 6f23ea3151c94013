"""The reader behind the phrases: a model that answers in the schema or abstains, however hostile it is."""

import json
import time

import pytest
from endpoints import ANSWERS, HUGE, KEY, files_with

import llf_teacher
from llf_teacher.models import LLMError
from llf_teacher.models.testing import ScriptedEndpoint, refusal
from llf_teacher.registry import entry
from llf_teacher.speakers.llm_reader import LLMReader
from llf_teacher.speakers.parsing import parse_reader
from pz_envs.text.claims import EXACT, LONGEST_TEXT, MODEL, MOST_SENTENCES, ClaimReader
from teachers.atoms import Moment

pytestmark = pytest.mark.usefixtures("no_settings")
ODD = "Whence the sun goes down, thither turn thy feet, ranger."
RIGHT = "Let the pole star be thy guide, ranger."
ID = "llf-gridworld-v0"


def claims(*given):
    return json.dumps({"claims": list(given)})


def star(request):
    """Stands for a model that knows the sky."""
    return claims({"type": "Go", "action": "north" if "pole" in request["messages"][-1]["content"] else "west"})


@pytest.fixture(scope="module")
def reader():
    """Of a student, which has no truth; the model is put in its place by each test."""
    family = entry(ID).family
    made = ClaimReader(family, family.make_world())
    made.did(None, 0)
    return made


def test_only_what_was_not_read_is_asked_and_the_truth_is_not_sent():
    env = llf_teacher.make(ID)
    session = env.session
    with ScriptedEndpoint(star) as server:
        made = ClaimReader(env.family, session.world, session.teacher.oracle, LLMReader("m", server.url, answer="json"))
        env.reset(seed=0)
        found = []
        for said in ("", f"Now head south. {RIGHT}", ODD, ODD):
            if session.moment.turn or said:
                env.step(3)
            made.see(session.moment)
            found += made.read(said)
    first, *odd = found
    assert (first.layer, first.outcome) == (EXACT, "false")
    assert [(each.layer, each.outcome) for each in odd] == [(MODEL, "true"), (MODEL, "false"), (MODEL, "false")]
    assert [each["messages"][1]["content"] for each in server.requests] == [RIGHT, ODD]  # an equal one is known
    assert "kitchen-2" not in json.dumps(server.requests), "the room of the student"
    assert server.requests[0]["response_format"]["json_schema"]["schema"]["properties"]["claims"]


def test_a_phrase_that_makes_no_single_claim_is_asked_too(reader):
    asked = []
    reader._model = lambda sentence, vocabulary: asked.append(sentence)
    outcomes = [each.outcome for each in reader.read("Now head south. Now head esat.")]
    assert (outcomes, asked) == (["built", "not read"], ["Now head esat."])


@pytest.mark.parametrize("answer", [*ANSWERS.values(), *HUGE.values(), claims(), claims(*[{"type": "Solved"}] * 2)])
def test_a_hostile_answer_reads_nothing(answer, reader):
    began = time.process_time()
    with ScriptedEndpoint(lambda request: answer) as server:
        reader._model = LLMReader("m", server.url, answer="json")
        (found,) = reader.read(ODD)
    assert (found.layer, found.claim, found.outcome) == ("", None, "not read")
    assert len(found.candidates[0]) <= 200
    assert time.process_time() - began < 5


def test_the_key_stays_out_of_what_is_found(reader, monkeypatch, tmp_path):
    monkeypatch.setenv("LLF_LLM_API_KEY", KEY)
    with ScriptedEndpoint(lambda request: claims({"type": "Found", "room": KEY})) as server:
        reader._model = LLMReader("m", server.url, answer="json")
        (found,) = reader.read(ODD)
    assert KEY not in f"{found}"
    assert not files_with(KEY, tmp_path)


def test_a_text_is_read_up_to_its_bounds(reader):
    asked = []
    reader._model = lambda sentence, vocabulary: asked.append(sentence)
    many = list(reader.read("Ho. " * (MOST_SENTENCES + 3)))
    assert len(asked) == MOST_SENTENCES
    assert [each.candidates[0][:9] for each in many[-3:]] == ["of a text"] * 3
    long = list(reader.read("x" * LONGEST_TEXT + " and more. Ho."))
    assert [each.outcome for each in long] == ["not read"] * 3


def test_a_model_gets_what_can_be_said_and_no_episode(reader):
    given = []
    reader._model = lambda sentence, vocabulary: given.append(vocabulary)
    list(reader.read(ODD))
    (vocabulary,) = given
    claim = vocabulary.claim_of({"type": "Go", "action": "west"})
    assert "Go" in vocabulary.schema_of("Go")["properties"]["type"]["const"]
    with pytest.raises(ValueError, match=r"Go\(.* cannot be checked: the world has no such thing"):
        vocabulary.holds(claim, Moment.opening(None))


def test_an_endpoint_without_json_schemas(reader):
    def picky(request):
        return refusal("response_format") if "response_format" in request else claims({"type": "Solved"})

    with ScriptedEndpoint(picky) as server:
        reader._model = LLMReader("m", server.url, answer="json")
        with pytest.raises(LLMError, match="give another answer, such as answer='text'"):
            list(reader.read(ODD))
        reader._model = LLMReader("m", server.url, answer="text")
        (found,) = reader.read(ODD)
    assert (found.layer, found.outcome, found.holds) == (MODEL, "built", None)


@pytest.mark.parametrize("spec", ["near", "llm_reader(speed=2)", "no_such_module:f", "json:nothing", 3, "a | b"])
def test_readers_that_do_not_exist(spec):
    with pytest.raises(ValueError, match="reader"):
        parse_reader(spec)


def test_readers_that_do():
    assert parse_reader("none") is parse_reader("exact") is None
    assert parse_reader("json:dumps") is json.dumps
    named = "llm_reader(model='m', base_url='http://localhost:1/v1')"
    assert str(parse_reader(named)) == named
