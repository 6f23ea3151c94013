"""The exact tier's knowledge of an environment."""

import warnings
from collections import Counter, deque
from collections.abc import Callable, Hashable
from typing import Any, NamedTuple

import gymnasium

from teachers.atoms import Moment
from teachers.planning.exact.worths import Worths
from teachers.planning.planner import PlanningError
from teachers.planning.transitions import Transitions
from worlds.wrapped.gym_world import GymWorld, Position

_KEPT = 16  # explored episodes, and such that are none
_CLOSE = 1e-6  # relative difference of rewards that is rounding
_NOWHERE = ("no state",)


class _Map(NamedTuple):
    """The result of exploring from one state on."""

    values: Worths
    begun: int
    """The turn of that first state."""
    depths: dict[Hashable, int]
    """Fewest actions from the first state to each state, if exploring stopped at the time limit; empty if it did not.

    From a state at or after its depth, all reachable states are known.
    """


class Atlas:
    """The values of all states, computed once, or again for each episode with unknown states.

    Args:
        values: the known values.
        explore: computes the values of all states that an environment can reach, given the number of earlier actions;
            None: all states are known.
    """

    def __init__(self, values: Worths, explore: Callable[[gymnasium.Env[Any, Any], int], Worths] | None = None) -> None:
        self._explore = explore
        self._known = [_Map(values, 0, _depths(values.transitions) if explore else {})]
        self.horizon, self.gamma, self.actions = values.horizon, values.gamma, values.actions
        self._nothing = Worths({_NOWHERE: [[]] * self.actions}, self.horizon, self.gamma)
        self._lost: deque[Any] = deque(maxlen=_KEPT)
        self.ended = ""
        """Why the transitions are wrong, as an episode has shown; empty: they are not known to be."""
        self.silences: Counter[str] = Counter()
        """The number of episodes without values, by the reason."""

    @property
    def spread(self) -> float:
        """The greatest difference between two actions in any known state."""
        return max(each.values.spread for each in self._known)

    @property
    def explores(self) -> bool:
        """Whether it explores unknown states."""
        return self._explore is not None

    @property
    def size(self) -> int:
        """The number of known states, terminal ones included."""
        return max(len(each.values.transitions) for each in self._known)

    @property
    def certain(self) -> bool:
        """Whether all known transitions are deterministic."""
        return all(each.values.certain for each in self._known)

    def at(self, truth: Position, lab: GymWorld) -> Worths:
        """Values that cover the state of a truth and all states after it; unknown states are explored in the lab.

        If there are too many, or actions have random results, the whole episode has no values, and a warning says so.
        """
        if self.ended:
            return self._nothing
        if (values := self._covering(truth)) is not None:
            return values
        start = truth.episode.anchor or truth.episode
        if self._explore is None or any(start is lost for lost in self._lost):
            return self._nothing
        lab.restore(truth)
        try:
            env = lab.env
        except RuntimeError as error:  # the episode cannot be replayed
            self._end(f"{error}")
            return self._nothing
        try:
            values = self._explore(env, truth.turn)
        except PlanningError as error:
            self._lost.append(start)
            self.silences[f"{error}"] += 1
            warnings.warn(f"the teacher knows no values in this episode: {error}", stacklevel=2)
            return self._nothing
        self._known = [_Map(values, truth.turn, _depths(values.transitions)), *self._known[: _KEPT - 1]]
        return values

    def check(self, moment: Moment[Position]) -> None:
        """Compare what an action did with its transitions; if it did something else, they serve no longer."""
        before, after = moment.past, moment.after.seen
        passed = moment.after.turn == before.turn + 1
        values = None if self.ended or not passed else self._covering(before)
        if values is None or not (outcomes := values.transitions[before.seen][moment.action]):
            return
        paid, share = moment.reward, 1.0 if self.gamma is not None else values.share(before.turn)
        for _, state, reward in outcomes:
            if (state is None or state == after) and abs(share * reward - paid) <= _CLOSE * max(1.0, abs(paid)):
                return
        self._end(
            f"action {moment.action} in turn {before.turn + 1} earned {paid:g} and led to a state that the plan lacks "
            "there; something outside of the environment's attributes decides, too"
        )

    def _covering(self, truth: Position) -> Worths | None:
        """Known values that cover a state and all states after it."""
        seen = truth.seen
        for values, begun, depths in self._known:
            if seen in values.transitions and (not depths or truth.turn - begun >= depths[seen]):
                return values
        return None

    def _end(self, why: str) -> None:
        """Know nothing from now on."""
        self.ended = why
        self.silences[why] += 1
        warnings.warn(f"the teacher knows no values any more: {why}", stacklevel=2)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_lost": deque(maxlen=_KEPT)}


def _depths(transitions: Transitions) -> dict[Hashable, int]:
    """The fewest actions from the first state to each state; empty if every reachable state was explored."""
    found = {next(iter(transitions)): 0}
    queue, cut = deque(found), False
    while queue:
        here = queue.popleft()
        for action in transitions[here]:
            cut |= not action
            for _, after, _ in action:
                if after is not None and after not in found:
                    found[after] = found[here] + 1
                    queue.append(after)
    return found if cut else {}
