"""Spec strings of personalities: they round-trip, compose, and run nothing."""

import copy
import dataclasses
import inspect
import pickle
import re
import sys
from types import ModuleType
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import llf_teacher
from teachers.common import Solved
from teachers.personalities.delayed import Delayed
from teachers.personalities.drifting import Drifting
from teachers.personalities.mistake import mistake
from teachers.personalities.only import Only
from teachers.personalities.oracle import oracle
from teachers.personality import PERSONALITIES, Personality, Pipeline, parse_personality, personality
from teachers.spec import Range, Registry, Share, SpecCall, parse_call, parse_calls, paths_in

NAMES = PERSONALITIES.names
# Values for parameters; a parameter that is not listed keeps its default.
VALUES = {
    "eps": st.floats(0, 1) | st.integers(0, 1),
    "turns": st.integers(0, 50),
    **dict.fromkeys(("p", "q", "rate", "fade", "plus", "minus", "fraction"), st.floats(0, 1)),
    **dict.fromkeys(("likelihood", "consistency"), st.floats(0, 1)),
    **dict.fromkeys(("budget", "after", "level", "k", "top_k"), st.integers(0, 50)),
    **dict.fromkeys(("threshold", "beta"), st.floats(0, 1e6)),
    "n": st.integers(1, 50),
    "gamma": st.floats(0, 0.99),
    "low": st.floats(0, 0.5),
    "high": st.floats(0.5, 1),
    "to": st.sampled_from(["silent", "mistake(eps=0.5) | delayed(turns=2)", "drifting(to='only(kinds=\\'r\\')')"]),
    "kinds": st.sampled_from(["r", "hp+fn", "r+hp+hn+fp+fn", "n"]),
}


def some(name):
    cls = PERSONALITIES[name]
    values = {field.name: VALUES[field.name] for field in dataclasses.fields(cls) if field.name in VALUES}
    return st.builds(cls, **values)


stages = st.sampled_from(NAMES).flatmap(some)
pipelines = st.lists(stages, min_size=2, max_size=5).map(lambda parts: Pipeline(tuple(parts)))


@pytest.mark.parametrize("name", NAMES)
def test_every_personality_is_named_like_its_module(name):
    personality = parse_personality(name)
    assert personality.name == str(personality) == name
    assert personality == PERSONALITIES[name]() == parse_personality(f" {name}() ")
    assert parse_personality(personality) is personality


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("x = 3", "broken.py must define one personality, a class that derives from .*Personality; it defines none"),
        ("def f(:", "the personality 'broken' cannot be imported: SyntaxError: .*; mend .*broken.py:1$"),
        ("import nowhere_at_all", "cannot be imported: ModuleNotFoundError: No module .*; mend .*broken.py$"),
        ("1 / 0", "cannot be imported: ZeroDivisionError: division by zero; mend .*broken.py$"),
    ],
)
def test_a_broken_file_is_named(written, message, tmp_path, monkeypatch):
    package = ModuleType("half_written")
    package.__path__ = [str(tmp_path)]
    monkeypatch.setitem(sys.modules, "half_written", package)
    (tmp_path / "broken.py").write_text(written)
    with pytest.raises(ValueError, match=message):
        Registry("personality", Personality, package)["broken"]
    sys.modules.pop("half_written.broken", None)


@given(stages | pipelines)
def test_specs_round_trip(personality):
    text = str(personality)
    parsed = parse_personality(text)
    assert parsed == personality
    assert type(parsed) is type(personality)
    assert hash(parsed) == hash(personality)
    assert str(parsed) == text
    assert pickle.loads(pickle.dumps(personality)) == personality


@pytest.mark.parametrize(
    ("personality", "text"),
    [
        (mistake(eps=0.1), "mistake"),
        (mistake(eps=0.2), "mistake(eps=0.2)"),
        (Only("r+hp"), "only(kinds='r+hp')"),
        (Delayed(turns=3), "delayed(turns=3)"),
        (mistake(eps=0.2) | Delayed(2), "mistake(eps=0.2) | delayed(turns=2)"),
        (oracle() | mistake() | Delayed(), "oracle | mistake | delayed"),
    ],
)
def test_only_what_is_not_the_default_is_written(personality, text):
    assert str(personality) == text
    assert parse_personality(text) == personality


