"""Text mode: strict in meaning, and it executes nothing. Forms of answers are in `answers`."""

import json
from itertools import product

import numpy as np
import pytest
from design import amount
from gymnasium import spaces
from hypothesis import given, settings
from hypothesis import strategies as st
from timing import grows_linearly

import llf_teacher
from pz_envs.family import all_families
from pz_envs.text.actions import failure, legal_text, parse_action, read_exactly
from teachers.atoms import ParseFailure
from worlds.bandits import Bandit
from worlds.gridworld import DIRECTIONS, Gridworld
from worlds.poem import Poem
from worlds.world import World

WORLDS = {family.name: family.make_world(**family.environments[family.showcase[0]]) for family in all_families()}
for world in WORLDS.values():
    world.reset(seed=0)
DISCRETE = {name: world for name, world in WORLDS.items() if isinstance(world.action_space, spaces.Discrete)}
NAMED = [(name, word) for name, world in DISCRETE.items() for word in world.action_words]
HOUSE, ARMS, POEM = WORLDS["gridworld"], WORLDS["bandits"], WORLDS["poem"]

NUMBERS = ["{0}", " {0} ", "{0}\n", '{{"action": {0}}}', '{{ "action" :\t{0} }}']
WORDS = [*("{0}", " {0} ", "{0}.", '"{0}"', "'{0}'", "`{0}`", "**{0}**", "{0}!", '"{0}".'), '{{"action": "{0}"}}']
ANSWERS = [
    "{0}",
    "Response: {0}",
    "response:{0}",
    "RESPONSE:\n\n{0}\n",
    "Thought: I was there.\nResponse: {0}",
    "Thought: north? My first Response: 7 was wrong.\nResponse: {0}",
]


@pytest.mark.parametrize("written", NUMBERS)
@pytest.mark.parametrize("name", DISCRETE)
def test_every_action_is_read_by_its_number(name, written):
    world = DISCRETE[name]
    for action, answer in product(range(world.action_space.n), ANSWERS):
        read = parse_action(answer.format(written.format(action)), world)
        assert read == action
        assert type(read) is type(world.legal(action))


@pytest.mark.parametrize("written", WORDS)
@pytest.mark.parametrize(("name", "word"), NAMED)
def test_every_action_is_read_by_its_name(name, word, written):
    world = DISCRETE[name]
    for answer, case in product(ANSWERS, (str.lower, str.upper, str.title)):
        assert parse_action(answer.format(written.format(case(word))), world) == world.action_words[word]


REFUSED = [
    *("", " ", "Response:", "Response: ", "nowhere", "north east", "north, east", "not north", "north\nsouth"),
    *("NaN", "nan", "Infinity", "-Infinity", "inf", "1e400", "-1e400", "1e3", "0.0", "1.0", "0.5", "1e0", "-0.0"),
    *("-1", "99", "9" * 30, "9" * 900, "9" * 5000, "-" + "9" * 900),
    *("true", "false", "null", "True", "None", '{"action": true}', '{"action": null}'),
    *("+0", "00", "0x0", "0b0", "1_0", "0 1", "0;1", "$0", "0 # arm"),
    *("\u0660", "\u0967", "\uff11", "\u00b9", "\u2460", "\U0001d7cf", "1\u0660", "\u0c67"),
    *("[]", "()", "(", ")", "[0, 1]", "[0", "{}", "{", "}", '"jump"'),
    *('{"action": {}}', '{"action": "jump"}', '{"action": 1.0}'),
    *('{"thought": 0}', '{"why": 0}', '{"action": 0, "action": 0}', '{"action": 0, "answer": 1}', '[{"action": 0}, 1]'),
    *('{"action": NaN}', '{"action": 1e400}', '{"action": 0} {"action": 1}'),
    # Would be actions, or worse, if anything evaluated them.
    *("__import__('os').system('echo ran')", "exec('1')", "1 if True else 0", "lambda: 0", "int('0')", "0 or 1", "0+0"),
    *("\x00", "0\x00", "\x1b[31m0", "\ud800", "0\ud800", "\u202e0", "\\u0030"),
    "Response: 0 Response: jump",
]


