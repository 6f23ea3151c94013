"""The cards of fifteen teachers beside each other, among them one that guesses, one that compares and one that learns.

    python examples/teacher_gallery.py --worlds 6 --key harvest --plot docs/teacher-gallery.png

`--cards FOLDER` writes the cards, too.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from suite_gallery import plot, table

from llf_teacher.suite.mirror import take

TEACHERS = (
    "oracle",
    "only(kinds='fp')",
    "harsh",
    "mistake(eps=0.3)",
    "sycophant",
    "delayed(turns=2)",
    "verbose",
    "early(budget=1)",
    "mistake_correcting(budget=100, threshold=0.0)",
    "scaffold",
    "hinter",
    "ruler",
    "partial",
    "comparing",
    "teacher_gallery:Learning",
)


class Learning:
    """A policy that learns in the lesson how often the student errs, and speaks, as the oracle, about as often."""

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a lesson without knowledge."""
        self._rng, self._wrong, self._right = rng, 1, 1

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The instruction; then the suggestion, if an error is drawn from what it believes of the student."""
        said = info["suggestion"]
        if not info["moment"].turn:
            return said
        erred = any(atom.kind == "hn" for atom in said.atoms)
        self._wrong, self._right = self._wrong + erred, self._right + (not erred)
        return said if self._rng.beta(self._wrong, self._right) > self._rng.random() else ""


def main() -> None:
    """Take the mirror by each teacher, and print the scores."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=Path("teacher-gallery.db"))
    parser.add_argument("--key", default="", help="a text from which other seeds are drawn")
    parser.add_argument("--worlds", type=int, default=20, help="number of worlds, 5 to 20")
    parser.add_argument("--only", nargs="+", default=TEACHERS, help="specs of teachers; all without it")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--cards", type=Path, help="folder for the cards, as JSON")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    cards = []
    for i, spec in enumerate(args.only):
        cards.append(take(spec, args.store, worlds=args.worlds, key=args.key, workers=args.workers))
        print(f"{spec}: {cards[-1].sentences()[0]}", flush=True)
        if args.cards is not None:
            args.cards.mkdir(parents=True, exist_ok=True)
            cards[-1].write(args.cards / f"{i:02}.json")
    print(f"\n{table(cards, 'teacher')}")
    if args.plot is not None:
        plot(cards, 6).savefig(args.plot, dpi=90)


if __name__ == "__main__":
    main()
