"""The first sentence of a report: on twenty studies with a known answer."""

import csv
import io
import re
from dataclasses import replace
from urllib.parse import unquote

import numpy as np
import pytest
from planted import BANDIT, GRID, NO, OPEN, OWN, STUDIES, YES, Grudge, Planted, one
from studying import filled

from llf_teacher.studies.definition.custom_specs import teacher_spec
from llf_teacher.studies.definition.study import Study, load_study, to_toml
from llf_teacher.studies.report import findings, render
from llf_teacher.studies.report.answers import answers
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.page import _counted
from llf_teacher.studies.report.parts.findings import _labels, _plots, ranked
from llf_teacher.studies.report.plots import folded
from llf_teacher.studies.store import Store
from teachers.personalities.mistake import mistake

WORDS = {YES: "Is this evidence of a difference? Yes", NO: "evidence of a difference? No:", OPEN: "Not decided"}


@pytest.mark.parametrize("planted", STUDIES, ids=lambda each: each.name.replace(" ", "-"))
def test_the_first_sentence_is_right(tmp_path, planted):
    study = planted.made()
    records = planted.records(study)
    with Store(filled(tmp_path / "s.db", records)) as store:
        data = read(store, study)
        said = answers(data)
        for label, answer in zip(planted.labels, said, strict=False):
            compared = answer.about.compared
            assert (compared.teacher, compared.other, compared.student) == (*label.pair, label.student), answer.text
            assert answer.finding.evidence == label.evidence, answer.text
            assert WORDS[label.evidence] in answer.text
            one, other, student = map(data.called, (*label.pair, label.student))
            if label.costlier:
                way = "more" if label.costlier == label.pair[0] else "less"
                assert f"{student} loses {way} with {one} than with {other}" in answer.text
            else:
                assert not re.search(r"loses (more|less) with [^ ]+ than", answer.text)
            assert answer.about.ratio == label.ratio == ("score " in answer.text.replace("no score", ""))
            if planted.name == "small but clear":
                assert "Yes, of a small one: the data exclude that one costs 22 % more than the other." in answer.text
            if label.mixed:
                assert "It depends on the family" in answer.text
            seeds = len({record.spec.seed for record in records})
            assert f"n = {seeds} seed" in answer.text
            regrets = [
                np.mean(
                    [r.episode.regret for r in records if (r.spec.teacher, r.spec.student) == (teacher, label.student)]
                )
                for teacher in label.pair
            ]
            if len(study.ids) == 1:
                assert f"({regrets[0]:.{digits(regrets)}f} against {regrets[1]:.{digits(regrets)}f})" in answer.text
        assert len(said) >= len(planted.labels)
        assert findings(data)[0].startswith(said[0].text[:60])


def digits(regrets):
    return 1 if max(regrets) >= 10 and abs(regrets[0] - regrets[1]) >= 0.1 else 2


def planted_study(name):
    return next(each for each in STUDIES if each.name == name)


def written(tmp_path, planted, **changes):
    """The study, and its page."""
    study = replace(planted.made(), **changes)
    with Store(filled(tmp_path / "s.db", planted.records(study))) as store:
        return study, render(store, study)


def data_of(html, figure):
    """The rows behind a figure."""
    address = re.search(rf'download="{figure}.csv" href="data:text/csv;charset=utf-8,([^"]*)"', html)[1]
    return list(csv.DictReader(io.StringIO(unquote(address.replace("&#39;", "'").replace("&amp;", "&")))))


def test_beside_a_teacher_without_regret_differences_tell_teachers_apart(tmp_path):
    """Every one of these teachers has a score of -1."""
    _, html = written(tmp_path, planted_study("baseline without regret"))
    assert 'id="findings-scores"' not in html
    assert 'id="overall"' not in html
    assert "3 comparisons have no score: a share of a regret that is about 0 says nothing." in html
    rows = {row["teacher"]: row for row in data_of(html, "findings-differences")}
    assert list(rows) == ["planted:Grudge(after=2)", "mistake(eps=0.1)", "silent"]
    assert [float(row["more"]) for row in rows.values()] == pytest.approx([0.5, 2.0, 19.8], rel=0.05)
    assert {(row["against"], row["unit"]) for row in rows.values()} == {("oracle", "moves wasted")}


