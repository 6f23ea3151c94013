"""Audits find what is wrong, and nothing where nothing is."""

import re
from dataclasses import dataclass

import pytest
from design import COSTLY, amount, sampled
from hedging import hedging
from shelf import FAMILIES, pairs

import llf_teacher
from llf_teacher.cli.audit import _print as print_audits
from llf_teacher.cli.audit import summary
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.execution.episode import play
from llf_teacher.testing import check_teacher
from llf_teacher.tools.audit import STUDENTS, audit
from pz_envs.family import all_families
from teachers.atoms import FP, HN, HP, KINDS, Label, ParseFailure, R
from teachers.common import Right, Truism, Wrong
from teachers.personalities.silent import silent
from teachers.personality import Personality, Stage, parse_personality, personality

GRID = "llf-gridworld-v0"
SHOWCASE = [PREFIX + family.showcase[0] for family in all_families()]


def few(family_id):
    """Turns for an audit in the default tests."""
    family = next(family for family in all_families() if PREFIX + family.showcase[0] == family_id)
    return amount(12, full=24) if family.slow or family.name in COSTLY else amount(30, full=60)


@sampled(lambda name, teacher: {name, teacher})
@pytest.mark.parametrize(("name", "teacher"), [(n, spec) for n, spec in pairs() if parse_personality(spec).honest])
def test_honest_personalities_are_never_caught(name, teacher):
    id = PREFIX + FAMILIES[name].showcase[0]
    found = audit(id, teacher, turns=few(id))
    assert not found.examples
    assert not found.caught
    assert found.count(Label.DISTORTED) == found.contradictions == 0
    assert found.turns == few(id)


@pytest.mark.parametrize("id", SHOWCASE)
def test_every_lie_of_a_liar_is_seen(id):
    found = audit(id, "mistake(eps=1)", turns=few(id))
    assert found.count(Label.DISTORTED) > few(id)
    assert not [label for (kind, label) in found.claims if kind is not None and label is not Label.DISTORTED]
    assert not found.caught  # it promises nothing
    assert found.withheld.total() >= found.count(Label.DISTORTED)


@personality()
def torn(claims, view):
    """Calls each action right and wrong."""
    action = view.moment.action
    return claims if action is None else [cls.on((), action=action) for cls in (Right, Wrong)]


def test_contradictions_are_counted_and_shown():
    found = audit(GRID, torn(), turns=60, students=["random"])
    assert found.contradictions == 60
    assert found.caught
    assert "contradiction" in {each.what for each in found.examples}
    assert found.as_dict()["contradictions"] == 60
    liar = audit(GRID, "mistake(eps=1)", turns=10)
    assert summary([found, liar]) == (
        f"{found.checked + liar.checked} claims checked. By teachers that promise honesty (1 of 2 audits): "
        f"{found.count(Label.DISTORTED)} false claims, 60 contradictions. By all: 0 leaks."
    )


def test_labels():
    assert {label for (kind, label) in audit(GRID, "placebo", turns=60).claims if kind} == {Label.PLACEBO}
    assert {label for (kind, label) in audit(GRID, "delayed(turns=1)", turns=60).claims if kind} == {Label.LATE}
    assert {label for (kind, label) in audit(GRID, "oracle", turns=60).claims if kind} == {Label.TRUTHFUL}


@pytest.mark.parametrize("id", SHOWCASE)
def test_words_from_elsewhere_are_true_there_and_mostly_not_here(id):
    found = audit(id, "misaligned", turns=few(id))
    assert not found.caught
    for kind, (claims, there, here) in found.displaced().items():
        assert kind in KINDS
        assert claims == there >= here
    said = sum(number for (kind, _), number in found.claims.items() if kind is not None)
    assert sum(found.elsewhere.values()) == said
    here = sum(number for (_, _, true), number in found.elsewhere.items() if true)
    assert here == said - found.count(Label.DISTORTED)
    advice, _, right = found.displaced()[FP]
    assert right < advice
    counted = found.as_dict()["elsewhere"]
    assert counted["fp"] == {"claims": advice, "true_there": advice, "true_here": right}
    assert audit(id, "oracle", turns=few(id)).as_dict()["elsewhere"] == {}


class Fibbing(Stage):
    """Says of a moment elsewhere what is true here."""

    def speak(self, claims, view):
        elsewhere = view.elsewhere(self.rng)
        elsewhere.go_on()
        return [view.displace(claim, claim, elsewhere.moments[0].moment) for claim in claims]


@dataclass(frozen=True)
class Mixing(Personality):
    """Calls what is true here the words of another moment."""

    honest = False
    elsewhere = True
    stage = Fibbing


def test_words_that_are_false_elsewhere_are_caught():
    found = audit(GRID, Mixing(), turns=60)
    assert found.caught
    assert {each.what for each in found.examples} == {"false"}
    assert sum(there for _, there, _ in found.displaced().values()) < sum(found.elsewhere.values())


