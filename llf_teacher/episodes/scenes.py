"""Playing an episode turn by turn, with every claim checked against the simulator."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from llf_teacher.episodes.record import TurnRow, as_dict, unchecked
from llf_teacher.gym import StudentEnv
from llf_teacher.serialization import to_json
from pz_envs.seatings.tutoring.env import TutoringEnv
from pz_envs.seats import STUDENT, entitled
from teachers.atoms import Atom, Label, Moment, ParseFailure
from teachers.seeds import Seeds


class Scene(NamedTuple):
    """One turn as it was played; the first is the opening."""

    moment: Moment[Any]
    observation: dict[str, Any]
    """The student's, as `StudentEnv` gives it."""
    atoms: tuple[tuple[Atom, Label], ...]
    """What was said, with what the simulator says of it."""


def scenes(
    env: StudentEnv, student: Any, seed: int, options: dict[str, Any] | None = None, sample: int = 0
) -> Iterator[Scene]:
    """Play an episode and check what is said; it stops at success, as LLF-Bench's evaluation does, unless the task is
    asked repeatedly.

    Args:
        env: with a teacher in the other seat.
        student: a policy with `reset(rng)` and `act(observation, info)`.
        seed: of the episode, for all who take part.
        options: those of the world's `reset`.
        sample: which of the streams that the student may draw from.
    """  # noqa: D205
    aec = env.aec
    lab = aec.world.scratch()
    student.reset(Seeds(seed).stream("student", sample))
    observation, info = env.reset(seed=seed, options=options)
    moments = [aec.moment]
    done = False
    while True:
        yield Scene(aec.moment, observation, tuple((atom, atom.label(moments, lab)) for atom in info["atoms"]))
        if done:
            break
        action = student.act(aec.observe(STUDENT), entitled(student, aec))
        observation, _, _, _, info = env.step(action)
        moments.append(aec.moment)
        done = env.family.is_over(aec.moment)


def turn_row(aec: TutoringEnv, family: str, scene: Scene, speaker: Any = None) -> TurnRow:
    """The turn that has just been played, as it is stored; the `changes` of the speaker are counted, if it has any."""
    moment = scene.moment
    failed = moment.action if type(moment.action) is ParseFailure else None
    return TurnRow(
        turn=moment.turn,
        observation=aec.state_now if aec.text else aec.world.describe(aec.state_now),
        action=None if moment.before is None else to_json(moment.action),
        action_words=None if moment.before is None or isinstance(moment.action, str) else f"{moment.action}",
        reward=moment.reward,
        regret=aec.teacher.oracle.regret(moment) if moment.turn else 0.0,
        success=moment.success,
        parse_failure=failed and failed.got,
        instruction=str(scene.observation["instruction"]) or None,
        feedback=str(scene.observation["feedback"]),
        atoms=to_json([as_dict(atom, label, family) for atom, label in scene.atoms]),
        unchecked=unchecked(str(scene.observation["feedback"]), [atom.text for atom, _ in scene.atoms]) or None,
        changes=len(getattr(speaker, "changes", ())) or None,
    )
