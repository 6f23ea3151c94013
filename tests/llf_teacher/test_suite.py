"""The suite: scores of known losses, cards that are whole, and students that fail."""

import json
import re
from dataclasses import replace
from pathlib import Path
from pkgutil import iter_modules

import numpy as np
import pytest
from commands import llf
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from typer.testing import CliRunner

from llf_teacher import chat_student
from llf_teacher.cli import app
from llf_teacher.registry import entry
from llf_teacher.studies import Study, run
from llf_teacher.studies.analysis.power import least_effect
from llf_teacher.studies.analysis.resampling import sign_flips
from llf_teacher.suite import Card, all_experiments, check, compare, digest, experiments, take, taking
from llf_teacher.suite.answers import AnswerSummary, LessonAnswers
from llf_teacher.suite.card import ABOVE, AbilityLine, CardError, check_file, checksum
from llf_teacher.suite.comparing import _difference
from llf_teacher.suite.environments import ARMS, FILMS, OPTIONS
from llf_teacher.suite.estimate import estimate
from llf_teacher.suite.experiment import ORDER
from llf_teacher.suite.score import Arms, score
from llf_teacher.suite.taking import actions_of, chosen, seeds_of, studies_of

DIGEST = "62844ec6818fff71"


def arms(better, worse, unit_better=0.0, unit_worse=10.0, n=20, noise=1.0, seed=0, **more):
    """Losses with these means."""
    rng = np.random.default_rng(seed)
    drawn = [mean + noise * rng.normal(size=n) for mean in (better, worse, unit_better, unit_worse)]
    return {"here": Arms(*drawn, **more)}


def test_the_digest_is_that_of_the_version():
    """If not, a score means something else: give the suite another version."""
    assert digest() == DIGEST


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FIRST_SEED", 1),
        ("QUICK_SEEDS", 9),
        ("OPTIONS", {}),
        ("TURNS", 13),
        ("FACTS", ()),
        ("LEVELS", (0.1,)),
        ("seeds_of", lambda *_, **__: ()),
    ],
)
def test_what_decides_a_score_is_in_the_digest(monkeypatch, name, value):
    monkeypatch.setattr(taking, name, value)
    assert digest() != DIGEST


def test_every_module_is_an_experiment():
    assert sorted(ORDER) == sorted(each.name for each in iter_modules(experiments.__path__))


@pytest.mark.parametrize("name", all_experiments())
def test_an_experiment_is_complete(name):
    each = all_experiments()[name]
    assert len({entry(id).family.name for id in each.ids}) >= 2
    assert set(each.rests_on) <= set(all_experiments()) - {name}
    seeds = {id: list[int]() for id in each.ids}
    for study in studies_of(["random"], {name: each}):
        for id in study.ids:
            seeds[id] += study.seeds
            played = study.tests(id) if each.lessons else study.grid(id)
            assert set(played.teachers) == {*each.arms, *(each.unit or ())}  # the specs in the store's rows
            assert each.reference in played.students
    assert {tuple(each) for each in seeds.values()} == {seeds_of()[: each.seeds]}


def test_each_world_of_rules_is_in_a_town_of_its_own():
    """Else the law of the one town could be known before the lesson."""
    towns = [
        study.world_options(id)["town"]
        for key in ("", "one")
        for study in studies_of([], {"rules": all_experiments()["rules"]}, seeds_of(key))
        for id in study.ids
    ]
    assert sorted(towns) == sorted(2 * [*seeds_of()[:20], *seeds_of("one")[:20]])


def test_scores_of_known_losses():
    assert score(arms(5, 10)).score == pytest.approx(0.5, abs=0.1)
    assert score(arms(10, 10)).score == pytest.approx(0, abs=0.1)
    assert score(arms(10, 15), margin=0.2).score == pytest.approx(0.5, abs=0.1)  # half of what the lies cost
    assert score(arms(5, 5), margin=0.2).alike
    assert not score(arms(5, 10), margin=0.2).alike
    assert score(arms(5, 10)).p < 0.01


