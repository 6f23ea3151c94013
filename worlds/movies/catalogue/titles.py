"""Titles: which works a title stands for, whatever its case, punctuation, leading article and small typos.

Nothing is guessed: a title that fits several works stands for all of them, and one that is not close enough for none.
"""

import re
import unicodedata
from collections.abc import Sequence
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

__all__ = ["Titles", "fold"]

_YEAR = re.compile(r"\s*\(\s*(\d{4})\s*(?:[-\u2013]\s*(?:\d{4})?\s*)?\)\s*$")
_ARTICLE_LAST = re.compile(r"(.*), (the|an?)", re.IGNORECASE | re.DOTALL)
_ARTICLE_FIRST = re.compile(r"(?:the|an?) (?=.)")
_DROPPED = str.maketrans("", "", ".'*\u2018\u2019\u00b4`")  # "L.A." is "LA", "Schindler's" is "Schindlers"
_WORD = re.compile(r"[^\W_]+")
_NUMERAL = re.compile(r"\d+|[ivx]+")
_SHORTEST = 6  # characters of a folded title in which one typo is forgiven ...
_LONG = 12  # ... and in which two are


@lru_cache(maxsize=8192)
def fold(title: str) -> str:
    """A title without case, accents, punctuation and leading article."""
    text = title.casefold().replace("&", " and ")
    if not text.isascii():
        text = unicodedata.normalize("NFKD", text)
        text = "".join(character for character in text if not unicodedata.combining(character))
    if last := _ARTICLE_LAST.fullmatch(text.strip()):  # "Matrix, The"
        text = last[1]
    words = " ".join(_WORD.findall(text.translate(_DROPPED)))
    return _ARTICLE_FIRST.sub("", words, count=1) if _ARTICLE_FIRST.match(words) else words


class Titles:
    """The titles of a list of works, to be looked up.

    Args:
        works: title and first year of each.
    """

    def __init__(self, works: Sequence[tuple[str, int]]) -> None:
        self._works = works
        self._keys = [fold(title) for title, _ in works]
        self._by_key: dict[str, list[int]] = {}
        self._by_length: dict[int, list[str]] = {}
        for i, key in enumerate(self._keys):
            self._by_key.setdefault(key, []).append(i)
        for key in self._by_key:
            self._by_length.setdefault(len(key), []).append(key)

    def label(self, work: int) -> tuple[str, bool]:
        """What names a work: its title, with the year if others have the same; and whether that names no other."""
        title, year = self._works[work]
        if len(self._by_key[self._keys[work]]) == 1 and not _YEAR.search(title):
            return title, True
        label = f"{title} ({year})"
        return label, self.find(label) == (work,)

    def find(self, text: str) -> tuple[int, ...]:
        """The works that a title stands for, in order.

        A year in brackets behind the title must be the work's first year, or the only one that is next to it.
        """
        year = _YEAR.search(text)
        key = fold(text[: year.start()] if year else text)
        works = self._by_key.get(key) or self._close(key)
        if year:
            wanted = int(year[1])
            for distance in (0, 1):
                if near := [i for i in works if abs(self._works[i][1] - wanted) == distance]:
                    return tuple(near)
            return ()
        return tuple(works)

    def _close(self, key: str) -> list[int]:
        """The works whose titles are as few typos away as can be, but no more than are forgiven."""
        if len(key) < _SHORTEST:
            return []
        most = 2 if len(key) >= _LONG else 1
        found: list[tuple[int, str]] = []
        for length in range(max(len(key) - most, _SHORTEST), len(key) + most + 1):
            keys = self._by_length.get(length, ())
            close = process.extract_iter(key, keys, scorer=OSA.distance, score_cutoff=most)
            found += [(int(distance), other) for other, distance, _ in close if _typo(key, other)]
        least = min(found, default=(0, ""))[0]
        return sorted(i for distance, other in found if distance == least for i in self._by_key[other])


def _typo(key: str, other: str) -> bool:
    """Whether titles may differ by mistake: another number or a plural is another work."""
    if _numerals(key) != _numerals(other):
        return False
    return [word.rstrip("s") for word in key.split()] != [word.rstrip("s") for word in other.split()]


def _numerals(key: str) -> list[str]:
    return [word for word in key.split() if _NUMERAL.fullmatch(word)]
