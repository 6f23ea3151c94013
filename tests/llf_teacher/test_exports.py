"""Data to train on, from a study's store: what is written is read back by the libraries that it is for."""

import gc
import json
import math
import tracemalloc

import pytest
from design import amount
from pyarrow import json as arrow
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.registry import entry
from llf_teacher.studies import Results, Study, run
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.export import export_names, write_export
from llf_teacher.studies.export.dialogue import exchanges
from llf_teacher.studies.store import Store
from pz_envs.text.actions import parse_action
from teachers.atoms import ParseFailure

STUDY = Study(
    ids=[
        "llf-gridworld-v0",
        "llf-optimization-Booth-v0",
        "llf-poem-Haiku-v0",
        "llf-bandits-BanditTwoArmedHighLowFixed-v0",
    ],
    teachers=["oracle", "silent"],
    students=["text_only", "random"],
    seeds=2,
    max_turns=4,
)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return run(STUDY, tmp_path_factory.mktemp("exports") / "s.db", workers=1)


def written(found, tmp_path, spec):
    """The rows of a format, and how many pyarrow counts."""
    path = tmp_path / "rows.jsonl"
    number = write_export(found, path, spec)
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    assert number == len(rows)
    if rows:
        table = arrow.read_json(path)
        assert table.num_rows == number
        assert table.to_pylist()[0].keys() == rows[0].keys()
    return rows


def test_what_was_done_is_written_as_text_mode_reads_it(found):
    failed = 0
    for row in found.rows():
        world = entry(row["id"]).family.make_world(**entry(row["id"]).options)
        world.reset(seed=row["seed"])
        for exchange in exchanges(found, row):
            read = parse_action(exchange.action, world)
            assert type(read) is not ParseFailure
            assert json.loads(json.dumps(read)) == exchange.row["action"]
            failed += exchange.row["parse_failure"] is not None
    assert failed == 0


def test_chat_is_an_episode_a_line_with_the_facts_of_its_turns(found, tmp_path):
    rows = written(found, tmp_path, "chat")
    assert len(rows) == len(list(found.rows())) == 32
    for row, episode in zip(rows, found.rows(), strict=True):
        roles = [message["role"] for message in row["messages"]]
        assert roles == ["system", *["user", "assistant"] * episode["turns"]]
        turns = found.turns(episode["key"])
        assert turns[0]["instruction"] in row["messages"][0]["content"]
        for number, turn in enumerate(row["turns"]):
            told, asked = turns[number], row["messages"][1 + 2 * number]["content"]
            assert told["feedback"] in asked
            assert told["observation"] in asked
            assert row["messages"][2 + 2 * number]["content"] == f"Response: {turn['action']}"
            assert [each["kind"] for each in turn["heard"]] == [atom["kind"] or "brief" for atom in told["atoms"]]
        assert math.fsum(turn["regret"] for turn in row["turns"]) == row["regret"] == episode["regret"]
        assert math.fsum(turn["reward"] for turn in row["turns"]) == row["total_reward"]
        assert row["last_feedback"] == turns[-1]["feedback"]
        for name in ("key", "id", "teacher", "student", "seed", "sample"):
            assert row[name] == episode[name]
        assert row["success"] is row["turns"][-1]["success"] is episode["success"]


def test_sft_keeps_what_is_asked_for(found, tmp_path):
    everything = written(found, tmp_path, "sft")
    assert len(everything) == sum(row["turns"] for row in found.rows())
    solved = {row["key"] for row in found.rows() if row["success"]}
    assert {row["key"] for row in written(found, tmp_path, "sft(success=True)")} == solved
    assert 0 < len(solved) < 32
    good = written(found, tmp_path, "sft(regret_below=0.5)")
    assert [row for row in everything if row["regret"] < 0.5] == good
    assert 0 < len(good) < len(everything)
    for row in everything:
        assert row["completion"] == [{"role": "assistant", "content": f"Response: {row['taken']}"}]
        assert row["prompt"][-1]["role"] == "user"
        assert len(row["prompt"]) == 2 * row["turn"]
        assert row["hindsight"] is False


def test_hindsight_puts_what_was_advised_in_place_of_what_was_done(found, tmp_path):
    rows = written(found, tmp_path, "sft(hindsight=True, regret_below=1e-9)")
    marked = [row for row in rows if row["hindsight"]]
    assert {row["teacher"] for row in marked} == {"oracle"}
    assert any(row["completion"][0]["content"] != f"Response: {row['taken']}" for row in marked)
    assert all(row["regret"] < 1e-9 for row in rows if not row["hindsight"])
    house = [row for row in marked if row["family"] == "gridworld"]
    for row in house:
        advised = row["completion"][0]["content"].removeprefix("Response: ")
        assert advised in ("north", "east", "west", "south")
        assert advised in row["prompt"][-1]["content"].partition("\n\n")[0]


