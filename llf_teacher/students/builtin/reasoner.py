"""reasoner: weighs possible worlds by each claim, and takes the action of least expected regret."""

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
        """Take over the observations, without the claims: its position depends on its past moves."""
        assert isinstance(past, _Policy)  # noqa: S101  # a policy of the same student
        self.belief = past.belief
        self.belief.forget()

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """See, learn, and act; ties are broken at random."""
        self.belief.see(info["sealed"])
        heard = self.heard(observation, info, self._turns)
        self.belief.learn(heard, read=heard[len(info["atoms"]) :])
        regrets = self.belief.regrets()
        action = int(self.rng.choice(np.flatnonzero(regrets <= regrets.min() + _NEAR)))
        self.did(action)
        self._turns += 1
        return action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Hear the last words; only rules matter."""
        self.belief.keep(atom.claim for atom in info["atoms"] if atom.claim.scope is Scope.FAMILY)


def _has_values(family: Subject) -> bool:
    make: Any = family.oracle_class()
    return "values" in make.abilities()


@dataclass(frozen=True)
class Reasoner(Student):
    """Draws worlds that it cannot distinguish from its own, and weighs them by each claim that it hears.

    It evaluates a claim's `means` in each world, so it needs no knowledge of a family's claims. Each claim that does
    not hold in a world multiplies the world's weight by 1 - trust, see `teachers.belief.Belief`. Among the actions that
    are best in some world it takes the one with the least mean regret, by the values of the family's oracle. It looks
    one action ahead, and so never acts only to learn. If it does not forget, rules of a town that it has heard also
    weigh worlds in later episodes.
    """

    worlds: Annotated[int, Range(1, 100_000)] = 256
    """Number of worlds drawn in a turn; more if few of them have weight."""
    trust: Share = 1.0
    """1 minus the factor of a world's weight for each claim that is false in it, 0 to 1; 0: claims have no effect."""
    forget: bool = True
    """Whether each episode starts without memory; use it if each has another town."""
    follows_words: bool = False
    """Whether it also believes words without claims, see `obedient`."""
    reads = "atoms"
    draws_worlds = True
    policy = _Policy
