"""Numbers: the student's observation as one flat array, of the same length in every turn."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.spaces.utils import flatdim, flatten, flatten_space

from teachers.atoms import FP, HP, KINDS, Atom, FeedbackType, R, action_of
from teachers.common import Reward
from teachers.session import CLAIMS
from worlds.actions import native
from worlds.world import World

Embed = Callable[[str], Any]
"""Gives the vector of a text: finite numbers, always of the same length."""
Writer = Callable[[Any], list[float]]
"""Gives the numbers of a value."""
_MEANINGS: dict[type, str] = {
    spaces.Box: "as it is",
    spaces.Discrete: "a 1 among zeros",
    spaces.MultiBinary: "0 or 1 each",
    spaces.MultiDiscrete: "each as a 1 among zeros",
}
"""The spaces with a fixed number of numbers, and how a value is written."""
_ASPECTS = {
    "said": "1 if something of this kind is said, else 0",
    "number": f"how many things of this kind are said, at most {CLAIMS}",
    "turn": "the turn that it is about, as a share of max_turns; 0 where nothing of this kind is said",
    "verdict": "1 if the action is called good, -1 if it is called bad, 0 where none is named",
}


class Field(NamedTuple):
    """Adjacent numbers with one meaning."""

    name: str
    """Such as `state.room`, `hn.verdict` or `fp.action`."""
    place: slice
    """The numbers are `observation[field.place]`."""
    meaning: str


class Numbers:
    """Converts the student's observations to flat arrays.

    The array has the state, one-hot where it is discrete; the turn; for each kind of feedback whether there is a claim,
    the number of claims, the turn that the first is about, its action and its verdict; for `r` the reward. Of several
    claims of a kind the first that names an action counts, of a plan its first action. With `embed` texts are vectors,
    and the array also has the words of the instruction and of the feedback. No number is read from words. Values
    outside the space are clipped.

    Args:
        world: gives the spaces of states and actions.
        max_turns: the student's turns in an episode.
        embed: gives the vector of a text; None: states and actions must have no texts.

    Raises:
        ValueError: a state or an action has no fixed number of numbers, or `embed` does not give vectors.
    """

    def __init__(self, world: World[Any, Any, Any], max_turns: int, embed: Embed | None = None) -> None:
        self._max_turns, self._embed = max_turns, embed
        self._words = None if embed is None else _vector(embed, "").size
        self._action_space = world.action_space
        self._state, self._action = self._writer(world.observation_space), self._writer(self._action_space)
        self._fields: list[Field] = []
        self._low: list[float] = []
        self._high: list[float] = []
        self._add_space("state", world.observation_space, "the state")
        self._add_field("turn", "turns so far, as a share of max_turns", 1, 0.0, 1.0)
        low, high = world.reward_range
        for kind in KINDS:
            self._add_field(f"{kind}.said", _ASPECTS["said"], 1, 0.0, 1.0)
            self._add_field(f"{kind}.number", _ASPECTS["number"], 1, 0.0, CLAIMS)
            self._add_field(f"{kind}.turn", _ASPECTS["turn"], 1, 0.0, 1.0)
            if kind is R:
                meaning = "the reward that is told; 0 where none is"
                self._add_field(f"{kind}.told", meaning, 1, min(low, 0.0), max(high, 0.0))
            else:
                good = kind in (HP, FP)
                self._add_space(f"{kind}.action", self._action_space, "the action that is named", blank=True)
                self._add_field(f"{kind}.verdict", _ASPECTS["verdict"], 1, 0.0 if good else -1.0, 1.0 if good else 0.0)
        if self._words is not None:
            for name in ("instruction", "feedback"):
                self._add_field(name, "the words, embedded", self._words, -np.inf, np.inf)
        low_bounds, high_bounds = np.array(self._low, np.float32), np.array(self._high, np.float32)
        self.space = spaces.Box(low_bounds, high_bounds, dtype=np.float32)
        """The space of the arrays."""
        self.fields = tuple(self._fields)
        """The fields, in their order."""
        most = np.finfo(np.float32).max
        self._least, self._greatest = np.clip(low_bounds, -most, most), np.clip(high_bounds, -most, most)
        self._nothing = [0.0] * sum(_size(part, self._words) for _, part in _parts(self._action_space))

    def of(
        self, state: Any, turn: int, instruction: str, feedback: str, atoms: Iterable[Atom]
    ) -> npt.NDArray[np.float32]:
        """The array of a turn, float32 of the shape of `space`.

        Args:
            state: the world's observation.
            turn: the student's turns so far.
            instruction, feedback: the words that the student sees.
            atoms: the claims heard last.
        """
        numbers = [*self._state(state), turn / self._max_turns]
        said: dict[FeedbackType | None, list[Atom]] = {}
        for atom in atoms:
            said.setdefault(atom.kind, []).append(atom)
        for kind in KINDS:
            self._add_claims(numbers, kind, said.get(kind, []))
        if self._embed is not None:
            for words in (instruction, feedback):
                numbers += self._embedded(words)
        array = np.array(numbers, float)
        np.maximum(array, self._least, out=array)
        np.minimum(array, self._greatest, out=array)
        return array.astype(np.float32)

    def _add_claims(self, numbers: list[float], kind: FeedbackType, said: list[Atom]) -> None:
        """Append the numbers of the claims of a kind."""
        naming = (atom for atom in said if action_of(atom.claim) is not None)
        first = next(naming, said[0] if said else None)
        numbers += (bool(said), len(said), first.about_turn / self._max_turns if first else 0.0)
        if kind is R:
            rewards = [atom.claim.reward for atom in said if isinstance(atom.claim, Reward)]
            numbers.append(rewards[0] if rewards else 0.0)
            return
        action = action_of(first.claim) if first else None
        if action is None:
            numbers += self._nothing
            numbers.append(0.0)
        else:
            numbers += self._action(native(self._action_space, action))
            numbers.append(1.0 if kind in (HP, FP) else -1.0)

    def _add_space(self, name: str, space: spaces.Space[Any], what: str, blank: bool = False) -> None:
        """Add the fields of a space; `blank`: zeros are allowed in their place."""
        for path, part in _parts(space):
            size = _size(part, self._words)
            if isinstance(part, spaces.Text):
                high = np.full(size, np.inf)
                low, how = -high, "embedded"
            else:
                flat = flatten_space(part)
                assert isinstance(flat, spaces.Box)  # noqa: S101  # as of all spaces of numbers
                low, high = flat.low.astype(float), flat.high.astype(float)
                how = next(how for kind, how in _MEANINGS.items() if isinstance(part, kind))
            meaning = f"{what}, {how}"
            if blank:
                low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
                meaning += "; zeros where there is none"
            self._add_field(".".join((name, *path)), meaning, size, low, high)

    def _add_field(self, name: str, meaning: str, size: int, low: Any, high: Any) -> None:
        start = len(self._low)
        self._fields.append(Field(name, slice(start, start + size), meaning))
        self._low += np.broadcast_to(low, size).tolist()
        self._high += np.broadcast_to(high, size).tolist()

    def _writer(self, space: spaces.Space[Any]) -> Writer:
        """The function that gives the numbers of a value of a space."""
        if isinstance(space, spaces.Dict):
            return partial(_of_parts, [(key, self._writer(part)) for key, part in space.spaces.items()])
        if isinstance(space, spaces.Tuple):
            return partial(_of_parts, [(i, self._writer(part)) for i, part in enumerate(space.spaces)])
        if isinstance(space, spaces.Text):
            return self._embedded
        if isinstance(space, spaces.Discrete):
            return partial(_one_of, int(space.n), int(space.start))
        return partial(_flat, space)

    def _embedded(self, text: str) -> list[float]:
        assert self._embed is not None  # noqa: S101  # or there are no texts
        vector = _vector(self._embed, text)
        if vector.size != self._words:
            raise ValueError(
                f"embed must give vectors of one length, got {self._words} numbers for the empty text and "
                f"{vector.size} for {text!r:.80}"
            )
        numbers: list[float] = vector.tolist()
        return numbers


# Writers must be picklable, so they are no closures.


def _of_parts(writers: Sequence[tuple[Any, Writer]], value: Any) -> list[float]:
    return [number for key, write in writers for number in write(value[key])]


def _flat(space: spaces.Space[Any], value: Any) -> list[float]:
    numbers: list[float] = flatten(space, value).tolist()  # type: ignore[union-attr]  # it is an array
    return numbers


def _one_of(count: int, start: int, value: Any) -> list[float]:
    """One-hot."""
    row = [0.0] * count
    row[int(value) - start] = 1.0
    return row


def _parts(space: spaces.Space[Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], spaces.Space[Any]]]:
    """The leaves of a space, each with its path."""
    if isinstance(space, spaces.Dict):
        for key, part in space.spaces.items():
            yield from _parts(part, (*path, str(key)))
    elif isinstance(space, spaces.Tuple):
        for number, part in enumerate(space.spaces):
            yield from _parts(part, (*path, str(number)))
    else:
        yield path, space


def _size(space: spaces.Space[Any], words: int | None) -> int:
    """The number of numbers of a leaf.

    Args:
        space: the leaf.
        words: numbers of a text; None: texts are not allowed.

    Raises:
        ValueError: the leaf has no fixed number of numbers.
    """
    if isinstance(space, spaces.Text):
        if words is None:
            raise ValueError(
                f"numbers=True needs states and actions without texts, got {space}; give embed=, a function that "
                "gives the vector of a text, always of the same length"
            )
        return words
    if not isinstance(space, tuple(_MEANINGS)):
        allowed = ", ".join(each.__name__ for each in (*_MEANINGS, spaces.Dict, spaces.Tuple))
        raise ValueError(
            f"numbers=True needs states and actions of a fixed number of numbers, got {space}; allowed: {allowed}, and "
            "texts with embed="
        )
    return flatdim(space)


def _vector(embed: Embed, text: str) -> npt.NDArray[np.float64]:
    """The vector of a text.

    Raises:
        ValueError: `embed` does not give a vector of finite numbers.
    """
    vector = np.asarray(embed(text))
    if vector.ndim != 1 or not vector.size or vector.dtype.kind not in "iuf" or not np.isfinite(vector).all():
        raise ValueError(f"embed must give a vector of finite numbers, got {vector!r:.80} for {text!r:.80}")
    return vector.astype(float)
