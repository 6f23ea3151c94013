"""The best learned teacher beside the rule `near mistakes`, with the same information, budget and students.

The rule of the verdict, which was written before any of the lifetimes that it judges:

- Compared are a learned teacher and `near mistakes`. Both see the same 14 numbers of a decision, have the same budget,
  and teach the same students in the same houses.
- Trainings may be of any kind and number. Of all trainings for a budget the one is taken with which students waste
  least in 500 lifetimes from seed 2,000,000 on; there the number of moves of `near mistakes` is chosen, too.
- Both then teach 500 lifetimes with the seeds 5,000,000 to 5,000,499, which no training, choice or earlier comparison
  has had.
- The statistic is the regret per episode with `near mistakes` less that with the learned teacher, paired by lifetime:
  its mean with Student's 95 % interval, and p of a sign-flip test, adjusted by Holm's method over all rows of a table.
- The verdict is `wins` or `loses` if the adjusted p is below 0.05; else `equal` if the interval lies within 0.5 moves
  of 0; else `undecided`.
- Other students: the same for each pair of students, those trained with and those tested with. The training and the
  number of moves are chosen with the students trained with.
- Levels: a teacher that chooses how many bits the next claim says, beside the best teacher that always says the same
  number of bits, chosen on lessons from seed 2,000,000 on. The same budget, students, seeds, statistic and verdict, by
  regret in a lesson.
"""

from collections.abc import Sequence

import numpy as np

from llf_teacher.studies.analysis.statistics import Difference, holm, paired_differences

FINAL, LIFETIMES = 5_000_000, 500
"""First seed and number of the lifetimes that the verdict is about."""
MARGIN, LEVEL = 0.5, 0.05
"""Moves an episode within which teachers are equal, and greatest adjusted p of a difference."""


def judge(gains: Sequence[np.ndarray]) -> list[tuple[Difference, float, str]]:
    """What the learned teacher saves beside the other one, its adjusted p and the verdict.

    Args:
        gains: of each row of a table, what it saves in each lifetime, shape (lifetimes,).
    """
    differences = paired_differences(gains)
    adjusted = holm([each.p for each in differences])
    return [(each, p, _verdict(each, p)) for each, p in zip(differences, adjusted, strict=True)]


def _verdict(difference: Difference, p: float) -> str:
    mean, low, high = difference.estimate[:3]
    if p < LEVEL:
        return "wins" if mean > 0 else "loses"
    return "equal" if low > -MARGIN and high < MARGIN else "undecided"