def test_the_interval_has_the_noise_of_the_unit():
    """Over fresh draws it holds the truth about as often as it says, with a unit as noisy as the score."""
    found = [score(arms(5, 10, noise=4.0, seed=seed)) for seed in range(200)]
    held = np.mean([each.low is not None and each.low <= 0.5 <= each.high for each in found])
    assert 0.88 <= held <= 0.99


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (arms(5, 10, unit_worse=0.0), "not even the scripted student gains significantly here"),
        (arms(0.0, 0.5, noise=0.1), "nothing to gain"),
        (arms(5, 10, unread={"any": 0.6, "other": 0.1}), "60% of the answers to any were no actions"),
        (arms(5, 10, unread={"any": 0.6, "other": 0.8}), "70% of the answers were no actions"),
        (arms(5, 10, n=4), "4 seeds are too few"),
        ({"here": Arms(*np.array([[1.0, np.nan], [2, 2], [0, 0], [5, 5]]))}, "1 of 2 seeds failed or were not played"),
    ],
)
def test_what_was_not_measured_says_why(given, why):
    found = score(given)
    assert found.score is None
    assert why in found.why


def test_a_place_that_cannot_be_measured_does_not_count():
    both = arms(5, 10) | {"there": arms(0, 10, unit_worse=0.0)["here"]}
    found = score(both)
    assert list(found.places) == ["here"]
    assert "there: not even the scripted student gains significantly here" in found.why


@pytest.mark.parametrize(
    ("taught", "placebo", "silence", "said"),
    [
        (2, 8, 8, "The student uses blame: 0."),
        (2, 2, 8, "it does better with useless words than in silence: it learns from when the teacher speaks."),
        (5, 9, 5, "it is harmed by useless words rather than helped by the teacher."),
        (8, 8, 8, "No ability was shown significantly."),
    ],
)
def test_an_ability_is_said_of_gains_beside_placebo_and_silence_alone(taught, placebo, silence, said):
    losses = arms(taught, placebo)["here"]
    silent = np.random.default_rng(1).normal(silence, 1.0, 20)
    card = Card.of(
        "it", all_experiments(), {"blame": score({"here": losses._replace(silent=silent)})}, [], [], **SETTINGS
    )
    (line,) = card.lines
    assert line.silence.score == pytest.approx((silence - taught) / 10, abs=0.15)
    assert any(said in each for each in card.sentences())
    assert ("uses blame: " in card.sentences()[0]) == (placebo - taught > 5 < silence)
    assert f"{line.silence.words}, p {line.silence.chance}" in card.as_markdown()


def test_gains_that_are_not_significant_beside_silence_are_said_so():
    losses = arms(5, 7)["here"]
    noisy = losses.better + np.random.default_rng(1).normal(1.0, 9.0, 20)
    card = Card.of(
        "it", all_experiments(), {"blame": score({"here": losses._replace(silent=noisy)})}, [], [], **SETTINGS
    )
    assert "does better than with useless words, but not significantly better than in silence" in card.sentences()[1]


SETTINGS = {"suite": "suite-v1", "digest": "", "key": "", "quick": False}


class Puzzled:
    """An agent that acts by chance, and has no action once it heard a text without a word of the task."""

    text = True

    def reset(self, rng):
        self._rng, self._lost = rng, False

    def act(self, observation, info):
        said = observation["feedback"]
        self._lost |= bool(said) and not re.search(r"arm|north|east|south|west|could not read", said)
        house = "treasure" in observation["instruction"]
        chance = ["north", "east", "south", "west"][self._rng.integers(4)] if house else f"{self._rng.integers(10)}"
        return "Interesting." if self._lost else f"Response: {chance}"


def test_a_student_that_answers_the_placebo_alone_in_prose_is_not_measured(store):
    (line,) = take(Puzzled, store, ["advice"], quick=True, workers=1).lines
    assert line.score is None
    assert re.search(r"\d\d% of the answers to only\(kinds='fp'\) \| placebo were no actions", line.why)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return tmp_path_factory.mktemp("suite") / "suite.db"


def test_the_reference_has_1_and_chance_has_0(store):
    best = take("obedient", store, ["advice", "turncoat"], quick=True, workers=1)
    assert [each.score for each in best.lines] == pytest.approx([1, 0])
    deaf = take("random", store, ["advice", "turncoat"], quick=True, workers=1)
    assert [each.score for each in deaf.lines] == [pytest.approx(0), None]
    assert "it does not gain significantly by the teacher" in deaf.lines[1].why
    assert "takes advice" in best.sentences()[0]


class Believer:
    """An agent that does what it heard last, and pulls the first arm in silence."""

    text = True

    def reset(self, rng):
        """Nothing."""

    def act(self, observation, info):
        heard = re.findall(r"\b(?:north|east|south|west|\d)\b", observation["feedback"].lower())
        return f"Response: {heard[-1] if heard else 0}"


