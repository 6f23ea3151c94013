"""bayesian: weighs a teacher's advice by its inferred reliability, which exposes liars."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from llf_teacher.students.student import Policy, Student, frozen, state_of
from pz_envs.subject import Subject
from teachers.atoms import FN, FP, HN, HP, action_of
from teachers.spec import Range
from worlds.world import World

_STEADY = 0.75  # probability that a teacher says its belief
_SWEEPS = 4
_DRAWS = 256
_ADVICE, _WARNING, _VERDICT = range(3)  # the skills of a teacher: fp, fn, and hp with hn


class _Policy(Policy["Bayesian"]):
    """Infers the posterior `best` and the skills `skill` in each turn."""

    def __init__(self, spec: "Bayesian", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        if not isinstance(world.action_space, spaces.Discrete) or world.action_space.n < 2:
            raise ValueError(
                f"the student {spec} weighs discrete actions, at least two, but the action space of "
                f"{family.name} is {world.action_space}; use another student there, such as obedient"
            )
        self._n = int(world.action_space.n)

    def begin(self) -> None:
        """Begin an episode without memory, with the trust of the spec."""
        trust = self.spec.trust
        self.skill = [trust, trust, trust]
        """Expected share of right beliefs, for advice, warnings and verdicts."""
        self.best: dict[Any, NDArray[np.float64]] = {}
        """For each state, each action's probability of being the best, shape (n,)."""
        self._advised: dict[Any, NDArray[np.float64]] = {}
        self._warned: dict[Any, set[int]] = {}
        self._judged: dict[tuple[Any, int], list[int]] = {}
        self._steps: list[tuple[Any, int]] = []
        self._rewards: list[float] = []
        self._trips: list[list[tuple[Any, int]]] = []
        self._solved: tuple[Any, int] | None = None

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Infer, then choose the most probable action; where tasks repeat, sample an action (Thompson 1933)."""
        state = frozen(state_of(observation))
        self._live(state, info)
        self._listen(state, info["atoms"])
        self._infer()
        chances = self.best[state]
        if self.family.repeated:
            action = int(self.rng.choice(self._n, p=chances))
        else:
            action = int(self.rng.choice(np.flatnonzero(chances >= chances.max() - 1e-9)))
        self._steps.append((state, action))
        return action

    def did(self, action: Any) -> None:
        """Note the action, which replaces the last one."""
        self._steps[-1] = self._steps[-1][0], int(action)

    def _live(self, state: Any, info: dict[str, Any]) -> None:
        """Note the outcome of the last action."""
        if self._steps:
            self._rewards.append(info["reward"])
            if info.get("success"):
                self._solved = self._steps[-1]
            visited = [at for at, _ in self._steps]
            if not self.family.repeated and state in visited:
                last = len(visited) - 1 - visited[::-1].index(state)
                self._trips.append(self._steps[last:])
        self.best.setdefault(state, np.full(self._n, 1 / self._n))

    def _listen(self, state: Any, atoms: Any) -> None:
        """Note the teacher's claims about this state and the one before."""
        for atom in atoms:
            claim, turn = atom.claim, atom.about_turn
            action = action_of(claim)
            if action is None or claim.kind is None:
                continue
            action = int(action)
            at = turn - 1 if claim.kind in (HP, HN) else turn
            if not 0 <= at <= len(self._steps):
                continue  # about another student's action
            where = state if at == len(self._steps) else self._steps[at][0]
            if claim.kind is FP:
                self._advised.setdefault(where, np.zeros(self._n))[action] += 1
            elif claim.kind is FN:
                self._warned.setdefault(where, set()).add(action)
            else:
                self._judged.setdefault((where, action), [0, 0])[claim.kind is HP] += 1

    def _infer(self) -> None:
        """Mean-field sweeps over best actions and skills."""
        beliefs = {state: list(self._beliefs(state)) for state in self.best}
        trust, weight = self.spec.trust, self.spec.weight
        for _ in range(_SWEEPS):
            evidence = self._evidence()
            right = [trust * weight] * 3
            total = [weight] * 3
            for state, stated in beliefs.items():
                score = evidence.get(state, np.zeros(self._n)).copy()
                weighed = []
                for field, yes, no in stated:
                    yes, no = yes + math.log(self.skill[field]), no + math.log(1 - self.skill[field])
                    heard = np.logaddexp(yes, no)
                    score += heard
                    weighed.append((field, yes - heard))
                chances = np.exp(score - score.max())
                self.best[state] = chances = chances / chances.sum()
                for field, share in weighed:
                    right[field] += float(chances @ np.exp(share))
                    total[field] += 1
            self.skill = [share / whole for share, whole in zip(right, total, strict=True)]

    def _beliefs(self, state: Any) -> Iterator[tuple[int, NDArray[np.float64], NDArray[np.float64]]]:
        """The likelihoods of the teacher's claims about a state, belief by belief.

        Yields:
            The skill; then, per action that may be best, shape (n,), the log-likelihood of the claims from a teacher
            whose belief is right, and from a teacher whose belief is wrong.
        """
        n = self._n
        steady, slip = math.log(_STEADY), math.log(1 - _STEADY)
        if state in self._advised:
            said = self._advised[state]
            # The log-likelihood of the claims for each action that the teacher may believe to be the best.
            heard = said * steady + (said.sum() - said) * (slip - math.log(n - 1))
            others = [np.logaddexp.reduce(np.delete(heard, i)) for i in range(n)]
            yield _ADVICE, heard, np.array(others) - math.log(n - 1)
        for action in sorted(self._warned.get(state, ())):
            right, wrong = np.full(n, -math.log(n - 1)), np.full(n, -math.inf)
            right[action], wrong[action] = -math.inf, 0.0
            yield _WARNING, right, wrong
        for action in range(n):
            if (state, action) in self._judged:
                blamed, praised = self._judged[state, action]
                good, bad = praised * steady + blamed * slip, blamed * steady + praised * slip
                right, wrong = np.full(n, bad), np.full(n, good)
                right[action], wrong[action] = good, bad
                yield _VERDICT, right, wrong

    def _evidence(self) -> dict[Any, NDArray[np.float64]]:
        """For each state, each action's log-probability of being the best, from experience; shape (n,)."""
        if self.family.repeated:
            return {} if not self._rewards else {state: self._by_rewards(state) for state in self.best}
        found: dict[Any, NDArray[np.float64]] = {}
        for trip in self._trips:
            chances = [self.best[state][action] for state, action in trip]
            for i, (state, action) in enumerate(trip):
                rest = math.prod(chances[:i] + chances[i + 1 :])
                found.setdefault(state, np.zeros(self._n))[action] += math.log(max(1 - rest, 1e-6))
        if self._solved is not None:
            state, action = self._solved
            found[state] = np.full(self._n, math.log(1e-6))
            found[state][action] = 0.0
        return found

    def _by_rewards(self, state: Any) -> NDArray[np.float64]:
        rewards = np.array(self._rewards)
        spread = float(rewards.std()) or 0.1 + abs(float(rewards[0]))
        tried = np.array([action for _, action in self._steps[: len(rewards)]])
        count = np.bincount(tried, minlength=self._n) + 1.0
        mean = (np.bincount(tried, weights=rewards, minlength=self._n) + rewards.mean()) / count
        draws = np.random.default_rng(len(rewards)).normal(mean, spread / np.sqrt(count), (_DRAWS, self._n))
        wins = np.bincount(draws.argmax(axis=1), minlength=self._n) + 0.5
        return np.asarray(np.log(wins / wins.sum()))


@dataclass(frozen=True)
class Bayesian(Student):
    """Infers the best of the discrete actions in each state, from claims and from experience.

    The teacher is modelled as an annotator of unknown skill (Dawid & Skene 1979; Raykar et al. 2010). It has beliefs
    about each state. The student infers the probability that they are right, separately for advice, warnings and
    verdicts. The teacher mostly says what it believes: a repetition adds no evidence, a contradiction weakens it.
    Claims of a teacher worse than chance count as their opposite. Experience is further evidence: if a task is asked
    repeatedly, the rewards of each action, as normal means with a prior worth one observation; otherwise two facts: a
    round trip cannot consist of best actions only, and the action that solved the task was best. Mean-field sweeps
    infer skills and best actions together.
    """

    trust: Annotated[float, Range(0.01, 0.99)] = 0.8
    """Prior mean of a teacher's skill, the share of its beliefs that are right, 0.01 to 0.99."""
    weight: Annotated[float, Range(0.01, 1e6)] = 2.0
    """Weight of the prior, in observed beliefs, 0.01 to 1e6."""
    reads = "atoms and reward"
    needs_discrete = True
    policy = _Policy
