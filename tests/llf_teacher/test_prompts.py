"""What models were asked is kept, shown and exported as it was sent."""

import json

import pytest
from commands import llf
from pyarrow import parquet
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.episodes.record import ASKED, pack_turns, unpack_turns
from llf_teacher.models.asked import as_asked, lines_of
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies import Results
from llf_teacher.studies.analysis.costs import cost_lines
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.export import write_export
from llf_teacher.studies.store import Store

pytestmark = pytest.mark.usefixtures("no_settings")
GRID = "llf-gridworld-v0"
TURNS = 5


def model():
    """As the teacher says the advice that it is shown; as the student walks, and its third answer is no action."""
    asked = []

    def answer(request):
        system, last = request["messages"][0]["content"], request["messages"][-1]["content"]
        if system.startswith("You teach"):
            return json.dumps({"claims": [json.loads(line) for line in last.splitlines() if '"Go"' in line]})
        asked.append(request)
        action = ("north", "west")[len(asked) % 2]
        if len(asked) == 3:
            return "no idea"
        return f"Response: {action}" if "Response:" in system else json.dumps({"thought": last[:9], "action": action})

    return answer


def student(url, **options):
    return f"llm(model='s', base_url='{url}', {', '.join(f'{name}={value!r}' for name, value in options.items())})"


def teacher(url):
    return f"llm_teacher(model='t', base_url='{url}', answer='json')"


def sent(server, name):
    return [request for request in server.requests if request["model"] == name]


@pytest.fixture(params=["json", "tool", "text"])
def played(request, tmp_path):
    """A store with an episode of a model in each form, the requests to it, and the form."""
    with ScriptedEndpoint(model()) as server, Store(tmp_path / "s.db") as store:
        (spec,) = Study(
            ids=[GRID], teachers=[teacher(server.url)], students=[student(server.url, answer=request.param, history=2)],
            seeds=1, max_turns=TURNS,
        ).episodes()  # fmt: skip
        record = play(spec)
        store.add(record)
    return tmp_path / "s.db", record, server, request.param


def test_a_record_has_what_was_sent(played):
    path, record, server, form = played
    with Results(path) as results:
        turns = results.turns(record.spec.key)
        assert not any(name in row for row in results.all_turns() for name in ASKED), "tables would repeat them"
    assert [turn["asked"]["messages"] for turn in turns[1:]] == [each["messages"] for each in sent(server, "s")]
    asked = [turn["teacher_asked"] for turn in turns if turn["teacher_asked"]]
    assert [each["messages"] for each in asked] == [each["messages"] for each in sent(server, "t")]
    field = {"json": "response_format", "tool": "tools", "text": "stop"}[form]
    assert [turn["asked"]["fields"][field] for turn in turns[1:]] == [each[field] for each in sent(server, "s")]
    assert unpack_turns(pack_turns(record.turns)) == turns


def test_a_table_of_turns_may_have_a_teaching_model(played, tmp_path):
    path, record, *_ = played
    with Results(path) as results:
        assert results.export(tmp_path / "turns.parquet", "turns") == TURNS + 1
    rows = parquet.read_table(tmp_path / "turns.parquet").to_pylist()
    assert [json.loads(row["reply"] or "null") for row in rows] == [turn.reply for turn in record.turns]


def test_images_are_kept_as_digests():
    image = {"type": "image_url", "image_url": {"url": "data:image/png;base64,AAAA"}}
    asked = as_asked([{"role": "user", "content": [{"type": "text", "text": "Your action?"}, image]}])
    assert "AAAA" not in json.dumps(asked)
    ((role, text), _) = lines_of(asked)
    assert (role, text.partition("sha256:")[0]) == ("user", "Your action?\n[image ")