def test_dpo_pairs_answers_to_the_same_state(found, tmp_path):
    rows = written(found, tmp_path, "dpo")
    assert rows
    for row in rows:
        assert row["chosen_regret"] < row["rejected_regret"]
        assert row["chosen"] != row["rejected"]
        assert [message["role"] for message in row["prompt"]] == ["system", "user"]
        assert "Teacher: " not in row["prompt"][1]["content"]
    assert len({json.dumps([row["id"], row["seed"], row["prompt"], row["rejected"]]) for row in rows}) == len(rows)
    arms = [row for row in rows if "bandits" in row["id"]]
    assert {row["seed"] for row in arms} == {0, 1}
    assert all(row["rejected_regret"] - row["chosen_regret"] == pytest.approx(0.6) for row in arms)
    assert written(found, tmp_path, "dpo(margin=0.7)") == [
        row for row in rows if row["rejected_regret"] > row["chosen_regret"] + 0.7
    ]


def model(request):
    return "<think>It says so.</think>\n**Response:** go west" if len(request["messages"]) < 5 else "no idea"


@pytest.fixture
def asked(tmp_path):
    """A store of a model's answers, of which the third and fourth are no action."""
    with ScriptedEndpoint(model) as endpoint, Store(tmp_path / "model.db") as store:
        student = f"llm(model='ours/scripted', base_url='{endpoint.url}', answer='text')"
        study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=1, max_turns=4)
        for spec in study.episodes():
            store.add(play(spec))
    return Results(tmp_path / "model.db")


def test_what_a_model_said_is_kept_and_what_it_thought_is_apart(asked, tmp_path):
    (row,) = written(asked, tmp_path, "chat")
    said = [message["content"] for message in row["messages"] if message["role"] == "assistant"]
    assert said == ["**Response:** go west", "**Response:** go west", "no idea", "no idea"]
    assert [turn["thought"] for turn in row["turns"]] == ["It says so.", "It says so.", "", ""]
    assert [turn["parse_failure"] for turn in row["turns"]] == [False, False, True, True]
    assert [each["turn"] for each in written(asked, tmp_path, "sft")] == [1, 2]
    assert all("<think>" not in json.dumps(each["prompt"]) for each in written(asked, tmp_path, "sft"))


class Many(Results):
    """A store in which each episode comes many times."""

    times = 1

    def rows(self):
        for _ in range(self.times):
            yield from super().rows()


@pytest.mark.parametrize("spec", ["chat", "sft(hindsight=True)", "dpo"])
def test_memory_does_not_grow_with_the_store(found, tmp_path, spec):
    def peak(times):
        many = Many(found.path)
        many.times = times
        gc.collect()
        tracemalloc.start()
        write_export(many, tmp_path / f"{times}", spec)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    peak(1)  # what is loaded once
    once = peak(1)
    assert any(
        peak(amount(3, full=6)) < 1.5 * once + 100_000 for _ in range(3)
    )  # caches of the process grow now and then


def test_what_is_no_format_is_refused(found, tmp_path):
    assert export_names() == ("chat", "dpo", "sft")
    for spec, said in (
        ("char", "unknown format 'char'; did you mean chat"),
        ("sft(sucess=True)", "format 'sft': unknown parameter 'sucess'; did you mean success"),
        ("sft(success=1)", "success must be True or False, got 1"),
        ("sft(regret_below=-1)", "regret_below"),
        ("dpo(margin='a')", "margin"),
        ("sft(", "bad format spec 'sft('; expected `name` or `name(key"),
        ("sft | dpo", "format spec 'sft | dpo' has 2 parts"),
    ):
        with pytest.raises(ValueError, match=said.replace("(", r"\(")):
            write_export(found, tmp_path / "x", spec)
    assert not (tmp_path / "x").exists()


def test_the_command_writes_them(found, tmp_path):
    done = CliRunner().invoke(app, ["study", "export", f"{found.path}", f"{tmp_path}/c.jsonl", "--format", "chat"])
    assert done.output == f"32 written in the format chat, stored in {tmp_path}/c.jsonl.\n"
    done = CliRunner().invoke(app, ["study", "export", f"{found.path}", "x.jsonl", "--format", "chat", "--turns"])
    assert done.exit_code == 2
    assert "leave out" in done.output