@pytest.mark.parametrize("name", DISCRETE)
def test_what_is_no_action_is_refused(name):
    world = DISCRETE[name]
    for text in REFUSED:
        read = parse_action(text, world)
        assert type(read) is ParseFailure, repr(text[:20])
        assert read.expected == world.action_syntax


def test_the_opposite_of_a_marker_is_no_marker():
    assert type(parse_action("Thought: north", HOUSE)) is ParseFailure
    assert parse_action("Response north Response: east", HOUSE) == DIRECTIONS[1]


def test_words_belong_to_their_world():
    assert parse_action("north", HOUSE) == 0
    assert type(parse_action("north", ARMS)) is ParseFailure


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("[0.5, -1]", [0.5, -1]),
        ("(0.5, -1)", [0.5, -1]),
        ("( 1e-3 , 2 )", [0.001, 2]),
        ('{"action": [0.5, -1]}', [0.5, -1]),
        ("[[1, 2], [3, 4]]", [[1, 2], [3, 4]]),
        ("0.5", 0.5),
        ('"x"', "x"),
        ("Response: (0.5, -1)", [0.5, -1]),
    ],
)
def test_numbers_and_lists_reach_the_world_as_values(text, value):
    assert parse_action(text, Anything()) == value


@pytest.mark.parametrize("text", ["[NaN, 0]", "[0, Infinity]", "(NaN, 0)", '{"action": [NaN]}', "true", "(1)(2)"])
def test_what_is_no_number_does_not_reach_the_world(text):
    assert type(parse_action(text, Anything())) is ParseFailure


@pytest.mark.parametrize("error", [ValueError, TypeError, OverflowError, RecursionError])
def test_a_world_that_cannot_read_a_value_refuses_it(error):
    class Picky(Anything):
        def legal(self, action):
            raise error("no")

    assert type(parse_action("0", Picky())) is ParseFailure


class Anything(Bandit):
    """A world that takes every value for an action."""

    def legal(self, action):
        return action


@pytest.mark.parametrize(
    ("text", "poem"),
    [
        ("snow\nrain", "snow\nrain"),
        ("  snow\nrain \n", "snow\nrain"),
        ("Thought: cold.\nResponse: snow\nrain", "snow\nrain"),
        ("RESPONSE:snow", "snow"),
        ('{"action": "snow"}', "snow"),
        ("0", "0"),
        ("", ""),
        ("caf\u00e9 \u2014 \U0001f525", "caf\u00e9 \u2014 \U0001f525"),
        ("x" * 10_000, "x" * 10_000),
    ],
)
def test_a_text_that_is_the_action_is_taken_as_it_is(text, poem):
    assert parse_action(text, POEM) == poem


@pytest.mark.parametrize("text", ["\x00", "snow\x07", "x" * 10_001, "Response: snow\x1b", "Response:"])
def test_a_text_that_is_no_poem_is_refused(text):
    assert type(parse_action(text, POEM)) is ParseFailure
    assert type(legal_text(text, POEM)) is ParseFailure or text.startswith("Response")


def test_a_text_given_as_it_is_has_no_marker():
    assert legal_text("Thought: cold.\nResponse: snow", POEM) == "Thought: cold.\nResponse: snow"


@pytest.mark.parametrize(
    ("text", "got"),
    [
        ("jump", "jump"),
        ("", ""),
        ("\n a\tb\x00c\nd", "a\\tb\\x00c"),
        ("\ud800\u202e", "\\ud800\\u202e"),
        ("\x00" * 99, "\\x00" * 19 + "\\..."),
        ("x" * 80, "x" * 80),
        ("x" * 81, "x" * 77 + "..."),
        ("x" * 10**6, "x" * 77 + "..."),
        ("caf\u00e9 \U0001f525", "caf\u00e9 \U0001f525"),
    ],
)
def test_a_failure_quotes_a_printable_excerpt(text, got):
    assert failure(text, HOUSE) == ParseFailure(got, HOUSE.action_syntax)