@dataclasses.dataclass(frozen=True)
class Sleepy(Personality):
    """Is defined elsewhere than on the shelf."""

    naps: int = 2


@personality(source="a dream", needs=["values", "plan"], honest=False, reveals=False)
def dreamy(claims, view, rng, *, share: Share = 0.5, least: int = 1, most: Annotated[int, Range("least", 9)] = 9):
    """Is a function, elsewhere than on the shelf."""
    return list(claims[: rng.integers(least, most, endpoint=True)]) if rng.random() < share else []


@dataclasses.dataclass(frozen=True)
class Oracle2(oracle):
    """Derived from one on the shelf."""


def test_a_personality_from_elsewhere_is_named_by_its_module_and_class():
    text = f"{__name__}:Sleepy(naps=3) | delayed(turns=2) | {__name__}:Oracle2"
    assert str(Sleepy()) == f"{__name__}:Sleepy"
    assert str(Sleepy(3) | Delayed(2) | Oracle2()) == text
    assert parse_personality(text) == Sleepy(3) | Delayed(2) | Oracle2()
    with pytest.raises(ValueError, match="unknown personality 'Sleepy'"):
        parse_personality("Sleepy")
    with pytest.raises(ValueError, match=r"unknown personality in .*test_specs 'Sleep'; did you mean Sleepy"):
        parse_personality(f"{__name__}:Sleep")
    assert paths_in(f"mistake | {__name__}:Sleepy | drifting(to='a.b:C | d:E(to=3)')") == [
        f"{__name__}:Sleepy",
        "a.b:C",
        "d:E",
    ]
    assert paths_in("llm(base_url='http://localhost:1/v1')") == []


def test_a_function_becomes_a_frozen_value():
    assert isinstance(dreamy(), Personality)
    assert dreamy() == dreamy(share=0.5) != dreamy(share=0.25)
    assert len({dreamy(), dreamy(share=0.5), dreamy(share=0.25), mistake()}) == 3
    assert [field.name for field in dataclasses.fields(dreamy)] == ["share", "least", "most"]
    assert dreamy.__doc__ == "Is a function, elsewhere than on the shelf."
    assert (dreamy.source, dreamy().needs) == ("a dream", {"values", "plan"})
    assert (dreamy().honest, dreamy().reveals, dreamy().transparent) == (False, False, False)
    assert (mistake().needs, mistake().honest, mistake().reveals) == (frozenset(), False, True)
    assert str(dreamy(share=0.25, most=3) | Delayed(2)) == f"{__name__}:dreamy(share=0.25, most=3) | delayed(turns=2)"
    with pytest.raises(dataclasses.FrozenInstanceError):
        dreamy().share = 1
    with pytest.raises(TypeError, match="positional"):
        dreamy(0.5)
    for value in (dreamy(share=0.25), dreamy() | Delayed(2)):
        assert copy.deepcopy(value) == pickle.loads(pickle.dumps(value)) == value


