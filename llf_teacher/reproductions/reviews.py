"""Lifetimes in a house with a teacher that comments on single moves, at once or after an episode."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.seats import STUDENT, TEACHER
from teachers.atoms import FP, HN, Claim, Moment, action_of
from teachers.common import Late
from teachers.feedback import BIT


class Remark(NamedTuple):
    """The content of a claim: whether an action is right in a room."""

    room: int
    action: Any
    right: bool


class Notes:
    """A teacher's notes on a student's way through a house, and on its own remarks."""

    def __init__(self) -> None:
        self._way: list[int] = []
        self._said: set[Remark] = set()

    def see(self, moment: Moment[Any]) -> None:
        """Note where the student is."""
        self._way[moment.turn :] = [moment.after.room]

    def remark(self, claim: Claim[Any], now: int) -> Remark:
        """The content of a claim that is made after `now` turns."""
        turn = claim.turn if isinstance(claim, Late) else now
        bare = claim.claim if isinstance(claim, Late) else claim
        return Remark(self._way[turn if bare.kind is FP else turn - 1], action_of(bare), bare.kind is not HN)

    def new(self, remarks: Sequence[Remark]) -> list[int]:
        """The indices of the remarks that tell something: the best action of the room has not been named."""
        settled = {each.room for each in self._said if each.right}
        return [i for i, each in enumerate(remarks) if each not in self._said and each.room not in settled]

    def best(self, remarks: Sequence[Remark]) -> int | None:
        """The index of the most useful remark; None if no remark is new.

        It is new, about a right action rather than a wrong one, and about the room that was visited most in this
        episode.
        """
        visits, new = Counter(self._way), self.new(remarks)
        return max(new, key=lambda i: (remarks[i].right, visits[remarks[i].room], i)) if new else None

    def say(self, remarks: Sequence[Remark]) -> None:
        """Note what was said."""
        self._said.update(remarks)


def commented(
    id: str,
    *,
    student: str,
    teacher: str,
    feedback: str,
    speech: str,
    budget: int,
    seed: int,
    episodes: int,
    turns: int,
) -> tuple[float, int]:
    """Play a lifetime; gives the moves wasted per episode, and the number of claims.

    All teachers know what they have said and where the student was, and speak when there is a new remark. With
    `claims` they say the most useful one, then the next, while there are any; with `new` those that are new among the
    claims of its kind, in the order of the offer; with `kinds` all claims of its kind, which is all that this form of
    speech allows.

    Args:
        id: an environment of houses.
        student: its spec, with `forget=False`.
        teacher: the personality's spec, which decides the claims on offer, and when.
        feedback: the kinds of claims.
        speech: `claims`, `new` or `kinds`.
        budget: claims in a lifetime.
        seed: of the world, the teacher and the student.
        episodes: number of episodes.
        turns: greatest number of each.
    """
    family = entry(id).family
    seats: Any = family.raw_env(
        teacher=teacher,
        feedback_type=feedback,
        speech="kinds" if speech == "kinds" else "claims",
        episodes=episodes,
        max_cycles=turns,
        budget=budget,
        cost=0.0,
        teacher_reward="student_progress",
    )
    turn = seats.unwrapped.teacher_view.teacher_turn
    world = seats.unwrapped.session.world
    env = ParallelSeats(seats, {STUDENT: parse_student(student).seat(family, world)})
    _, infos = env.reset(seed=seed)
    notes, lost, last, kind = Notes(), 0.0, None, None
    while env.agents:
        moment = infos[TEACHER]["moment"]
        notes.see(moment)
        if moment is not last:
            last, kind = moment, None
        listed = turn.listed() if turn.budget.left else []
        remarks = [notes.remark(claim, moment.turn) for claim in listed]
        best, action = notes.best(remarks), 0
        if best is not None and speech == "new":
            kind = listed[best].kind if kind is None else kind
            best = next((i for i in notes.new(remarks) if listed[i].kind is kind), None)
        if best is not None:
            alike = [i for i, claim in enumerate(listed) if claim.kind is listed[best].kind][: turn.budget.left]
            notes.say([remarks[i] for i in (alike if speech == "kinds" else [best])])
            action = BIT[listed[best].kind] if speech == "kinds" else 1 + best
        _, rewards, _, _, infos = env.step({TEACHER: action})
        lost -= rewards[TEACHER]
    env.close()
    return lost / episodes, turn.budget.spent
