"""The checks of claims about titles: SQL on the catalogue, and offers to users with given wishes."""

import json
import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from rapidfuzz.distance import Indel

from teachers.atoms import Moment
from worlds.movies import (
    AGE,
    AGE_NAMES,
    GENRE,
    PERIOD_NAMES,
    TYPE,
    TYPE_NAMES,
    YEAR,
    Movies,
    Profile,
    Truth,
    titles_of,
)
from worlds.movies.catalogue import AGES, CERTIFICATES, GENRES, PERIODS, Catalogue, Item, aliases
from worlds.movies.catalogue.titles import fold

_LABEL = re.compile(r"(.*?)\s*\(\s*(\d{4})\s*(?:[-\u2013]\s*(?:\d{4}\s*)?)?\)\s*", re.DOTALL)
NAMES = {TYPE: TYPE_NAMES, YEAR: PERIOD_NAMES, GENRE: GENRES, AGE: AGE_NAMES}
"""The possible wishes by attribute, in words."""


def user_with(profile: Profile) -> Truth:
    """A world's truth in which the user has these wishes."""
    return Truth(profile, "", (0, 0), "")


def earns(lab: Movies, truth: Truth, answer: str) -> float:
    """The reward that the world gives for an answer."""
    lab.restore(truth)
    return lab.step(answer)[1]


def pays(lab: Movies, profile: Profile, title: str) -> bool:
    """Whether a user with these wishes is content with a title."""
    return earns(lab, user_with(profile), json.dumps([title])) == 0.0


def leaves_one_out(lab: Movies, truth: Truth) -> bool:
    """Whether the request omits exactly one of the user's wishes."""
    lab.restore(truth)
    said = lab.step("[]")[0]
    uttered = sum(bool(np.any(said[name])) for name in ("type", "periods", "genres", "age"))
    return uttered == sum(bool(truth.profile.words(attribute)) for attribute in NAMES) - 1


def left_out(lab: Movies, truth: Truth) -> str:
    """The attribute of the wish that the request omits."""
    lab.restore(truth)
    said = lab.step("[]")[0]
    parts = zip(NAMES, ("type", "periods", "genres", "age"), strict=True)
    return next(each for each, part in parts if truth.profile.words(each) and not np.any(said[part]))


def tally(lab: Movies, moment: Moment[Truth], first: int) -> tuple[int, int]:
    """How many titles of the last list from title `first` on suit the user when offered alone, and of how many."""
    titles = titles_of(moment.action)[first - 1 :] if moment.before is not None and first >= 1 else ()
    return sum(pays(lab, moment.after.profile, title) for title in titles), len(titles)


def pays_by_rules(lab: Movies) -> bool:
    """Whether the world pays for one of several genres, and for a show in each period when it ran."""
    shows = lab.catalogue.query("SELECT title, first, last FROM title WHERE series LIMIT 5")
    ran = (
        pays(lab, Profile(True, (period,)), f"{title} ({first})") == (first <= end and (last or 9999) >= begin)
        for title, first, last in shows
        if len(lab.catalogue.find(f"{title} ({first})")) == 1
        for period, (begin, end) in enumerate(PERIODS)
    )
    enough = (
        pays(lab, Profile(item.series, (), (other, genre)), item.label)
        for item in lab.catalogue.items[:5]
        if item.named
        for genre, name in enumerate(GENRES)
        if name in item.genres
        for other in range(genre)
    )
    return all(ran) and all(enough)


def pays_by_age(lab: Movies, age: int, group: Sequence[str]) -> bool:
    """Whether a title is of an age group exactly if the group has its certificate, as the world pays."""
    for certificate in CERTIFICATES:
        sql = "SELECT title, first, series FROM title WHERE certificate = ? LIMIT 1"
        for title, first, series in lab.catalogue.query(sql, certificate):
            label = f"{title} ({first})"
            known = len(lab.catalogue.find(label)) == 1
            if known and pays(lab, Profile(bool(series), age=age), label) != (certificate in group):
                return False
    return True