def test_a_believer_that_keeps_nothing_in_silence_does_not_notice_that_a_teacher_turns(store):
    """It loses nothing by lies, as it had nothing left of the truth."""
    card = take(Believer, store, ["advice", "turncoat"], quick=True, workers=1)
    assert card.lines[0].score > 0.9
    assert f"{ARMS}: it does not gain significantly by the teacher" in card.lines[1].why
    assert ARMS not in card.lines[1].places


def test_a_card_is_read_as_it_was_written(store, tmp_path):
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    for suffix in (".json", ".md", ".svg", ".html"):
        card.write(tmp_path / f"card{suffix}")
    assert Card.load(tmp_path / "card.json").as_json() == card.as_json()
    assert check(tmp_path / "card.json").student == "obedient"
    replace(card, digest="0").write(tmp_path / "other.json")
    with pytest.raises(CardError, match="cannot be compared"):
        check(tmp_path / "other.json")
    text = (tmp_path / "card.json").read_text()
    (tmp_path / "card.json").write_text(text.replace('"score": 1.0', '"score": 1.5', 1))
    with pytest.raises(CardError, match="changed after it was written"):
        Card.load(tmp_path / "card.json")
    assert "takes advice" in (tmp_path / "card.html").read_text()
    with pytest.raises(ValueError, match=r"allowed: \.json"):
        card.write(tmp_path / "card.png")
    with pytest.raises(FileNotFoundError, match=r"folder .*none of the card does not exist"):
        card.write(tmp_path / "none" / "card.json")


IN_THE_LINE = [
    ({"low": "a"}, "must be a number, got 'a'"),
    ({"score": True}, "lines[0].score must be a number, got True"),
    ({"score": float("nan")}, "must be from -1e+12 to 1e+12, got nan"),
    ({"high": float("inf")}, "got inf"),
    ({"p": 7}, "p must be from 0 to 1, got 7"),
    ({"moments_p": -0.1}, "from 0 to 1"),
    ({"silence": {}}, "silence: missing or unknown: alike"),
    ({"low": 5.0, "high": -5.0}, "a score in its interval"),
    ({"score": 3.0}, "a score in its interval"),
    ({"low": None}, "a score in its interval"),
    ({"silence": 1.0}, "silence must be an object"),
    ({"seeds": 1}, "by 5 seeds at least"),
    ({"seeds": -3}, "seeds must be from 0"),
    ({"seeds": 10**400}, "seeds must be from 0"),
    ({"finds": -4.0}, "finds must be from 0"),
    ({"places": {"a": "b"}}, "places.a must be a number"),
    ({"alike": "yes"}, "alike must be true or false"),
    ({"why": 5}, "why must be a text"),
    ({"extra": 1}, "missing or unknown: extra"),
    ({"name": "nosuch"}, "unknown line 'nosuch: takes advice'"),
    ({"ability": "walks on water"}, "unknown line 'advice: walks on water'"),
]
IN_THE_CARD = [
    ({"lines": []}, "lines of different names, got none"),
    ({"lines": {}}, "lines must be a list"),
    ({"lines": [None]}, "lines[0] must be an object"),
    ({"cost": {}}, "its cost lacks answers, episodes"),
    ({"cost": {"turns": "x"}}, "cost.turns must be a number"),
    ({"failures": -1}, "failures must be from 0"),
    ({"versions": []}, "versions must be an object"),
    ({"suite": "suite-v0"}, "unknown suite 'suite-v0'"),
    ({"quick": 1}, "quick must be true or false"),
    ({"kee": ""}, "card: missing or unknown: kee"),
]


@pytest.mark.parametrize(("change", "why"), [*IN_THE_LINE, *IN_THE_CARD, ({"lines": 2}, "names, got advice, advice")])
def test_a_card_that_cannot_be_is_refused(tmp_path, store, change, why):
    """Though its checksum fits."""
    values = json.loads(take("obedient", store, ["advice"], quick=True, workers=1).as_json())
    del values["checksum"]
    if change == {"lines": 2}:
        values["lines"] *= 2
    else:
        (values if (change, why) in IN_THE_CARD else values["lines"][0]).update(change)
    (tmp_path / "card.json").write_text(json.dumps(values | {"checksum": checksum(values)}))
    with pytest.raises(CardError, match=re.escape(why)):
        check(tmp_path / "card.json")