def check(text, world):
    read = parse_action(text, world)
    if type(read) is ParseFailure:
        assert len(read.got) <= 80
        assert read.got.isprintable()
        assert read.expected == world.action_syntax
    else:
        assert world.legal(read) == read
    return read


class Thrower(Bandit):
    """A world whose actions are dicts."""

    def __init__(self, **parts):
        super().__init__()
        self.action_space = spaces.Dict(parts or {"m": spaces.Discrete(3), "v": spaces.Box(-1, 1, (2,))})
        del self.__dict__["action_syntax"]

    legal = World.legal


@pytest.mark.parametrize("written", ["{0}", "Response: {0}", '{{"action": {0}}}', " {0}\n"])
def test_a_dict_is_written_as_the_instruction_asks(written):
    world = Thrower()
    assert world.action_syntax.startswith('a JSON object with "m": an integer from 0 to 2; "v": a list of 2 numbers')
    answer = '{"m": 1, "v": [0.5, -0.5]}'
    assert parse_action(written.format(answer), world) == (("m", 1), ("v", (0.5, -0.5)))


@pytest.mark.parametrize(
    "text",
    [
        *('{"m": 1}', '{"m": 1, "v": [0.5, -0.5], "w": 0}', '{"m": 1, "m": 1, "v": [0, 0]}', '{"m": 3, "v": [0, 0]}'),
        *(
            '{"m": true, "v": [0, 0]}',
            '{"m": 1, "v": [false, 0]}',
            '{"m": 1, "v": {"v": [0, 0]}}',
            '{"m": 1, "v": [NaN, 0]}',
        ),
        *("{}", '{"action": 1}', '{"action": {}}', '{"m": 1, "v": [0, 0], "action": 1}', "1"),
    ],
)
def test_another_dict_is_refused(text):
    assert type(parse_action(text, Thrower())) is ParseFailure


def test_dicts_within_and_a_key_that_is_called_action():
    world = Thrower(action=spaces.Discrete(2))
    assert parse_action('{"action": 1}', world) == (("action", 1),)
    assert parse_action('{"action": {"action": 2}}', world).got == '{"action": {"action": 2}}'
    nested = Thrower(a=spaces.Dict(b=spaces.Discrete(2)), c=spaces.Sequence(spaces.Discrete(2)))
    assert parse_action('{"a": {"b": 1}, "c": [0, 1, 1]}', nested) == (("a", (("b", 1),)), ("c", (0, 1, 1)))


FRAGMENTS = ["Response:", "Thought:", "north", "action", '{"action":', "__import__('os')", "1e400", "NaN", "-", "true"]
fragments = st.lists(st.sampled_from([*FRAGMENTS, *'0123[](){}",:.\\ \n\x00\u0660\ud800']), max_size=30).map("".join)
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["action", "a"]), inner, max_size=2),
    max_leaves=6,
)


@given(text=st.text(st.characters(), max_size=200) | fragments | values.map(json.dumps))
@settings(deadline=None, max_examples=300)
def test_any_text_is_an_action_or_a_failure(text):
    for world in WORLDS.values():
        check(text, world)


@given(text=st.text(st.sampled_from("0123.-[](), \"'`*north{}:x="), max_size=30) | fragments | values.map(json.dumps))
@settings(deadline=None, max_examples=300)
def test_what_is_an_action_and_nothing_else_means_what_it_says(text):
    for world in WORLDS.values():
        exact = read_exactly(text, world)
        if type(exact) is not ParseFailure and not isinstance(world.action_space, spaces.Text):
            assert parse_action(text, world) == exact


