"""The movies' oracle: it judges each recommended title by each wish, and names titles that fit.

What it finds in tables of bits, its claims look up in the catalogue's SQLite tables, or try on the world.
"""

import json
from collections.abc import Iterable, Sequence, Set
from difflib import SequenceMatcher
from functools import lru_cache
from typing import Any

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim
from teachers.oracle import Oracle
from worlds.catalogue import AGES, CERTIFICATES, GENRES, PERIODS, Catalogue, Item, period_bit
from worlds.catalogue.titles import fold
from worlds.movies import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
    GENRE,
    MAX_LENGTH,
    MAX_TITLES,
    PERIOD_NAMES,
    TYPE,
    TYPE_NAMES,
    YEAR,
    Profile,
    Truth,
    answer_of,
    titles_of,
)
from worlds.world import World


@claim
class Goal(Claim):
    """True if titles are wanted that meet a user's wishes, of which the request leaves out exactly one."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Count the wishes that the user utters, and those that the catalogue's titles are paid for."""
        lab.restore(moment.after)
        said = lab.step("[]")[0]
        uttered = sum(bool(np.any(said[name])) for name in ("type", "periods", "genres", "age"))
        return uttered == sum(bool(moment.after.profile.words(attribute)) for attribute in ATTRIBUTES) - 1


@claim
class Rules(Claim):
    """True if one of several wished periods or genres is enough, and a TV show counts for each period it ran in."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer shows of several periods and titles of several genres to users who wish for each of these alone."""
        shows = lab.catalogue.query("SELECT title, first, last FROM title WHERE series LIMIT 5")
        ran = (
            _pays(lab, Profile(True, (period,)), f"{title} ({first})") == (first <= end and (last or 9999) >= begin)
            for title, first, last in shows
            if len(lab.catalogue.find(f"{title} ({first})")) == 1
            for period, (begin, end) in enumerate(PERIODS)
        )
        enough = (
            _pays(lab, Profile(item.series, (), (other, genre)), item.label)
            for item in lab.catalogue.items[:5]
            if item.named
            for genre, name in enumerate(GENRES)
            if name in item.genres
            for other in range(genre)
        )
        return all(ran) and all(enough)


@claim
class AgeGroups(Claim):
    """True if these are the certificates that are child-friendly, family-friendly, and R-rated."""

    child: str
    family: str
    adult: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer a title of each certificate to a user of each kind."""
        groups = [listing.split(", ") for listing in (self.child, self.family, self.adult)]
        for certificate in CERTIFICATES:
            sql = "SELECT title, first, series FROM title WHERE certificate = ? LIMIT 1"
            for title, first, series in lab.catalogue.query(sql, certificate):
                label = f"{title} ({first})"
                for age, group in enumerate(groups if len(lab.catalogue.find(label)) == 1 else ()):
                    if _pays(lab, Profile(bool(series), age=age), label) != (certificate in group):
                        return False
        return True


@claim
class Answer(Claim):
    """True if an answer is a JSON list of at most `limit` titles, with a year in brackets where titles are equal."""

    limit: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer lists of strings and of objects, and lists about the limit."""
        item = next(item for item in lab.catalogue.items if item.named)
        forms = ([item.label], [{"title": item.title, "year": item.first}])
        try:
            lab.legal(json.dumps(["x"] * (self.limit + 1)))
        except ValueError:
            lab.restore(_user(Profile(item.series)))
            return len(titles_of(lab.legal(json.dumps(["x"] * self.limit)))) == self.limit and all(
                lab.step(json.dumps(form))[4]["success"] for form in forms
            )
        return False


@claim
class Wish(Claim):
    """True if the user wants titles whose `attribute` is `wish`."""

    attribute: str
    wish: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Read the words, and compare what SQL finds for them with what the world pays for this wish alone."""
        return _wished(lab, moment.after, self.attribute, self.wish)


@claim
class Solution(Claim):
    """True if all titles of the list `action` fit."""

    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it."""
        return _earns(lab, moment.after, self.action) == 0.0