def test_a_card_with_a_byte_order_mark_is_read_and_one_without_a_checksum_is_not(tmp_path, store):
    text = take("obedient", store, ["advice"], quick=True, workers=1).as_json()
    (tmp_path / "card.json").write_text(text, encoding="utf-8-sig")
    assert check(tmp_path / "card.json").student == "obedient"
    (tmp_path / "card.json").write_text(text.replace('"checksum"', '"sum"'))
    with pytest.raises(CardError, match="it has no checksum"):
        Card.load(tmp_path / "card.json")
    twice = text.replace('"student"', '"student": "perfect", "student"', 1)  # the checksum is that of the last one
    assert json.loads(twice) == json.loads(text)
    (tmp_path / "card.json").write_text(twice)
    with pytest.raises(CardError, match="each key must occur once"):
        Card.load(tmp_path / "card.json")


def test_a_file_for_the_card_is_checked_before_the_suite_is_played(tmp_path):
    store = tmp_path / "it.db"
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(ValueError, match=r"cannot write the card to .*folder\.json"):
        check_file(tmp_path / "folder.json")
    command = ["suite", "--student", "obedient", "--quick", "--store", f"{store}", "--card", f"{tmp_path / 'card.pdf'}"]
    result = CliRunner().invoke(app, command)
    assert "unknown format of a card '.pdf'" in f"{result.exception}"
    assert not store.exists()


def test_of_own_code_the_command_says_what_it_cannot_know_and_failed_episodes_end_it_with_3(tmp_path):
    (tmp_path / "tired.py").write_text(
        "import numpy\nclass Tired:\n    def act(self, observation):\n        raise ValueError('tired')\n"
    )
    command = ("suite", "--student", "tired:Tired", "--quick", "--only", "advice", "--store", "own.db", "--workers", 1)
    first, second = (llf(*command, cwd=tmp_path) for _ in range(2))
    assert (first.returncode, second.returncode) == (3, 3)
    unseen = "Of tired:Tired, a run does not compare the installed packages numpy"
    assert unseen not in " ".join(first.stderr.split())
    assert unseen in " ".join(second.stderr.split())
    assert "48 episodes failed" in " ".join(second.stdout.split()) + " ".join(second.stderr.split())


def test_a_command_that_measures_nothing_says_why_once_and_ends_with_1(tmp_path):
    (tmp_path / "lost.py").write_text("class Lost:\n    def act(self, observation):\n        return 'north'\n")
    done = llf("suite", "--student", "lost:Lost", "--quick", "--workers", 1, cwd=tmp_path)
    said = " ".join(done.stdout.split())
    assert done.returncode == 1, done.stderr
    assert said.count("100% of the answers were no actions") == 1
    assert said.startswith("advice, hints, silence, turncoat: This could not be measured")
    assert "answered 'north', which is no action here" in said
    assert f"An answer in {ARMS} is the number of an arm, 0 to 9." in " ".join(done.stderr.split())


def test_the_actions_of_every_environment_are_said():
    """As the worlds' own errors say them."""
    assert actions_of(quick=True) == {ARMS: "the number of an arm, 0 to 9"}
    assert {*actions_of()} == {id for each in all_experiments().values() for id in each.ids}
    assert actions_of(["silence"])[FILMS].startswith("a JSON list")


def test_a_student_that_draws_worlds_is_left_out_where_it_cannot(store):
    (line,) = take("reasoner(worlds=4)", store, ["silence"], workers=1).lines
    assert list(line.places) == ["llf-bandits-BanditTenArmedRandomFixed-v0"]
    assert "llf-reco-movie-v0: the student reasoner(worlds=4) needs a family with" in line.why


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    )
)
def test_whatever_a_file_holds_is_no_card(tmp_path_factory, value):
    path = tmp_path_factory.mktemp("card") / "card.json"
    path.write_text(json.dumps(value))
    with pytest.raises(CardError, match="is not a card of the suite"):
        Card.load(path)


class Broken:
    """An agent that fails in some lessons."""

    def reset(self, rng):
        self._turn = 0

    def act(self, observation, info):
        raise RuntimeError("out of order")


def test_an_agent_that_raises_is_not_measured(store):
    with pytest.warns(RuntimeWarning, match="failed"):
        card = take(Broken, store, ["advice"], quick=True, workers=1)
    (line,) = card.lines
    assert line.score is None
    assert "seeds failed or were not played" in line.why
    assert re.fullmatch(r".*out of order.* \(test_suite\.py, line \d+\)", card.error)
    first, rest = card.sentences()
    assert first == "Nothing was measured."
    assert rest.startswith("Only the whole suite asks whether it ")


