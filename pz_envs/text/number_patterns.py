"""Regular expressions of decimal numbers between two bounds, for JSON Schemas that grammars keep.

llama.cpp's grammars ignore the bounds of a JSON number, but keep the pattern of a string.
"""

import math
from collections.abc import Iterator
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

__all__ = ["number_pattern"]

_DECIMALS = 6
_STEP = Decimal(1).scaleb(-_DECIMALS)
_INTEGERS = 15  # digits of a number without a bound
_FREE = f"[0-9]{{1,{_INTEGERS}}}(\\.[0-9]{{1,{_DECIMALS}}})?"


def number_pattern(low: float, high: float) -> str:
    """A pattern, without anchors, of numbers from `low` to `high` with at most six decimals.

    It has no other constructs than alternatives, groups, ranges of digits and counts. Next to a bound with decimals, a
    number has at least as many decimals as the bound.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return f"-?{_FREE}"
    least = Decimal(repr(float(low))).quantize(_STEP, ROUND_CEILING)
    most = Decimal(repr(float(high))).quantize(_STEP, ROUND_FLOOR)
    found = []
    if least < 0:
        found.append(f"-({_unsigned(max(-most, Decimal(0)), -least)})")
    if most >= 0:
        found.append(_unsigned(max(least, Decimal(0)), most))
    return f"({'|'.join(found)})"


def _unsigned(low: Decimal, high: Decimal) -> str:
    """Numbers between two bounds of at least 0."""
    (first, after), (last, until) = _parts(low), _parts(high)
    if first == last:
        return _number(str(first), after, until)
    inner = [f"({each})(\\.[0-9]{{1,{_DECIMALS}}})?" for each in _integers(first + bool(after), last - 1)]
    return "|".join([*([_number(str(first), after, "")] if after else ()), *inner, _number(str(last), "", until)])


def _parts(number: Decimal) -> tuple[int, str]:
    """The integer part and the decimals, without zeros at their end."""
    whole, _, decimals = f"{number:f}".partition(".")
    return int(whole), decimals.rstrip("0")


def _number(whole: str, after: str, until: str) -> str:
    """Numbers with an integer part, whose decimals are at least `after` and at most `until`; for "": 0 and any 9s."""
    digits = max(len(after), len(until))
    low = after.ljust(digits, "0")
    if not digits:  # both bounds are the integer, or `until` is "" as the decimals of an integer
        return f"{whole}(\\.0{{1,{_DECIMALS}}})?"
    high = until.ljust(digits, "0") if until or not after else "9" * digits
    rest = _DECIMALS - digits
    tail = f"[0-9]{{0,{rest}}}" if rest else ""
    zeros = f"0{{0,{rest}}}" if rest else ""
    if until or not after:
        below = [f"{each}{tail}" for each in _fixed(low, str(int(high) - 1).zfill(digits))] if low < high else []
        found = [*below, f"{high}{zeros}"]
    else:
        found = [f"{each}{tail}" for each in _fixed(low, high)]
    decimals = f"(\\.({'|'.join(found)}))"
    return f"{whole}{decimals}" if after else f"{whole}{decimals}?"


def _integers(low: int, high: int) -> Iterator[str]:
    """Patterns of the integers from `low` to `high`, each of one length."""
    for length in range(len(str(low)), len(str(high)) + 1):
        least, most = max(low, 10 ** (length - 1) if length > 1 else 0), min(high, 10**length - 1)
        if least <= most:
            yield from _fixed(str(least), str(most))


def _fixed(low: str, high: str) -> list[str]:
    """Patterns of the texts of digits between two texts of the same length."""
    if not low:
        return [""]
    if low[0] == high[0]:
        return [low[0] + each for each in _fixed(low[1:], high[1:])]
    rest = len(low) - 1
    zeros, nines = "0" * rest, "9" * rest
    found, first, last = [], int(low[0]), int(high[0])
    if low[1:] != zeros:
        found += [low[0] + each for each in _fixed(low[1:], nines)]
        first += 1
    if high[1:] != nines:
        last -= 1
    if first <= last:
        found.append((f"[{first}-{last}]" if first < last else f"{first}") + "[0-9]" * rest)
    if high[1:] != nines:
        found += [high[0] + each for each in _fixed(zeros, high[1:])]
    return found