def test_the_question_stands_before_its_answer_and_own_teachers_before_others(tmp_path):
    planted = planted_study("no question is stated: her own teacher comes first")
    _, html = written(tmp_path, planted, question="Does <Grudge> help?")
    assert re.search(
        r"<h1>Feedback study</h1>\s*<p class=\"lead\"><strong>Does &lt;Grudge&gt; help\?</strong> "
        r"obedient loses less with planted:Grudge\(after=2\) than with silent: ",
        html,
    )
    assert html.count("obedient loses less with planted:Grudge(after=2) than with silent: ") == 1
    shown = re.findall(r"<summary><code>([^<]*)</code> teaches", html)
    assert shown == ["planted:Grudge(after=2)", "oracle", "mistake(eps=0.1)", "silent"]
    assert data_of(html, "findings-scores")[0]["teacher"] == "planted:Grudge(after=2)"


def test_an_interval_beyond_the_scale_says_why(tmp_path):
    means = {OWN: 0.5, "silent": 5.0}
    planted = replace(planted_study("better"), means=means, noise=1.2, study={"seeds": 12})
    study = planted.made()
    with Store(filled(tmp_path / "s.db", planted.records(study))) as store:
        (answer,) = answers(read(store, study))
    assert answer.about.score.estimate.high > 1
    assert "(beyond 1, since the interval takes the sum of both mean regrets as known)" in answer.text


def test_a_file_states_its_question(tmp_path):
    study = replace(planted_study("two questions").made(), question="Which?")
    (tmp_path / "s.toml").write_text(to_toml(study))
    assert load_study(tmp_path / "s.toml") == study
    assert study.compare == ((OWN, "oracle"), ("mix", "oracle"))
    spelled = replace(study, teachers=["mistake", "oracle"], compare=[["mistake(eps=0.1)", "oracle"]])
    assert spelled.compare == (("mistake", "oracle"),)
    objects = replace(spelled, teachers=[Grudge(after=3), mistake()], compare=[[Grudge(after=3), mistake()]])
    assert objects.compare == (("planted:Grudge(after=3)", "mistake"),)
    assert replace(spelled, compare=(), primary=[{"teacher": "mistake(eps=0.1)"}], baseline="oracle").primary == (
        {"teacher": "mistake"},
    )


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"question": 3}, "question must be a text, got 3"),
        (
            {"compare": "oracle"},
            "compare must be a list of pairs of teachers, as in .*, got 'oracle'",
        ),
        (
            {"question": "Which?", "compare": ()},
            r"question: no comparison answers it, since there is no teacher 'silent' to compare with; name pairs of "
            r"teachers, as in compare = \[\[.planted:Grudge., .mix.\]\], or another .* in baseline = .planted:Grudge.",
        ),
        ({"compare": [["oracle"]]}, r"compare must be a list of pairs .* got \['oracle'\] among them"),
        ({"compare": [["oracle", "silent"]]}, "compare: unknown teacher 'silent'"),
        ({"compare": [["oracle", {}]]}, "compare: unknown teacher {}"),
        ({"compare": [["oracle", "oracle"]]}, "compare: a teacher cannot be compared with itself, got 'oracle' twice"),
        (
            {"compare": [["mix", "oracle"], ["oracle", "mix"]]},
            "'oracle' and 'mix' are given in both orders",
        ),
        (
            {"primary": [{"teacher": "mix"}]},
            "primary and compare both say which comparisons are primary; leave out one of them",
        ),
    ],
)
def test_a_bad_question_is_refused(changes, match):
    with pytest.raises(ValueError, match=match):
        replace(planted_study("two questions").made(), **changes)


def test_names_show_the_strength_of_teachers_and_traits():
    study = Study(
        ids=["llf-gridworld-v0"],
        teachers=["mistake", "mistake(eps=0.2) | delayed", "only(kinds='hp+hn')", OWN, "oracle | voice(tone='curt')"],
        students=["obedient | stubborn", "q_learning"],
    )
    assert study.named == {
        "mistake": "mistake(eps=0.1)",
        "mistake(eps=0.2) | delayed": "mistake(eps=0.2) | delayed(turns=1)",
        "only(kinds='hp+hn')": "only(kinds='praise+blame')",
        OWN: "planted:Grudge(after=2)",
        "oracle | voice(tone='curt')": "oracle | voice(tone='curt')",
        "obedient | stubborn": "obedient | stubborn(p=0.3)",
        "q_learning": "q_learning",
    }
    for spec in study.teachers:
        assert teacher_spec(study.named[spec]) == spec