class Flaky:
    """An agent that fails while its class is out of order, and counts its actions."""

    broken, acts, remembers = True, 0, True

    def reset(self, rng):
        pass

    def act(self, observation, info):
        type(self).acts += 1
        if self.broken and type(self).acts > 20:
            raise RuntimeError("no connection")
        return 0


def test_what_failed_is_played_again_and_nothing_else(tmp_path):
    with pytest.warns(RuntimeWarning, match="failed"):
        first = take(Flaky, tmp_path / "it.db", ["advice"], quick=True, workers=1)
    assert 0 < first.cost["episodes"] < 48
    assert first.cost["episodes"] + first.failures == 48
    Flaky.broken, Flaky.acts = False, 0
    second = take(Flaky, tmp_path / "it.db", ["advice"], quick=True, workers=1)
    assert second.lines[0].score == pytest.approx(0, abs=0.2)
    assert second.failures == 0
    assert Flaky.acts == second.cost["turns"] - first.cost["turns"]


def test_an_agent_that_answers_nonsense_is_not_measured(tmp_path):
    card = take(chat_student(lambda prompt: "I would rather not."), tmp_path / "it.db", ["advice"], True, workers=1)
    assert card.failures == 0
    assert "100% of the answers were no actions" in card.lines[0].why


def test_a_family_that_is_not_installed_does_not_count(store, monkeypatch):
    films = entry(FILMS).family
    monkeypatch.setattr(type(films), "missing", lambda self: "no films here" if self is films else "")
    (line,) = take("obedient", store, ["advice"], quick=True, workers=1).lines
    assert line.score == pytest.approx(1)
    assert len(line.places) == 1
    assert f"{FILMS}: no films here" in line.why


def test_a_student_that_forgets_between_episodes_is_not_measured_there(store):
    forgets, recalls = (take(each, store, ["recall"], True, workers=1).lines[0] for each in ("obedient", RECALLS))
    assert "does not remember earlier episodes" in forgets.words
    assert recalls.score == pytest.approx(1)


RECALLS = "obedient(forget=False)"


def test_a_card_says_what_its_tests_find(store):
    """The test has about that power, also with few worlds, whose p-values are coarse; seven find nothing."""
    (line,) = take("obedient | mishears(p=0.5)", store, ["advice"], quick=True, workers=1).lines
    assert 0 < line.finds < 1
    assert least_effect(7, 1.0, 0.0125) == np.inf
    for n, alpha in ((8, 0.0125), (8, 0.05), (10, 0.0125)):
        draws = np.random.default_rng(n).normal(least_effect(n, 1.0, alpha), 1.0, (n, 1000))
        assert np.mean(sign_flips(draws, 9999) <= alpha) == pytest.approx(0.78, abs=0.05), n


class HalfBroken:
    """An agent that does what it hears, and in silence or at other words has no action in some worlds."""

    text = True
    odd = "Answer with one whole number from 0 to 9"
    """A part of the instruction of worlds in which it fails."""
    heard_only = True

    def reset(self, rng):
        self._turn = 0

    def act(self, observation, info):
        self._turn += 1
        named = re.findall(r"\b\d\b", observation["feedback"].replace("0 to 9", ""))
        if self.odd in observation["instruction"] and bool(named) != self.heard_only:
            return "east"
        return f"Response: {named[-1] if named else 3 * self._turn % 10}"


class Whole(HalfBroken):
    """The same agent without the fault."""

    odd = "no such text"


class BrokenWhenAdvised(HalfBroken):
    """The same agent, with the fault where it hears advice."""

    heard_only = False


def test_failing_answers_in_controls_do_not_make_a_good_score(tmp_path):
    """The score of an agent that fails only without advice is above its score without the fault: the card says so."""
    good, bad = (take(each, tmp_path / "it.db", (), True, workers=1) for each in (Whole, HalfBroken))
    whole, line = good.lines[0], bad.lines[0]
    assert line.score > whole.score + 0.1
    lessons = line.answers.lessons
    failing = [lessons[kind].no_action for kind in ("better", "worse", "silent")]
    assert failing[0] == 0 < failing[1] == failing[2]
    assert line.too == "too high"
    counts = f"0 of 40 with the teacher's words, {failing[1]} of 40 with useless words, {failing[2]} of 40 in silence"
    assert line.readable.score == pytest.approx(whole.score, abs=0.1)
    assert line.readable.seeds == 8 - failing[1] // 5
    (said,) = (each for each in bad.sentences() if "takes advice" in each)
    assert "the score is too high, since more answers failed with useless words" in said
    assert counts in said
    assert f"it is {line.readable.words}, p " in said
    for text in (bad.as_markdown(), bad.as_html().replace("&#39;", "'")):
        assert counts in text
        assert f"{line.words}, too high" in text
    assert (whole.too, whole.failing, whole.readable) == ("", "", None)


