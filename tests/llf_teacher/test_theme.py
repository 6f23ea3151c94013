"""What all that people look at has in common: colours, sizes, words, and a sentence with its verdict."""

import itertools
import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.text import Text
from studying import stored

from llf_teacher import make, theme
from llf_teacher.registry import family
from llf_teacher.studies.analysis.statistics import Band, Estimate
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.report import render
from llf_teacher.studies.report.plots import MOST, NARROW, STYLE, WIDTH, curve_plot, dot_plot, profile_plot, spread
from llf_teacher.studies.store import Store
from llf_teacher.theme import SHADES
from llf_teacher.tools.pages import family_page
from pz_envs.frames import HEIGHT
from pz_envs.frames import WIDTH as FRAME
from teachers.atoms import KINDS
from teachers.words import KIND_COLOURS, KIND_WORDS, VERDICTS, coded_words, feedback_words, type_words
from worlds.pictures.testing import Proof
from worlds.pictures.themes import SERIES, SIZES, SPACES, THEMES, contrast

WEB = Path(theme.__file__).parents[1] / "web" / "static" / "web.css"
CODE = re.compile(r"\b(?:hp|hn|fp|fn)\b")
STUDY = Study(
    ids=("llf-gridworld-v0",),
    teachers=("oracle", "mistake(eps=0.5)", "silent"),
    students=("obedient", "text_only"),
    feedback_types=("a", "r+hp"),
    seeds=3,
    max_turns=6,
)


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    path = stored(tmp_path_factory.mktemp("theme") / "s.db", STUDY)
    return render(Store(path), STUDY)


def test_text_is_legible():
    """Contrasts of WCAG 2's level AA on every ground on which text stands, of pages and of pictures."""
    for mode in range(2):
        text = {name: SHADES[name][mode] for name in ("ink", "muted", "link", "good", "bad")}
        for ground in ("page", "stripe"):
            assert all(contrast(colour, SHADES[ground][mode]) >= 4.5 for colour in text.values()), (ground, text)
        assert contrast(SHADES["ink"][mode], SHADES["notice"][mode]) >= 4.5
        assert all(contrast(SHADES["on"][mode], SHADES[f"kind-{kind}"][mode]) >= 4.5 for kind in (*KINDS, "none"))
        assert contrast(SHADES["on"][mode], SHADES["link"][mode]) >= 4.5
    for colours in THEMES.values():
        for name in ("ink", "muted", "blue", "green", "orange", "red", "purple"):
            for ground in (colours.ground, colours.card):
                assert contrast(getattr(colours, name), ground) >= 4.5, (name, ground)


def test_series_differ_in_grey():
    """Any two are apart by a quarter in luminance, and each stands out from its page."""
    for mode, series in enumerate(SERIES.values()):
        assert len(series) == MOST == 6
        assert all(contrast(one, other) >= 1.25 for one, other in itertools.combinations(series, 2))
        assert all(contrast(each, SHADES["page"][mode]) >= 3 for each in series)


def test_styles_keep_to_the_scale():
    """No size of type and no space in the styles is a number of its own."""
    for css in (theme.style().partition("* {")[2], WEB.read_text()):
        sizes = re.findall(r"font-size: ([^;}]*)", css.partition("@media print")[0])
        assert {size.strip() for size in sizes} <= {*(f"var(--{name})" for name in SIZES), ".88em", "1em"}
        spaces = re.findall(r"(?<!scroll-)(?:margin|padding|gap)[\w-]*: ([^;}]*)", css)
        assert spaces
        assert not re.findall(r"\d*\.?\d+r?em", " ".join(spaces))
    rooms = {f"--space-{i}: {space}rem" for i, space in enumerate(SPACES, 1)}
    assert rooms <= set(re.findall(r"--space[^;]*", theme.style()))


def test_kinds_have_the_same_words_and_colours_everywhere(html):
    """In a report, on a family's page, and in a film, whose marks are drawn with the same names of colours."""
    page = family_page(family("gridworld"))
    for kind in KINDS:
        assert kind == "r" or theme.kind_mark(kind) in page
        assert f">{KIND_WORDS[kind]}</abbr>" in theme.kind_mark(kind)
        assert [*SHADES[f"kind-{kind}"]] == [getattr(each, KIND_COLOURS[kind]) for each in THEMES.values()]
    for kind in ("r", "hp", "hn", "fp", "fn", None):
        assert theme.kind_mark(kind) in html
    assert html.count('</abbr>\n<span class="words">') > 20


def test_people_read_words_and_not_codes(html):
    """Codes stand only in brackets behind their words, where files have them, and in titles."""
    told = html[: html.index('id="manifest"')]
    told = re.sub(r"<style.*?</style>|<[^>]*>", " ", told, flags=re.DOTALL)
    assert CODE.findall(re.sub(r"\((?:hp|hn|fp|fn)\)", "", told)) == []
    assert "feedback: reward, praise" in told
    assert "gridworld (basic, all kinds)" in " ".join(told.split())


