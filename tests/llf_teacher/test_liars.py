"""Teachers that promise the truth and say something else, by every way around the checks that was thought of."""

import enum

import pytest

import llf_teacher
from llf_teacher.testing import check_teacher
from llf_teacher.tools.audit import audit
from teachers.atoms import Atom, Claim, Label, Utterance, claim, fast_constructor
from teachers.common import hedge
from teachers.oracles.gridworld.claims import Go
from teachers.personality import personality

GRID = "llf-gridworld-v0"


@personality()
def sure(claims, view, rng, *, p: float = 0.99):
    """Hedges what is false."""
    return [hedge(false, p) for each in claims if each.kind and (false := view.distort(each, rng))]


@pytest.mark.parametrize("p", [0.51, 0.7, 0.99])
def test_hedged_lies_are_caught(p):
    found = audit(GRID, sure(p=p), turns=240)
    assert found.caught
    assert found.overconfident
    assert not found.examples
    assert not found.count(Label.DISTORTED)
    with pytest.raises(AssertionError, match=r"sure.* was caught .*\n  its hedges are overconfident, p = "):
        check_teacher(GRID, sure(p=p), turns=240)
    assert not audit(GRID, "partial(worlds=16)", turns=60).overconfident


@personality()
def lost_in_truth(claims, view, rng, *, p: float = 0.6, share: float = 0.08):
    """Hedges few lies at 99 %, and much truth far below what it is worth, so that the sums cancel."""
    for each in claims:
        if each.kind:
            lie = view.distort(each, rng) if rng.random() < share else None
            return [hedge(lie, 0.99) if lie else hedge(each, p)]
    return []


def test_lies_among_timid_truth_are_caught():
    found = audit(GRID, lost_in_truth(), turns=600)
    assert found.hedges.p_value > 0.1
    assert found.caught
    assert found.overconfident
    assert not found.contradictions


def test_an_honest_teacher_is_not_overconfident_by_worlds_that_come_again():
    """In each combination of student and instruction type other seeds are played: one hard world is counted once."""
    found = audit("llf-bandits-BanditTenArmedRandomFixed-v0", "partial(worlds=256)", turns=300)
    assert not found.caught
    assert found.hedges.verdict == "calibrated"
    assert audit(
        "llf-bandits-BanditTenArmedRandomFixed-v0", "partial(worlds=64) | overconfident", turns=300
    ).overconfident


class Chameleon(str):
    """Equals everything, and prints another room."""

    __hash__ = str.__hash__

    def __eq__(self, other):
        return True

    def __str__(self):
        return "cellar"

    __format__ = lambda self, spec: "cellar"  # noqa: E731


class Row(tuple):
    """Equals everything."""

    __slots__ = ()
    __hash__ = tuple.__hash__

    def __eq__(self, other):
        return True


class Any(enum.Enum):
    """Its members equal everything."""

    ONE = "one"
    __hash__ = enum.Enum.__hash__

    def __eq__(self, other):
        return True


class Fine(enum.StrEnum):
    ONE = "one"


@claim
class Says(Claim):
    """True of everything."""

    what: object

    def holds(self, moment, lab):
        return True


@pytest.mark.parametrize(
    "value", [Chameleon("x"), Row((1,)), Any.ONE, (1, (Chameleon("x"),)), type("I", (int,), {})(3)]
)
def test_a_claim_holds_no_value_that_may_equal_what_it_does_not_say(value):
    with pytest.raises(TypeError, match="no subclasses of them"):
        Says(what=value)


def test_scalars_tuples_and_enumerations_are_held():
    for value in (1, "x", None, True, 0.5, (1, ("x",)), Fine.ONE, (Fine.ONE,)):
        assert Says(what=value).what == value


class Speaker:
    """Says what the oracle says after a change by `twist(atom, turn)`."""

    def __init__(self, twist):
        env = llf_teacher.make(GRID)
        self.teacher, self.twist, self.turn = env.family.make_teacher(env.session.world), twist, 0

    def reset(self, rng):
        self.teacher.reset(rng)
        self.turn = 0

    def act(self, observation, info):
        said = self.teacher.act(observation, info)
        atoms = [self.twist(atom, self.turn) if atom.kind else atom for atom in said.atoms]
        self.turn += 1
        return Utterance.of(atoms)


