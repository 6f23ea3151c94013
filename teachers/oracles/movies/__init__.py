"""The movies' oracle: it judges each recommended title by each wish, and names titles that fit.

What it finds in tables of bits, its claims look up in the catalogue's SQLite tables, or try on the world.
"""

from collections.abc import Iterable, Set
from functools import lru_cache

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim, slot
from teachers.oracle import Oracle
from teachers.oracles.movies import checks
from teachers.oracles.movies.checks import found_words, wish_words
from teachers.oracles.movies.claims import (
    LISTED,
    AllFit,
    Ambiguous,
    AttributeFits,
    AttributeMisses,
    AvoidTitle,
    AvoidTrait,
    Fits,
    Nothing,
    NotInCatalogue,
    OthersFit,
    OthersMiss,
    Recommend,
    Repeat,
    Solution,
    SpeltLike,
    TakenFor,
    TriedInVain,
    TriedWell,
    Unrated,
    Wish,
)
from worlds.movies import (
    AGE,
    AGE_NAMES,
    MAX_LENGTH,
    MAX_TITLES,
    PERIOD_NAMES,
    TYPE,
    TYPE_NAMES,
    YEAR,
    Movies,
    Profile,
    Truth,
    answer_of,
    titles_of,
)
from worlds.movies.catalogue import AGES, CERTIFICATES, PERIODS, Catalogue, Item, period_bit, type_bit


@claim
class Goal(Claim[Truth, Movies]):
    """True if titles are wanted that meet a user's wishes, of which the request leaves out exactly one."""

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Count the wishes that the user has, and those that are uttered."""
        return checks.leaves_one_out(lab, moment.after)


@claim
class Rules(Claim[Truth, Movies]):
    """True if one of several wished periods or genres is enough, and a TV show counts for each period it ran in."""

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer shows of several periods and titles of several genres to users who wish for each of these alone."""
        return checks.pays_by_rules(lab)


@claim
class AgeGroup(Claim[Truth, Movies]):
    """True if `certificates` are those that count as `age`, which is child-friendly, family-friendly or R-rated."""

    age: str
    certificates: tuple[str, ...]
    ratings = slot(", ".join, "certificates")

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer a title of each certificate to a user with this wish."""
        return checks.pays_by_age(lab, AGE_NAMES.index(self.age), self.certificates)


@claim
class Answer(Claim[Truth, Movies]):
    """True if an answer is a JSON list of at most `limit` titles, with a year in brackets where titles are equal."""

    limit: int

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer lists of strings and of objects, and lists about the limit."""
        return checks.takes_lists(lab, self.limit)


_TRIES = 3
_SHOWN = 3
_ALL_FIT, _NOTHING, _GOAL, _RULES, _ANSWER = AllFit(), Nothing(), Goal(), Rules(), Answer(limit=MAX_TITLES)
_AGE_GROUPS = tuple(AgeGroup(age=age, certificates=group) for age, group in zip(AGE_NAMES, AGES, strict=True))


class MoviesOracle(Oracle[Truth, Movies]):
    """Judges lists title by title and wish by wish, and has the student replace a title that does not fit."""

    max_importance = 1.0

    def start(self, truth: Truth) -> None:
        """Find what fits, and what is to be avoided."""
        catalogue: Catalogue = self.lab.catalogue
        items = [catalogue.items[i] for i in catalogue.fitting(truth.profile.wishes.values()).tolist()]
        first, second = truth.manner  # another user hears of other titles first
        begin = (7 * first + 31 * second) % max(1, len(items))
        self._fitting = [item.label for item in (items[begin:] + items[:begin])[:_LONGEST]]
        self._traits = [AvoidTrait(attribute=a, trait=t) for a, t in _traits(catalogue, truth.profile, items)]

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        return _GOAL, _RULES, *_AGE_GROUPS, _ANSWER

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A few titles that were tried; each is told once."""
        told: dict[Claim, None] = {}
        items = [item for item in self.lab.catalogue.items if item.named]
        for draw in rng.integers(len(items), size=_TRIES).tolist():
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
        wishes = (Wish(attribute=attribute, wish=wish) for attribute, wish in wish_words(truth.profile))
        return *wishes, *(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Each title is told of, up to `max_items`; those behind are counted."""
        titles, catalogue, profile = titles_of(moment.action), self.lab.catalogue, moment.past.profile
        limit = self.lab.max_items
        told = [
            found
            for place, said in enumerate(titles[:limit], 1)
            for found in _verdicts(catalogue, profile, place, said)
            if found.kind in kinds
        ]
        if HP in kinds:
            claims += (_ALL_FIT,) if moment.success else ()
            claims += [claim for claim in told if claim.kind is HP and (not moment.success or type(claim) is TakenFor)]
        if HN in kinds:
            claims += [claim for claim in told if claim.kind is HN] if titles else (_NOTHING,)
        if not moment.success and (behind := titles[limit:]):
            fit = sum(catalogue.meets(title, profile.wishes.values()) for title in behind)
            if HP in kinds and fit:
                claims.append(OthersFit(first=limit + 1, count=fit, total=len(behind)))
            if HN in kinds and fit < len(behind):
                claims.append(OthersMiss(first=limit + 1, count=len(behind) - fit, total=len(behind)))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """The first title that does not fit is replaced by one that does."""
        truth = moment.after
        catalogue = self.lab.catalogue
        titles, wishes = titles_of(truth.answer), truth.profile.wishes.values()
        items, wrong = [], []
        for i, title in enumerate(titles):
            item = catalogue.item(title)
            items.append(item)
            if item is None or not item.meets(wishes):
                wrong.append(i)
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

    def regret(self, moment: Moment[Truth]) -> float:
        """The reward of a list that fits less the action's: 0 to 1."""
        return self.idle(moment.after) if moment.before is None else 0.0 - moment.reward

    def idle(self, truth: Truth) -> float:
        """1: no part of what is not there is right."""
        return 1.0