@claim
class TriedWell(Claim):
    """True if a title meets all of the user's wishes."""

    kind = HP
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look each wish up by SQL."""
        return _suits(lab, moment.after.profile, self.title)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        item = _item(lab, self.title)
        return tuple(
            TriedInVain(title=self.title, attribute=attribute, found=found_words(item, attribute), wanted=wanted)
            for attribute, wanted in _wish_words(moment.after.profile)
        )


@claim
class TriedInVain(Claim):
    """True if a title's `attribute` is `found`, which does not meet the user's wish, `wanted`."""

    kind = HN
    title: str
    attribute: str
    found: str
    wanted: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the attribute up by SQL."""
        return _misses(lab, moment.after.profile, self)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(title=self.title),)


@claim
class AllFit(Claim):
    """True if the last list is not empty and all of its titles meet all wishes."""

    kind = HP

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the list again."""
        return moment.before is not None and _earns(lab, moment.before, moment.action) == 0.0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault with the first title."""
        return _faults(moment, lab, 1)


@claim
class TakenFor(Claim):
    """True if title `item` of the last list, which reads `said`, was taken for the catalogue's `title`."""

    kind = HP
    item: int
    said: str
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the title up by SQL, compare the spellings, and let the world pay for what was said."""
        return _at(moment, self.item) == self.said and _means(lab, self.said, self.title)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Take it for something else."""
        return tuple(TakenFor(item=self.item, said=self.said, title=title) for title in _others(lab, self.title))


@claim
class Fits(Claim):
    """True if title `item` of the last list is `title`, and meets all wishes."""

    kind = HP
    item: int
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look each wish up by SQL."""
        said = _at(moment, self.item)
        return said and _means(lab, said, self.title) and _suits(lab, moment.before.profile, self.title)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault with it."""
        return _faults(moment, lab, self.item)


