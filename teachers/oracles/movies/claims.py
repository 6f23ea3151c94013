"""What is said about lists of titles, each looked up in the catalogue's SQLite tables, or tried on the world."""

import json
from collections.abc import Sequence
from itertools import islice

import numpy as np

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, claim
from teachers.oracles.movies import checks
from worlds.movies import AGE, AGE_NAMES, ATTRIBUTES, Movies, Truth, answer_of
from worlds.movies.catalogue import AGES

LISTED = 3
"""How many works are named at most where a title could be several."""


@claim
class Goal(Claim[Truth, Movies]):
    """True if titles are wanted that meet a user's wishes, of which the request leaves out exactly one."""

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Count the wishes that the user utters, and those that the catalogue's titles are paid for."""
        lab.restore(moment.after)
        said = lab.step("[]")[0]
        uttered = sum(bool(np.any(said[name])) for name in ("type", "periods", "genres", "age"))
        return uttered == sum(bool(moment.after.profile.words(attribute)) for attribute in ATTRIBUTES) - 1


@claim
class Rules(Claim[Truth, Movies]):
    """True if one of several wished periods or genres is enough, and a TV show counts for each period it ran in."""

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer shows of several periods and titles of several genres to users who wish for each of these alone."""
        return checks.pays_by_rules(lab)


@claim
class AgeGroups(Claim[Truth, Movies]):
    """True if these are the certificates that are child-friendly, family-friendly, and R-rated."""

    groups: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]

    @property
    def child(self) -> str:
        """Those of the first group."""
        return ", ".join(self.groups[0])

    @property
    def family(self) -> str:
        """Those of the second group."""
        return ", ".join(self.groups[1])

    @property
    def adult(self) -> str:
        """Those of the third group."""
        return ", ".join(self.groups[2])

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer a title of each certificate to a user of each kind."""
        return checks.pays_by_age(lab, self.groups)


@claim
class Answer(Claim[Truth, Movies]):
    """True if an answer is a JSON list of at most `limit` titles, with a year in brackets where titles are equal."""

    limit: int

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer lists of strings and of objects, and lists about the limit."""
        return checks.takes_lists(lab, self.limit)


@claim
class _Wished(Claim[Truth, Movies]):
    attribute: str
    wish: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Read the words, and compare what SQL finds for them with what the world pays for this wish alone."""
        return checks.is_wished(lab, moment.after, self.attribute, self.wish)


@claim
class Wish(_Wished):
    """True if the user wants titles whose `attribute` is `wish`."""


@claim
class Solution(ActionClaim[Truth, Movies]):
    """True if all titles of the list `action` fit."""

    action: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer it."""
        return checks.earns(lab, moment.after, self.action) == 0.0


@claim
class TriedWell(Claim[Truth, Movies]):
    """True if a title meets all of the user's wishes."""

    kind = HP
    title: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look each wish up by SQL."""
        return checks.suits(lab, moment.after.profile, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(
            TriedInVain(title=self.title, attribute=attribute, found=found, wanted=wanted)
            for attribute, found, wanted in checks.faults_of(lab, self.title, moment.after.profile)
        )


@claim
class TriedInVain(Claim[Truth, Movies]):
    """True if a title's `attribute` is `found`, which does not meet the user's wish, `wanted`."""

    kind = HN
    title: str
    attribute: str
    found: str
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        profile = moment.after.profile
        met = checks.wish_met(lab, profile, self.title, self.attribute, self.found)
        return met is False and self.wanted == profile.words(self.attribute)

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
        return checks.said_at(moment, self.item) == self.said and checks.means(lab, self.said, self.title)


@claim
class _Title(Claim[Truth, Movies]):
    item: int
    title: str

    def meant(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Whether title `item` of the last list stands for `title`."""
        said = checks.said_at(moment, self.item)
        return said != "" and checks.means(lab, said, self.title)


