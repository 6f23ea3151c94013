"""JSON is found within other words, and read strictly."""

import pytest

from pz_envs.text.json_values import find_message, finite_value, unique_keys


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"claims":' + "[" * 100_000, "", "{}{}", '{"a": NaN}', '{"a":1,"a":2}']
)
def test_no_text_raises(text):
    assert find_message(text) is None


def test_a_message_is_found_in_a_text():
    assert find_message('Sure!\n```json\n{"claims": []}\n```') == {"claims": []}


@pytest.mark.parametrize(
    "text",
    [
        'The set {a, b} is {"empty"}: {"claims": []} Hope {that} helps.',
        "{" * 20 + '{"claims": []}',
        '{"claims": []} {"claims": [1]}',
    ],
)
def test_braces_may_stand_around_a_message(text):
    assert find_message(text) == {"claims": []}
    assert find_message("{a} " + text.replace('"claims"', '"claim"')) is None


@pytest.mark.parametrize("text", ['{"a": 1, "a": 2}', "[1e999]", "NaN", "-Infinity", "1 2", "[" * 100_000])
def test_a_value_is_json_as_a_whole_and_finite(text):
    with pytest.raises((ValueError, RecursionError)):
        finite_value(text)
    assert finite_value(' {"a": [1.5, "x"]} ') == {"a": [1.5, "x"]}


def test_a_key_occurs_once():
    with pytest.raises(ValueError, match="each key must occur once, got a, b, a"):
        unique_keys([("a", 1), ("b", 2), ("a", 3)])
