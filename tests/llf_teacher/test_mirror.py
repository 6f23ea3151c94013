"""The mirror: qualities of known teachers, cards of teachers, and teachers that fail."""

import os
import time
from pathlib import Path
from pkgutil import iter_modules

import numpy as np
import pytest
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.models.cache import spending
from llf_teacher.models.settings import BUDGET
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.registry import entry
from llf_teacher.suite.card import Card
from llf_teacher.suite.estimate import estimate_teacher
from llf_teacher.suite.mirror import TeacherCard, all_qualities, digest, play, qualities, take
from llf_teacher.suite.mirror.qualities.fades import _fading
from llf_teacher.suite.mirror.quality import ORDER, TaughtEpisode, TaughtWorld, claims_of
from llf_teacher.suite.places import ARMS
from teachers.atoms import Utterance
from teachers.personality import parse_personality

DIGEST = "e674a97c942131e9"


def test_the_digest_is_that_of_the_version():
    """If not, a score means something else: give the mirror another version."""
    assert digest() == DIGEST


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, "other") for name in ("ARMS", "HOUSE", "FILMS", "OPTIONS")),
        ("TURNS", 13),
        ("seeds_of", lambda *_: [1, 2]),
    ],
)
def test_what_decides_a_score_is_in_the_digest(monkeypatch, name, value):
    monkeypatch.setattr(play, name, value)
    assert digest() != DIGEST


def test_every_module_is_a_quality():
    assert sorted(ORDER) == sorted(each.name for each in iter_modules(qualities.__path__))


@pytest.mark.parametrize("name", all_qualities())
def test_a_quality_is_complete(name):
    each = all_qualities()[name]
    assert set(each.rests_on) <= set(all_qualities()) - {name}
    assert all(parse_personality(spec) for spec in each.teachers)
    assert len({entry(id).family.name for id in each.ids}) >= 2


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return tmp_path_factory.mktemp("mirror") / "mirror.db"


def scores(teacher, store, *names):
    """The scores by name, in fewer worlds."""
    return {each.name: each.score for each in take(teacher, store, names, quick=True, workers=1).lines}


def test_known_teachers_have_known_scores(store):
    """An oracle is firm; of a liar it is not known."""
    assert scores("oracle", store, "pushback") == pytest.approx({"pushback": 1})
    assert scores("mistake(eps=1)", store, "pushback") == {"pushback": None}  # it never spoke truly


def test_a_family_that_does_not_serve_a_teacher_does_not_count(store):
    (line,) = take("noisy | only(kinds='hp')", store, ["fades"], quick=True, workers=1).lines
    assert "llf-reco-movie-v0: the oracle lacks what the teacher needs" in line.why
    assert set(line.places) <= {ARMS}


def test_what_a_teacher_never_does_is_not_measured(store):
    (line,) = take("silent", store, ["pushback"], quick=True, workers=1).lines
    assert line.score is None
    assert "it spoke against nothing" in line.why


def atom(kind="fp", **more):
    return {"kind": kind, "label": "truthful", "holds": True, "action": None, "fields": {}} | more


def lessons(*turns, regrets=None):
    """An episode with these claims a turn, the opening first."""
    rows = [{"atoms": list(said)} for said in turns]
    return TaughtEpisode(regrets or [1.0] * (len(rows) - 1), 8, rows)


def test_calibration_is_unbiased_where_the_hedges_of_a_world_agree():
    """Of hedges that are right in the mean the score is 0 in the mean, though all of a world are true or none is."""
    agreement = all_qualities()["calibration"].outcome
    rng = np.random.default_rng(3)

    def drawn(p, truth):
        said = [atom(label="hedged", fields={"p": p}, holds=bool(rng.random() < truth))] * 4
        return TaughtWorld([lessons(said)], [])

    right = [agreement([drawn(0.8, 0.8) for _ in range(12)]).mean() for _ in range(400)]
    wrong = [agreement([drawn(0.99, 0.6) for _ in range(12)]).mean() for _ in range(400)]
    assert abs(np.mean(right)) < 4 * np.std(right) / 20
    assert np.mean(wrong) == pytest.approx(-(0.39**2), abs=0.02)


def test_use_is_the_regret_that_a_bit_saves():
    """Over worlds the ratio of the means; what is said in a world in which nothing is known has no bits."""
    use = all_qualities()["use"].outcome
    silent = [lessons((), (), regrets=[4.0])]
    one, other = ([lessons((), [atom(information={"bits": bits})], regrets=[1.0])] for bits in (1.0, 2.0))
    found = use([TaughtWorld(one, silent), TaughtWorld(other, silent)])
    assert found.mean() == pytest.approx(6 / 3)
    assert found.tolist() == pytest.approx([2 + (3 - 2) / 1.5, 2 + (3 - 4) / 1.5])
    unknown = [lessons((), [atom()], regrets=[1.0])]
    assert np.isnan(use([TaughtWorld(unknown, silent)] * 2)).all()