HUGE = [
    *(
        "[",
        "(",
        "{",
        '{"action":',
        '"',
        "\\",
        "9",
        "-",
        "0 ",
        "\x00",
        "\ud800",
        "Response:",
        "response: ",
        "\n",
        " ",
        "'",
    ),
    *("()", "[]", "north ", "1e", "NaN,", "\u0660", "__import__('os')"),
]


def some(name, pieces):
    """A third of them, another one for each of three families in turn."""
    return amount(pieces[list(WORLDS).index(name) % 3 :: 3], full=pieces)


@pytest.mark.parametrize("name", WORLDS)
def test_a_huge_text_returns(name):
    world = WORLDS[name]
    for piece in some(name, HUGE):
        text = piece * (20_000 // len(piece))
        for answer in (text, f"Response: {text}", f"[{text}]", f"({text})", f'{{"action": {text}}}'):
            assert type(check(answer, world)) is ParseFailure or isinstance(world.action_space, spaces.Text), piece


@pytest.mark.parametrize("name", WORLDS)
@pytest.mark.parametrize("nested", [("[", "]"), ('{"action": ', "}"), ("(", ")"), ("{'a': [", "]}")])
def test_deep_brackets_are_no_error(name, nested):
    for depth in (50, 400, 700, 950, 3000):
        text = f"{nested[0] * depth}0{nested[1] * depth}"
        for answer in (text, f"Response: {text}", f"north {text}", f"```json\n{text}"):
            check(answer, WORLDS[name])


SLOW = [
    *HUGE,
    "```\n",
    "answer: 0\n",
    "a:\n",
    "<answer>",
    "\\boxed{",
    "{'a'",
    "[1,2]\n",
    "x1 = 1, ",
    "</think>",
    "'\\",
    "a (",
    "\n\n",
    "1, ",
    ", I go",
    " " * 20,
]


@pytest.mark.parametrize("name", WORLDS)
def test_no_text_takes_long(name):
    slow = [
        piece
        for piece in some(name, SLOW)
        if not grows_linearly(
            lambda size, piece=piece: parse_action(f"north {piece * (size // len(piece))}", WORLDS[name])
        )
    ]
    assert slow == []


def test_the_answer_behind_many_markers_is_found():
    assert check("Response: " * 10_000 + "north", HOUSE) == 0
    assert check("x" * 100_000 + " Response: 3", HOUSE) == 3


@pytest.mark.parametrize("world", [Gridworld(), Bandit(), Poem()], ids=lambda world: type(world).__name__)
@pytest.mark.parametrize("text", ["0", "north", "jump", "\x00"])
def test_reading_changes_nothing(world, text):
    world.reset(seed=0)
    before, drawn = world.save(), world.np_random.bit_generator.state
    parse_action(text, world)
    assert world.save() == before
    assert world.np_random.bit_generator.state == drawn


def test_numbers_are_given_in_the_form_that_the_world_takes():
    assert type(parse_action("2", ARMS)) is int
    assert parse_action("2", HOUSE) is DIRECTIONS[2]
    assert not isinstance(parse_action("2", ARMS), np.generic)


@pytest.mark.parametrize("text", ["[- 1, 0]", "(- 1, 0)", "Response: [ - 1, 0 ]", "x = [- .5, 0]", '["- 1", "0"]'])
def test_a_sign_apart_from_its_number_is_not_lost(text):
    """`[- 1, 0]` is not 1, 0."""
    world = llf_teacher.make("llf-optimization-Booth-v0").session.world
    assert type(parse_action(text, world)) is ParseFailure


@pytest.mark.parametrize(
    "text", ["[\u22121, \u22120.5]", '{"action": [\u22121, \u22120.5]}', "{'x1': \u22121, 'x2': \u22120.5,}"]
)
def test_the_minus_sign_of_unicode_is_one_in_json_too(text):
    world = llf_teacher.make("llf-optimization-Booth-v0").session.world
    assert parse_action(text, world) == (-1.0, -0.5)
