"""What is said about lists of titles, each looked up in the catalogue's SQLite tables, or tried on the world."""

import json
from collections.abc import Sequence

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, Moment, claim
from teachers.oracles.movies.checks import (
    alike,
    earns,
    exists,
    found_words,
    is_wished,
    item_of,
    means,
    meets,
    pays,
    row_of,
    row_words,
    split_label,
    suits,
    user_with,
    wish_words,
    works_meeting,
    years_of,
)
from worlds.movies import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
    GENRE,
    PERIOD_NAMES,
    TYPE,
    TYPE_NAMES,
    YEAR,
    Profile,
    answer_of,
    titles_of,
)
from worlds.movies.catalogue import AGES, CERTIFICATES, GENRES, PERIODS
from worlds.movies.catalogue.titles import fold
from worlds.world import World

LISTED = 3
"""How many works are named at most where a title could be several."""


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
                    if pays(lab, Profile(bool(series), age=age), label) != (certificate in group):
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
            lab.restore(user_with(Profile(item.series)))
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
        return is_wished(lab, moment.after, self.attribute, self.wish)


@claim
class Solution(Claim):
    """True if all titles of the list `action` fit."""

    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it."""
        return earns(lab, moment.after, self.action) == 0.0


@claim
class TriedWell(Claim):
    """True if a title meets all of the user's wishes."""

    kind = HP
    title: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look each wish up by SQL."""
        return suits(lab, moment.after.profile, self.title)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        item = item_of(lab, self.title)
        return tuple(
            TriedInVain(title=self.title, attribute=attribute, found=found_words(item, attribute), wanted=wanted)
            for attribute, wanted in wish_words(moment.after.profile)
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
        return moment.before is not None and earns(lab, moment.before, moment.action) == 0.0

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
        return _at(moment, self.item) == self.said and means(lab, self.said, self.title)

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
        return said and means(lab, said, self.title) and suits(lab, moment.before.profile, self.title)

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
        if not said or not means(lab, said, self.title):
            return False
        row = row_of(lab, self.title)
        profile = moment.before.profile
        return (
            bool(profile.words(self.attribute))
            and self.found == row_words(lab, row, self.attribute)
            and meets(lab, row[0], profile, self.attribute)
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
        return said and means(lab, said, self.title) and _misses(lab, moment.before.profile, self)

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
        if not said or not means(lab, said, self.title):
            return False
        return row_of(lab, self.title)[5] is None and moment.before.profile.words(AGE) == self.wanted != ""

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
        if _at(moment, self.item) != self.said or exists(lab, self.said):
            return False
        name, year = split_label(self.said)
        return not any(not year or abs(first - year) <= 1 for first in years_of(lab.catalogue).get(fold(name), ()))

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
        name, _ = split_label(self.said)
        works = self.candidates.split("; ")
        rows = [row_of(lab, work, several=True) for work in works]
        return (
            _at(moment, self.item) == self.said
            and not exists(lab, self.said)
            and self.count >= 2
            and len(works) == min(self.count, LISTED)
            and all(rows)
            and all(alike(name, row[1]) for row in rows)
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
        return is_wished(lab, moment.after, self.attribute, self.wish)

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
        before = earns(lab, truth, truth.answer) if truth.answer else -1.0
        return (
            self.title in json.loads(self.action)
            and suits(lab, truth.profile, self.title)
            and earns(lab, truth, self.action) > before
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Name a title that does not fit."""
        return _unfit(moment, lab, json.loads(self.action), self.title)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The wishes that the title meets."""
        return tuple(Seek(attribute=attribute, wish=wish) for attribute, wish in wish_words(moment.after.profile))


@claim
class Repeat(Claim):
    """True if the list `action` is the last one, and all of its titles fit."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it again."""
        return self.action == moment.after.answer and earns(lab, moment.after, self.action) == 0.0

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
        return row_of(lab, self.title) is not None and not suits(lab, moment.after.profile, self.title)

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
        catalogue, rows = lab.catalogue, works_meeting(lab.catalogue, moment.after.profile)
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


def _misses(lab: World, profile: Profile, verdict: "TriedInVain | AttributeMisses") -> bool:
    row = row_of(lab, verdict.title)
    return (
        row is not None
        and verdict.wanted == profile.words(verdict.attribute) != ""
        and verdict.found == row_words(lab, row, verdict.attribute)
        and not meets(lab, row[0], profile, verdict.attribute)
    )


def _at(moment: Moment, item: int) -> str:
    """Title `item` of the last list, counted from 1; empty if there is none."""
    titles = json.loads(moment.action) if moment.before is not None else ()
    return titles[item - 1] if 1 <= item <= len(titles) else ""


def _faults(moment: Moment, lab: World, place: int) -> tuple[AttributeMisses, ...]:
    """Faults that could be found with a title of the last list."""
    item = item_of(lab, _at(moment, place))
    return tuple(
        AttributeMisses(
            item=place, title=item.label, attribute=attribute, found=found_words(item, attribute), wanted=wanted
        )
        for attribute, wanted in wish_words(moment.before.profile)
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


_COUNTERPARTS = 3