def takes_lists(lab: Movies, limit: int) -> bool:
    """Whether the world takes lists of strings and of objects, of at most `limit` titles."""
    item = next(item for item in lab.catalogue.items if item.named)
    forms = ([item.label], [{"title": item.title, "year": item.first}])
    try:
        lab.legal(json.dumps(["x"] * (limit + 1)))
    except ValueError:
        lab.restore(user_with(Profile(item.series)))
        return len(titles_of(lab.legal(json.dumps(["x"] * limit)))) == limit and all(
            lab.step(json.dumps(form))[4]["success"] for form in forms
        )
    return False


def said_at(moment: Moment[Truth], item: int) -> str:
    """Title `item` of the last list, counted from 1; empty if there is none."""
    titles = titles_of(moment.action) if moment.before is not None else ()
    return titles[item - 1] if 1 <= item <= len(titles) else ""


def exists(lab: Movies, said: str) -> bool:
    """Whether the world takes a text for any title."""
    return any(pays(lab, Profile(series), said) for series in (False, True))


def split_label(said: str) -> tuple[str, int]:
    """A title and the year in brackets after it, 0 if there is none."""
    found = _LABEL.fullmatch(said)
    return (found[1], int(found[2])) if found else (said, 0)


def row_of(lab: Movies, label: str, several: bool = False) -> tuple[Any, ...] | None:
    """The row (id, title, series, first, last, certificate) of the work that a label names; None if it names none."""
    sql = "SELECT id, title, series, first, last, certificate FROM title WHERE title = ?"
    name, year = split_label(label)
    rows = lab.catalogue.query(sql, label) or lab.catalogue.query(f"{sql} AND first = ?", name, year)
    return rows[0] if len(rows) == 1 or (several and rows) else None


def item_of(lab: Movies, label: str) -> Item:
    """The catalogue's item that a label names."""
    return lab.catalogue.items[lab.catalogue.find(label)[0]]


@lru_cache(maxsize=4)
def years_of(catalogue: Catalogue) -> dict[str, list[int]]:
    """The first years of all works by title, case-folded."""
    years: dict[str, list[int]] = {}
    for title, first in catalogue.query("SELECT title, first FROM title"):
        years.setdefault(fold(title), []).append(first)
    return years


@lru_cache(maxsize=4096)
def alike(said: str, title: str) -> bool:
    """Whether a spelling is close to a title or to another name of the work, with their articles or without."""
    for name in (title, *(alias for alias, meant, _ in aliases() if meant == title)):
        whole = fold(said), fold(name)
        bare = [text.removeprefix("the ").removeprefix("an ").removeprefix("a ") for text in whole]
        if any(Indel.normalized_similarity(*pair) > _ALIKE for pair in (whole, bare)):
            return True
    return False


def means(lab: Movies, said: str, title: str) -> bool:
    """Whether a text stands for a title of the catalogue."""
    row = row_of(lab, title)
    return row is not None and alike(split_label(said)[0], row[1]) and pays(lab, Profile(bool(row[2])), said)


def is_unknown(lab: Movies, said: str) -> bool:
    """Whether a text names no title, of its year if it gives one, by the world and by all titles."""
    name, year = split_label(said)
    years = years_of(lab.catalogue).get(fold(name), ())
    return not exists(lab, said) and not any(not year or abs(first - year) <= 1 for first in years)


def is_like(lab: Movies, said: str, title: str) -> bool:
    """Whether a text is spelt like a title of the catalogue."""
    row = row_of(lab, title)
    return row is not None and alike(split_label(said)[0], row[1])


def could_be(lab: Movies, said: str, works: Sequence[str]) -> bool:
    """Whether each of these works is spelt like a text that the world takes for none of them."""
    name, _ = split_label(said)
    rows = [row_of(lab, work, several=True) for work in works]
    return not exists(lab, said) and all(row is not None and alike(name, row[1]) for row in rows)


def is_rated(lab: Movies, title: str) -> bool:
    """Whether the certificate of a title is known."""
    row = row_of(lab, title)
    return row is not None and row[5] is not None


def wish_met(lab: Movies, profile: Profile, title: str, attribute: str, found: str) -> bool | None:
    """Whether a title meets a wish; None if there is no such wish or title, or its attribute is not `found`."""
    row = row_of(lab, title)
    if row is None or not profile.words(attribute) or row_words(lab, row, attribute) != found:
        return None
    return meets(lab, row[0], profile, attribute)