def test_a_function_is_asked_each_turn_with_its_parameters_and_the_random_stream():
    claims = tuple(Solved() for _ in range(9))
    for spec, (share, least, most) in ((dreamy(), (0.5, 1, 9)), (dreamy(share=1, least=2, most=4), (1, 2, 4))):
        stage, rng = spec.start(np.random.default_rng(5)), np.random.default_rng(5)
        expected = [rng.integers(least, most, endpoint=True) if rng.random() < share else 0 for _ in range(50)]
        assert [len(stage.speak(claims, None)) for _ in range(25)] == expected[:25]
        stage = pickle.loads(pickle.dumps(copy.deepcopy(stage)))
        assert [len(stage.speak(claims, None)) for _ in range(25)] == expected[25:]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"share": 2}, "share must be a number from 0 to 1, got 2"),
        ({"share": True}, "share must be a number from 0 to 1, got True"),
        ({"most": 10}, "most must be an integer from 1 to 9, got 10"),
        ({"most": 1.5}, r"most must be an integer from 1 to 9, got 1\.5"),
        ({"least": 4, "most": 3}, "most must be an integer from 4 to 9, got 3"),
    ],
)
def test_the_parameters_of_a_function_are_checked(given, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        dreamy(**given)


def no_view(claims):
    return claims


def other_names(view, claims):
    return claims


def by_position(claims, view, eps=0.1):
    return claims


def without_default(claims, view, *, eps):
    return claims


def rest(claims, *view):
    return claims


def anything(claims, view, **parameters):
    return claims


def late_random_stream(claims, view, *, rng=None, start=0):
    return claims


@pytest.mark.parametrize(
    "function", [no_view, other_names, by_position, without_default, rest, anything, late_random_stream]
)
def test_a_function_of_another_signature_is_no_personality(function):
    given = re.escape(str(inspect.signature(function)))
    with pytest.raises(
        TypeError, match=rf"^{function.__name__}{given} is not a personality: it must take \(claims, view\)"
    ):
        personality()(function)


def test_what_stands_behind_a_bar_must_be_a_personality():
    with pytest.raises(
        TypeError, match=r"^what stands behind \| must be a personality, such as harsh\(\), got 'harsh'$"
    ):
        mistake() | "harsh"


def test_a_personality_that_returns_nothing_is_refused_by_name():
    @personality()
    def forgetful(claims, view):
        """Forgets to return."""

    env = llf_teacher.make("llf-gridworld-v0", teacher=forgetful())
    with pytest.raises(TypeError, match=r"forgetful must return claims, .*or \(\) to say nothing, got None"):
        env.reset(seed=0)


def test_a_default_out_of_range_and_an_unknown_need_are_refused_at_once():
    def bold(claims, view, *, eps: Share = 1.5):
        return claims

    with pytest.raises(ValueError, match=r"^eps must be a number from 0 to 1, got 1\.5$"):
        personality()(bold)
    with pytest.raises(
        ValueError, match=r"^unknown ability 'value'; did you mean values or clues\? allowed: values, import"
    ):
        personality(needs=["hindsight", "value"])


@pytest.mark.parametrize(
    "to", [Sleepy(), dreamy(), oracle() | dreamy(share=1), Sleepy(3) | Delayed(2), mistake() | Oracle2()]
)
def test_a_spec_within_a_spec_may_name_a_class_of_ones_own(to):
    drifting = Drifting(to=to)
    assert parse_personality(drifting.to) == to
    assert parse_personality(str(drifting)) == drifting


def test_what_no_spec_can_name_is_refused_where_a_spec_is_needed():
    @personality()
    def hidden(claims, view):
        """Says all."""
        return claims

    assert str(hidden()) == "hidden"
    for to in (hidden(), mistake() | hidden()):
        with pytest.raises(ValueError, match=r"^to must be a spec, .* got .*hidden\(.*; define it in a module"):
            Drifting(to=to)
    assert Drifting(to=mistake(eps=0.5) | Delayed(2)).to == "mistake(eps=0.5) | delayed(turns=2)"


def test_composition_is_the_parsed_string():
    assert mistake(eps=0.2) | Delayed(2) == parse_personality("mistake(eps=0.2)|delayed(turns=2)")
    assert mistake(eps=0.2) | Delayed(2) != Delayed(2) | mistake(eps=0.2)
    assert (mistake() | Delayed()) | oracle() == mistake() | (Delayed() | oracle())


@pytest.mark.parametrize("name", NAMES)
def test_personalities_are_frozen(name):
    personality = parse_personality(name)
    for field in dataclasses.fields(personality):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(personality, field.name, 1)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            "mistakes",
            r"unknown personality 'mistakes'; did you mean mistake\b.*\? allowed: adversarial, ",
        ),
        ("oracle | orcale", r"unknown personality 'orcale'; did you mean oracle\b.*\? allowed: "),
        ("Oracle", r"unknown personality 'Oracle'; did you mean oracle\b.*\? allowed: "),
        ("__init__", "unknown personality '__init__'; .*allowed: "),
        ("mistake(rate=1)", "personality 'mistake': unknown parameter 'rate'; allowed: eps$"),
        ("oracle(eps=1)", "personality 'oracle': unknown parameter 'eps'; allowed: none$"),
        ("mistake(eps=2)", "eps must be a number from 0 to 1, got 2"),
        ("mistake(eps=1e999)", "eps must be a number from 0 to 1, got inf"),
        ("delayed(turns=-1)", "turns must be an integer from 0 to 10000, got -1"),
        ("delayed(turns=1.5)", r"turns must be an integer from 0 to 10000, got 1\.5"),
        ("delayed(turns=10001)", "turns must be an integer from 0 to 10000, got 10001"),
        ("only(kinds='x')", "feedback type 'x' names 'x'; allowed: "),
        ("only(kinds=5)", r"kinds must be names of kinds joined by '\+', got 5"),
    ],
)
def test_errors_name_what_is_wrong_and_what_is_allowed(spec, message):
    with pytest.raises(ValueError, match=message):
        parse_personality(spec)