def test_failing_answers_in_the_better_lessons_make_a_low_score(tmp_path):
    line = take(BrokenWhenAdvised, tmp_path / "it.db", (), True, workers=1).lines[0]
    assert line.too == "too low"
    assert (
        "The score is too low, since more answers failed with the teacher's words than with useless words" in line.did
    )


def tilted(score_, worse, better=0, **more):
    """A line whose answers failed this often in 40 turns."""
    lessons = {
        kind: LessonAnswers(turns=40, no_action=n) for kind, n in (("better", better), ("worse", worse), ("silent", 0))
    }
    found = replace(line(score_, 0.1), name="advice", p=0.01, answers=AnswerSummary(turns=120, lessons=lessons))
    return replace(found, **more)


@pytest.mark.parametrize(
    ("readable", "shown"),
    [
        (score(arms(1, 10)), True),
        (score(arms(10, 10)), False),
        (score(arms(1, 10, n=4)), False),
        (None, False),
    ],
)
def test_a_score_that_is_too_high_shows_an_ability_only_by_the_worlds_without_failing_answers(store, readable, shown):
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    each = tilted(1.3, 20, readable=readable)
    assert each.shown is shown
    first = replace(card, lines=[each]).sentences()[0]
    assert first.startswith("The student b: 1.30" if shown else "Whether it b is not decided: 1.30")
    assert "too high" in first
    assert tilted(1.3, 2, readable=readable).shown  # few failing answers
    assert tilted(1.3, 0, 20, readable=readable).shown  # too low


def test_where_an_ability_is_to_take_no_notice_failing_answers_in_the_worse_lessons_lower_the_score():
    assert tilted(0.5, 20, alike=False).too == "too low"
    assert tilted(1.0, 0, 20, alike=True).too == "too high"
    assert not tilted(1.0, 0, 20, alike=True).shown
    assert tilted(1.0, 20, alike=True).shown


def test_failing_answers_in_silence_alone_are_said_to_raise_the_score_beside_silence():
    lessons = {"better": LessonAnswers(turns=40), "silent": LessonAnswers(turns=40, no_action=20)}
    each = tilted(1.0, 0, answers=AnswerSummary(turns=120, lessons=lessons), silence=line(1.3, 0.1))
    assert "the score against silence is too high, since more answers failed in silence" in each.bias
    assert not each.shown


@pytest.mark.parametrize(
    ("tests", "worlds", "least"), [(1, 8, "0.008"), (4, 8, "0.031"), (1, 6, "0.031"), (2, 20, "0.000")]
)
def test_a_card_says_the_least_p_of_its_tests(store, tests, worlds, least):
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    lines = [replace(line(0.3, 0.1, worlds), name=f"{i}") for i in range(tests)]
    assert f"in {worlds} worlds, no p can be below {least}" in replace(card, lines=lines).explained


def test_scores_that_are_the_same_in_all_worlds_are_explained(store):
    """Of an agent that does what it is advised and keeps nothing."""
    card = take(Whole, store, ["silence"], quick=True, workers=1)
    (each,) = card.lines
    assert (each.score, each.answers.followed) == (0, 8)  # the first turn of each bandit
    assert (
        "In each world its loss from turn 3 on, which alone counts, was the same with the teacher's words" in each.did
    )
    assert card.table()[1][3] == "all equal"


def test_more_than_the_reference_saves_is_said_to_be_that():
    assert "more loss than it spares a scripted student that obeys, 131% of that" in tilted(1.31, 0).did
    assert "the teacher spared it 100% of the loss" in tilted(1.001, 0).did


def test_a_card_explains_scores_above_1_if_it_has_one(store):
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    assert ABOVE not in card.explained
    assert ABOVE in replace(card, lines=[tilted(1.31, 0)]).as_markdown()


PLACEBOS = [name for name, each in all_experiments().items() if not each.worse]


