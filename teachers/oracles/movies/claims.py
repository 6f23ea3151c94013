"""The claims about lists of titles, each checked in the catalogue's SQLite tables, or in the lab."""

import json
from collections.abc import Sequence
from itertools import islice
from typing import Annotated, Any

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, Scope, claim, slot
from teachers.oracles.movies import checks
from teachers.rules import TownRule
from teachers.words import listed
from worlds.movies import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
    Movies,
    Truth,
    answer_of,
)
from worlds.movies.catalogue import AGES

Attribute = Annotated[str, (*checks.NAMES,)]
"""An attribute of titles that users can have wishes for."""
LISTED = 3
"""Most works that a claim about an ambiguous title names."""


@claim
class Goal(Claim[Truth, Movies]):
    """True if titles are wanted that meet a user's wishes, of which the request leaves out exactly one."""

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Count the user's wishes and those in the request."""
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


@claim
class _Wished(Claim[Truth, Movies]):
    attribute: Attribute
    wish: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Compare what SQL finds for the words with what the world pays for this wish alone."""
        return checks.is_wished(lab, moment.after, self.attribute, self.wish)


@claim
class Wish(_Wished):
    """True if the user wants titles whose `attribute` is `wish`."""


@claim
class _List(ActionClaim[Truth, Movies]):
    action: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer it."""
        return checks.earns(lab, moment.after, self.action) == 0.0


@claim
class Solution(_List):
    """True if all titles of the list `action` fit."""


@claim
class _Title(Claim[Truth, Movies]):
    title: str

    def meant(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Whether the claim is about this title."""
        return True

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look each wish up by SQL."""
        return self.meant(moment, lab) and checks.suits(lab, moment.after.profile, self.title)


@claim
class TriedWell(_Title):
    """True if a title meets all of the user's wishes."""

    kind = HP
    tried = True

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(TriedInVain(**fault) for fault in checks.faults_of(lab, self.title, moment.after.profile))


@claim
class TriedInVain(_Title):
    """True if a title's `attribute` is `found`, which does not meet the user's wish, `wanted`."""

    kind = HN
    tried = True
    attribute: Attribute
    found: str
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        return checks.misses(lab, moment, self.title, self.attribute, self.found, self.wanted)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(title=self.title),)


@claim
class AllFit(Claim[Truth, Movies]):
    """True if the last list is not empty and all of its titles meet all wishes."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer the list again."""
        return moment.before is not None and checks.earns(lab, moment.before, moment.action) == 0.0

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Find fault with the first title."""
        return _faults(moment, lab, 1)


@claim
class _Entry(Claim[Truth, Movies]):
    item: int
    said: str

    def names(self, moment: Moment[Truth]) -> bool:
        """Whether title `item` of the last list reads `said`."""
        return checks.said_at(moment, self.item) == self.said

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Take it for something else."""
        labels = (item.label for item in lab.catalogue.items[: _COUNTERPARTS + 1])
        taken = (TakenFor(item=self.item, said=self.said, title=label) for label in labels)
        return tuple(other for other in taken if other != self)


