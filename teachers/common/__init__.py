"""Claims that belong to no family; their phrases are in `phrases/common.toml`."""

from teachers.atoms import Claim
from teachers.common.advice import Chance, Example, Trap, rounded
from teachers.common.comparisons import HORIZON, Better, BetterTurn, NoDifference, WorseTurn
from teachers.common.hedges import Late, Probably, bend, hedge
from teachers.common.notices import Maximize, MayAsk, NotUnderstood, Syntax
from teachers.common.placebos import FACTS, Truism
from teachers.common.rewards import SIGNS, Paid, Reward, as_said, sign_of
from teachers.common.verdicts import ChangeVerdict, PartlyRight, Right, Solved, TryAgain, Wrong

__all__ = [
    "CLAIMS",
    "FACTS",
    "HORIZON",
    "SIGNS",
    "Better",
    "BetterTurn",
    "Chance",
    "ChangeVerdict",
    "Example",
    "Late",
    "Maximize",
    "MayAsk",
    "NoDifference",
    "NotUnderstood",
    "Paid",
    "PartlyRight",
    "Probably",
    "Reward",
    "Right",
    "Solved",
    "Syntax",
    "Trap",
    "Truism",
    "TryAgain",
    "WorseTurn",
    "Wrong",
    "as_said",
    "bend",
    "hedge",
    "rounded",
    "sign_of",
]

CLAIMS: tuple[type[Claim], ...] = (
    Reward,
    TryAgain,
    Solved,
    Truism,
    Right,
    PartlyRight,
    Wrong,
    NoDifference,
    Better,
    BetterTurn,
    WorseTurn,
    Paid,
    Chance,
    Trap,
    Example,
    NotUnderstood,
    MayAsk,
    Maximize,
    Syntax,
    Late,
    Probably,
)
"""The classes of claims, in the order in which schemas list them."""