@pytest.mark.parametrize("name", PLACEBOS)
def test_a_placebo_has_as_many_words(tmp_path, name):
    """To a student that acts alike in both lessons, which are its tests where an experiment has these."""
    asked = all_experiments()[name]
    for id in asked.ids:
        study = Study(
            ids=(id,), teachers=asked.arms[:2], students=("random",), seeds=range(asked.seeds), max_turns=12,
            options={id: OPTIONS[id]} if id in OPTIONS else {},
        )  # fmt: skip
        with run(study, tmp_path / "it.db", 1) as results:
            rows = [row for row in results.rows() if row["id"] == id]
        said, placebo = (sum(row["words"] for row in rows if row["teacher"] == each) for each in asked.arms[:2])
        assert placebo == pytest.approx(said, rel=0.13 if id == FILMS else 0.08), id  # no truism is as long as titles


def test_the_quick_suite_fits_400_turns():
    assert estimate("obedient", quick=True).turns <= 400
    assert estimate(RECALLS).turns > estimate("obedient").turns  # tests and the lessons before them


def test_other_keys_have_other_seeds():
    assert seeds_of() == seeds_of()
    assert not set(seeds_of("one")) & set(seeds_of("two"))
    assert not set(seeds_of("one")) & set(seeds_of())
    assert len(seeds_of("one", quick=True)) < len(seeds_of("one"))


def test_unknown_experiments_are_refused():
    with pytest.raises(ValueError, match=r"unknown experiment 'advise'.*advice"):
        chosen(["advise"])


def test_the_command(store, tmp_path):
    command = ["suite", "--student", "obedient", "--quick", "--only", "advice", "--store", f"{store}", "--workers", "1"]
    result = CliRunner().invoke(app, [*command, "--card", f"{tmp_path / 'card.md'}"])
    assert result.exit_code == 0, result.output
    assert "takes advice" in (tmp_path / "card.md").read_text()
    assert "at most 48 episodes, 240 turns" in result.output


MODEL = "llm(model='m', base_url='http://127.0.0.1:9/v1', max_tokens=10{})"


def test_an_estimate_is_of_what_would_be_played():
    """Three teachers and two environments with 8 seeds of 5 turns; only a model with prices has a price."""
    plain = estimate("obedient", ["advice"], quick=True)
    assert (plain.episodes, plain.turns, plain.input_tokens, plain.usd) == (48, 240, None, None)
    model = estimate(MODEL.format(""), ["advice"], quick=True)
    assert model.output_tokens == 240 * 10
    assert model.usd is None
    priced = estimate(MODEL.format(", input_price=2.0, output_price=3.0") + " | stubborn", ["advice"], quick=True)
    assert priced.usd == pytest.approx((model.input_tokens * 2 + 2400 * 3) / 1e6)
    shorter = estimate(MODEL.format(", history=1"), ["advice"], quick=True)
    assert 0 < shorter.input_tokens < model.input_tokens


def line(score, half, seeds=20, **more):
    """A line of a card whose interval has this half width."""
    ends = {"low": None, "high": None} if half is None else {"low": score - half, "high": score + half}
    return AbilityLine(
        name="a", ability="b", score=score, p=0.1, seeds=seeds, places={}, why="skewed", alike=None, **ends, **more
    )


def test_the_head_of_a_card_names_what_was_shown_with_and_without_an_interval():
    """The best first; three at most."""
    shown = [
        replace(line(score, half), p=0.01, ability=ability)
        for ability, score, half in (("keeps it", 0.69, 0.4), ("takes advice", 0.83, None), ("hears hints", 0.4, 0.3))
    ]
    settings = {"suite": "", "digest": "", "quick": False, "key": "", "cost": {}, "failures": 0, "error": ""}
    card = Card(student="s", lines=shown, versions={}, **settings)
    first, *others = "takes advice: 0.83 (no interval: skewed)", "keeps it: 0.69 [0.29, 1.09]"
    named = "; ".join((first, *others, "hears hints in part: 0.40 [0.10, 0.70]"))
    assert card.sentences()[0] == f"The student {named}."
    fourth = replace(card, lines=[*shown, replace(line(0.3, 0.29), p=0.01)])
    assert fourth.sentences()[0] == f"The student {named}; and 1 more."


def test_a_difference_of_cards_is_significant_as_often_as_it_says():
    """Of two cards with equal truth 5 % differ; the interval has the truth in 95 %."""
    rng = np.random.default_rng(7)
    rejected = []
    for _ in range(800):
        pair = []
        for n, spread in ((8, 1.0), (20, 3.0)):
            values = rng.normal(0.4, spread, n)
            pair.append(line(values.mean(), stats.t.ppf(0.975, n - 1) * stats.sem(values), n))
        found = _difference(*pair)
        assert (found.p < 0.05) == (not found.low <= 0 <= found.high)
        rejected.append(found.p < 0.05)
    assert 0.03 < np.mean(rejected) < 0.07