@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf"), "0.1", True, None, [0.1]])
def test_constructors_check_their_parameters(value):
    with pytest.raises(ValueError, match="eps must be a number from 0 to 1, got"):
        mistake(eps=value)


BAD_SYNTAX = [
    "",
    " ",
    "|",
    "oracle |",
    "| oracle",
    "oracle || silent",
    "oracle silent",
    "oracle, silent",
    "oracle; silent",
    "oracle & silent",
    "oracle + silent",
    "oracle or silent",
    "not oracle",
    "'oracle'",
    "5",
    "oracle.start",
    "oracle[0]",
    "oracle()()",
    "(oracle, silent)",
    "[oracle]",
    "mistake(0.1)",
    "mistake(*[0.1])",
    "mistake(**{'eps': 0.1})",
    "mistake(eps)",
    "mistake(eps=)",
    "mistake(eps=oracle)",
    "mistake(eps=float('0.1'))",
    "mistake(eps=delayed(turns=1))",
    "mistake(eps=0.1",
    "mistake eps=0.1",
    "mistake(eps=1/2)",
    "mistake(eps=10**10**10)",
    "mistake(eps=[0][0])",
    "mistake(eps=f'{0}')",
    "lambda: oracle",
    "oracle if 1 else silent",
    "x := oracle",
    "import os",
    "oracle\nsilent",
    "oracle\x00",
    "oracle\ud800",
    "mistake(eps={[]: 1})",
    "mistake(eps={[]})",
    "mistake(eps=0.1, eps=0.2)",
]


@pytest.mark.parametrize("spec", BAD_SYNTAX)
def test_bad_syntax_is_refused_with_the_names(spec):
    with pytest.raises(ValueError, match=r"(?s)bad personality spec .*expected names with .*; names: adversarial, "):
        parse_personality(spec)


@pytest.mark.parametrize(
    ("text", "calls"),
    [
        ("mistake", [SpecCall("mistake", {})]),
        ("a(x=1,) | b(y=-2.5, z=None)", [SpecCall("a", {"x": 1}), SpecCall("b", {"y": -2.5, "z": None})]),
        ("(a | b()) | c", [SpecCall("a", {}), SpecCall("b", {}), SpecCall("c", {})]),
        ("a | (b | c)", [SpecCall("a", {}), SpecCall("b", {}), SpecCall("c", {})]),
        ("p.q : a(x={'k': [1, (2,)]})", [SpecCall("a", {"x": {"k": [1, (2,)]}}, ("p.q",))]),
        ("p:a |\n chat:p.q:b", [SpecCall("a", {}, ("p",)), SpecCall("b", {}, ("chat", "p.q"))]),
        ("a(x='b | c:d@e (') | p:a", [SpecCall("a", {"x": "b | c:d@e ("}), SpecCall("a", {}, ("p",))]),
        ("a(x='''it's | ''' \"'\")  # b | c", [SpecCall("a", {"x": "it's | '"})]),
    ],
)
def test_a_spec_string_is_calls(text, calls):
    assert list(parse_calls("test", text, "calls", prefixes=2)) == calls
    written = " | ".join(map(str, calls))
    assert list(parse_calls("test", written, "calls", prefixes=2)) == calls