def heard(twist, turns=60):
    return audit(GRID, Speaker(twist), turns=turns, instruction_types=["b"])


def test_true_claims_in_their_own_words_are_fine():
    found = heard(lambda atom, turn: atom)
    assert not found.caught
    assert not found.reworded


def smuggled(atom, turn):
    """A claim that was made past its constructor."""
    if type(atom.claim) is not Go:
        return atom
    made = fast_constructor(Go)(*(getattr(atom.claim, name) for name in Go.__dataclass_fields__))
    object.__setattr__(made, "action", type("D", (int,), {"__eq__": lambda a, b: True, "__hash__": int.__hash__})(3))
    return atom._replace(claim=made)


def test_a_claim_that_was_changed_after_it_was_made_is_false():
    found = heard(smuggled)
    assert found.caught
    assert "false" in {each.what for each in found.examples}


class Lie(Go):
    """Its own check says that it is true."""

    __slots__ = ()

    def holds(self, moment, lab):
        return True


def test_a_class_of_ones_own_is_not_checked():
    def twist(atom, turn):
        if type(atom.claim) is not Go:
            return atom
        made = object.__new__(Lie)
        for name in Go.__dataclass_fields__:
            object.__setattr__(made, name, getattr(atom.claim, name))
        return atom._replace(claim=made)

    found = heard(twist)
    assert found.count(Label.UNCHECKED) == found.reworded > 10


@pytest.mark.parametrize(
    "twist",
    [
        lambda atom, turn: atom._replace(text=f"Do the opposite: {atom.text}"),
        lambda atom, turn: atom._replace(text="Go to the cellar."),
        lambda atom, turn: Atom(atom.claim, f"{atom.text} Not!", atom.about_turn),
        lambda atom, turn: atom._replace(text=f"Do not {atom.text}"),
    ],
)
def test_other_words_than_those_of_the_claim_are_marked(twist):
    found = heard(twist)
    assert found.reworded >= sum(number for (kind, _), number in found.claims.items() if kind)
    assert found.as_dict()["reworded"] == found.reworded


def test_words_beside_the_claims_are_marked():
    class Beside(Speaker):
        def act(self, observation, info):
            said = super().act(observation, info)
            return Utterance(f"{said} All of this is wrong.", said.atoms)

    found = audit(GRID, Beside(lambda atom, turn: atom), turns=60, instruction_types=["b"])
    assert found.reworded >= found.turns


def test_old_truths_said_as_new_ones_are_marked():
    """What was true at the first turn, in words that speak of now."""
    kept = {}

    def twist(atom, turn):
        if turn == 0:
            kept[type(atom.claim)] = atom
        return kept.get(type(atom.claim), atom)

    assert heard(twist).reworded > 10


FRAMES = """[frames]
fp = ["Do the opposite: {sentence}", "It is wrong: {sentence}", "Never believe this: {sentence}", "No! {sentence}"]
"""


def test_a_voice_that_turns_the_meaning_round_is_marked(tmp_path):
    path = tmp_path / "upside.toml"
    path.write_text(FRAMES)
    found = audit(GRID, "only(kinds='fp')", turns=60, voice=str(path))
    assert found.reworded == sum(number for (kind, _), number in found.claims.items() if kind) > 20
    for voice in ("curt", "plain"):
        assert not audit(GRID, "oracle", turns=60, voice=voice).reworded
    assert audit(GRID, "only(kinds='fp')", turns=60, voice=lambda sentence: f"Do not {sentence}").reworded
    assert audit(GRID, "only(kinds='fp')", turns=60, paraphrase=lambda ways, **slots: "Go to the cellar.").reworded


@pytest.mark.parametrize("spec", ["delayed(turns=2)", "verbose", "sandwich", "partial(worlds=8)", "mix", "scaffold"])
def test_no_shipped_teacher_is_marked(spec):
    assert not audit(GRID, spec, turns=45).reworded
