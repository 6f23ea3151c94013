"""The student's observation as one flat array of numbers, of the same length in every turn."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.spaces.utils import flatdim, flatten, flatten_space

from teachers.atoms import FP, HP, KINDS, Atom, FeedbackType, R, action_of
from teachers.common import Reward
from teachers.teacher_turn import CLAIMS
from worlds.actions import native
from worlds.world import World

Embed = Callable[[str], Any]
"""Gives the vector of a text: finite numbers, always of the same length."""
Rows = npt.NDArray[Any]
"""An array with a row per lesson."""
Writer = Callable[[Any], list[float]]
"""Gives the numbers of a value."""
_MEANINGS: dict[type, str] = {
    spaces.Box: "as it is",
    spaces.Discrete: "a 1 among zeros",
    spaces.MultiBinary: "0 or 1 each",
    spaces.MultiDiscrete: "each as a 1 among zeros",
}
"""The spaces with a fixed number of numbers, and the functions that write their values."""
_ASPECTS = {
    "said": "1 if something of this kind is said, else 0",
    "number": f"how many things of this kind are said, at most {CLAIMS}",
    "turn": "the turn that it is about, as a share of max_turns; 0 where nothing of this kind is said",
    "verdict": "1 if the action is called good, -1 if it is called bad, 0 where none is named",
}


MASK = "action_mask"
ENTRIES = {
    "available": "1 for each kind that can be said: r, hp, hn, fp, fn; in a class of each student",
    "features": "turn / max_turns, the last reward, importance of the next action, share of the budget that is left, "
    "whether the episode is over",
    "asked": "1 if the student asks",
    "claims": "of each claim that can be said its kind, one of five; whether it is about an action, a plan, an edit",
    "heard": "1 for each kind that others have said before in this round",
    "episode": "share of the episodes of the lifetime that are over",
    "lifetime": "the student's lifetime so far, nine numbers from 0 to 1",
    "students": "of each student: turn / max_turns, the last reward, importance of the next action, whether its "
    "episode is over, whether it is there, whether it was addressed in this round",
    "remaining": "share of the round's attention that is left, share of the budget that is left",
    "asking": "1 for the student that asks",
}
"""What a teacher's observation has, by entry: see `Flat`."""


class Field(NamedTuple):
    """Adjacent numbers with one meaning."""

    name: str
    """Such as `state.room`, `hn.verdict` or `fp.action`."""
    place: slice
    """The numbers are `observation[field.place]`."""
    meaning: str


class RowClaims(NamedTuple):
    """The claims in many rows, for `Numbers.of_rows`."""

    number: Rows
    """Per kind the number of claims, if the kind is said; int (rows, 5)."""
    named: Rows
    """Per kind whether one of them names an action; bool (rows, 5)."""
    action: Sequence[Rows]
    """Per kind the named actions, each of shape (rows, ...); the entry of r is not read."""


class Numbers:
    """Converts the student's observations to flat arrays.

    The array has the state, one-hot where it is discrete; the turn; for each kind of feedback whether there is a claim,
    the number of claims, and of the first claim its turn, action and verdict; for `r` the reward. If there are several
    claims of a kind, the first with an action counts; a plan counts by its first action. With `embed` texts are
    vectors, and the array also has the words of the instruction and of the feedback. Without `embed` no number depends
    on words. Values outside the space are clipped.

    Args:
        world: gives the spaces of states and actions.
        max_turns: the student's turns in an episode.
        embed: gives the vector of a text; None: states and actions must have no texts.
        lenient: whether parts without a fixed number of numbers, such as texts without `embed`, are left out.

    Raises:
        ValueError: a state or an action has no fixed number of numbers, or `embed` does not give vectors.
    """

    def __init__(
        self, world: World[Any, Any, Any], max_turns: int, embed: Embed | None = None, *, lenient: bool = False
    ) -> None:
        self._max_turns, self._embed, self._lenient = max_turns, embed, lenient
        self._words = None if embed is None else _vector(embed, "").size
        self._state_space, self._action_space = world.observation_space, world.action_space
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
                meaning = "the reward in the claim; 0 without a claim"
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
        self.least, self.greatest = finite(low_bounds), finite(high_bounds)
        """Least and greatest values of the arrays, float32."""
        self._nothing = [0.0] * sum(self._size(part) for _, part in _parts(self._action_space))

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
        np.maximum(array, self.least, out=array)
        np.minimum(array, self.greatest, out=array)
        return array.astype(np.float32)

    def of_rows(self, state: Any, turn: Rows, reward: Rows, kinds: Rows, claims: "RowClaims", late: int = 0) -> Rows:
        """The arrays of many lessons, as `of` gives them one by one, float32 of shape (rows, numbers).

        Args:
            state: the worlds' observations, as Gymnasium batches them.
            turn: the students' turns so far; this array and the next ones have shape (rows,).
            reward: the reward of the turn that the claims are about.
            kinds: the kinds that are said, as subset numbers.
            claims: the claims.
            late: the delay of the claims, in turns.
        """
        count = len(turn)
        share, about = turn / self._max_turns, (turn - late) / self._max_turns
        all_said = (kinds[:, None] >> np.arange(len(KINDS)) & 1).astype(bool)
        columns = [*self._of_state(state, count), share]
        for i, kind in enumerate(KINDS):
            said = all_said[:, i]
            columns += [said, np.where(said, claims.number[:, i], 0), np.where(said, about, 0.0)]
            if kind is R:
                columns.append(np.where(said, reward, 0.0))
                continue
            named = said & claims.named[:, i]
            action = _rows_of(self._action_space, claims.action[i], count)
            columns += [np.where(named[:, None], action, 0.0), np.where(named, 1.0 if kind in (HP, FP) else -1.0, 0.0)]
        table = np.concatenate([np.asarray(each, float).reshape(count, -1) for each in columns], axis=1)
        arrays: Rows = np.clip(table, self.least, self.greatest).astype(np.float32)
        return arrays

    def _of_state(self, state: Any, count: int) -> Iterator[Rows]:
        for path, part in _parts(self._state_space):
            found = state
            for key in path:
                found = found[key]
            yield _rows_of(part, found, count)

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
        """Add the fields of a space; `blank`: zeros may stand in their place."""
        for path, part in _parts(space):
            size = self._size(part)
            if not size:
                continue
            if isinstance(part, spaces.Text):
                high = np.full(size, np.inf)
                low, how = -high, "embedded"
            else:
                flat = flatten_space(part)
                assert isinstance(flat, spaces.Box)  # noqa: S101  # all spaces of numbers have one
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

    def _size(self, space: spaces.Space[Any]) -> int:
        """The count of numbers of a leaf; 0 if the leaf is left out."""
        try:
            return _size(space, self._words)
        except ValueError:
            if self._lenient:
                return 0
            raise

    def _writer(self, space: spaces.Space[Any]) -> Writer:
        """The function that gives the numbers of a value of a space."""
        if not isinstance(space, spaces.Dict | spaces.Tuple) and not self._size(space):
            return _left_out
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
        assert self._embed is not None  # noqa: S101  # without it there are no texts
        vector = _vector(self._embed, text)
        if vector.size != self._words:
            raise ValueError(
                f"embed must give vectors of one length, got {self._words} numbers for the empty text and "
                f"{vector.size} for {text!r:.80}"
            )
        numbers: list[float] = vector.tolist()
        return numbers


