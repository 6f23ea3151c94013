"""Data to train on, from a study's store: what is written is read back by the libraries that it is for."""

import gc
import json
import math
import re
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
    assert export_names() == ("chat", "dpo", "preferences", "ratings", "sft")
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


RATED = Study(
    ids=["llf-gridworld-v0"],
    teachers=["only(kinds='hp+hn')", "only(kinds='hp+hn') | mistake(eps=1)", "only(kinds='r')", "placebo", "silent"],
    students=["random", "obedient", "text_only"],
    seeds=8,
    max_turns=4,
)


@pytest.fixture(scope="module")
def rated(tmp_path_factory):
    return run(RATED, tmp_path_factory.mktemp("rated") / "s.db", workers=1)


def test_ratings_are_what_the_teacher_said_beside_the_truth(rated, tmp_path):
    rows = written(rated, tmp_path, "ratings")
    assert len(rows) == sum(row["turns"] for row in rated.rows())
    teachers = {teacher: [row for row in rows if row["teacher"] == teacher] for teacher in RATED.teachers}
    honest, wrong, paid, placebo, silent = teachers.values()
    for each in (honest, wrong):
        said = [row for row in each if row["rating"] is not None]
        assert len(said) > len(each) / 2
        agreed = sum(row["rating"] == row["true_rating"] for row in said) / len(said)
        assert agreed == (1 if each is honest else 0)
        assert all(atom["holds"] is (each is honest) for row in said for atom in row["said"])
    assert all(row["stated_reward"] == row["reward"] and row["rating"] is None for row in paid)
    assert not any(row["said"] or row["rating"] is not None for row in (*placebo, *silent))
    assert all((row["regret"] < 1e-9) == (row["true_rating"] == 1) for row in rows)


@pytest.mark.parametrize("length", [0, 2])
def test_preferences_are_the_teachers_beside_the_truth(rated, tmp_path, length):
    pairs = written(rated, tmp_path, f"preferences(length={length}, same_world={length == 0})")
    assert {pair["teacher"] for pair in pairs} == {*RATED.teachers[:2]}  # the others rated nothing by praise and blame
    honest, wrong = ([pair for pair in pairs if pair["teacher"] == teacher] for teacher in RATED.teachers[:2])
    for pair in pairs:
        one, other = pair["first"], pair["second"]
        assert (one["key"], one["first_turn"]) != (other["key"], other["first_turn"])
        if length == 0:
            assert one["seed"] == other["seed"]
        for each in (one, other):
            assert len(each["obs"]) == len(each["acts"]) + 1 == len(each["rews"]) + 1 == len(each["ratings"]) + 1
            assert not length or len(each["acts"]) == length
            turns = rated.turns(each["key"])
            assert each["acts"] == [t["action"] for t in turns[each["first_turn"] :]][: len(each["acts"])]
            assert each["obs"][0] == turns[each["first_turn"] - 1]["observation"]
            assert each["regret"] == pytest.approx(sum(each["regrets"]))
        assert pair["true_label"] == (
            0.5 if one["regret"] == other["regret"] else float(one["regret"] < other["regret"])
        )
        assert pair["agrees"] == (pair["label"] == pair["true_label"])
    keys = [(each["key"], each["first_turn"]) for pair in pairs for each in (pair["first"], pair["second"])]
    assert len(keys) == len(set(keys))
    decided = [[pair for pair in of if 0.5 not in (pair["label"], pair["true_label"])] for of in (honest, wrong)]
    shares = [sum(pair["agrees"] for pair in each) / len(each) for each in decided]
    assert shares[0] > 0.9  # not 1: a verdict does not say how much an action lost
    assert shares[1] < 0.1
    assert written(rated, tmp_path, f"preferences(length={length}, same_world={length == 0})") == pairs


def test_preferences_by_stated_rewards(rated, tmp_path):
    pairs = written(rated, tmp_path, "preferences(by='rewards')")
    assert {pair["teacher"] for pair in pairs} == {"only(kinds='r')"}
    for pair in pairs:
        assert pair["first"]["score"] == pytest.approx(sum(pair["first"]["rews"]))


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("preferences(length=-1)", "length must be a number of turns, or 0 for whole episodes, got -1"),
        ("preferences(by='x')", "unknown value of by 'x'; allowed: verdicts, rewards"),
        ("preferences(same_world=1)", "same_world must be True or False, got 1"),
        ("preferences(seed='a')", "seed must be an integer, got 'a'"),
        ("ratings(x=1)", "format 'ratings': unknown parameter 'x'"),
    ],
)
def test_options_of_preferences_are_checked(rated, tmp_path, spec, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        write_export(rated, tmp_path / "rows.jsonl", spec)
