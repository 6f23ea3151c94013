"""Voices: the tone of the words. A voice never changes which claims are said.

A voice is a file, `voices/<name>.toml` or one of the user's own:

    shortest = 2                        # use only that many of the shortest plain paraphrases; all by default
    [frames]                            # per kind of feedback, what surrounds a plain sentence
    hn = ["Never mind. {sentence}", ...]
    [phrases]                           # the voice's own phrases for claims that belong to no family
    Right = ["Well done!", ...]

A family may have phrases for a voice in a table of the voice's name beside its plain ones. No frames surround a
voice's own phrases, instructions and verdicts on actions tried before an episode. A voice may also be a function that
rewrites each sentence; changes of numbers and names are reported.
"""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from teachers.atoms import KINDS, Atom, Claim, FeedbackType, Utterance, slots_of

PLAIN = "plain"
LEAST, MOST = 4, 20
"""Allowed numbers of frames per kind, and of paraphrases per claim."""
Voice = str | Path | Callable[[str], str]
"""The name of a voice, the path of a file ending in `.toml`, or a function that rewrites a sentence."""
SENTENCE = "{sentence}"
"""The slot of a frame."""


class Tone(NamedTuple):
    """The contents of a voice's file."""

    name: str
    frames: Mapping[FeedbackType, tuple[str, ...]]
    """Per kind templates with the slot `sentence`."""
    shortest: int
    """How many plain paraphrases are used, the shortest first."""
    phrases: Mapping[str, list[str]]
    """Its own phrases for claims that belong to no family."""

    def frame(self, kind: FeedbackType | None, templates: Sequence[str]) -> list[str]:
        """Plain templates of a kind in this tone: each template in each frame of the kind."""
        brief = sorted(templates, key=lambda template: (len(template.split()), len(template)))[: self.shortest]
        kept = [template for template in templates if template in brief]
        frames = self.frames.get(kind, ()) if kind else ()
        return [frame.replace(SENTENCE, template) for frame in frames or (SENTENCE,) for template in kept]


@cache
def voice_names() -> tuple[str, ...]:
    """The names of all voices."""
    files = resources.files("teachers.voices").iterdir()
    return PLAIN, *sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def load_tone(voice: str | Path) -> Tone | None:
    """The tone of a voice; None for the plain voice, which changes no phrases.

    Raises:
        ValueError: the voice is unknown, or its file is not valid; one error lists all problems.
    """
    if voice == PLAIN:
        return None
    path = Path(voice)
    if path.suffix == ".toml":
        try:
            return _read(path.stem, path.read_text(encoding="utf-8-sig"), f"{path}")
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f"cannot read the voice {path}: {error}") from None
    if voice not in voice_names():
        raise ValueError(
            f"unknown voice {voice!r}; allowed: {', '.join(voice_names())}, the path of a .toml file, or a function"
        )
    return _shipped(f"{voice}")


@cache
def _shipped(name: str) -> Tone:
    file = resources.files("teachers.voices").joinpath(f"{name}.toml")
    return _read(name, file.read_text(encoding="utf-8"), f"voices/{name}.toml")


def _read(name: str, text: str, source: str) -> Tone:
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"cannot read the voice {source}: {error}") from None
    if problems := list(_problems(table)):
        raise ValueError(f"bad voice in {source}:\n  " + "\n  ".join(problems))
    frames = {FeedbackType(kind): tuple(each) for kind, each in table.get("frames", {}).items()}
    return Tone(name, frames, table.get("shortest", MOST), table.get("phrases", {}))


