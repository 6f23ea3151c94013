"""The cards of fifteen teachers beside each other, among them one that guesses, one that compares and one that learns.

    python examples/teacher_gallery.py --worlds 6 --key explore --plot docs/teacher-gallery.png

`--cards FOLDER` writes the cards, too.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from llf_teacher.suite.card import Card
from llf_teacher.suite.mirror import all_qualities, take

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
LEAST, MOST = -1.0, 2.0


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


def table(cards: Sequence[Card]) -> str:
    """The scores in Markdown; empty: not measured."""
    names = list(all_qualities())
    lines = [["teacher", *names], ["---"] * (len(names) + 1)]
    for card in cards:
        scores = ["" if each.score is None else f"{each.score:.2f}" for each in card.lines]
        lines.append([f"`{card.student}`".replace("|", "then"), *scores])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plot(cards: Sequence[Card]) -> Figure:
    """An axis for each quality, with a dot and an interval for each teacher."""
    names, rows = list(all_qualities()), range(len(cards))
    figure = Figure(figsize=(13, 8), layout="constrained")
    for i, (ax, name) in enumerate(zip(figure.subplots(2, 5, sharey=True).flat, names, strict=True)):
        for row, line in zip(rows, (card.lines[i] for card in cards), strict=True):
            if line.score is None:
                continue
            if line.low is not None and line.high is not None:
                ax.plot(np.clip([line.low, line.high], LEAST, MOST), [row, row], color="C0", linewidth=1.6)
            beyond = "<" if line.score < LEAST else ">" if line.score > MOST else "o"
            ax.plot(np.clip(line.score, LEAST, MOST), row, beyond, color="C0", markersize=4)
        for value, style in ((0, "-"), (1, ":")):
            ax.axvline(value, color="0.6", linewidth=0.8, linestyle=style, zorder=0)
        ax.set(title=name, xlim=(LEAST - 0.1, MOST + 0.1), ylim=(len(cards) - 0.5, -0.5))
        ax.set_yticks(rows, [card.student for card in cards], fontsize=8)
        ax.grid(axis="y", linewidth=0.3)
    figure.suptitle("0: nothing of it, 1: as the reference; no dot: not measured; triangle: beyond the axis")
    return figure


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
    print(f"\n{table(cards)}")
    if args.plot is not None:
        plot(cards).savefig(args.plot, dpi=90)


if __name__ == "__main__":
    main()