def test_fading_is_less_in_the_second_half():
    said = [atom()]
    assert _fading([lessons((), said, said, (), (), ())]) == 1
    assert _fading([lessons((), said, said, said, said, said)]) == 0
    assert np.isnan(_fading([lessons((), (), ())]))


def test_help_after_mistakes_only_is_adapting():
    adapts = all_qualities()["adapts"].outcome
    lost = [1.0, 0.0, 1.0, 0.0, 1.0]
    turns = [(), [atom()], (), [atom("fn")], [atom("hp")], ()]
    assert adapts([TaughtWorld([lessons(*turns, regrets=lost)], [])]) == [1]
    always = [(), *([atom()],) * 5]
    assert adapts([TaughtWorld([lessons(*always, regrets=lost)], [])]) == [0]


def test_hints_leave_the_action_open_and_say_something():
    hints = all_qualities()["hints"].outcome
    new, known = {"information": {"bits": 1.0}}, {"information": {"bits": 0.0}}
    said = [atom(**new), atom(**known), atom(action=3, **known), atom("hn", **new)]
    assert hints([TaughtWorld([lessons(said)], [])]) == [0.5]


def test_a_student_that_insists_must_be_spoken_against_again():
    firm = all_qualities()["pushback"].outcome
    lie = [atom("hp", label="distorted", holds=False)]
    assert firm([TaughtWorld([lessons((), [atom()], [atom()], lie, ())], [])]) == [0.5]
    assert np.isnan(firm([TaughtWorld([lessons((), (), (), ())], [])])).all()


class Fails:
    """A teacher that raises."""

    def reset(self, rng):
        """Nothing."""

    def act(self, observation, info):
        """Fail."""
        raise RuntimeError("out of chalk")


class Nonsense(Fails):
    """A teacher that says no words."""

    def act(self, observation, info):
        """A number."""
        return 7


class Hangs(Fails):
    """A teacher that does not answer."""

    def act(self, observation, info):
        """Wait."""
        time.sleep(60)


class Talks(Fails):
    """A teacher whose words carry no claims."""

    def act(self, observation, info):
        """Words."""
        return "Well."


@pytest.mark.parametrize(
    ("teacher", "seconds", "why"),
    [
        (Fails, None, "out of chalk') (test_mirror.py, line "),
        (Nonsense, None, "7"),
        pytest.param(Hangs, 0.5, "over", marks=pytest.mark.full),
    ],
)
def test_a_teacher_that_fails_is_not_measured(tmp_path, teacher, seconds, why):
    with pytest.warns(RuntimeWarning, match="failed"):
        card = take(teacher, tmp_path / "a.db", ["pushback"], quick=True, workers=1, turn_seconds=seconds)
    assert card.lines[0].score is None
    assert "were not played" in card.lines[0].why
    assert why in card.error


def test_words_that_cannot_be_read_are_not_judged(store):
    card = take(Talks, store, ["pushback", "timing"], workers=1, worlds=5)
    assert [each.score for each in card.lines] == [pytest.approx(0), None]


class Writes(Fails):
    """A teacher that says what the oracle advises, as text."""

    def act(self, observation, info):
        """Words of its own, some of which say nothing of the task."""
        words = [atom.text for atom in info["suggestion"].atoms if atom.kind in (None, "fp")]
        return " ".join((*words, *(("Lovely weather.",) if info["moment"].turn else ())))


class Misleads(Fails):
    """A teacher that advises what the oracle warns of, as text."""

    def act(self, observation, info):
        """The instruction, then false advice."""
        said = info["suggestion"]
        if not info["moment"].turn:
            return Utterance.of([atom for atom in said.atoms if atom.kind is None])
        false = [atom.claim.action for atom in said.atoms if atom.kind == "fn"]
        return "".join(f"Go {way}." if isinstance(way, str) else f"Pull arm {way}." for way in false[:1])


def test_words_that_are_read_count_as_claims(store):
    """And students follow them; the card has the reader's own errors."""
    names = ("timing", "pushback")
    flat, own, false = (
        take(each, store, names, workers=1, worlds=5) for each in ("only(kinds='fp')", Writes, Misleads)
    )
    assert [each.score for each in own.lines] == pytest.approx([each.score for each in flat.lines], abs=0.1)
    assert (own.cost["read_false"], own.cost["read_model"]) == (0, 0)
    assert own.cost["read_exact"] > 0.8 * own.cost["unread"] > 0  # as many sentences say nothing
    assert "were read; of these 0% were false, with the reader's own errors 0% to" in own.settings()
    assert "of these 100% were false" in false.settings()
    assert false.lines[0].score < 0.1 < own.lines[0].score
    assert false.lines[1].score is None  # it never spoke truly


