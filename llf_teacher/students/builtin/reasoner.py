"""reasoner: weighs the worlds it may be in by each claim, and takes the action of least expected regret."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from llf_teacher.students.listening import ListeningPolicy
from llf_teacher.students.student import Policy, Student
from pz_envs.family import all_families
from pz_envs.subject import Subject
from teachers.atoms import Scope
from teachers.belief import Belief
from teachers.spec import Range, Share
from worlds.world import World

_NEAR = 1e-9  # differences of regrets below this are rounding


class _Policy(ListeningPolicy["Reasoner"]):
    """Keeps a `belief`."""

    belief: Belief = None  # type: ignore[assignment]  # before the first episode

    def __init__(self, spec: "Reasoner", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        if not (family.posterior and _has_values(family)):
            able = ", ".join(each.name for each in all_families() if each.posterior and _has_values(each))
            lacks = "values of actions" if family.posterior else "posterior"
            raise ValueError(
                f"the student {spec} needs a family with a posterior and values of actions; {family.name} has no "
                f"{lacks}; allowed: {able}; elsewhere use another student, such as obedient"
            )
        self._context = family.make_posterior_context(world)

    def begin(self) -> None:
        """Begin an episode without memory; a student that does not forget still knows the rules that it has heard."""
        super().begin()
        self._turns = 0
        rules = () if self.spec.forget or self.belief is None else self.belief.rules
        self.belief = Belief(self._context, self.rng, self.spec.worlds, self.spec.trust)
        self.belief.keep(rules)

    def succeed(self, past: Policy[Any]) -> None:
        """Take over what was seen, without what was said: where it is depends on where it has been."""
        assert isinstance(past, _Policy)  # noqa: S101  # of the same student
        self.belief = past.belief
        self.belief.forget()

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """See, learn, and act; equally good actions are drawn from."""
        self.belief.see(info["sealed"])
        heard = self.heard(observation, info, self._turns)
        self.belief.learn(heard, read=heard[len(info["atoms"]) :])
        regrets = self.belief.regrets()
        action = int(self.rng.choice(np.flatnonzero(regrets <= regrets.min() + _NEAR)))
        self.did(action)
        self._turns += 1
        return action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Hear the last words, of which only rules matter."""
        self.belief.keep(atom.claim for atom in info["atoms"] if atom.claim.scope is Scope.FAMILY)


def _has_values(family: Subject) -> bool:
    make: Any = family.oracle_class()
    return "values" in make.abilities()


@dataclass(frozen=True)
class Reasoner(Student):
    """Draws worlds that it cannot distinguish from its own, and weighs them by each claim that it hears.

    A claim is whatever it `means` in a world, so that no family's claims need to be known. A world counts less by the
    factor 1 - trust for each claim that does not hold in it, as `teachers.belief.Belief` says. It takes the action
    whose regret, by the values of the family's oracle in each of these worlds, is least in the mean, among those that
    are best in one of them. It looks one action ahead, and so never acts only to learn.

    If it does not forget, the rules of a town that it has heard weigh worlds in later episodes, too.
    """

    worlds: Annotated[int, Range(1, 100_000)] = 256
    """Number of worlds that are drawn in a turn; more where few of them count."""
    trust: Share = 1.0
    """By how much less than 1 a world counts for each claim that is false in it, 0 to 1; 0: it hears nothing."""
    forget: bool = True
    """Whether each episode starts without memory, as it should if each has another town."""
    follows_words: bool = False
    """As of `obedient`."""
    reads = "atoms"
    draws_worlds = True
    policy = _Policy