def test_no_is_not_said_before_the_last_analysis(tmp_path):
    planted = planted_study("none, many seeds")
    design = {"interim_analyses": {"at": [20, 40]}, "seeds": 40}
    early = replace(planted, study=design, played=lambda spec: spec.seed < 20)
    for each, evidence in ((early, OPEN), (replace(planted, study=design), NO)):
        study = each.made()
        with Store(filled(tmp_path / f"{evidence}.db", each.records(study))) as store:
            (answer,) = answers(read(store, study))
        assert answer.finding.evidence == evidence
    assert "interim analysis" not in answer.text


FAMILIES = ("llf-alfworld-v0", BANDIT, GRID, "llf-reco-movie-v0", "llf-optimization-Booth-v0", "llf-poem-Haiku-v0")


def said(tmp_path, means, changes=None, noise=0.05, **planted):
    """The findings of a study of regrets, of `OWN` against `mix` by default."""
    pair = planted.pop("pair", (OWN, "mix"))
    planted = Planted("", means, one(*pair, evidence=""), changes or {}, noise, **planted)
    study = planted.made()
    with Store(filled(tmp_path / "s.db", planted.records(study))) as store:
        return findings(read(store, study))


def test_a_comparison_with_evidence_of_no_difference_is_not_open(tmp_path):
    first, test, last = said(tmp_path, {OWN: 5.0, "mix": 5.0}, {"seeds": 40})
    assert "No: the data exclude" in first
    assert "in 0 and significantly worse in 0; 1 has evidence of no difference; 0 are not decided." in test
    assert last == "No primary comparison is significant.", "no more seeds are needed, and it is a proof"


def means_of(*families, more=1.0, base=5.0):
    """Regrets in `FAMILIES`: a teacher's own is greater by a factor in some of them."""
    own = {(OWN, id): base * (more if id in families else 1) for id in FAMILIES}
    return own | {("mix", id): base for id in FAMILIES}


def test_a_difference_in_one_family_is_said_to_be_there_only(tmp_path):
    first = said(tmp_path, means_of(GRID, more=1.6), {"ids": FAMILIES, "seeds": 30})[0]
    start = "Over 6 families obedient loses more with planted:Grudge(after=2) than with mix"
    assert first.startswith(f"{start}, by itself significantly in gridworld only: ")


def test_a_difference_in_one_family_is_not_hidden_by_the_others(tmp_path):
    rng = np.random.default_rng(7)
    worse = {OWN: 8.0, "mix": 5.0}

    def regret(spec):
        return rng.normal(worse[spec.teacher] if spec.id == GRID else 5.0, 0.5 if spec.id == GRID else 2.0)

    first = said(tmp_path, worse, {"ids": FAMILIES, "seeds": 20}, regret=regret)[0]
    assert "is not decided" in first or "loses as much" in first
    assert ", but it loses more with planted:Grudge(after=2) in gridworld: " in first


def test_families_of_different_seeds_weigh_the_same(tmp_path):
    means = {(OWN, GRID): 5.0, ("mix", GRID): 5.0, (OWN, BANDIT): 20.0, ("mix", BANDIT): 5.0}
    changes = {"ids": [GRID, BANDIT], "seeds": 30, "fewer": {BANDIT: {"seeds": 6}}}
    first = said(tmp_path, means, changes, noise=0.02)[0]
    score = float(re.search(r"score (\S+) ", first)[1].replace("\N{MINUS SIGN}", "-"))
    assert score == pytest.approx((0 - 15 / 25) / 2, abs=0.02), "the mean over the families, not over their seeds"
    assert "No: the data exclude" not in first
    assert re.search(r"bandits \S+ \[[^;]*\(20.\d against 5.\d\), n = 6\.", first)