def test_the_bits_of_what_was_read_are_not_known():
    """So a world in which something was read does not count."""
    use, silent = all_qualities()["use"].outcome, [lessons((), (), regrets=[4.0])]
    known = TaughtWorld([lessons((), [atom(information={"bits": 1.0})], regrets=[1.0])], silent)
    read = TaughtWorld([lessons((), [atom(information={"bits": 1.0}), atom()], regrets=[1.0])], silent)
    assert use([known, read, known]) == pytest.approx([3, np.nan, 3], nan_ok=True)


def test_a_sentence_that_words_a_claim_is_counted_once():
    said = [atom(text="Go north."), atom(text="Go south.", holds=False)]
    turn = {"atoms": said[:1], "readings": said}
    assert [(each["text"], each["label"]) for each in claims_of(turn)] == [
        ("Go north.", "truthful"),
        ("Go south.", "distorted"),
    ]


MODEL = "llm_teacher(model='scripted', input_price=1.0, output_price=4.0{})"


def test_an_estimate_is_of_what_is_played(tmp_path, monkeypatch):
    """A student that repeats its action, 10 seeds and 12 turns in two environments; tokens are about those paid for."""
    plain, model = (estimate_teacher(each, ["pushback"], quick=True) for each in ("oracle", MODEL.format("")))
    assert (plain.episodes, plain.turns, plain.input_tokens, plain.usd) == (20, 240, None, None)
    asked = []

    def answer(request):
        asked.append(sum(len(each["content"].encode()) for each in request["messages"]))
        return "You could look around before you try the same again, and then again."

    with ScriptedEndpoint(answer) as endpoint:
        monkeypatch.setenv("LLF_LLM_BASE_URL", endpoint.url)
        monkeypatch.setenv("LLF_LLM_CACHE", f"{tmp_path / 'answers.db'}")
        card = take(MODEL.format(""), tmp_path / "a.db", ["pushback"], quick=True, workers=1)
    ledger = spending(f"{tmp_path / 'answers.db'}")[0]
    assert card.cost["answers"] == len(asked) >= ledger["requests"]
    assert card.cost["input_tokens"] >= ledger["input_tokens"] > 0
    assert card.cost["usd"] == pytest.approx((card.cost["input_tokens"] + 4 * card.cost["output_tokens"]) / 1e6)
    assert f"{len(asked)} answers" in card.settings()
    assert f"Of {int(card.cost['unread'])} sentences without claims 0% were read" in card.settings()
    assert 0 < len(asked) <= model.turns == 240
    assert sum(asked) / 4 == pytest.approx(model.input_tokens, rel=0.3)
    assert model.usd == pytest.approx((model.input_tokens + 4 * 240 * 300) / 1e6)
    shorter, claims = (estimate_teacher(MODEL.format(each), ["pushback"], True) for each in (", history=1", _CLAIMS))
    assert 0 < shorter.input_tokens < model.input_tokens < claims.input_tokens


_CLAIMS = ", says='claims'"


def test_lessons_before_tests_are_estimated():
    """Of a teacher one lesson of 24 turns before each test, in which it is absent."""
    assert estimate_teacher("ruler", ["remains"], quick=True).turns == 10 * 2 * 24


def test_the_command_writes_a_card_that_is_checked(store, tmp_path, monkeypatch):
    files = [f"{tmp_path / name}" for name in ("a.json", "a.html", "a.svg", "a.md")]
    command = ["suite", "--teacher", "oracle", "--quick", "--only", "pushback", "--store", f"{store}", "--workers", "1"]
    monkeypatch.setenv(BUDGET, "9")
    result = CliRunner().invoke(app, [*command, "--budget", "7", *(x for file in files for x in ("--card", file))])
    assert os.environ[BUDGET] == "7.0"
    assert result.exit_code == 0, result.output
    assert "The teacher plays at most 20 episodes, 240 turns, less" in " ".join(result.output.split())
    assert "withstands pushback" in Path(files[1]).read_text()
    assert Card.load(files[0]).suite == "mirror-v1"
    assert TeacherCard.load(files[0]).as_html() == Path(files[1]).read_text()
    assert "of oracle." in CliRunner().invoke(app, ["suite", "check", files[0]]).output
    assert "+0.00" in CliRunner().invoke(app, ["suite", "compare", files[0], files[0]]).output


def test_unknown_qualities_and_teachers_are_refused(store):
    with pytest.raises(ValueError, match=r"unknown quality 'true'.*truth"):
        take("oracle", store, ["true"])
    with pytest.raises(ValueError, match="unknown"):
        take("oracl", store)
    with pytest.raises(ValueError, match="worlds must be an integer from 5 to 20, got 4"):
        take("oracle", store, worlds=4)
    result = CliRunner().invoke(app, ["suite", "--teacher", "oracle", "--student", "random"])
    assert result.exit_code == 2
