"""stubborn(p): repeats its last action, whatever it chooses."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.scene import Scene, SceneBatch
from llf_teacher.students.trait import Trait
from teachers.spec import Share
from worlds.batches import Ints


@dataclass(frozen=True)
class Stubborn(Trait):
    """In each turn but the first, repeats its last action with probability p instead of its choice."""

    p: Share = 0.3
    """The probability, 0 to 1; 0: never."""
    strength = "p"

    def act(self, action: Any, scene: Scene) -> Any:
        """The last action, or this one."""
        return scene.last if scene.turn and scene.happens(self.p) else action

    def act_rows(self, actions: Ints, scene: SceneBatch) -> Ints:
        """`act` in arrays."""
        return np.where(scene.happens(self.p, scene.turn > 0), scene.last, actions)