_LONGEST = MAX_TITLES + 1


def _recommend(titles: tuple[str, ...], place: int, title: str) -> Recommend:
    """Advice to put a title at a place of a list; it stands alone if the list would be too long."""
    action = answer_of([*titles[:place], title, *titles[place + 1 :]])
    return Recommend(action=action if len(action) <= MAX_LENGTH else answer_of([title]), title=title)


def _traits(catalogue: Catalogue, profile: Profile, fitting: Iterable[Item]) -> list[tuple[str, str]]:
    """Attributes that no fitting title has, where they matter: the other type, periods and certificates."""
    bits, certificates = _together(fitting)
    all_bits, all_certificates = _of_all(catalogue)
    some = [(TYPE, TYPE_NAMES[not profile.series])] if all_bits & type_bit(not profile.series) else []
    if profile.age >= 0:
        some += [(AGE, each) for each in CERTIFICATES if each in all_certificates - certificates]
    if profile.periods:
        lacking = all_bits & ~bits
        some += [(YEAR, PERIOD_NAMES[period]) for period in range(len(PERIODS)) if lacking & period_bit(period)]
    return some


def _together(items: Iterable[Item]) -> tuple[int, set[str | None]]:
    """The bits and the certificates that any of the items has."""
    bits, certificates = 0, set()
    for item in items:
        bits |= item.bits
        certificates.add(item.certificate)
    return bits, certificates


@lru_cache(maxsize=16)
def _of_all(catalogue: Catalogue) -> tuple[int, set[str | None]]:
    return _together(catalogue.items)


@lru_cache(maxsize=4096)
def _verdicts(catalogue: Catalogue, profile: Profile, place: int, said: str) -> tuple[Claim, ...]:
    """What there is to say of a title of the list."""
    found = catalogue.find(said)
    if not found:
        near = next((each.label for each in map(catalogue.items.__getitem__, catalogue.near(said)) if each.named), None)
        return (SpeltLike(item=place, said=said, title=near) if near else NotInCatalogue(item=place, said=said),)
    if len(found) > 1:
        works = tuple([f"{catalogue.items[i].title} ({catalogue.items[i].first})" for i in found[:LISTED]])
        return (Ambiguous(item=place, said=said, count=len(found), works=works),)
    item = catalogue.items[found[0]]
    if not item.named:
        return ()
    title = item.label
    claims: list[Claim] = []
    plain = (item.title, f"{item.title} ({item.first})")
    if said not in plain and said.casefold() not in map(str.casefold, plain):
        claims.append(TakenFor(item=place, said=said, title=title))
    if item.meets(profile.wishes.values()):
        return (*claims, Fits(item=place, title=title))
    bits = item.bits
    for attribute, wish, wanted in _wanted(profile):
        words = found_words(item, attribute)
        if bits & wish:
            claims.append(AttributeFits(item=place, title=title, attribute=attribute, found=words))
        elif words:
            claims.append(AttributeMisses(item=place, title=title, attribute=attribute, found=words, wanted=wanted))
        else:
            claims.append(Unrated(item=place, title=title, wanted=wanted))
    return tuple(claims)


@lru_cache(maxsize=1024)
def _wanted(profile: Profile) -> tuple[tuple[str, int, str], ...]:
    """Per attribute that matters the bits of which a title must have one, and the wish in words."""
    return tuple((attribute, wish, profile.words(attribute)) for attribute, wish in profile.wishes.items())
