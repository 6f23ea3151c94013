"""What a report says of students that ask models, and what it calls them."""

import itertools
import re

import matplotlib
import numpy as np
import pytest

from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.studies import load
from llf_teacher.studies.analysis.statistics import Band, Estimate
from llf_teacher.studies.definition.names import short_names
from llf_teacher.studies.definition.study import Study, load_study, to_toml
from llf_teacher.studies.execution.runner import RunOptions, play_missing
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.page import page
from llf_teacher.studies.report.plots import STYLE, curve_plot, dot_plot
from llf_teacher.studies.store import Store

ONE = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle", "silent"], "seeds": 2, "max_turns": 3}


def model(request):
    """Answers `no` to a third of the questions, at length to another."""
    turn = len(request["messages"]) // 2
    finish, said = ("length", "so?") if turn == 2 else ("stop", "<think>I go <west>.</think>Response: west")
    return Reply(body=completion(said, request, finish=finish))


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    path = tmp_path_factory.mktemp("models") / "s.db"
    with ScriptedEndpoint(model) as server, Store(path) as store:
        cheap = f"llm(model='small', base_url='{server.url}', answer='text', input_price=0.0, output_price=1000.0)"
        study = Study(
            students=[cheap, f"llm(model='large', base_url='{server.url}', answer='text')", "obedient"],
            names={cheap: "The cheap one"},
            **ONE,
        )
        play_missing(study, store, options=RunOptions("here"))
        rows = list(store.rows())
        return study, rows, page(read(store, study)), path


def cells(html, student):
    part = html[html.index('id="models"') :]
    row = re.search(rf"<code>{re.escape(student)}</code></th>(.*?)</tr>", part, re.DOTALL)[1]
    return [re.sub(r"\s+", " ", each).strip() for each in re.findall(r"<td[^>]*>(.*?)</td>", row, re.DOTALL)]


def test_each_student_has_its_failures_tokens_money_and_latency(told):
    _, rows, html, _ = told
    mine = [row for row in rows if "small" in row["student"]]
    answers, failures = (sum(row[name] for row in mine) for name in ("answers", "parse_failures"))
    assert failures == sum(row["truncated"] for row in mine) > 0
    found = cells(html, "The cheap one")
    assert found[:3] == [f"{answers}", f"{failures} ({100 * failures / answers:.1f}&nbsp;%) ✗ many", f"{failures}"]
    assert found[3:6] == [
        f"{sum(row['input_tokens'] for row in mine)}",
        f"{sum(row['output_tokens'] for row in mine)}",
        f"{sum(row['usd'] for row in mine):.4f}",
    ]
    assert found[6] == f"{sum(row['seconds'] for row in mine) / answers:.2f}"
    assert cells(html, "llm(large)")[5] == "unknown"
    assert "<code>obedient</code>" not in html[html.index('id="models"') : html.index('id="manifest"')]


def test_a_report_without_models_has_no_such_part(told):
    *_, path = told
    with Store(path) as store:
        assert 'id="models"' not in page(read(store, Study(students=["obedient"], **ONE)))


def test_thoughts_are_in_the_transcripts(told):
    _, rows, html, path = told
    assert "<summary>Thought</summary><pre>I go &lt;west&gt;.</pre>" in html
    assert "The answer was cut for its length." in html
    key = next(row["key"] for row in rows if "small" in row["student"])
    assert "\n    thinks: I go <west>.\n[1] student: west" in load(path).transcript(key)


def test_specs_stand_in_the_manifest_alone(told):
    _, _, html, _ = told
    for name in ("The cheap one", "llm(large)"):
        assert name in html[: html.index('id="manifest"')]
    assert "base_url" not in re.sub(r'href="data:[^"]*"', "", html[: html.index('id="manifest"')])
    assert "called The cheap one" in html


def test_names_are_in_the_studys_file(told, tmp_path):
    study, *_ = told
    (tmp_path / "s.toml").write_text(to_toml(study))
    assert load_study(tmp_path / "s.toml") == study
    assert study.named[study.students[0]] == "The cheap one"


@pytest.mark.parametrize(
    ("names", "match"),
    [
        ({"obedeint": "B"}, "names: unknown teacher or student 'obedeint'; did you mean obedient"),
        ({"obedient": ""}, "a name must be a text of 1 to 60 printable characters, got ''"),
        ({"obedient": "silent"}, "a name must be unique, got 'silent' several times"),
        ({"obedient": "A", "silent": "A"}, "a name must be unique, got 'A' several times"),
        (["obedient"], "names must be a table"),
    ],
)
def test_names_that_are_none(names, match):
    with pytest.raises(ValueError, match=match):
        Study(students=["obedient"], names=names, **ONE)


def test_students_of_one_model_are_told_apart():
    url = "http://localhost:1/v1"
    specs = [
        f"llm(model='m', base_url='{url}'{more})"
        for more in (", answer='text'", ", answer='text', temperature=0.5", ", answer='json'")
    ]
    study = Study(students=[*specs, f"llm(model='n', base_url='{url}')", "obedient(forget=False)"], **ONE)
    assert [study.named[spec] for spec in study.students] == [
        "llm(m, temperature=0.0, answer='text')",
        "llm(m, temperature=0.5, answer='text')",
        "llm(m, temperature=0.0, answer='json')",
        "llm(n)",
        "obedient(forget=False)",
    ]
    assert short_names({}, {}) == {}


def test_labels_never_meet():
    """Every label is as high as its lines, however long it is."""
    rows = [f"worked_example(n={i}) | " * 5 for i in range(4)]
    one = Estimate(0.5, 0.4, 0.6, 3)
    pairs = {(row, "s"): one for row in rows}
    with matplotlib.rc_context(STYLE):
        figure = dot_plot(rows, ["s"], pairs, pairs, "moves")
        figure.draw_without_rendering()
        labels = figure.axes[0].get_yticklabels()
        boxes = sorted((label.get_window_extent() for label in labels), key=lambda box: box.y0)
    assert all("\n" in label.get_text() for label in labels)
    assert all(below.y1 <= above.y0 for below, above in itertools.pairwise(boxes))


def test_negated_rewards_are_drawn_below_zero():
    ends = {}
    with matplotlib.rc_context(STYLE):
        for sign in (1, -1):
            mean = sign * np.array([2.0, 4.0, 8.0])
            (ax,) = curve_plot({"p": {"t": Band(mean, mean, mean)}}, ["t"], "reward").axes
            ends[sign] = ax.get_ylim()
    assert ends[1][0] == 0
    assert ends[1][1] >= 8
    assert ends[-1][0] <= -8
    assert ends[-1][1] >= -2


def test_titles_never_meet():
    """Of panels side by side, whatever students are called."""
    band = Band(*(np.linspace(0, 1, 5),) * 3)
    panels = {
        f"llm(model='a-name-that-is-long-{i}', temperature=0.5, answer='json') (reads words)": {"t": band}
        for i in range(3)
    }
    with matplotlib.rc_context(STYLE):
        figure = curve_plot(panels, ["t"], "moves")
        figure.draw_without_rendering()
        boxes = [ax._left_title.get_window_extent() for ax in figure.axes if ax.get_title(loc="left")]
    assert len(boxes) == 3
    assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))
    assert all(box.x1 <= figure.bbox.x1 for box in boxes)
