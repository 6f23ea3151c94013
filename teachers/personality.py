"""Personalities: what becomes of an oracle's claims before they are said.

A personality is a frozen dataclass in a module of its name under `teachers/personalities/`; its fields
are its parameters. Its nested class `Stage` holds one episode's state. Personalities compose left to
right with `|`, and are written as strings that round-trip: `mistake(eps=0.1) | delayed(turns=2)`.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from teachers import personalities
from teachers.atoms import Claim
from teachers.oracle import Oracle
from teachers.spec import Catalogue, Spec
from teachers.view import View

__all__ = [
    "PERSONALITIES",
    "Personality",
    "Pipeline",
    "Stage",
    "View",
    "check_served",
    "parse_personality",
    "stages_of",
]


class Stage(ABC):
    """One personality in one episode."""

    def __init__(self, spec: Any, rng: np.random.Generator) -> None:
        self.spec = spec
        """The personality, for its parameters."""
        self.rng = rng
        """A random stream of its own."""
        self.begin()

    def begin(self) -> None:
        """Set up what is to be remembered within the episode."""

    @abstractmethod
    def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
        """What to say, given what the oracle, or the stage before, would say. Called once a turn."""


class Personality(Spec):
    """Base of all personalities: a frozen value that starts a `Stage` for each episode."""

    shelf = personalities.__name__
    Stage: ClassVar[type[Stage]]
    source: ClassVar[str] = "ours"
    """Where the definition comes from."""
    needs: ClassVar[frozenset[str]] = frozenset()
    """What the oracle must be able to do, of `teachers.oracle.ABILITIES`."""
    honest: ClassVar[bool] = True
    """Whether every claim that it makes is true, if those that it is given are."""
    reveals: ClassVar[bool] = True
    """Whether it may tell the action to take; one that may not is audited for it."""

    def start(self, rng: np.random.Generator) -> Stage:
        """The stage for one episode."""
        return self.Stage(self, rng)

    @property
    def transparent(self) -> bool:
        """Whether it passes every claim on as it is, so that it need not be asked."""
        return False

    def __or__(self, after: "Personality") -> "Pipeline":
        return Pipeline((*stages_of(self), *stages_of(after)))


class PipelineStage(Stage):
    """Stages in a row, each with a random stream of its own."""

    def begin(self) -> None:
        """Start every stage."""
        stages = self.spec.stages
        self._stages = [stage.start(rng) for stage, rng in zip(stages, self.rng.spawn(len(stages)), strict=True)]

    def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
        """Pass the claims through."""
        for stage in self._stages:
            claims = tuple(stage.speak(claims, view))
        return claims


@dataclass(frozen=True)
class Pipeline(Personality):
    """Personalities that are asked from left to right."""

    stages: tuple[Personality, ...]
    Stage = PipelineStage

    @property
    def needs(self) -> frozenset[str]:  # type: ignore[override]
        """What any stage needs."""
        return frozenset().union(*(stage.needs for stage in self.stages))

    @property
    def transparent(self) -> bool:
        """Whether every stage is."""
        return all(stage.transparent for stage in self.stages)

    @property
    def honest(self) -> bool:  # type: ignore[override]
        """Whether every stage is."""
        return all(stage.honest for stage in self.stages)

    @property
    def reveals(self) -> bool:  # type: ignore[override]
        """Whether every stage may tell the action to take."""
        return all(stage.reveals for stage in self.stages)

    def __str__(self) -> str:
        return " | ".join(map(str, self.stages))


def stages_of(personality: Personality) -> tuple[Personality, ...]:
    """The stages of a pipeline; any other personality is its own only stage."""
    return personality.stages if isinstance(personality, Pipeline) else (personality,)


def check_served(personality: Personality, oracle: Oracle | type[Oracle]) -> None:
    """Make sure that an oracle can do what a personality needs.

    Raises:
        ValueError: it cannot; the message names what is missing.
    """
    able = oracle.abilities()
    for stage in stages_of(personality):
        if missing := sorted(stage.needs - able):
            name = oracle.__name__ if isinstance(oracle, type) else type(oracle).__name__
            raise ValueError(
                f"personality '{stage}' needs {', '.join(missing)} of the oracle, which {name} does not give; "
                f"it gives: {', '.join(sorted(able)) or 'nothing'}; docs/personalities.md shows which family serves "
                "which personality"
            )


PERSONALITIES = Catalogue("personality", Personality, personalities)
"""Every personality by its name."""


def parse_personality(spec: str | Personality) -> Personality:
    """The personality that a spec string describes.

    Raises:
        ValueError: an unknown name or parameter, or bad syntax; the message says what is allowed.
    """
    if isinstance(spec, Personality):
        return spec
    stages = PERSONALITIES.parse(spec)
    return stages[0] if len(stages) == 1 else Pipeline(stages)
