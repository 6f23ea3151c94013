"""Test students with unusual behaviour: what teachers say to them must be true, too."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from teachers.atoms import FN, FP, ActionClaim, Claim, FeedbackType, Moment
from worlds.world import World
from worlds.wrapped.position import same


class Unread(str):
    """A text that does not parse as an action."""

    __slots__ = ()


class Seen(NamedTuple):
    """What a test student sees in a turn."""

    world: World[Any]
    """A scratch world, to try actions in."""
    moment: Moment[Any]
    """The last turn."""
    claims: Sequence[Claim[Any]]
    """The claims about it."""
    listed: Sequence[Any]
    """The actions that have an effect now, if the world lists them."""
    rng: np.random.Generator

    def one_of(self, actions: Sequence[Any]) -> Any:
        """A random one of the actions."""
        return actions[int(self.rng.integers(len(actions)))]

    def anything(self) -> Any:
        """A random action."""
        return self.one_of(self.listed) if self.listed else self.world.sample_action(self.rng)

    def action_in(self, kind: FeedbackType) -> Any | None:
        """The action of a claim of this kind; None if there is no legal one."""
        claims = [each for each in self.claims if isinstance(each, ActionClaim) and each.kind is kind]
        found = [each.action for each in claims if self.is_legal(each.action)]
        return self.one_of(found) if found else None

    def is_legal(self, action: Any) -> bool:
        """Whether the world accepts an action."""
        try:
            self.world.restore(self.moment.after)
            self.world.legal(action)
        except ValueError:
            return False
        return True


def repeating(seen: Seen) -> Any:
    """The last action again, most of the time."""
    again = seen.moment.before is not None and seen.rng.random() < 0.8
    return seen.moment.action if again else seen.anything()


def idle(seen: Seen) -> Any:
    """An action that changes nothing; if none is found, the last one again, or a zero."""
    lab, truth = seen.world, seen.moment.after
    candidates = list(_candidates(seen))
    for action in candidates:
        lab.restore(truth)
        lab.step(action)
        if same(lab.state_of(lab.truth), lab.state_of(truth)):
            return action
    return candidates[0]


def _candidates(seen: Seen) -> Iterator[Any]:
    space = seen.world.action_space
    if seen.moment.before is not None:
        yield seen.moment.action
    if isinstance(space, spaces.Box) and seen.is_legal(zero := np.zeros(space.shape, space.dtype)):
        yield zero
    if isinstance(space, spaces.Discrete):
        yield from range(int(space.start), int(space.start + min(space.n, _MANY)))
    yield from seen.listed[:_MANY]
    yield seen.anything()


def rounding(seen: Seen) -> Any:
    """Numbers of at most three decimals, near the advised ones or anywhere."""
    box, advised = seen.world.action_space, seen.action_in(FP)
    if not isinstance(box, spaces.Box):
        return seen.anything()
    near = seen.anything() if advised is None or seen.rng.random() < 0.3 else advised
    near = np.asarray(near, float) + seen.rng.normal(0.0, seen.one_of((0.0, 0.01, 0.1)), box.shape)
    action = np.round(near, int(seen.rng.integers(4))).clip(box.low, box.high).astype(box.dtype)
    return action.tolist() if seen.is_legal(action.tolist()) else action


def contrary(seen: Seen) -> Any:
    """The action of a warning, if there is one."""
    warned = seen.action_in(FN)
    return seen.anything() if warned is None else warned


def extreme(seen: Seen) -> Any:
    """A corner of the space, an edge or its middle; the first or the last action; an empty or a long text."""
    space, some = seen.world.action_space, seen.anything()
    found: list[Any] = []
    if isinstance(space, spaces.Box) and space.is_bounded():
        share = seen.rng.choice([0.0, 0.5, 1.0], size=space.shape, p=[0.4, 0.2, 0.4])
        found.append((space.low + share * (space.high - space.low)).astype(space.dtype))
    elif isinstance(space, spaces.Discrete):
        found += [int(space.start), int(space.start + space.n - 1)]
    elif isinstance(space, spaces.Text):
        text = str(some)
        longest = (f"{text}\n" * (space.max_length // (len(text) + 1) + 1))[: space.max_length]
        found += ["", " ", text[:1], text.splitlines()[0] if text else text, longest, "x" * space.max_length]
    found = [action for action in found if seen.is_legal(action)]
    return seen.one_of(found) if found and seen.rng.random() < 0.8 else some


def garbling(seen: Seen) -> Any:
    """A text that does not parse, half of the time."""
    if seen.rng.random() < 0.5:
        return seen.anything()
    text: str = seen.one_of(_GARBLED)
    return text if isinstance(seen.world.action_space, spaces.Text) and seen.is_legal(text) else Unread(text)


_MANY = 10  # candidates
_GARBLED = (
    *("", "?", "I do not know.", "Response:", "[1, 2", "[nan, nan]", "1e999", '{"action": true}', "null", "[[], {}]"),
    *("\x07", "\u202e[0]", "[0.5, 0.5, 0.5, 0.5, 0.5, 0.5]", "x" * 100_000),
)


class Habit(NamedTuple):
    """The behaviour of a test student, whatever the teacher says."""

    act: Callable[[Seen], Any]
    """The action of a turn; `Unread` for a text that does not parse."""
    patience: int | None = None
    """The number of turns after which it leaves and the next episode begins; None: it never leaves."""


HABITS: Mapping[str, Habit] = MappingProxyType(
    {
        "repeating": Habit(repeating),
        "idle": Habit(idle),
        "rounding": Habit(rounding),
        "contrary": Habit(contrary),
        "extreme": Habit(extreme),
        "garbling": Habit(garbling),
        "hasty": Habit(Seen.anything, patience=3),
    }
)
"""Every habit by its name."""