def misses(lab: Movies, moment: Moment[Truth], title: str, attribute: str, found: str, wanted: str) -> bool:
    """Whether an attribute of a title is `found`, and the user wants `wanted`, which this does not meet."""
    profile = moment.after.profile
    return wish_met(lab, profile, title, attribute, found) is False and wanted == profile.words(attribute)


def meets(lab: Movies, id: int, profile: Profile, attribute: str) -> bool:
    """Whether a work meets a wish; there must be one."""
    query = lab.catalogue.query
    if attribute == TYPE:
        return bool(query("SELECT 1 FROM title WHERE id = ? AND series = ?", id, profile.series))
    if attribute == YEAR:
        sql = "SELECT 1 FROM title WHERE id = ? AND coalesce(last, 9999) >= ? AND first <= ?"
        return any(query(sql, id, *PERIODS[period]) for period in profile.periods)
    if attribute == GENRE:
        sql = "SELECT 1 FROM genre WHERE id = ? AND genre = ?"
        return any(query(sql, id, GENRES[genre]) for genre in profile.genres)
    return any(query("SELECT 1 FROM title WHERE id = ? AND certificate = ?", id, each) for each in AGES[profile.age])


@lru_cache(maxsize=64)
def works_meeting(catalogue: Catalogue, profile: Profile) -> dict[int, tuple[Any, ...]]:
    """The rows (id, series, first, last, certificate) of all works that meet all wishes, by id."""
    wishes = {"periods": (PERIODS, profile.periods), "genres": (GENRES, profile.genres), "ages": (AGES, (profile.age,))}
    lists = {name: json.dumps([each[i] for i in chosen if i >= 0]) for name, (each, chosen) in wishes.items()}
    rows = catalogue.query(_MEETING, series=profile.series, **lists)
    return {row[0]: row for row in rows}


_MEETING = """
SELECT id, series, first, last, certificate FROM title
WHERE series = :series
AND (:periods = '[]' OR EXISTS (
    SELECT 1 FROM json_each(:periods)
    WHERE first <= json_extract(value, '$[1]') AND coalesce(last, 9999) >= json_extract(value, '$[0]')))
AND (:genres = '[]' OR EXISTS (SELECT 1 FROM genre JOIN json_each(:genres) ON genre = value WHERE genre.id = title.id))
AND (:ages = '[]' OR certificate IN (SELECT value FROM json_each(:ages, '$[0]')))
"""


def suits(lab: Movies, profile: Profile, title: str) -> bool:
    """Whether a title meets all wishes, by SQL."""
    row = row_of(lab, title)
    return row is not None and row[0] in works_meeting(lab.catalogue, profile)


def is_useless(lab: Movies, profile: Profile, attribute: str, trait: str) -> bool:
    """Whether the catalogue has titles with a trait, and none of them meets all wishes."""
    catalogue, rows = lab.catalogue, works_meeting(lab.catalogue, profile)
    if attribute == TYPE:
        series = TYPE_NAMES.index(trait)
        some = catalogue.query("SELECT 1 FROM title WHERE series = ? LIMIT 1", series)
        return bool(some) and not any(row[1] == series for row in rows.values())
    if attribute == YEAR:
        begin, end = PERIODS[PERIOD_NAMES.index(trait)]
        sql = "SELECT 1 FROM title WHERE first <= ? AND coalesce(last, 9999) >= ? LIMIT 1"
        some = catalogue.query(sql, end, begin)
        return bool(some) and not any(row[2] <= end and (row[3] or 9999) >= begin for row in rows.values())
    some = catalogue.query("SELECT 1 FROM title WHERE certificate = ? LIMIT 1", trait)
    return bool(some) and not any(row[4] == trait for row in rows.values())


def traits_wished(profile: Profile) -> list[tuple[str, str]]:
    """The types, periods and certificates that a user wants, each with its attribute."""
    wished = [(TYPE, TYPE_NAMES[profile.series])]
    wished += [(YEAR, PERIOD_NAMES[period]) for period in profile.periods]
    return wished + [(AGE, certificate) for certificate in (AGES[profile.age] if profile.age >= 0 else ())]