@claim
class AttributeFits(Claim):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, meets the user's wish."""

    kind = HP
    item: int
    title: str
    attribute: str
    found: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the attribute up by SQL."""
        said = _at(moment, self.item)
        if not said or not _means(lab, said, self.title):
            return False
        row = _row(lab, self.title)
        profile = moment.before.profile
        return (
            bool(profile.words(self.attribute))
            and self.found == _row_words(lab, row, self.attribute)
            and _meets(lab, row[0], profile, self.attribute)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(fault for fault in _faults(moment, lab, self.item) if fault.attribute == self.attribute)


@claim
class AttributeMisses(Claim):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, does not meet `wanted`."""

    kind = HN
    item: int
    title: str
    attribute: str
    found: str
    wanted: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the attribute up by SQL."""
        said = _at(moment, self.item)
        return said and _means(lab, said, self.title) and _misses(lab, moment.before.profile, self)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (AttributeFits(item=self.item, title=self.title, attribute=self.attribute, found=self.found),)


@claim
class Unrated(Claim):
    """True if title `item` of the last list is `title`, whose certificate is unknown, while `wanted` is wished."""

    kind = HN
    item: int
    title: str
    wanted: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the certificate up by SQL."""
        said = _at(moment, self.item)
        if not said or not _means(lab, said, self.title):
            return False
        return _row(lab, self.title)[5] is None and moment.before.profile.words(AGE) == self.wanted != ""

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Make a certificate up."""
        wanted = AGES[AGE_NAMES.index(self.wanted)]
        return tuple(
            AttributeFits(item=self.item, title=self.title, attribute=AGE, found=certificate) for certificate in wanted
        )


@claim
class NotInCatalogue(Claim):
    """True if the catalogue has no title, of its year if it gives one, that `said`, title `item`, could stand for."""

    kind = HN
    item: int
    said: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Go through all titles, and let the world refuse this one."""
        if _at(moment, self.item) != self.said or _exists(lab, self.said):
            return False
        name, year = _split(self.said)
        return not any(not year or abs(first - year) <= 1 for first in _years_of(lab.catalogue).get(fold(name), ()))

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Take it for something."""
        return tuple(TakenFor(item=self.item, said=self.said, title=title) for title in _others(lab, ""))


@claim
class Ambiguous(Claim):
    """True if `said`, title `item` of the last list, could be `count` works, those of `candidates` among them."""

    kind = HN
    item: int
    said: str
    count: int
    candidates: str
    """At most three works with their years, such as `Aladdin (1992) or Aladdin (2019)`."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the works up by SQL, compare the spellings, and let the world refuse what was said."""
        name, _ = _split(self.said)
        works = self.candidates.split("; ")
        rows = [_row(lab, work, several=True) for work in works]
        return (
            _at(moment, self.item) == self.said
            and not _exists(lab, self.said)
            and self.count >= 2
            and len(works) == min(self.count, _LISTED)
            and all(rows)
            and all(_alike(name, row[1]) for row in rows)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny that there is any."""
        return (NotInCatalogue(item=self.item, said=self.said),)


@claim
class Nothing(Claim):
    """True if the last list is empty."""

    kind = HN

    def holds(self, moment: Moment, lab: World) -> bool:
        """Read it."""
        return moment.before is not None and json.loads(moment.action) == []

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (AllFit(),)


@claim
class Seek(Claim):
    """True if it is good to look for titles whose `attribute` is `wish`: the user wants them."""

    kind = FP
    attribute: str
    wish: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """As for `Wish`."""
        return _wished(lab, moment.after, self.attribute, self.wish)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another wish."""
        names = {TYPE: TYPE_NAMES, YEAR: PERIOD_NAMES, GENRE: GENRES, AGE: AGE_NAMES}[self.attribute]
        return tuple(Seek(attribute=self.attribute, wish=name) for name in names if name != self.wish)


@claim
class Recommend(Claim):
    """True if the list `action` earns more than the last one, and has `title`, which meets all wishes."""

    kind = FP
    action: str
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the title up by SQL, and offer both lists."""
        truth = moment.after
        before = _earns(lab, truth, truth.answer) if truth.answer else -1.0
        return (
            self.title in json.loads(self.action)
            and _suits(lab, truth.profile, self.title)
            and _earns(lab, truth, self.action) > before
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Name a title that does not fit."""
        return _unfit(moment, lab, json.loads(self.action), self.title)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The wishes that the title meets."""
        return tuple(Seek(attribute=attribute, wish=wish) for attribute, wish in _wish_words(moment.after.profile))


@claim
class Repeat(Claim):
    """True if the list `action` is the last one, and all of its titles fit."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it again."""
        return self.action == moment.after.answer and _earns(lab, moment.after, self.action) == 0.0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Name a title that does not fit."""
        titles = json.loads(self.action)
        return _unfit(moment, lab, titles, titles[0])


@claim
class AvoidTitle(Claim):
    """True if a title of the catalogue does not meet all wishes."""

    kind = FN
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look each wish up by SQL."""
        return _row(lab, self.title) is not None and not _suits(lab, moment.after.profile, self.title)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of titles that fit."""
        fitting = lab.catalogue.fitting(moment.after.profile.wishes.values())[:_COUNTERPARTS]
        return tuple(AvoidTitle(title=lab.catalogue.items[i].label) for i in fitting.tolist())


@claim
class AvoidTrait(Claim):
    """True if the catalogue has titles whose `attribute` is `trait`, and none of them meets all wishes."""

    kind = FN
    attribute: str
    trait: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the titles that have it, and those that meet all wishes, up by SQL."""
        catalogue, rows = lab.catalogue, _meeting(lab.catalogue, moment.after.profile)
        if self.attribute == TYPE:
            series = TYPE_NAMES.index(self.trait)
            some = catalogue.query("SELECT 1 FROM title WHERE series = ? LIMIT 1", series)
            return bool(some) and not any(row[1] == series for row in rows.values())
        if self.attribute == YEAR:
            begin, end = PERIODS[PERIOD_NAMES.index(self.trait)]
            sql = "SELECT 1 FROM title WHERE first <= ? AND coalesce(last, 9999) >= ? LIMIT 1"
            some = catalogue.query(sql, end, begin)
            return bool(some) and not any(row[2] <= end and (row[3] or 9999) >= begin for row in rows.values())
        some = catalogue.query("SELECT 1 FROM title WHERE certificate = ? LIMIT 1", self.trait)
        return bool(some) and not any(row[4] == self.trait for row in rows.values())

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of what is wished."""
        profile = moment.after.profile
        wished = [(TYPE, TYPE_NAMES[profile.series])]
        wished += [(YEAR, PERIOD_NAMES[period]) for period in profile.periods]
        wished += [(AGE, certificate) for certificate in (AGES[profile.age] if profile.age >= 0 else ())]
        return tuple(AvoidTrait(attribute=attribute, trait=trait) for attribute, trait in wished)


def _user(profile: Profile) -> Truth:
    return Truth(profile, "", (0, 0), "")


def _earns(lab: World, truth: Truth, answer: str) -> float:
    lab.restore(truth)
    return lab.step(answer)[1]


def _pays(lab: World, profile: Profile, title: str) -> bool:
    """Whether a user with these wishes is content with a title."""
    return _earns(lab, _user(profile), json.dumps([title])) == 0.0


def _exists(lab: World, said: str) -> bool:
    return any(_pays(lab, Profile(series), said) for series in (False, True))


def _split(said: str) -> tuple[str, int]:
    """A title and the year in brackets behind it, 0 if there is none."""
    name, bracket, year = said.rpartition(" (")
    digits = year[:4]
    return (name, int(digits)) if bracket and digits.isdecimal() and year.endswith(")") else (said, 0)


def _row(lab: World, label: str, several: bool = False) -> tuple[Any, ...] | None:
    """The row (id, title, series, first, last, certificate) of the work that a label names; None if it names none."""
    sql = "SELECT id, title, series, first, last, certificate FROM title WHERE title = ?"
    name, year = _split(label)
    rows = lab.catalogue.query(sql, label) or lab.catalogue.query(f"{sql} AND first = ?", name, year)
    return rows[0] if len(rows) == 1 or (several and rows) else None


def _item(lab: World, label: str) -> Item:
    return lab.catalogue.items[lab.catalogue.find(label)[0]]


@lru_cache(maxsize=4)
def _years_of(catalogue: Catalogue) -> dict[str, list[int]]:
    """Per title, folded, the first years of the works that have it."""
    years: dict[str, list[int]] = {}
    for title, first in catalogue.query("SELECT title, first FROM title"):
        years.setdefault(fold(title), []).append(first)
    return years


@lru_cache(maxsize=4096)
def _alike(said: str, title: str) -> bool:
    """Whether a spelling is close to another one."""
    return SequenceMatcher(None, fold(said), fold(title)).ratio() > 0.7


def _means(lab: World, said: str, title: str) -> bool:
    """Whether what was said stands for a title of the catalogue."""
    row = _row(lab, title)
    return row is not None and _alike(_split(said)[0], row[1]) and _pays(lab, Profile(bool(row[2])), said)


def _meets(lab: World, id: int, profile: Profile, attribute: str) -> bool:
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
def _meeting(catalogue: Catalogue, profile: Profile) -> dict[int, tuple[Any, ...]]:
    """The rows (id, series, first, last, certificate) of all works that meet all wishes, by id."""
    periods, genres, certificates = (
        json.dumps([list_[i] for i in chosen if i >= 0])
        for list_, chosen in ((PERIODS, profile.periods), (GENRES, profile.genres), (AGES, (profile.age,)))
    )
    rows = catalogue.query(_MEETING, profile.series, periods, genres, certificates)
    return {row[0]: row for row in rows}


_MEETING = """
SELECT id, series, first, last, certificate FROM title
WHERE series = ?1
AND (?2 = '[]' OR EXISTS (
    SELECT 1 FROM json_each(?2)
    WHERE first <= json_extract(value, '$[1]') AND coalesce(last, 9999) >= json_extract(value, '$[0]')))
AND (?3 = '[]' OR EXISTS (SELECT 1 FROM genre JOIN json_each(?3) ON genre = value WHERE genre.id = title.id))
AND (?4 = '[]' OR certificate IN (SELECT value FROM json_each(?4, '$[0]')))
"""


def _suits(lab: World, profile: Profile, title: str) -> bool:
    row = _row(lab, title)
    return row is not None and row[0] in _meeting(lab.catalogue, profile)


def _misses(lab: World, profile: Profile, verdict: "TriedInVain | AttributeMisses") -> bool:
    row = _row(lab, verdict.title)
    return (
        row is not None
        and verdict.wanted == profile.words(verdict.attribute) != ""
        and verdict.found == _row_words(lab, row, verdict.attribute)
        and not _meets(lab, row[0], profile, verdict.attribute)
    )


def _wished(lab: World, truth: Truth, attribute: str, wish: str) -> bool:
    names = wish.split(" or ")
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
        _pays(lab, alone, item.label) == _suits(lab, read, item.label)
        for item in items[:: max(1, len(items) // _SAMPLE)]
    )


def _row_words(lab: World, row: tuple[Any, ...], attribute: str) -> str:
    id, _, series, first, last, certificate = row
    if attribute == TYPE:
        return TYPE_NAMES[series]
    if attribute == YEAR:
        return _years(first, last)
    if attribute == AGE:
        return certificate
    return _genres(
        [genre for (genre,) in lab.catalogue.query("SELECT genre FROM genre WHERE id = ? ORDER BY rowid", id)]
    )


def found_words(item: Item, attribute: str) -> str:
    """What an item is, in words, such as "1994 to 2004"; empty for an unknown age rating."""
    if attribute == TYPE:
        return TYPE_NAMES[item.series]
    if attribute == YEAR:
        return _years(item.first, item.last)
    return _genres(item.genres) if attribute == GENRE else item.certificate or ""


def _years(first: int, last: int | None) -> str:
    return f"{first}" if last == first else f"{first} to {last or 'now'}"


def _genres(genres: Sequence[str]) -> str:
    return " and ".join((", ".join(genres[:-1]), genres[-1]) if len(genres) > 1 else genres) or "none listed"


def _at(moment: Moment, item: int) -> str:
    """Title `item` of the last list, counted from 1; empty if there is none."""
    titles = json.loads(moment.action) if moment.before is not None else ()
    return titles[item - 1] if 1 <= item <= len(titles) else ""


def _wish_words(profile: Profile) -> list[tuple[str, str]]:
    return [(attribute, profile.words(attribute)) for attribute in profile.wishes]


def _faults(moment: Moment, lab: World, place: int) -> tuple[AttributeMisses, ...]:
    """Faults that could be found with a title of the last list."""
    item = _item(lab, _at(moment, place))
    return tuple(
        AttributeMisses(
            item=place, title=item.label, attribute=attribute, found=found_words(item, attribute), wanted=wanted
        )
        for attribute, wanted in _wish_words(moment.before.profile)
    )


def _others(lab: World, title: str) -> list[str]:
    """Labels of the catalogue other than this one."""
    return [item.label for item in lab.catalogue.items[: _COUNTERPARTS + 1] if item.label != title]


def _unfit(moment: Moment, lab: World, titles: list[str], title: str) -> tuple[Claim, ...]:
    """Recommendations of titles that do not fit in place of one that does."""
    wishes = moment.after.profile.wishes.values()
    unfit = (item.label for item in lab.catalogue.items if item.named and not all(item.bits & w for w in wishes))
    place = titles.index(title)
    return tuple(
        Recommend(action=answer_of([*titles[:place], label, *titles[place + 1 :]]), title=label)
        for label, _ in zip(unfit, range(_COUNTERPARTS), strict=False)
    )


_TRIES = 3
_TOLD = 12  # claims of a kind: a list can have a hundred titles
_LISTED = 3
_COUNTERPARTS = 3
_SAMPLE = 30
_SHOWN = 3
_ALL_FIT, _NOTHING, _GOAL, _RULES, _ANSWER = AllFit(), Nothing(), Goal(), Rules(), Answer(limit=MAX_TITLES)
_AGE_GROUPS = AgeGroups(**dict(zip(("child", "family", "adult"), map(", ".join, AGES), strict=True)))


class MoviesOracle(Oracle):
    """Judges lists title by title and wish by wish, and has the student replace a title that does not fit."""

    max_importance = 1.0

    def start(self, truth: Truth, rng: np.random.Generator) -> None:
        """Find what fits, and what is to be avoided."""
        super().start(truth, rng)
        catalogue: Catalogue = self.lab.catalogue  # type: ignore[attr-defined]
        items = [catalogue.items[i] for i in catalogue.fitting(truth.profile.wishes.values()).tolist()]
        first, second = truth.manner  # another user hears of other titles first
        begin = (7 * first + 31 * second) % max(1, len(items))
        self._fitting = [item.label for item in (items[begin:] + items[:begin])[:_LONGEST]]
        self._traits = [AvoidTrait(attribute=a, trait=t) for a, t in _traits(catalogue, truth.profile, items)]

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        return _GOAL, _RULES, _AGE_GROUPS, _ANSWER

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """A few titles that were tried; each is told once."""
        told: dict[Claim, None] = {}
        items = [item for item in self.lab.catalogue.items if item.named]  # type: ignore[attr-defined]
        for draw in self.rng.integers(len(items), size=_TRIES).tolist():
            item = items[draw]
            wrong = next((each for each in truth.profile.wishes.items() if not item.bits & each[1]), None)
            if wrong is None:
                told[TriedWell(title=item.label)] = None
            elif found := found_words(item, wrong[0]):
                told[
                    TriedInVain(title=item.label, attribute=wrong[0], found=found, wanted=truth.profile.words(wrong[0]))
                ] = None
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        wishes = (Wish(attribute=attribute, wish=wish) for attribute, wish in _wish_words(truth.profile))
        return *wishes, *(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """At most twelve claims of a kind are told."""
        right: list[Claim] = []
        wrong: list[Claim] = []
        catalogue, profile = self.lab.catalogue, moment.before.profile  # type: ignore[attr-defined]
        titles = titles_of(moment.action)
        for place, said in enumerate(titles, 1):
            for found in _verdicts(catalogue, profile, place, said):
                (right if found.kind is HP else wrong).append(found)
            if len(right) >= _TOLD and len(wrong) >= _TOLD:
                break
        if HP in kinds:
            if moment.success:
                right = [_ALL_FIT, *(claim for claim in right if type(claim) is TakenFor)]
            claims += right[:_TOLD]
        if HN in kinds:
            claims += wrong[:_TOLD] if titles else (_NOTHING,)

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """The first title that does not fit is replaced by one that does."""
        truth = moment.after
        catalogue = self.lab.catalogue  # type: ignore[attr-defined]
        titles, wishes = titles_of(truth.answer), truth.profile.wishes.values()
        found = [catalogue.find(title) for title in titles]
        items = [catalogue.items[each[0]] if len(each) == 1 else None for each in found]
        wrong = [i for i, item in enumerate(items) if item is None or not all(item.bits & wish for wish in wishes)]
        if FP in kinds:
            if titles and not wrong:
                claims.append(Repeat(action=truth.answer))
            elif self._fitting:  # a user that was made by hand may have wishes that nothing meets
                used = {item.label for item in items if item}
                title = next((label for label in self._fitting if label not in used), self._fitting[0])
                claims.append(_recommend(titles, wrong[0] if wrong else 0, title))
        if FN in kinds:
            bad = next((items[i].label for i in wrong if items[i] and items[i].named), None)  # type: ignore[union-attr]
            if bad:
                claims.append(AvoidTitle(title=bad))
            elif self._traits:
                claims.append(self._traits[moment.turn % len(self._traits)])

    def importance(self, truth: Truth) -> float:
        """The reward of a list that fits less that of one that fits in nothing: always 1."""
        return 1.0

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """The same list of titles that fit `n` times."""
        return (answer_of(self._fitting[:_SHOWN]),) * n if self._fitting else ()

    def regret(self, moment: Moment) -> float:
        """The reward of a list that fits less the action's: 0 to 1; a turn without an action loses 1."""
        return 1.0 if moment.before is None else 0.0 - moment.reward


_LONGEST = MAX_TITLES + 1


@lru_cache(maxsize=4096)
def _recommend(titles: tuple[str, ...], place: int, title: str) -> Recommend:
    """Advice to put a title at a place of a list; it stands alone if the list would be too long."""
    action = answer_of([*titles[:place], title, *titles[place + 1 :]])
    return Recommend(action=action if len(action) <= MAX_LENGTH else answer_of([title]), title=title)


def _traits(catalogue: Catalogue, profile: Profile, fitting: Iterable[Item]) -> list[tuple[str, str]]:
    """Attributes that no fitting title has, where they matter: the other type, periods and certificates."""
    fitting = tuple(fitting)
    some = [(TYPE, TYPE_NAMES[not profile.series])] if _has_series(catalogue, not profile.series) else []
    if profile.age >= 0:
        bad = {item.certificate for item in catalogue.items} - {item.certificate for item in fitting}
        some += [(AGE, certificate) for certificate in CERTIFICATES if certificate in bad]
    if profile.periods:
        bits = {period: period_bit(period) for period in range(len(PERIODS))}
        some += [
            (YEAR, PERIOD_NAMES[period])
            for period, bit in bits.items()
            if not any(item.bits & bit for item in fitting) and any(item.bits & bit for item in catalogue.items)
        ]
    return some


@lru_cache(maxsize=16)
def _has_series(catalogue: Catalogue, series: bool) -> bool:
    return any(item.series == series for item in catalogue.items)


@lru_cache(maxsize=4096)
def _verdicts(catalogue: Catalogue, profile: Profile, place: int, said: str) -> tuple[Claim, ...]:
    """What there is to say of a title of the list."""
    found = catalogue.find(said)
    if not found:
        return (NotInCatalogue(item=place, said=said),)
    if len(found) > 1:
        works = [f"{catalogue.items[i].title} ({catalogue.items[i].first})" for i in found[:_LISTED]]
        return (Ambiguous(item=place, said=said, count=len(found), candidates="; ".join(works)),)
    item = catalogue.items[found[0]]
    if not item.named:
        return ()
    claims: list[Claim] = []
    plain = (item.title, f"{item.title} ({item.first})")
    if said.casefold() not in map(str.casefold, plain):
        claims.append(TakenFor(item=place, said=said, title=item.label))
    wrong = [attribute for attribute, wish in profile.wishes.items() if not item.bits & wish]
    if not wrong:
        return (*claims, Fits(item=place, title=item.label))
    for attribute in profile.wishes:
        words = found_words(item, attribute)
        if attribute not in wrong:
            claims.append(AttributeFits(item=place, title=item.label, attribute=attribute, found=words))
        elif not words:
            claims.append(Unrated(item=place, title=item.label, wanted=profile.words(AGE)))
        else:
            wanted = profile.words(attribute)
            claims.append(
                AttributeMisses(item=place, title=item.label, attribute=attribute, found=words, wanted=wanted)
            )
    return tuple(claims)