def test_a_record_says_whether_a_claim_is_true_elsewhere_and_here():
    spec = EpisodeSpec(GRID, "misaligned", "random", "b", "a", 8, 3, llf_teacher.__version__)
    atoms = [atom for turn in play(spec).turns for atom in turn.atoms]
    taken = [atom for atom in atoms if atom["kind"] is not None]
    assert all(atom["elsewhere"] is True for atom in taken)
    assert {(atom["holds"], atom["label"]) for atom in taken} == {(True, "truthful"), (False, "distorted")}
    assert not any("elsewhere" in atom for atom in atoms if atom["kind"] is None)
    honest = play(spec._replace(teacher="oracle"))
    assert not any("elsewhere" in atom for turn in honest.turns for atom in turn.atoms)


def test_words_from_elsewhere_are_printed(capsys):
    found = audit(GRID, "misaligned", turns=60)
    print_audits([found])
    shown = capsys.readouterr().out
    claims, there, here = found.displaced()[FP]
    assert "claims from other worlds by misaligned in llf-gridworld-v0" in shown
    assert re.search(rf"fp +{claims} +{there} +{here} \({here / claims:.0%}\)", shown)


def test_what_is_withheld():
    """By kind, what the oracle offered and the student never heard."""
    found, everything = (audit(GRID, spec, turns=120, students=["random"]) for spec in ("only(kinds='r+fp')", "oracle"))
    assert not everything.withheld
    said = {kind: sum(n for (k, _), n in everything.claims.items() if k == kind) for kind in KINDS}
    assert found.withheld == {kind: said[kind] for kind in KINDS if kind not in (R, FP)}


def test_what_comes_late_is_not_withheld():
    found = audit(GRID, "delayed(turns=1)", turns=20, students=["random"], instruction_types=["b"])
    assert found.episodes == 1
    said = sum(n for (kind, _), n in found.claims.items() if kind)
    last = found.withheld.total()  # only what would have come after the end
    assert 0 < last <= 5
    assert said > 10 * last


@personality(reveals=False)
def blabber(claims, view):
    """Promises not to tell the action, and tells it."""
    return claims


@personality()
def offended(claims, view, rng):
    """Promises to tell the truth, and lies to those who write what is no action."""
    return distorted(claims, view, rng) if type(view.moment.action) is ParseFailure else claims


@personality()
def unsettled(claims, view, rng):
    """Promises to tell the truth, and lies in small houses."""
    return distorted(claims, view, rng) if len(view.moment.after.layout.names) < 10 else claims


def distorted(claims, view, rng):
    return [false for claim in claims if (false := view.distort(claim, rng))]


def test_students_of_every_habit_are_taught():
    found = audit(GRID, "oracle", turns=270)
    assert set(found.students) == {str(parse_student(spec)) for spec in STUDENTS}
    assert sum(found.students.values()) == found.checked
    assert found.as_dict()["students"]["random"] == {"claims": found.students["random"], "false": 0}
    caught = audit(GRID, offended(), turns=270)
    assert caught.caught
    assert {student for student, number in caught.falsehoods.items() if number} == {"wayward(habit='garbling')"}
    assert not audit(GRID, offended(), turns=270, students=("random", "obedient")).caught


def test_other_options_are_drawn_unless_they_are_given():
    found = audit(GRID, unsettled(), turns=270)
    assert found.caught
    assert all(example.options["num_rooms"] < 10 for example in found.examples)
    assert not audit(GRID, unsettled(), turns=270, num_rooms=20, min_goal_dist=4).caught


class Stranger:
    """A policy of somebody's own, which passes on what a teacher says."""

    def __init__(self, feedback_type="a"):
        env = llf_teacher.make(GRID)
        self.teacher = env.family.make_teacher(env.session.world, feedback_type=feedback_type)
        self.extra = ""

    def reset(self, rng):
        self.teacher.reset(rng)

    def act(self, observation, info):
        said = self.teacher.act(observation, info)
        return f"{said}{self.extra}" if self.extra else said


def test_an_answer_that_leaks():
    found = audit(GRID, blabber(), turns=60)
    assert found.caught
    assert found.leaks == sum(n for (kind, _), n in found.claims.items() if kind == FP)
    assert found.examples[0].what == "leak"
    assert found.teacher == f"{__name__}:blabber"
    assert not audit(GRID, silent(), turns=60).caught
    with pytest.raises(AssertionError, match=r"blabber was caught in llf-gridworld-v0:\n  Finding\(what='leak'"):
        check_teacher(GRID, blabber(), turns=60)


@pytest.mark.parametrize(
    ("spec", "reveals"),
    [
        ("ruler | worked_example(n=3)", True),
        ("ruler | partial(worlds=256)", True),
        ("partial(worlds=256) | ruler", False),
        ("placebo | misaligned", True),
        ("worked_example(n=3) | ruler", False),
        ("verification | delayed(turns=1)", False),
        ("verification | mix | worked_example | only(kinds='r')", False),
    ],
)
def test_a_composition_promises_what_its_last_stages_do(spec, reveals):
    assert parse_personality(spec).reveals == reveals
    found = audit(GRID, spec, turns=45)
    assert not found.caught
    assert not found.leaks


