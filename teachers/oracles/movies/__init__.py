"""The movies' oracle: it judges each recommended title by each wish, and names titles that fit.

It uses tables of bits; its claims are checked in the catalogue's SQLite tables, or in the lab.
"""

from collections.abc import Callable, Sequence, Set
from functools import lru_cache

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, fast_constructor
from teachers.oracle import Oracle
from teachers.oracles.movies.checks import FOUND, NAMES, found_words, wish_words
from teachers.oracles.movies.claims import (
    LISTED,
    About,
    AgeGroup,
    AllFit,
    AlwaysSays,
    AlwaysWants,
    Ambiguous,
    Answer,
    AttributeFits,
    AttributeMisses,
    AvoidTitle,
    AvoidTrait,
    Fits,
    Goal,
    Nothing,
    NotInCatalogue,
    OthersFit,
    OthersMiss,
    Recommend,
    Repeat,
    Rules,
    Solution,
    SpeltLike,
    TakenFor,
    TriedInVain,
    TriedWell,
    Unrated,
    Wish,
    WithinWishes,
)
from worlds.movies import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
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
from worlds.movies.catalogue import AGES, CERTIFICATES, PERIODS, Catalogue, Item, certificate_bit, period_bit, type_bit

_TRIES = 3
_SHOWN = 3
_SOME = 4  # one wish in so many is named, where there are many
_ALL_FIT, _NOTHING, _GOAL, _RULES, _ANSWER = AllFit(), Nothing(), Goal(), Rules(), Answer(limit=MAX_TITLES)
_AGE_GROUPS = tuple(AgeGroup(age=age, certificates=group) for age, group in zip(AGE_NAMES, AGES, strict=True))
_fits, _attribute_fits = fast_constructor(Fits), fast_constructor(AttributeFits)
_unrated, _attribute_misses = fast_constructor(Unrated), fast_constructor(AttributeMisses)
_taken_for, _spelt_like = fast_constructor(TakenFor), fast_constructor(SpeltLike)
_not_in_catalogue = fast_constructor(NotInCatalogue)
_repeat, _recommend = fast_constructor(Repeat), fast_constructor(Recommend)
_avoid_title, _avoid_trait = fast_constructor(AvoidTitle), fast_constructor(AvoidTrait)


class MoviesOracle(Oracle[Truth, Movies]):
    """Judges lists title by title and wish by wish, and advises to replace a title that does not fit."""

    max_importance = 1.0

    def start(self, truth: Truth) -> None:
        """Find the titles that fit, and the traits to avoid."""
        catalogue: Catalogue = self.lab.catalogue
        fitting = catalogue.fitting(truth.profile.wishes.values())
        first, second = truth.manner  # each user gets other titles first
        begin = (7 * first + 31 * second) % max(1, len(fitting))
        self._fitting: list[int] = np.concatenate((fitting[begin:], fitting[:begin]))[:_LONGEST].tolist()
        self._traits = _traits(catalogue, truth.profile)

    def texts_at_hand(self, claim: type[Claim], field: str, moment: Moment[Truth]) -> Sequence[str]:
        """The titles of the last list, for claims about one of them."""
        listed = field == "said" or (field == "title" and claim not in (Recommend, TakenFor, SpeltLike))
        return titles_of(moment.after.answer) if listed else ()

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        return _GOAL, _RULES, *_AGE_GROUPS, _ANSWER

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Verdicts on a few titles; each is judged once."""
        claims: dict[Claim, None] = {}
        items = [item for item in self.lab.catalogue.items if item.named]
        for draw in rng.integers(len(items), size=_TRIES).tolist():
            item = items[draw]
            wrong = next((each for each in truth.profile.wishes.items() if not item.bits & each[1]), None)
            if wrong is None:
                claims[TriedWell(title=item.label)] = None
            elif found := found_words(item, wrong[0]):
                claims[
                    TriedInVain(title=item.label, attribute=wrong[0], found=found, wanted=truth.profile.words(wrong[0]))
                ] = None
        return tuple(claims)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        wishes = (Wish(attribute=attribute, wish=wish) for attribute, wish in wish_words(truth.profile))
        return *wishes, *(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Judge titles one by one up to `max_items`, and count the rest."""
        titles, catalogue, profile = titles_of(moment.action), self.lab.catalogue, moment.past.profile
        items, limit, success = catalogue.look_up(titles), self.lab.max_items, moment.success
        good: list[Claim] = [_ALL_FIT] if success else []
        bad: list[Claim] = [] if titles else [_NOTHING]
        wanted = () if success else _wanted(profile)
        for place, said in enumerate(titles[:limit], 1):
            item = items[place - 1]
            if item is None:
                bad.append(_unclear(catalogue, place, said))
            elif item.named:
                if said != item.label and _is_other(said, item):
                    good.append(_taken_for(place, said, item.label))
                _judge(good, bad, place, item, wanted)
        if HP in kinds:
            claims += good
        if HN in kinds:
            claims += bad
        if not success and (behind := items[limit:]):
            wishes = profile.wishes.values()
            fit = sum(item is not None and item.meets(wishes) for item in behind)
            if HP in kinds and fit:
                claims.append(OthersFit(first=limit + 1, count=fit, total=len(behind)))
            if HN in kinds and fit < len(behind):
                claims.append(OthersMiss(first=limit + 1, count=len(behind) - fit, total=len(behind)))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Advise to replace the first title that does not fit."""
        truth = moment.after
        catalogue = self.lab.catalogue
        titles, wishes = titles_of(truth.answer), truth.profile.wishes.values()
        items = catalogue.look_up(titles)
        wrong = [i for i, item in enumerate(items) if item is None or not item.meets(wishes)]
        if FP in kinds:
            if titles and not wrong:
                claims.append(_repeat(truth.answer))
            elif self._fitting:  # the wishes of a user made by hand may fit no title
                title = self._other_than({item.label for item in items if item})
                claims.append(_replace(titles, wrong[0] if wrong else 0, title))
        if FN in kinds:
            for i in wrong:
                if (item := items[i]) and item.named:
                    claims.append(_avoid_title(item.label))
                    return
            if self._traits:
                attribute, trait = self._traits[moment.turn % len(self._traits)]
                claims.append(_avoid_trait(attribute, trait))

    def _other_than(self, used: Set[str]) -> str:
        """The first fitting title that is not used yet; if all are used, the first one."""
        items = self.lab.catalogue.items
        for i in self._fitting:
            if (label := items[i].label) not in used:
                return label
        return items[self._fitting[0]].label

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """The attribute of the omitted wish, some wishes with it among them, and the rules of a town."""
        profile, unsaid, (first, second), _, law = truth
        names, wish = NAMES[unsaid], profile.words(unsaid).split(" or ")
        others = [name for name in names if name not in wish]
        begin = (7 * first + 31 * second) % max(1, len(others))  # each user gets others
        count = max(1, len(names) // _SOME - len(wish))
        some = {*wish, *(others[begin:] + others[:begin])[:count]}
        listed = tuple(name for name in names if name in some)
        within = (WithinWishes(attribute=unsaid, wishes=listed),) if len(listed) < len(names) else ()
        always = AlwaysSays(attribute=ATTRIBUTES[ATTRIBUTES.index(unsaid) - 1])
        rules = (always, AlwaysWants(attribute=unsaid, wish=profile.words(unsaid))) if law else ()
        return About(attribute=unsaid), *within, *rules

    def importance(self, truth: Truth) -> float:
        """The reward of a fitting list minus that of a list without a fitting title: always 1."""
        return 1.0

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """A fitting list, `n` times."""
        items = self.lab.catalogue.items
        return (answer_of([items[i].label for i in self._fitting[:_SHOWN]]),) * n if self._fitting else ()

    def regret(self, moment: Moment[Truth]) -> float:
        """The reward of a fitting list minus the action's: 0 to 1."""
        return self.idle(moment.after) if moment.before is None else 0.0 - moment.reward

    def idle(self, truth: Truth) -> float:
        """1: without a list no title fits."""
        return 1.0