def test_a_pair_without_data_is_not_answered_by_another(tmp_path):
    means = {OWN: 5.0, "mix": 6.0, "oracle": 1.0}
    compare = {"compare": [[OWN, "oracle"], ["mix", "oracle"]]}
    first, second, *_ = said(tmp_path, means, compare, played=lambda spec: spec.teacher != OWN)
    assert first == (
        "Nothing can be said about planted:Grudge(after=2) and oracle: no student that reads what teachers say was "
        "taught by both on the same seeds. 40 of 60 episodes have been played."
    )
    assert second.startswith("Whether obedient loses more with mix or with oracle is not decided")


@pytest.mark.parametrize(
    ("changes", "played"),
    [({}, lambda spec: (spec.seed < 10) == (spec.teacher == OWN)), ({"students": ["random"]}, lambda spec: True)],
)
def test_a_question_without_any_data_is_answered_by_why(tmp_path, changes, played):
    (first,) = said(tmp_path, {OWN: 5.0, "mix": 6.0}, changes, played=played)
    assert first.startswith("Nothing can be said about planted:Grudge(after=2) and mix: no student ")
    assert "silent is" not in first, "a baseline that the study does not have"


def test_the_largest_difference_without_scores_is_that_of_regret(tmp_path):
    means = {OWN: 0.5, "oracle": 0.0, "mistake": 2.0, "silent": 19.8}
    texts = said(tmp_path, means, {"baseline": "oracle", "compare": None}, pair=(OWN, "oracle"))
    largest = next(text for text in texts if text.startswith("Largest "))
    assert re.search(r": silent for obedient is worse than oracle \(\+19\.\d \[\S+ \S+ moves wasted", largest)


@pytest.mark.parametrize(
    ("base", "shown"),
    [(1.1e-9, r"\(1\.\S*e\S09 against 2\.\S*e\S09\)"), (1.1e12, r"\(1\.\S*e\+12 against 2\.\S*e\+12\)")],
)
def test_regrets_of_any_size_are_legible(tmp_path, base, shown):
    first = said(tmp_path, {OWN: base, "mix": 2 * base}, noise=0.01)[0]
    assert re.search(shown, first)


def test_one_seed_is_one_seed(tmp_path):
    assert ": 1 seed is too few for any difference" in said(tmp_path, {OWN: 9.0, "mix": 2.0}, {"seeds": 1})[0]


def test_what_was_changed_after_data_is_said(tmp_path):
    planted = Planted("", {OWN: 5.0, "mix": 6.0, "oracle": 1.0}, one(OWN, "mix", evidence=""), {"seeds": 8})
    study = planted.made()
    with Store(filled(tmp_path / "s.db", ())) as store:
        store.define({"study": study.as_dict(), "versions": {}})
        for record in planted.records(study):
            store.add(record)
        texts = {
            name: " ".join(findings(read(store, replace(study, **changes))))
            for name, changes in {
                "nothing": {},
                "added": {"teachers": [*study.teachers, "silent"], "students": [*study.students, "text_only"]},
                "compare": {"compare": [[OWN, "oracle"]]},
                "question": {"question": "Is it better?"},
                "seeds": {"seeds": 6},
                "teachers": {"teachers": [OWN, "mix"]},
            }.items()
        }
    for name, text in texts.items():
        if name in ("nothing", "added"):
            assert "Changed after data" not in text
        else:
            played = {"seeds": 18, "teachers": 16}.get(name, 24)
            assert f"Changed after data. {played} episodes had been played before {name} got the present form." in text


def test_a_student_looks_the_same_in_both_figures_and_rows_say_against_whom(tmp_path):
    """The first comparison has no score with `obedient`, since nothing is lost in bandits."""

    def regret(spec):
        means = {"oracle": 2.0, OWN: 2.1 if spec.student == "obedient" else 5.0, "mix": 6.0}
        nothing = spec.student == "obedient" and spec.id == BANDIT and spec.teacher != "mix"
        return 0.0 if nothing else means[spec.teacher] * (0.9 + 0.01 * spec.seed)

    study = {"ids": [GRID, BANDIT], "students": ["obedient", "text_only"], "teachers": ["oracle", OWN, "mix"]}
    study |= {"compare": [[OWN, "oracle"], [OWN, "mix"]]}
    for baseline in ("silent", "mix"):
        path = tmp_path / baseline
        path.mkdir()
        _, html = written(path, Planted("", {}, (), {**study, "baseline": baseline}, regret=regret))
        start, end = (html.index(f'id="findings-{name}"') for name in ("scores", "differences"))
        for figure in (html[start:end], html[end:]):
            assert re.findall(r">(obedient|text_only)<", figure)[:2] == ["obedient", "text_only"]
        assert not re.search("(against|with) (<code>)?silent", html[start:end]), "the study does not have it"
        assert ("against mix, or the teacher that is named: above 0" in html[start:end]) == (baseline == "mix")