@claim
class TakenFor(_Entry):
    """True if title `item` of the last list, which reads `said`, was taken for the catalogue's `title`."""

    kind = HP
    title: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the title up by SQL, compare the spellings, and let the world pay for what was said."""
        return self.names(moment) and checks.means(lab, self.said, self.title)


@claim
class _Item(_Title):
    item: int

    def meant(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Whether title `item` of the last list stands for `title`."""
        said = checks.said_at(moment, self.item)
        return said != "" and checks.means(lab, said, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Find fault with it."""
        return _faults(moment, lab, self.item)


@claim
class Fits(_Item):
    """True if title `item` of the last list is `title`, and meets all wishes."""

    kind = HP


@claim
class AttributeFits(_Item):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, meets the user's wish."""

    kind = HP
    attribute: Attribute
    found: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        profile = moment.after.profile
        return self.meant(moment, lab) and bool(checks.wish_met(lab, profile, self.title, self.attribute, self.found))

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(fault for fault in _faults(moment, lab, self.item) if fault.attribute == self.attribute)


@claim
class AttributeMisses(_Item):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, does not meet `wanted`."""

    kind = HN
    attribute: Attribute
    found: str
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        meant = self.meant(moment, lab)
        return meant and checks.misses(lab, moment, self.title, self.attribute, self.found, self.wanted)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return (AttributeFits(item=self.item, title=self.title, attribute=self.attribute, found=self.found),)


@claim
class Unrated(_Item):
    """True if title `item` of the last list is `title`, whose certificate is unknown, while `wanted` is wished."""

    kind = HN
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the certificate up by SQL."""
        wanted = self.meant(moment, lab) and moment.after.profile.words(AGE) == self.wanted != ""
        return wanted and not checks.is_rated(lab, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Make a certificate up."""
        made_up = AGES[AGE_NAMES.index(self.wanted)]
        return tuple(AttributeFits(item=self.item, title=self.title, attribute=AGE, found=each) for each in made_up)


@claim
class _Behind(Claim[Truth, Movies]):
    first: int
    count: int
    total: int

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer each of them alone."""
        fit, total = checks.tally(lab, moment, self.first)
        return (self.count, self.total) == (fit if self.kind is HP else total - fit, total)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Other numbers."""
        return tuple(type(self)(first=self.first, count=n, total=self.total) for n in range(self.total + 1))


@claim
class OthersFit(_Behind):
    """True if the last list has `total` titles from title `first` on, and `count` of them meet all wishes."""

    kind = HP


@claim
class OthersMiss(_Behind):
    """True if the last list has `total` titles from title `first` on, and `count` of them miss a wish."""

    kind = HN


@claim
class NotInCatalogue(_Entry):
    """True if the catalogue has no title, of its year if it gives one, that `said`, title `item`, could stand for."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Go through all titles, and let the world refuse this one."""
        return self.names(moment) and checks.is_unknown(lab, self.said)


@claim
class SpeltLike(_Entry):
    """True if `said`, title `item` of the last list, is none of the catalogue's titles, but is spelt like `title`."""

    kind = HN
    title: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Go through all titles, let the world refuse this one, and compare the spellings."""
        return self.names(moment) and checks.is_unknown(lab, self.said) and checks.is_like(lab, self.said, self.title)


@claim
class Ambiguous(_Entry):
    """True if `said`, title `item` of the last list, could be `count` works, those of `works` among them."""

    kind = HN
    count: int
    works: tuple[str, ...]
    """At most three works with their years, such as `Aladdin (1992)`."""
    candidates = slot("; ".join, "works")

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the works up by SQL, compare the spellings, and let the world refuse what was said."""
        several = self.count >= 2 and len(self.works) == min(self.count, LISTED)
        return self.names(moment) and several and checks.could_be(lab, self.said, self.works)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Deny that there is any."""
        return (NotInCatalogue(item=self.item, said=self.said),)


@claim
class Nothing(Claim[Truth, Movies]):
    """True if the last list is empty."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Read it."""
        return moment.before is not None and json.loads(moment.action) == []

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Praise it."""
        return (AllFit(),)


@claim
class Seek(_Wished):
    """True if it is good to look for titles whose `attribute` is `wish`: the user wants them."""

    kind = FP
    scope = Scope.WORLD
    counterparts = Claim.varied("wish", lambda claim, _, __: checks.NAMES[claim.attribute])


@claim
class Recommend(_List):
    """True if the list `action` earns more than the last one, and has `title`, which meets all wishes."""

    kind = FP
    title: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the title up by SQL, and offer both lists."""
        return checks.is_better(lab, moment.after, self.action, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Name a title that does not fit."""
        return _unfit(moment, lab, self.action, self.title)

    def coarser(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The wishes that the title meets."""
        wishes = checks.wish_words(moment.after.profile)
        return tuple(Seek(attribute=attribute, wish=wish) for attribute, wish in wishes)


@claim
class Repeat(_List):
    """True if the list `action` is the last one, and all of its titles fit."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer it again."""
        return self.action == moment.after.answer and checks.earns(lab, moment.after, self.action) == 0.0

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Name a title that does not fit."""
        return _unfit(moment, lab, self.action, json.loads(self.action)[0])


@claim
class AvoidTitle(_Title):
    """True if a title of the catalogue does not meet all wishes."""

    kind = FN
    scope = Scope.WORLD

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look each wish up by SQL."""
        return checks.row_of(lab, self.title) is not None and not checks.suits(lab, moment.after.profile, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Warn of titles that fit."""
        fitting = lab.catalogue.fitting(moment.after.profile.wishes.values())[:_COUNTERPARTS]
        return tuple(AvoidTitle(title=lab.catalogue.items[i].label) for i in fitting.tolist())


@claim
class AvoidTrait(Claim[Truth, Movies]):
    """True if the catalogue has titles whose `attribute` is `trait`, and none of them meets all wishes."""

    kind = FN
    scope = Scope.WORLD
    attribute: Attribute
    trait: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the titles that have it, and those that meet all wishes, up by SQL."""
        return checks.is_useless(lab, moment.after.profile, self.attribute, self.trait)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Warn of wished traits."""
        wished = checks.traits_wished(moment.after.profile)
        return tuple(AvoidTrait(attribute=attribute, trait=trait) for attribute, trait in wished)


@claim
class _Unsaid(Claim[Truth, Movies]):
    """Base of claims about the wish that the request leaves out."""

    scope = Scope.WORLD
    attribute: Attribute


@claim
class About(_Unsaid):
    """True if the wish that the request leaves out is about `attribute`."""

    kind = FP
    counterparts = Claim.varied("attribute", checks.NAMES)

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Read the request, and look for the wish that it lacks."""
        return self.attribute == checks.left_out(lab, moment.after)

    def excludes(self, other: Claim) -> bool:
        """Another attribute."""
        return isinstance(other, _Unsaid) and other.attribute != self.attribute


@claim
class WithinWishes(_Unsaid):
    """True if the wish that the request leaves out is about `attribute`, and whatever it asks for is among `wishes`."""

    kind = FP
    wishes: tuple[str, ...]
    listing = slot(lambda wishes: listed(wishes, "and"), "wishes")

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Read the request, and look for the wish that it lacks."""
        wish = moment.after.profile.words(self.attribute).split(" or ")
        return self.attribute == checks.left_out(lab, moment.after) and set(wish) <= set(self.wishes)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """As many other wishes."""
        others = [name for name in checks.NAMES[self.attribute] if name not in self.wishes]
        return (WithinWishes(attribute=self.attribute, wishes=tuple(others[: len(self.wishes)])),) if others[1:] else ()

    def excludes(self, other: Claim) -> bool:
        """Another attribute, or wishes without any of these."""
        apart = isinstance(other, WithinWishes) and not set(self.wishes) & set(other.wishes)
        return apart or About(attribute=self.attribute).excludes(other)


def _faults(moment: Moment[Truth], lab: Movies, item: int) -> tuple[AttributeMisses, ...]:
    """Faults that could be found with a title of the last list."""
    title = checks.item_of(lab, checks.said_at(moment, item)).label
    return tuple(AttributeMisses(item=item, **fault) for fault in checks.faults_of(lab, title, moment.after.profile))


def _unfit(moment: Moment[Truth], lab: Movies, action: str, title: str) -> tuple[Claim, ...]:
    """Recommendations of titles that do not fit, in place of a fitting one."""
    titles = json.loads(action)
    lists = ((label, [label if each == title else each for each in titles]) for label in checks.unfit(lab, moment))
    return tuple(Recommend(action=answer_of(each), title=label) for label, each in islice(lists, _COUNTERPARTS))


_COUNTERPARTS = 3


@claim
class _LeftOut(TownRule[Truth, Movies]):
    """Base of rules about the wish that requests omit."""

    attribute: Attribute

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Compare with the omitted wish, which is the law of the town."""
        return moment.after.law is not None and bool(self.fits(moment.after))


@claim
class AlwaysWants(_LeftOut):
    """True if each request of the town's user leaves out the wish that `attribute` is `wish`."""

    kind = FP
    wish: str
    counterparts = Claim.varied("wish", lambda claim, _, __: checks.NAMES[claim.attribute])

    def fits(self, truth: Truth) -> bool:
        """Read the wish that the request leaves out."""
        return truth.unsaid == self.attribute and truth.profile.words(self.attribute) == self.wish

    def excludes(self, other: Claim) -> bool:
        """Another wish, or the claim that requests never omit one about this attribute."""
        return isinstance(other, _LeftOut) and (
            other != self if isinstance(other, AlwaysWants) else other.attribute == self.attribute
        )


@claim
class AlwaysSays(_LeftOut):
    """True if no request of the town's user leaves out a wish about `attribute`."""

    kind = FN
    counterparts = Claim.varied("attribute", ATTRIBUTES)

    def fits(self, truth: Truth) -> bool:
        """Look up what the request leaves out."""
        return truth.unsaid != self.attribute