def test_types_have_words():
    assert feedback_words("a") == "all kinds"
    assert feedback_words("r+fn") == "reward, warning"
    assert type_words("p", "n") == "with practice, none"
    assert coded_words(("b", "c")) == "basic (b), complete (c)"
    assert coded_words(["r", "fn"]) == "reward (r), warning (fn)"
    assert {f"{verdict}"[0] for verdict in VERDICTS.values()} == {"✓", "✗", "~"}


def test_no_heading_is_empty(tmp_path):
    """Of the smallest study, and of one with a silent teacher: each heading has words, and something below it."""
    for teacher in ("oracle", "silent"):
        study = Study(ids=STUDY.ids, teachers=(teacher,), students=("obedient",), seeds=1, max_turns=2)
        page = render(Store(stored(tmp_path / f"{teacher}.db", study)), study)
        body = re.sub(r"<(script|style).*?</\1>", "", page, flags=re.DOTALL)
        pieces = re.split(r"(<h[123][^>]*>.*?</h[123]>)", body, flags=re.DOTALL)
        assert len(pieces) > 9
        for head, below in zip(pieces[1::2], pieces[2::2], strict=True):
            assert re.sub("<[^>]*>", "", head).strip()
            assert re.sub("<[^>]*>", "", below).strip(), head


def band(rng, turns=12):
    mean = np.cumsum(rng.random(turns))
    return Band(mean, mean - 0.2, mean + 0.2)


@pytest.mark.parametrize("width", [WIDTH, NARROW])
def test_at_most_six_lines_have_a_colour_and_their_names_do_not_meet(width):
    rng = np.random.default_rng(3)
    names = [f"mistake(eps={i / 10})" for i in range(9)]
    bands = {name: band(rng) for name in names}
    profiles = {name: (np.linspace(-1, 1, 12).tolist(), Band(*(np.linspace(1, 0, 12),) * 3)) for name in names}
    with matplotlib.rc_context(STYLE):
        panels = {"a student": bands, "another": dict.fromkeys(names, bands[names[0]])}
        for figure in (curve_plot(panels, names[:6], "moves", width), profile_plot(profiles, width)):
            assert not figure.legends
            check_lines(figure)
            check_labels(figure)
        ends = curve_plot(panels, names[:6], "moves", width).axes[1].texts
    assert [each.get_text() for each in ends] == ["all teachers alike"]


def check_lines(figure):
    grey = {SHADES[name].light for name in ("muted", "ink")}
    for ax in figure.axes:
        coloured = [line for line in ax.lines if line.get_color() not in grey or line.get_marker() != "None"]
        assert len(coloured) <= MOST
        assert len({line.get_color() for line in coloured}) == len(coloured)


def check_labels(figure: Figure):
    figure.draw_without_rendering()
    for ax in figure.axes:
        boxes = [Text.get_window_extent(label) for label in ax.texts]  # without the lines that join them
        assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))
        assert all(box.x0 >= 0 and box.x1 <= figure.bbox.x1 for box in boxes)


def test_of_many_students_each_six_have_a_plot():
    students = [f"student {i}" for i in range(8)]
    found = {("oracle", student): Estimate(0.5, 0.4, 0.6, 3) for student in students}
    with matplotlib.rc_context(STYLE):
        figure = dot_plot(["oracle"], students, found, found, "moves")
    counts = [len({line.get_color() for line in ax.lines}) for ax in figure.axes]
    assert counts == [6, 6, 2, 2]


@given(st.lists(st.floats(0, 100), min_size=1, max_size=6).map(sorted), st.floats(60, 200))
def test_labels_are_spread(wanted, room):
    places = spread(wanted, [10.0] * len(wanted), room)
    assert all(below + 10 <= above + 1e-6 for below, above in itertools.pairwise(places))
    assert places[0] >= 5 - 1e-6
    assert places[-1] <= max(room, 10 * len(wanted)) - 5 + 1e-6


def test_a_film_names_kinds_as_a_page_does():
    """The words on a frame are those of the table."""
    written = []
    env = make(STUDY.ids[0], render_mode="rgb_array", privileged_info=True, teacher="mistake(eps=0.5)")
    env.reset(seed=2)
    for _ in range(6):
        env.step(1)
        canvas = Proof(FRAME, HEIGHT, THEMES["light"])
        env.student_view.renderer.draw(canvas, env.student_view.description())
        written += [each.text for each in canvas._written]
    assert {KIND_WORDS[kind] for kind in KINDS if kind != "hp"} <= set(written)
    assert not any(CODE.fullmatch(text) for text in written)
    assert {"true", "false"} <= set(written)