def test_a_transcript_shows_it(played):
    path, _, server, form = played
    without = CliRunner().invoke(app, ["study", "transcript", f"{path}"]).output
    shown = CliRunner().invoke(app, ["study", "transcript", f"{path}", "--prompts"]).output
    assert "was asked" not in without
    assert [line for line in shown.splitlines() if line in without.splitlines()] == without.splitlines()
    assert shown.count("student's model was asked:") == TURNS
    assert shown.count("teacher's model was asked:") == len(sent(server, "t")) == TURNS
    for request in server.requests:
        for message in request["messages"]:
            for line in (message["content"] or "").splitlines():
                assert line.strip() in shown
    assert {"json": "JSON of the schema", "tool": "a call of the tool act with", "text": "a text that ends"}[
        form
    ] in shown


def test_a_transcript_says_what_was_not_kept(tmp_path):
    with ScriptedEndpoint(model()) as server, Store(tmp_path / "s.db") as store:
        lessons = {"ids": [GRID], "seeds": 1, "max_turns": 2}
        (spec,) = Study(teachers=["oracle"], students=[student(server.url, answer="json")], **lessons).episodes()
        record = play(spec)
        store.add(record._replace(turns=tuple(turn._replace(asked=None) for turn in record.turns)))
        (other,) = Study(teachers=["oracle"], students=["random"], **lessons).episodes()
        store.add(play(other))
    with Results(tmp_path / "s.db") as results:
        assert results.transcript(spec.key, prompts=True).count("student's model: the prompt was not kept") == 2
        assert results.transcript(other.key, prompts=True).startswith("Neither student nor teacher asked a model")
        (row,) = rows_of(results, tmp_path, "chat", spec.key)
        assert "Answer with JSON" in row["messages"][0]["content"], "its answers are JSON"
        (row,) = rows_of(results, tmp_path, "chat", other.key)
        assert "Answer with a line: Response: your action" in row["messages"][0]["content"]


def rows_of(results, folder, spec, key):
    write_export(results, folder / "rows.jsonl", spec)
    rows = map(json.loads, (folder / "rows.jsonl").read_text(encoding="utf-8").splitlines())
    return [row for row in rows if row["key"] == key]


def test_exports_have_the_prompts_that_were_asked(played, tmp_path):
    path, record, server, form = played
    asked = [request["messages"] for request in sent(server, "s")]
    with Results(path) as results:
        sft = rows_of(results, tmp_path, "sft", record.spec.key)
        (chat,) = rows_of(results, tmp_path, "chat", record.spec.key)
        hindsight = rows_of(results, tmp_path, "sft(hindsight=True)", record.spec.key)
    assert [row["prompt"] for row in sft] == [asked[row["turn"] - 1] for row in sft]
    assert len(sft) == TURNS - 1
    for row in (*sft, chat):
        assert bool(row.get("tools")) == (form == "tool")
    for row in sft:
        (said,) = row["completion"]
        answer = said["tool_calls"][0]["function"]["arguments"] if form == "tool" else said["content"]
        assert answer == record.turns[row["turn"]].answer
    assert chat["messages"][0] == asked[0][0]
    assert sum(each["role"] == "assistant" for each in chat["messages"]) == TURNS
    questions = [each["content"] for each in chat["messages"] if each["role"] in ("user", "tool")]
    assert [text.count("Your action?") for text in questions] == [1] * TURNS, "each turn once"
    for before, each in zip(chat["messages"], chat["messages"][1:], strict=False):
        if each["role"] == "tool":
            assert each["tool_call_id"] == before["tool_calls"][0]["id"]
    marked = [row for row in hindsight if row["hindsight"]]
    assert marked
    for row in marked:
        assert row["completion"][0]["content"].startswith("Response: ")
        assert "Answer with a line: Response: your action" in row["prompt"][0]["content"]
        assert "JSON" not in row["prompt"][0]["content"]


@pytest.mark.parametrize("seat", ["watch", "teacher"])
def test_a_lesson_shows_it(seat):
    with ScriptedEndpoint(model()) as server:
        own = ("--seat", "teacher") if seat == "teacher" else ("--teacher", teacher(server.url))
        common = (
            "play",
            GRID,
            "--student",
            student(server.url, answer="json"),
            *own,
            "--seed",
            "3",
            "--max-turns",
            "2",
        )
        shown = llf(*common, "--prompts", text="a\n" * 9)
        without = llf(*common, text="a\n" * 9)
    assert shown.returncode == 0, shown.stderr
    assert shown.stdout.count("the student's model was asked:") == 2
    assert shown.stdout.count("the teacher's model was asked:") == (3 if seat == "watch" else 0)
    assert '"thought" says in a few words' in " ".join(shown.stdout.split())
    assert "form of answer:" in shown.stdout
    assert "was asked" not in without.stdout