@personality()
def groundless(claims, view):
    """Calls each action right, on the ground that ice is cold."""
    acted = view.moment.before is not None
    return [Right.on((Truism(kind=HP, fact="ice is cold"),), action=view.moment.action)] if acted else ()


def test_a_claim_is_false_that_only_its_ground_makes_true():
    found = audit(GRID, groundless(), turns=60)
    assert found.caught
    assert 0 < found.count(Label.DISTORTED) < found.turns
    assert {example.what for example in found.examples} == {"false"}


def test_the_feedback_type_bounds_everyone():
    found = audit(GRID, Stranger(), feedback_type="r+hn", turns=60)
    assert {kind for kind, _ in found.claims} == {None, R, HN}
    assert not found.leaks


def test_a_policy_of_ones_own_is_checked():
    check_teacher(GRID, Stranger(), turns=60)
    liar = Stranger()
    liar.teacher = llf_teacher.make(GRID, teacher="mistake(eps=1)").teacher
    with pytest.raises(AssertionError, match="Stranger was caught in llf-gridworld-v0:\n  Finding\\(what='false'"):
        check_teacher(GRID, liar, turns=60)
    liar.honest = False
    check_teacher(GRID, liar, turns=60)


def test_text_without_claims_is_unchecked():
    talker = Stranger()
    talker.extra = " Good luck!"
    found = audit(GRID, talker, turns=30, instruction_types=["b"], students=["random"])
    assert found.claims == {(None, Label.UNCHECKED): 30}
    assert found.held is None
    with pytest.raises(AssertionError, match="made no claim"):
        check_teacher(GRID, talker, turns=30)


def test_what_a_rewriting_voice_does_to_numbers_and_names_is_counted():
    """And nothing is counted twice, also where the teacher is silent between two sentences."""
    said = []

    def swap(sentence):
        said.append(sentence)
        return sentence.replace("north", "south")

    found = audit(GRID, "only(kinds='fp') | mix", turns=120, voice=swap)
    assert found.changes == sum("north" in each and "south" not in each for each in said) > 5
    assert [change.appeared for change in found.changed] == [("south",)] * 5
    assert not found.caught
    assert found.as_dict()["changes"] == found.changes
    assert found.as_dict()["changed"][0]["vanished"] == ("north",)
    plain = audit(GRID, "oracle", turns=60)
    assert (plain.changes, plain.changed) == (0, [])


def test_the_same_audit_finds_the_same():
    assert audit(GRID, "mix", turns=90) == audit(GRID, "mix", turns=90)


@pytest.mark.parametrize("settings", [{"turns": 0}, {"students": ["nobody"]}, {"instruction_types": ["z"]}])
def test_bad_arguments(settings):
    with pytest.raises(ValueError, match=r"turns must be|unknown student|instruction type 'z'"):
        audit(GRID, **settings)


def test_bits_are_measured_where_they_are_wanted():
    found = audit("llf-bandits-BanditTenArmedGaussian-v0", turns=40, students=["random"], worlds=16)
    assert found.measured == 40
    said = found.gains["bandits.Pull"]
    assert said.claims > 0 == said.unknown
    assert 0 < said.bits < 4 * said.claims
    assert found.gain.claims == sum(each.claims for each in found.gains.values())
    assert found.as_dict()["information"]["claims"]["bandits.Pull"] == said._asdict()
    assert not audit(GRID, turns=10, students=["random"]).gains
    with pytest.raises(ValueError, match="'poem' has no posterior; families with one: bandits, gridworld"):
        audit("llf-poem-Haiku-v0", turns=10, worlds=16)
    with pytest.raises(ValueError, match="set the option map=True"):
        audit(GRID, turns=10, worlds=16, map=False)


@pytest.mark.parametrize(
    ("bends", "verdict"),
    [("timid(by=1)", "calibrated"), ("overconfident(by=3)", "overconfident"), ("timid(by=3)", "timid")],
)
def test_the_hedges_of_an_audit_are_judged_together(bends, verdict, capsys):
    found = audit(GRID, hedging() | parse_personality(bends), turns=600, students=["random"], instruction_types=["b"])
    assert found.hedges.verdict == verdict
    feedback = {label for kind, label in found.claims if kind is not None}
    assert feedback == {Label.HEDGED}
    assert found.hedges.sentences == found.count(Label.HEDGED) > 1000
    assert found.held == 1.0  # the instruction; hedges are neither true nor false
    assert {each.what for each in found.examples} == ({"contradiction"} if found.honest else set())  # drawn one by one
    assert found.as_dict()["hedges"]["verdict"] == verdict
    print_audits([found])
    shown = " ".join(capsys.readouterr().out.split())
    assert (
        f"{found.hedges.sentences:,} sentences in {found.episodes} episodes: Brier score {found.hedges.brier:.3f}"
        in shown
    )
    for each in found.hedges.bins:
        assert f"{each.sentences:,} {each.said:.1%} {each.held:.1%}" in shown
