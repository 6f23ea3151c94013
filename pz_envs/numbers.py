"""Numbers: what a student sees, and what is said to it, as one flat array of the same length in every turn."""

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
"""Gives the vector of a text: finite numbers, always as many."""
Writer = Callable[[Any], list[float]]
"""Gives the numbers of a value."""
_MEANINGS: dict[type, str] = {
    spaces.Box: "as it is",
    spaces.Discrete: "a 1 among zeros",
    spaces.MultiBinary: "0 or 1 each",
    spaces.MultiDiscrete: "each as a 1 among zeros",
}
"""The spaces that are a fixed number of numbers, and how."""
_ASPECTS = {
    "said": "1 if something of this kind is said, else 0",
    "number": f"how many things of this kind are said, at most {CLAIMS}",
    "turn": "the turn that it is about, as a share of max_turns; 0 where nothing of this kind is said",
    "verdict": "1 if the action is called good, -1 if it is called bad, 0 where none is named",
}


class Field(NamedTuple):
    """Some of the numbers, which mean one thing."""

    name: str
    """Such as `state.room`, `hn.verdict` or `fp.action`."""
    place: slice
    """Where they are: `observation[field.place]`."""
    meaning: str


class Numbers:
    """Turns what a student observes into a flat array.

    First the state, as it is, with a 1 among zeros for one of finitely many; then the turn; then for each kind of
    feedback whether it is said, how often, about which turn, the action that is advised or judged, and the verdict on
    it; of `r` the reward. Of several things of a kind the first that names an action counts, of a plan its first
    action. With `embed`, texts are vectors, and the words of the instruction and of the feedback are there, too.
    Nothing is read out of words. What lies outside of the space is moved to its edge.

    Args:
        world: of which spaces the state and the actions are.
        max_turns: turns of the student in an episode.
        embed: gives the vector of a text; None: there must be no texts among states and actions.

    Raises:
        ValueError: a state or an action has no fixed number of numbers, or `embed` gives something else than vectors.
    """

    def __init__(self, world: World[Any, Any, Any], max_turns: int, embed: Embed | None = None) -> None:
        self._max_turns, self._embed = max_turns, embed
        self._words = None if embed is None else _vector(embed, "").size
        self._action_space = world.action_space
        self._state, self._action = self._writer(world.observation_space), self._writer(self._action_space)
        self._fields: list[Field] = []
        self._low: list[float] = []
        self._high: list[float] = []
        self._lay("state", world.observation_space, "the state")
        self._add("turn", "turns so far, as a share of max_turns", 1, 0.0, 1.0)
        low, high = world.reward_range
        for kind in KINDS:
            self._add(f"{kind}.said", _ASPECTS["said"], 1, 0.0, 1.0)
            self._add(f"{kind}.number", _ASPECTS["number"], 1, 0.0, CLAIMS)
            self._add(f"{kind}.turn", _ASPECTS["turn"], 1, 0.0, 1.0)
            if kind is R:
                meaning = "the reward that is told; 0 where none is"
                self._add(f"{kind}.told", meaning, 1, min(low, 0.0), max(high, 0.0))
            else:
                good = kind in (HP, FP)
                self._lay(f"{kind}.action", self._action_space, "the action that is named", blank=True)
                self._add(f"{kind}.verdict", _ASPECTS["verdict"], 1, 0.0 if good else -1.0, 1.0 if good else 0.0)
        if self._words is not None:
            for name in ("instruction", "feedback"):
                self._add(name, "the words, embedded", self._words, -np.inf, np.inf)
        low_bounds, high_bounds = np.array(self._low, np.float32), np.array(self._high, np.float32)
        self.space = spaces.Box(low_bounds, high_bounds, dtype=np.float32)
        """The space of what `of` gives."""
        self.fields = tuple(self._fields)
        """What the numbers are, in their order."""
        most = np.finfo(np.float32).max
        self._least, self._greatest = np.clip(low_bounds, -most, most), np.clip(high_bounds, -most, most)
        self._nothing = [0.0] * sum(_size(part, self._words) for _, part in _parts(self._action_space))

    def of(
        self, state: Any, turn: int, instruction: str, feedback: str, atoms: Iterable[Atom]
    ) -> npt.NDArray[np.float32]:
        """The numbers of a turn.

        Args:
            state: what the world shows.
            turn: turns of the student so far.
            instruction, feedback: the words that the student sees.
            atoms: what was said last.
        """
        numbers = [*self._state(state), turn / self._max_turns]
        said: dict[FeedbackType | None, list[Atom]] = {}
        for atom in atoms:
            said.setdefault(atom.kind, []).append(atom)
        for kind in KINDS:
            self._tell(numbers, kind, said.get(kind, []))
        if self._embed is not None:
            for words in (instruction, feedback):
                numbers += self._embedded(words)
        array = np.array(numbers, float)
        np.maximum(array, self._least, out=array)
        np.minimum(array, self._greatest, out=array)
        return array.astype(np.float32)

    def _tell(self, numbers: list[float], kind: FeedbackType, said: list[Atom]) -> None:
        """What is said of a kind."""
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

    def _lay(self, name: str, space: spaces.Space[Any], what: str, blank: bool = False) -> None:
        """Find a place for something of a space; `blank`: or for zeros in its stead."""
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
            self._add(".".join((name, *path)), meaning, size, low, high)

    def _add(self, name: str, meaning: str, size: int, low: Any, high: Any) -> None:
        start = len(self._low)
        self._fields.append(Field(name, slice(start, start + size), meaning))
        self._low += np.broadcast_to(low, size).tolist()
        self._high += np.broadcast_to(high, size).tolist()

    def _writer(self, space: spaces.Space[Any]) -> Writer:
        """What gives the numbers of something of a space."""
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


# Writers are no closures, which could not be pickled.


def _of_parts(writers: Sequence[tuple[Any, Writer]], value: Any) -> list[float]:
    return [number for key, write in writers for number in write(value[key])]


def _flat(space: spaces.Space[Any], value: Any) -> list[float]:
    numbers: list[float] = flatten(space, value).tolist()  # type: ignore[union-attr]  # it is an array
    return numbers


def _one_of(count: int, start: int, value: Any) -> list[float]:
    """A 1 among zeros."""
    row = [0.0] * count
    row[int(value) - start] = 1.0
    return row


def _parts(space: spaces.Space[Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], spaces.Space[Any]]]:
    """The parts of a space that have no parts, each with where it is."""
    if isinstance(space, spaces.Dict):
        for key, part in space.spaces.items():
            yield from _parts(part, (*path, str(key)))
    elif isinstance(space, spaces.Tuple):
        for number, part in enumerate(space.spaces):
            yield from _parts(part, (*path, str(number)))
    else:
        yield path, space


def _size(space: spaces.Space[Any], words: int | None) -> int:
    """How many numbers something of a space without parts is.

    Args:
        space: the space.
        words: how many numbers a text is; None: texts are no numbers.

    Raises:
        ValueError: it has none, or no fixed number of them.
    """
    if isinstance(space, spaces.Text):
        if words is None:
            raise ValueError(
                f"numbers=True needs numbers, and there are texts among the states or the actions ({space}); give "
                "embed=, a function of a text that gives a vector of numbers, always of the same length"
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
        ValueError: it is none.
    """
    vector = np.asarray(embed(text))
    if vector.ndim != 1 or not vector.size or vector.dtype.kind not in "iuf" or not np.isfinite(vector).all():
        raise ValueError(f"embed must give a vector of finite numbers, got {vector!r:.80} for {text!r:.80}")
    return vector.astype(float)