def test_a_difference_that_cannot_be_tested_says_why():
    assert _difference(line(0.2, 0.1), line(0.5, None)).words == "+0.30 (no interval: second card: skewed)"
    assert _difference(line(None, None), line(0.5, 0.1)).words == "not measured: first card: skewed"
    assert _difference(line(1.0, 0.0), line(0.0, 0.0, 8)).p == 2 / 2**8
    assert _difference(line(1.0, 0.0), line(1.0, 0.0)).p == 1


def test_cards_are_compared_and_checked(store, tmp_path):
    files = [f"{tmp_path / name}.json" for name in ("obedient", "random")]
    for name, file in zip(("obedient", "random"), files, strict=True):
        take(name, store, ["advice"], quick=True, workers=1).write(Path(file))
    (found,) = compare(*files)
    assert found.score == pytest.approx(-1)
    assert found.p < 0.01
    result = CliRunner().invoke(app, ["suite", "compare", *files])
    assert "-1.00 [" in result.output
    assert f"suite-v1 ({DIGEST}, quick); 48 episodes" in " ".join(result.output.split())
    result = CliRunner().invoke(app, ["suite", "check", *files])
    assert "of obedient." in result.output
    take("random", store, ["turncoat"], quick=True, workers=1).write(Path(files[1]))
    with pytest.raises(CardError, match="no ability in common: advice; turncoat"):
        compare(*files)
    replace(Card.load(files[0]), quick=False).write(Path(files[1]))
    with pytest.raises(CardError, match=r"obedient.json is of the quick suite, .*random.json is not"):
        compare(*files)


class Hostile:
    """An agent whose error would control a terminal."""

    text = True

    def reset(self, rng):
        """Nothing."""

    def act(self, observation, info):
        raise RuntimeError("\x1b[2J\u202eevil")


def test_text_of_agents_and_cards_does_not_control_the_terminal(store, tmp_path, monkeypatch):
    with pytest.warns(RuntimeWarning, match="episodes failed"):
        card = take(Hostile, tmp_path / "it.db", ["hints"], quick=True, workers=1)
    assert "\x1b" not in card.as_markdown() + card.as_html()
    assert r"\x1b[2J\u202eevil" in card.error
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    for path in (first := tmp_path / "\u202eone.json", second := tmp_path / "two.json"):
        replace(card, lines=[replace(card.lines[0], low=None, high=None, why="\x1b[2J\u202eevil")]).write(path)
    for command in (["compare", f"{first}", f"{second}"], ["check", f"{second}"]):
        assert not re.search("[\x1b\u202e]", CliRunner().invoke(app, ["suite", *command]).output)
    monkeypatch.setattr("llf_teacher.suite.take", lambda *_: card.load(second))
    assert not re.search("[\x1b\u202e]", CliRunner().invoke(app, ["suite", "--student", "obedient"]).output)


def test_the_progress_ends_at_its_total(tmp_path):
    shown = []
    take(RECALLS, tmp_path / "it.db", ["advice", "recall"], True, "", 1, lambda *of: shown.append(of))
    assert shown[-1][0] == shown[-1][1] > 100
    assert all(done <= total and left >= 0 for done, total, left in shown)


def test_an_interrupted_suite_says_where_its_episodes_are(tmp_path, monkeypatch):
    def take(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("llf_teacher.suite.take", take)
    result = CliRunner().invoke(app, ["suite", "--student", "obedient", "--store", f"{tmp_path / 'it.db'}"])
    assert "it.db; the same command goes on" in result.output
    assert result.exit_code == 130


def test_a_low_score_is_an_ability_in_part_and_what_is_lacking_is_counted(store):
    card = take("obedient", store, ["advice"], quick=True, workers=1)
    lines = [replace(line(0.3, 0.1), name=name, p=0.01) for name in ("a", "b", "c", "d", "e")]
    said = replace(card, lines=lines).sentences()
    assert re.search(r"in part: 0\.30 \[0\.20, 0\.40\]", said[0])
    assert said[1].endswith("and 2 more.")
    assert "(no interval)" in replace(card, lines=[line(0.3, None)]).as_svg()


def test_a_suite_without_a_student_says_what_to_give():
    result = CliRunner().invoke(app, ["suite"])
    assert result.exit_code == 2
    assert "give --student, such as" in result.output