@claim
class Fits(_Title):
    """True if title `item` of the last list is `title`, and meets all wishes."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look each wish up by SQL."""
        return self.meant(moment, lab) and checks.suits(lab, moment.past.profile, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Find fault with it."""
        return _faults(moment, lab, self.item)


@claim
class _Attribute(_Title):
    attribute: str
    found: str

    def met(self, moment: Moment[Truth], lab: Movies) -> bool | None:
        """Look the attribute up by SQL: whether it meets the user's wish; None if it is another one."""
        known = self.meant(moment, lab)
        return checks.wish_met(lab, moment.past.profile, self.title, self.attribute, self.found) if known else None


@claim
class AttributeFits(_Attribute):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, meets the user's wish."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        return self.met(moment, lab) is True

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(fault for fault in _faults(moment, lab, self.item) if fault.attribute == self.attribute)


@claim
class AttributeMisses(_Attribute):
    """True if title `item` of the last list is `title`, and its `attribute`, `found`, does not meet `wanted`."""

    kind = HN
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the attribute up by SQL."""
        return self.met(moment, lab) is False and self.wanted == moment.past.profile.words(self.attribute)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The opposite verdict."""
        return (AttributeFits(item=self.item, title=self.title, attribute=self.attribute, found=self.found),)


@claim
class Unrated(_Title):
    """True if title `item` of the last list is `title`, whose certificate is unknown, while `wanted` is wished."""

    kind = HN
    wanted: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the certificate up by SQL."""
        wanted = self.meant(moment, lab) and moment.past.profile.words(AGE) == self.wanted != ""
        return wanted and not checks.is_rated(lab, self.title)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Make a certificate up."""
        made_up = AGES[AGE_NAMES.index(self.wanted)]
        return tuple(AttributeFits(item=self.item, title=self.title, attribute=AGE, found=each) for each in made_up)


@claim
class NotInCatalogue(_Entry):
    """True if the catalogue has no title, of its year if it gives one, that `said`, title `item`, could stand for."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Go through all titles, and let the world refuse this one."""
        return checks.said_at(moment, self.item) == self.said and checks.is_unknown(lab, self.said)


@claim
class Ambiguous(_Entry):
    """True if `said`, title `item` of the last list, could be `count` works, those of `works` among them."""

    kind = HN
    count: int
    works: tuple[str, ...]
    """At most three works with their years, such as `Aladdin (1992)`."""

    @property
    def candidates(self) -> str:
        """The works, one after the other."""
        return "; ".join(self.works)

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the works up by SQL, compare the spellings, and let the world refuse what was said."""
        return (
            checks.said_at(moment, self.item) == self.said
            and self.count >= 2
            and len(self.works) == min(self.count, LISTED)
            and checks.could_be(lab, self.said, self.works)
        )

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

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Another wish."""
        names = checks.NAMES[self.attribute]
        return tuple(Seek(attribute=self.attribute, wish=name) for name in names if name != self.wish)


@claim
class Recommend(ActionClaim[Truth, Movies]):
    """True if the list `action` earns more than the last one, and has `title`, which meets all wishes."""

    kind = FP
    action: str
    title: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the title up by SQL, and offer both lists."""
        truth = moment.after
        before = checks.earns(lab, truth, truth.answer) if truth.answer else -1.0
        return (
            self.title in json.loads(self.action)
            and checks.suits(lab, truth.profile, self.title)
            and checks.earns(lab, truth, self.action) > before
        )

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Name a title that does not fit."""
        return _unfit(moment, lab, json.loads(self.action), self.title)

    def coarser(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """The wishes that the title meets."""
        wishes = checks.wish_words(moment.after.profile)
        return tuple(Seek(attribute=attribute, wish=wish) for attribute, wish in wishes)


@claim
class Repeat(ActionClaim[Truth, Movies]):
    """True if the list `action` is the last one, and all of its titles fit."""

    kind = FP
    action: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Offer it again."""
        return self.action == moment.after.answer and checks.earns(lab, moment.after, self.action) == 0.0

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Name a title that does not fit."""
        titles = json.loads(self.action)
        return _unfit(moment, lab, titles, titles[0])


@claim
class AvoidTitle(Claim[Truth, Movies]):
    """True if a title of the catalogue does not meet all wishes."""

    kind = FN
    title: str

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
    attribute: str
    trait: str

    def holds(self, moment: Moment[Truth], lab: Movies) -> bool:
        """Look the titles that have it, and those that meet all wishes, up by SQL."""
        return checks.is_useless(lab, moment.after.profile, self.attribute, self.trait)

    def counterparts(self, moment: Moment[Truth], lab: Movies) -> Sequence[Claim]:
        """Warn of what is wished."""
        wished = checks.traits_wished(moment.after.profile)
        return tuple(AvoidTrait(attribute=attribute, trait=trait) for attribute, trait in wished)


def _faults(moment: Moment[Truth], lab: Movies, place: int) -> tuple[AttributeMisses, ...]:
    """Faults that could be found with a title of the last list."""
    title = checks.item_of(lab, checks.said_at(moment, place)).label
    return tuple(
        AttributeMisses(item=place, title=title, attribute=attribute, found=found, wanted=wanted)
        for attribute, found, wanted in checks.faults_of(lab, title, moment.past.profile)
    )


def _unfit(moment: Moment[Truth], lab: Movies, titles: list[str], title: str) -> tuple[Claim, ...]:
    """Recommendations of titles that do not fit in place of one that does."""
    place = titles.index(title)
    return tuple(
        Recommend(action=answer_of([*titles[:place], label, *titles[place + 1 :]]), title=label)
        for label in islice(checks.unfit(lab, moment.after.profile), _COUNTERPARTS)
    )


_COUNTERPARTS = 3