def faults_of(lab: Movies, title: str, profile: Profile) -> list[dict[str, str]]:
    """The fields of a claim that finds fault with a title, for each attribute with a wish."""
    item = item_of(lab, title)
    return [
        {"title": title, "attribute": attribute, "found": found_words(item, attribute), "wanted": wanted}
        for attribute, wanted in wish_words(profile)
    ]


def unfit(lab: Movies, moment: Moment[Truth]) -> Iterator[str]:
    """The labels of titles that do not meet all wishes."""
    wishes = moment.after.profile.wishes.values()
    return (item.label for item in lab.catalogue.items if item.named and not all(item.bits & w for w in wishes))


def is_better(lab: Movies, truth: Truth, action: str, title: str) -> bool:
    """Whether a list has a title that meets all wishes, and earns more than the last list."""
    before, listed = earns(lab, truth, truth.answer) if truth.answer else -1.0, json.loads(action)
    return (
        isinstance(listed, list)
        and title in listed
        and suits(lab, truth.profile, title)
        and earns(lab, truth, action) > before
    )


def is_wished(lab: Movies, truth: Truth, attribute: str, wish: str) -> bool:
    """Whether these words are the user's wish: SQL finds for them what the world pays for this wish alone."""
    names = wish.split(" or ")
    known: Any = {TYPE: TYPE_NAMES, YEAR: PERIOD_NAMES, GENRE: GENRES}.get(attribute, AGE_NAMES)
    if not set(names) <= set(known):
        return False
    series = truth.profile.series
    if attribute == TYPE:
        read = Profile(wish == TYPE_NAMES[1])
    elif attribute == YEAR:
        read = Profile(series, tuple(map(PERIOD_NAMES.index, names)))
    elif attribute == GENRE:
        read = Profile(series, (), tuple(map(GENRES.index, names)))
    else:
        read = Profile(series, age=AGE_NAMES.index(wish))
    items = [item for item in lab.catalogue.items if item.named and (item.series == series or attribute == TYPE)]
    alone = truth.profile.only(attribute)
    return bool(truth.profile.words(attribute)) and all(
        pays(lab, alone, item.label) == suits(lab, read, item.label) for item in items[:: max(1, len(items) // _SAMPLE)]
    )


def row_words(lab: Movies, row: tuple[Any, ...], attribute: str) -> str | None:
    """An attribute of a work in words, from its row; `found_words` does this for an item."""
    id, _, series, first, last, certificate = row
    if attribute == TYPE:
        return TYPE_NAMES[series]
    if attribute == YEAR:
        return _years(first, last)
    if attribute == AGE:
        return None if certificate is None else str(certificate)
    genres = lab.catalogue.query("SELECT genre FROM genre WHERE id = ? ORDER BY rowid", id)
    return _genres(tuple([genre for (genre,) in genres]))


def found_words(item: Item, attribute: str) -> str:
    """An attribute of an item in words, such as "1994 to 2004"; empty for an unknown age rating."""
    return FOUND[attribute](item)


def _years(first: int, last: int | None) -> str:
    return f"{first}" if last == first else f"{first} to {last or 'now'}"


@lru_cache(maxsize=1024)
def _genres(genres: tuple[str, ...]) -> str:
    return " and ".join((", ".join(genres[:-1]), genres[-1]) if len(genres) > 1 else genres) or "none listed"


FOUND: dict[str, Callable[[Item], str]] = {
    TYPE: lambda item: TYPE_NAMES[item.series],
    YEAR: lambda item: _years(item.first, item.last),
    GENRE: lambda item: _genres(item.genres),
    AGE: lambda item: item.certificate or "",
}
"""Per attribute, the function that gives an item's value in words."""


def wish_words(profile: Profile) -> list[tuple[str, str]]:
    """The attributes with a wish of the user, and the wishes in words."""
    return [(attribute, profile.words(attribute)) for attribute in profile.wishes]


_ALIKE = 0.7  # of the letters of both, in the same order
_SAMPLE = 30
