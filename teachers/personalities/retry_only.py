"""retry_only: "that was not it, try again" while the task is unsolved, no information beyond success.

A control: it measures the gain from being asked to try again (arXiv 2606.30774).
"""

from teachers.common import TryAgain
from teachers.personality import Claims, View, personality

_TRY_AGAIN = (TryAgain(),)


@personality(source="arXiv 2606.30774", reveals=False)
def retry_only(claims: Claims, view: View) -> Claims:
    """Says "try again" after each action that did not solve the task."""
    moment = view.moment
    return () if moment.success or moment.action is None else _TRY_AGAIN