def test_a_lesson_without_models_says_so():
    done = llf("play", GRID, "--student", "random", "--seed", "3", "--max-turns", "1", "--prompts")
    assert "Neither student nor teacher asked a model, so there are no prompts." in done.stdout
    done = llf("play", GRID, "--prompts")
    assert done.returncode == 2
    assert "--prompts shows what models are asked" in " ".join(done.stderr.split())


@pytest.mark.parametrize(
    ("answer", "said", "counted"),
    [
        ("Go north.", "(without a claim, or words, to say): Go north. not made: an answer must be a JSON object",
         "gave 2 answers: 2 without a claim, or words, to say;"),
        ('{"claims": [{"type": "Warn"}]}', "not made: unknown claim 'Warn'; did you mean Wrong? allowed: Found,",
         "gave 2 answers: none with a fault; 2 claims could not be made;"),
    ],
)  # fmt: skip
def test_a_lesson_says_what_is_wrong_with_an_answer(answer, said, counted):
    with ScriptedEndpoint(lambda request: answer) as server:
        done = llf(
            *("play", GRID, "--student", "random", "--teacher", teacher(server.url), "--seed", "3", "--max-turns", "1")
        )
    words = " ".join(done.stdout.split())
    assert said in words
    assert counted in words


def test_without_a_key_the_only_episode_is_printed_or_the_first_are_listed(tmp_path):
    study = Study(ids=[GRID], teachers=["oracle"], students=["random"], seeds=12, max_turns=2)
    records = [play(spec) for spec in study.episodes()]
    with Store(tmp_path / "s.db") as store:
        store.add(records[0])
    only = CliRunner().invoke(app, ["study", "transcript", f"{tmp_path / 's.db'}"])
    assert only.exit_code == 0
    assert "teacher, instruction: " in only.output
    with Store(tmp_path / "s.db") as store:
        for record in records[1:]:
            store.add(record)
    done = llf("study", "transcript", "s.db", cwd=tmp_path)
    assert done.returncode == 2
    key = records[0].spec.key[:12]
    head, names, first, *rest = done.stderr.splitlines()
    assert head.startswith("llf: s.db has 12 episodes; give the key of one, or how it begins, as in")
    assert f"`llf study transcript s.db {key}`" in head
    assert names.split() == ["key", "id", "teacher", "student", "seed"]
    assert first.split() == [key, GRID, "oracle", "random", "0"]
    assert rest[9:] == ["`llf study export` writes all keys"]
    assert llf("study", "transcript", "s.db", key, cwd=tmp_path).returncode == 0


def test_a_trial_of_the_form_is_named_and_what_this_machine_computes_is_free(tmp_path):
    with ScriptedEndpoint(model()) as server:
        (tmp_path / "s.toml").write_text(
            f'ids = ["{GRID}"]\nteachers = ["oracle"]\nstudents = ["{student(server.url, answer="auto")}"]\nseeds = 1\n'
            "max_turns = 2\n"
        )
        done = llf("study", "s.toml", cwd=tmp_path)
    assert "s: 4 requests paid so far, 2 of them to try the form of answers, " in " ".join(done.stderr.split())
    spent = {"requests": 5, "trials": 1, "input_tokens": 9, "output_tokens": 8, "usd": 0.0, "unpriced": 0}
    with Store(tmp_path / "local.db") as store:
        store.write_manifest({"llm": [{"model": "local:b179", **spent}, {"model": "far", **spent}]})
        here, far = cost_lines(store)
    tried = "1 of them to try the form of answers, 9 tokens in, 8 out"
    assert here == f"local:b179: 5 requests so far, {tried}, on this machine, free of charge"
    assert far == f"far: 5 requests paid so far, {tried}, 0.0000 USD"