def test_a_long_label_breaks_between_kinds():
    assert folded("only(kinds='reward+praise+blame')") == "only(kinds='reward+praise+\nblame')"
    assert folded("mistake(eps=0.3) against delayed(turns=2)") == "mistake(eps=0.3) against\ndelayed(turns=2)"


def with_claims(records, counts):
    """The records with numbers of distorted and of truthful claims, by teacher and id."""
    for record in records:
        distorted, truthful = counts[record.spec.teacher, record.spec.id]
        claims = {"distorted": distorted, "truthful": truthful, "claims": distorted + truthful, "unchecked": 0}
        yield record._replace(episode=record.episode._replace(**claims))


def test_an_answer_says_where_one_side_said_nothing_of_its_kind(tmp_path):
    """A teacher may be called a liar and never lie in one family: its name alone would mislead."""
    means = {(OWN, GRID): 0.5, ("mix", GRID): 4.0, (OWN, BANDIT): 4.0, ("mix", BANDIT): 4.0}
    planted = Planted("", means, one(OWN, "mix", evidence=""), {"ids": [GRID, BANDIT]})
    study = planted.made()
    counts = {(OWN, GRID): (0, 5), ("mix", GRID): (6, 6), (OWN, BANDIT): (6, 30), ("mix", BANDIT): (6, 3)}
    with Store(filled(tmp_path / "s.db", with_claims(planted.records(study), counts))) as store:
        data = read(store, study)
        (answer,) = answers(data)
        html = render(store, study)
    assert answer.text.endswith(
        " Said in an episode: false claims 0.0 against 6.0 in gridworld; true and timely claims 30.0 against 3.0 in "
        "bandits."
    )
    table = html[html.index('<section id="accounting"') :]
    rows = re.findall(r'<th scope="row"><code>([^<]*)</code></th><td>(\w+)</td>', table[: table.index("</section>")])
    assert rows == [(name, family) for family in ("bandits", "gridworld") for name in (f"{OWN}(after=2)", "mix")]


def test_of_many_families_an_answer_says_the_mean_of_what_was_said(tmp_path):
    ids = [GRID, BANDIT, "llf-reco-movie-v0"]
    means = {(name, id): 4.0 for name in (OWN, "mix") for id in ids}
    planted = Planted("", means, one(OWN, "mix", evidence=""), {"ids": ids})
    study = planted.made()
    counts = {(OWN, GRID): (0, 5), (OWN, BANDIT): (1, 5), (OWN, ids[2]): (2, 5)} | {("mix", id): (6, 5) for id in ids}
    with Store(filled(tmp_path / "s.db", with_claims(planted.records(study), counts))) as store:
        (answer,) = answers(read(store, study))
    assert answer.text.endswith(" Said in an episode: false claims 1.0 against 6.0 on average in 3 of 3 families.")


def test_against_a_silent_teacher_nothing_is_said_about_claims(tmp_path):
    planted = Planted("", {OWN: 4.0, "silent": 8.0}, one(OWN, "silent", evidence=""))
    study = planted.made()
    counts = {(OWN, GRID): (0, 5), ("silent", GRID): (0, 0)}
    with Store(filled(tmp_path / "s.db", with_claims(planted.records(study), counts))) as store:
        (answer,) = answers(read(store, study))
    assert "Said in an episode" not in answer.text