_LONGEST = MAX_TITLES + 1


def _replace(titles: tuple[str, ...], place: int, title: str) -> Recommend:
    """Advice to put a title at a place of a list, or alone if the list would be too long."""
    action = answer_of([*titles[:place], title, *titles[place + 1 :]])
    return _recommend(action if len(action) <= MAX_LENGTH else answer_of([title]), title)


def _traits(catalogue: Catalogue, profile: Profile) -> list[tuple[str, str]]:
    """Traits that no fitting title has: the other type, periods and certificates."""
    lacking = catalogue.bits & ~catalogue.bits_of(profile.wishes.values())
    some = [(TYPE, TYPE_NAMES[not profile.series])] if catalogue.bits & type_bit(not profile.series) else []
    if profile.age >= 0:
        some += [(AGE, each) for each in CERTIFICATES if lacking & certificate_bit(each)]
    if profile.periods:
        some += [(YEAR, PERIOD_NAMES[period]) for period in range(len(PERIODS)) if lacking & period_bit(period)]
    return some


def _unclear(catalogue: Catalogue, place: int, said: str) -> Claim:
    """The claim about a title of the list that names no item, or several."""
    found = catalogue.find(said)
    if found:
        works = tuple([f"{catalogue.items[i].title} ({catalogue.items[i].first})" for i in found[:LISTED]])
        return Ambiguous(item=place, said=said, count=len(found), works=works)
    for i in catalogue.near(said):
        if (near := catalogue.items[i]).named:
            return _spelt_like(place, said, near.label)
    return _not_in_catalogue(place, said)


def _is_other(said: str, item: Item) -> bool:
    """Whether a title of the list differs from the item's title by more than case."""
    plain = (item.title, f"{item.title} ({item.first})")
    return said not in plain and said.casefold() not in map(str.casefold, plain)


_Wanted = tuple[tuple[str, int, str, Callable[[Item], str]], ...]


def _judge(good: list[Claim], bad: list[Claim], place: int, item: Item, wanted: _Wanted) -> None:
    """Append the verdicts on an item of the list, wish by wish; none without wishes."""
    title, bits = item.label, item.bits
    for _, wish, _, _ in wanted:
        if not bits & wish:
            break
    else:
        if wanted:
            good.append(_fits(title, place))
        return
    for attribute, wish, words, find in wanted:
        found = find(item)
        if bits & wish:
            good.append(_attribute_fits(title, place, attribute, found))
        elif found:
            bad.append(_attribute_misses(title, place, attribute, found, words))
        else:
            bad.append(_unrated(title, place, words))


@lru_cache(maxsize=1024)  # a turn of movies takes 12 % longer without it
def _wanted(profile: Profile) -> _Wanted:
    """Per wish: attribute, bits of which a title must have one, wish in words, function for an item in words."""
    wishes = profile.wishes.items()
    return tuple((attribute, wish, profile.words(attribute), FOUND[attribute]) for attribute, wish in wishes)