@pytest.mark.parametrize(
    "text",
    [*BAD_SYNTAX, "p:", ":a", "a:b:c:d", "p:(q:a)", "(p:a)", "p@a", "(p@a)", "p:a.b", "p()(): a", "a) | (b", "p::a"],
)
def test_what_is_no_calls_is_refused(text):
    with pytest.raises(ValueError, match=r"(?s)^bad test spec .*; expected calls$"):
        parse_calls("test", text, "calls", prefixes=2)


def test_prefixes_and_parts_are_counted():
    with pytest.raises(ValueError, match=r"^bad test spec 'p:q:a'; expected a call$"):
        parse_calls("test", "p:q:a", "a call", prefixes=1)
    with pytest.raises(ValueError, match=r"^test spec 'a \| b' has 2 parts, separated by `\|`; allowed: 1$"):
        parse_call("test", "a | b", "a call")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no_such_module:f", "test 'no_such_module:f': cannot import the module 'no_such_module': ModuleNotFound"),
        ("fnmatch:filter(name='x')", "test 'fnmatch:filter': unknown parameter 'name'; did you mean names"),
        ("fnmatch:filter(pat='x')", r"test 'fnmatch:filter': cannot call filter\(names, pat\): missing .*'names'"),
        ("fnmatch:filter(names=[], pat='x')", None),
    ],
)
def test_a_call_is_checked_against_what_it_calls(text, message):
    call = parse_call("test", text, "a call", prefixes=1)
    if message is None:
        call.check_arguments("test", call.imported("test")[1])
        return
    with pytest.raises(ValueError, match=message):
        call.check_arguments("test", call.imported("test")[1])


@pytest.mark.parametrize("spec", [None, 5, 0.1, ["oracle"], object()])
def test_what_is_no_string_is_refused(spec):
    with pytest.raises(ValueError, match="bad personality spec"):
        parse_personality(spec)


CODE = [
    "__import__('pathlib').Path({path!r}).touch()",
    "open({path!r}, 'w')",
    "mistake(eps=open({path!r}, 'w'))",
    "mistake(eps=__import__('pathlib').Path({path!r}).touch())",
    "mistake(eps=[open({path!r}, 'w') for _ in (1,)])",
    "oracle | open({path!r}, 'w')",
    "(lambda: open({path!r}, 'w'))()",
    "mistake(eps=(x := open({path!r}, 'w')))",
    "mistake(eps=f\"{{open({path!r}, 'w')}}\")",
]


@pytest.mark.parametrize("code", CODE)
def test_code_is_refused_and_does_not_run(code, tmp_path):
    path = tmp_path / "ran"
    with pytest.raises(ValueError, match=r"bad personality spec|unknown personality"):
        parse_personality(code.format(path=str(path)))
    assert not path.exists()


HUGE = [
    "(" * 100_000,
    "(" * 150 + "oracle" + ")" * 150 + "x",
    "mistake(eps=" + "[" * 50_000 + "]" * 50_000 + ")",
    "mistake(eps=" + "-" * 50_000 + "1)",
    "mistake(eps=" + "1+" * 50_000 + "1)",
    "mistake(eps=" + "9" * 5000 + ")",
    "oracle | " * 50_000 + "oracle",
    "oracle(" * 50_000,
    "oracle" + "()" * 50_000,
    "oracle" + ".x" * 50_000,
    "x" * 1_000_000,
    "'" + "x" * 1_000_000,
    "\\" * 100_000,
]


@pytest.mark.parametrize("spec", HUGE, ids=lambda spec: f"{spec[:20]}...{len(spec)}")
def test_very_long_and_deeply_nested_strings_are_refused(spec):
    with pytest.raises(ValueError, match=r"bad personality spec|unknown personality|eps must be"):
        parse_personality(spec)


tokens = st.sampled_from([*NAMES, *"()[]{}|=,.'\"*01-: ", "eps", "turns"])


@given(st.text(max_size=50) | st.lists(tokens, max_size=12).map("".join))
def test_any_text_is_a_spec_or_a_value_error(text):
    try:
        personality = parse_personality(text)
    except ValueError:
        return
    assert parse_personality(str(personality)) == personality