def _problems(table: dict[str, Any]) -> Iterator[str]:
    yield from (f"{key}: allowed are shortest, frames, phrases" for key in table if key not in _KEYS)
    shortest = table.get("shortest", MOST)
    if not isinstance(shortest, int) or isinstance(shortest, bool) or not 1 <= shortest <= MOST:
        yield f"shortest: must be an integer from 1 to {MOST}, got {shortest!r}"
    yield from (f"{key}: must be a table" for key in ("frames", "phrases") if not isinstance(table.get(key, {}), dict))
    frames = table.get("frames", {})
    for kind, each in frames.items() if isinstance(frames, dict) else ():
        if kind not in KINDS:
            yield f"frames.{kind}: is no kind of feedback; allowed: {', '.join(KINDS)}"
        if not isinstance(each, list) or not all(isinstance(frame, str) for frame in each):
            yield f"frames.{kind}: must be a list of strings"
            continue
        if not LEAST <= len(each) <= MOST:
            yield f"frames.{kind}: has {len(each)} frames; allowed: {LEAST} to {MOST}"
        for frame in each:
            if frame.count(SENTENCE) != 1 or set(frame.replace(SENTENCE, "")) & set("{}"):
                yield f"frames.{kind}: {frame!r} must have the slot {SENTENCE} once, and no other"
        yield from (f"frames.{kind}: {frame!r} comes twice" for frame in sorted(set(each)) if each.count(frame) > 1)


_KEYS = ("shortest", "frames", "phrases")


class Change(NamedTuple):
    """Numbers and names of a sentence that a rewriting voice changed."""

    before: str
    after: str
    vanished: tuple[str, ...]
    appeared: tuple[str, ...]


def rewrite(said: Utterance, voice: Callable[[str], str]) -> tuple[Utterance, tuple[Change, ...]]:
    """Rewrite an utterance sentence by sentence; also return the changes of numbers and names.

    Instructions and notices do not change, nor do sentences that the voice would leave empty.
    """
    atoms, changes = [], []
    for atom in said.atoms:
        text = f"{voice(atom.text)}".strip() if atom.kind is not None else atom.text
        if text != atom.text:
            vanished, appeared = compare(atom.claim, atom.text, text)
            if vanished or appeared or not text:
                changes.append(Change(atom.text, text, vanished, appeared))
        atoms.append(Atom(atom.claim, text or atom.text, atom.about_turn))
    return Utterance.of(atoms), tuple(changes)


def compare(claim: Claim, before: str, after: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The numbers and names that a rewritten sentence has lost and gained.

    Names are the values of the claim's fields that the sentence contains, the other members of a field's enumeration,
    words with digits, and capitalized words inside a sentence. Only their spelling counts.
    """
    old, new = _numbers(before), _numbers(after)
    values = [getattr(claim, name) for name in slots_of(type(claim))]
    said = {f"{value}" for value in values if isinstance(value, str | Enum)}
    others = {f"{other}" for value in values if isinstance(value, Enum) for other in type(value)}
    words = _names(before) | {name for name in said if _has(before, name)}
    there = _names(after) | {name for name in others if _has(after, name)}
    vanished = [*(old[n] for n in old if n not in new), *sorted(word for word in words if not _has(after, word))]
    appeared = [*(new[n] for n in new if n not in old), *sorted(word for word in there if not _has(before, word))]
    return tuple(vanished), tuple(appeared)


_NUMBER = re.compile(r"(?<![\w.-])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w-])")
_WORD = re.compile(r"[^\W_][\w'-]*")
_START = re.compile(r"(?:^|[.!?:\"'(]\s*)$")  # where a capital means nothing


def _numbers(text: str) -> dict[float, str]:
    return {float(number): number for number in _NUMBER.findall(text)}


def _names(text: str) -> set[str]:
    found = set()
    for match in _WORD.finditer(text):
        word = match.group()
        digits = any(c.isdigit() for c in word) and not _NUMBER.fullmatch(word)
        capital = word[0].isupper() and word not in _PRONOUNS and not _START.search(text[: match.start()])
        if digits or capital:
            found.add(word)
    return found


_PRONOUNS = ("I", "I'd", "I'll", "I'm", "I've")


def _has(text: str, name: str) -> bool:
    return re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text, re.IGNORECASE) is not None