@pytest.mark.parametrize(("truthful", "surprising"), [((20, 20), False), ((10, 20), True), ((20, 10), False)])
def test_equal_words_are_no_surprise(tmp_path, truthful, surprising):
    planted = Planted("", {OWN: 4.0, "mix": 8.0}, one(OWN, "mix", evidence=""))
    study = planted.made()
    counts = {(OWN, GRID): (1, truthful[0]), ("mix", GRID): (1, truthful[1])}
    with Store(filled(tmp_path / "s.db", with_claims(planted.records(study), counts))) as store:
        texts = " ".join(findings(read(store, study)))
    assert ("Largest contradiction" in texts) == surprising
    assert ("No contradiction" in texts) == (not surprising)


def test_evidence_without_an_interval_names_its_test(tmp_path):
    means = {(OWN, GRID): 0.0, ("mix", GRID): 4.0, (OWN, BANDIT): 4.0, ("mix", BANDIT): 4.0}

    def regret(spec):
        base = means[spec.teacher, spec.id]
        return base * (1 + (spec.seed % 10 == 0) * 10 * (spec.id == GRID))

    planted = Planted("", means, one(OWN, "mix", evidence=""), {"ids": [GRID, BANDIT]}, regret=regret)
    study = planted.made()
    with Store(filled(tmp_path / "s.db", planted.records(study))) as store:
        (answer,) = answers(read(store, study))
    assert "score 0.50 (no interval: " in answer.text
    share = "score by family: gridworld 1.00, bandits 0.00"
    assert f"? Yes, by p alone: the sign-flip test needs no interval; {share}." in answer.text


def test_rows_and_colours_keep_the_order_of_the_study(tmp_path):
    """More seeds may change which teacher is best, and which student comes first."""
    orders = []
    for number, (good, bad) in enumerate(((2.0, 6.0), (6.0, 2.0))):
        means = {"oracle": good, "mix": bad, "mistake": 4.0, "silent": 9.0}
        students = ["text_only", "obedient"]
        planted = Planted("", means, one("mix", "mistake", evidence=""), {"students": students, "baseline": "silent"})
        study = planted.made()
        with Store(filled(tmp_path / f"{number}.db", planted.records(study))) as store:
            data = read(store, study)
        plot = next(plot for plot in _plots(data) if plot.name == "findings-scores")
        orders.append((list(dict.fromkeys(row[:2] for row in plot.rows)), _labels(data, ranked(data))[1]))
    assert orders[0] == orders[1]
    assert [row[0] for row in orders[0][0]] == ["mix", "oracle", "mix", "mistake(eps=0.1)"]
    assert orders[0][1] == ["text_only", "obedient"]


def test_compared_teachers_are_drawn_and_named_among_many(tmp_path):
    means = {f"mistake(eps=0.{n})": float(n) for n in range(2, 10)} | {OWN: 4.2, "silent": 9.0}
    pair = ("mistake(eps=0.5)", "mistake(eps=0.4)")
    planted = Planted("", means, one(*pair, evidence=""), {"baseline": "silent"})
    study = planted.made()
    with Store(filled(tmp_path / "s.db", planted.records(study))) as store:
        data = read(store, study)
    (section,) = data.sections
    assert {*pair, OWN, "silent"} <= {*section.drawn}
    assert len(section.drawn) == 6
    assert list(section.drawn) == [each for each in study.teachers if each in section.drawn]


def test_values_without_an_interval_do_not_look_like_one():
    assert _counted([0.13, 0.2, 0.3, 0.4, 0.5, 1.05], 2) == "seeds range from 0.13 to 1.05"


def test_sentences_of_a_caption_are_apart(tmp_path):
    means = {OWN: 0.5, "mix": 4.0, "silent": 5.0}
    planted = replace(planted_study("better"), labels=one(OWN, "mix", evidence=""), means=means, noise=1.2)
    _, html = written(tmp_path, planted, seeds=12)
    assert "how much the differences vary between seeds. 2 comparisons of 3 are not primary" in html


def test_the_manifest_shows_all_parameters_beside_a_given_name(tmp_path):
    _, html = written(tmp_path, planted_study("better"), names={OWN: "the grudge"})
    rows = re.findall(r'<th scope="row"><code>([^<]*)</code> <span class="quiet">called ([^<]*)<', html)
    assert rows == [(f"{OWN}(after=2)", "the grudge")]