class Flat:
    """A Dict of boxes as one flat array, without its action mask, in the order of the Dict.

    Args:
        space: the Dict.

    Raises:
        ValueError: a part has no fixed count of numbers.
    """

    def __init__(self, space: spaces.Space[Any]) -> None:
        parts: dict[str, Any] = {**space} if isinstance(space, spaces.Dict) else {"": space}
        parts.pop(MASK, None)
        if texts := [name for name, part in parts.items() if not isinstance(part, spaces.Box | spaces.MultiBinary)]:
            raise ValueError(
                f"teacher_numbers=True needs a teacher that observes numbers, got {texts[0]!r}: {parts[texts[0]]}; set "
                "speech to 'kinds' or 'claims'"
            )
        boxes = {name: flatten_space(part) for name, part in parts.items()}
        ends = np.cumsum([box.shape[0] for box in boxes.values()]).tolist()  # type: ignore[index]  # they are flat
        low, high = (
            np.concatenate([getattr(box, bound) for box in boxes.values()]).astype(np.float32)
            for bound in ("low", "high")
        )
        self.space = spaces.Box(low, high, dtype=np.float32)
        """The space of the arrays."""
        places = map(slice, [0, *ends[:-1]], ends)
        self.fields = tuple(
            Field(name, place, ENTRIES.get(name, "")) for name, place in zip(boxes, places, strict=True)
        )
        """The fields, in their order."""

    def of(self, seen: Mapping[str, npt.NDArray[Any]], rows: int | None = None) -> npt.NDArray[np.float32]:
        """The array of an observation, float32 of the shape of `space`; with `rows` of each row, (rows, numbers)."""
        lead = () if rows is None else (rows,)
        parts = [np.asarray(seen[field.name], np.float32).reshape(*lead, -1) for field in self.fields]
        return np.concatenate(parts, axis=-1)


def finite(bounds: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """The bounds, clipped to the range of float32."""
    most = np.finfo(np.float32).max
    held: npt.NDArray[np.float32] = np.clip(bounds, -most, most).astype(np.float32)
    return held


# Writers must be picklable, so they are no closures.


def _left_out(value: Any) -> list[float]:
    return []


def _of_parts(writers: Sequence[tuple[Any, Writer]], value: Any) -> list[float]:
    return [number for key, write in writers for number in write(value[key])]


def _flat(space: spaces.Space[Any], value: Any) -> list[float]:
    numbers: list[float] = flatten(space, value).tolist()  # type: ignore[union-attr]  # it is an array
    return numbers


def _rows_of(space: spaces.Space[Any], values: Rows, count: int) -> Rows:
    """The numbers of many values of a leaf, of shape (rows, numbers)."""
    if isinstance(space, spaces.Discrete):
        rows: Rows = np.eye(int(space.n)).take(np.clip(values - int(space.start), 0, int(space.n) - 1), axis=0)
    elif isinstance(space, spaces.MultiDiscrete):
        wide = zip(values.reshape(count, -1).T, space.nvec.ravel(), space.start.ravel(), strict=True)
        rows = np.concatenate([np.eye(int(n)).take(column - start, axis=0) for column, n, start in wide], axis=1)
    else:
        rows = values.reshape(count, -1)
    return rows


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
