"""The audit: check every claim of a teacher against the simulator."""

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.episodes.loop import play_turns
from llf_teacher.episodes.record import claim_name, unchecked
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import entry
from llf_teacher.speakers.parsing import parse_teacher
from llf_teacher.speakers.speaker import Speaker
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy
from pz_envs.settings import Settings
from pz_envs.subject import Subject
from teachers.atoms import (
    FP,
    ActionClaim,
    Atom,
    Claim,
    EditClaim,
    FeedbackType,
    Grounded,
    Label,
    Moment,
    PlanClaim,
    confidence,
    contradictions,
    unhedged,
)
from teachers.information import Gain
from teachers.oracle import POSTERIOR, Oracle
from teachers.personality import Personality
from teachers.reliability import Reliability
from teachers.teacher import Teacher
from teachers.testing.habits import HABITS
from teachers.voice import PLAIN, Change, voice_names
from worlds.world import World

STUDENTS = ("random", "obedient", *(f"wayward(habit={habit!r})" for habit in HABITS))
"""Specs of the students in an audit: random actions, advised actions, and unusual habits."""
_EXAMPLES = 5
_CAUGHT = 0.002  # p-value, on both sides, of hedges that no honest teacher says


class Finding(NamedTuple):
    """A false claim, a leak or a contradiction, with the place where it occurred."""

    what: str
    """`false`, `leak` or `contradiction`."""
    text: str
    claim: str
    student: str
    instruction_type: str
    options: dict[str, Any]
    """The drawn options of the world, and of its reset."""
    seed: int
    turn: int


@dataclass
class Audit:
    """The result for one teacher in one environment."""

    id: str
    teacher: str
    """Its spec, or the name of its class."""
    honest: bool
    """Whether it promises to tell the truth."""
    episodes: int = 0
    turns: int = 0
    """Number of the students' turns."""
    words: int = 0
    """Number of words of feedback."""
    claims: Counter[tuple[FeedbackType | None, Label]] = field(default_factory=Counter)
    """Number of claims by kind and label; the kind is None for instructions and notices. Feedback without claims counts
    as an `unchecked` claim of kind None.
    """
    withheld: Counter[FeedbackType | None] = field(default_factory=Counter)
    """Number of the oracle's claims that the personality left out, by kind."""
    students: Counter[str] = field(default_factory=Counter)
    """Number of claims to each student, by its spec."""
    falsehoods: Counter[str] = field(default_factory=Counter)
    """Number of false claims to each student, by its spec."""
    leaks: int = 0
    """Number of leaks: claims of a kind that was not requested, advised actions by a personality that must not reveal
    them, and actions in a basic instruction.
    """
    contradictions: int = 0
    """Number of pairs of contradictory claims in one turn; see `Claim.excludes`."""
    elsewhere: Counter[tuple[FeedbackType | None, bool, bool]] = field(default_factory=Counter)
    """Number of claims taken from other lessons, by kind, whether they hold there, and whether they hold here."""
    hedges: Reliability = field(default_factory=Reliability)
    """How often hedged claims hold, by their stated probability."""
    gains: dict[str, Gain] = field(default_factory=dict)
    """The information of the claims of feedback by the name of their class, if measured."""
    measured: int = 0
    """Number of turns with this measurement."""
    examples: list[Finding] = field(default_factory=list)
    """The first falsehoods, leaks and contradictions."""
    changes: int = 0
    """Number of sentences in which a rewriting voice changed a number or a name."""
    changed: list[Change] = field(default_factory=list)
    """The first changes."""
    reworded: int = 0
    """Number of sentences that are no shipped paraphrase of their claim; nobody checked whether they say the same."""

    def count(self, *labels: Label) -> int:
        """Number of claims with one of these labels."""
        return sum(number for (_, label), number in self.claims.items() if label in labels)

    @property
    def checked(self) -> int:
        """Number of claims that are true or false: hedged ones are neither."""
        return sum(self.claims.values()) - self.count(Label.UNCHECKED, Label.HEDGED)

    @property
    def gain(self) -> Gain:
        """The information of all measured claims of feedback."""
        return sum(self.gains.values(), Gain())

    @property
    def held(self) -> float | None:
        """Share of the claims that hold; None if there are none."""
        return 1 - self.count(Label.DISTORTED) / self.checked if self.checked else None

    @property
    def caught(self) -> bool:
        """Whether there are leaks, claims false elsewhere, or what an honest teacher does not say.

        That is false claims, contradictions and overconfident hedges.
        """
        if self.leaks or any(number for (_, there, _), number in self.elsewhere.items() if not there):
            return True
        return self.honest and self.count(Label.DISTORTED) + self.contradictions + self.overconfident > 0

    @property
    def overconfident(self) -> bool:
        """Whether hedged claims hold far less often than said: so that calibrated ones seem so twice in 1,000 audits.

        All of them together, or those of one interval of 10 per cent.
        """
        together = self.hedges.verdict == "overconfident" and self.hedges.p_value < _CAUGHT
        return together or self.hedges.overstated < _CAUGHT / 2

    def displaced(self) -> dict[FeedbackType | None, tuple[int, int, int]]:
        """For each kind with claims of other lessons: their number, how many hold there, and how many hold here."""
        found: dict[FeedbackType | None, tuple[int, int, int]] = {}
        for (kind, there, here), number in self.elsewhere.items():
            claims, true_there, true_here = found.get(kind, (0, 0, 0))
            found[kind] = claims + number, true_there + there * number, true_here + here * number
        return found

    def as_dict(self) -> dict[str, Any]:
        """The result as JSON values."""
        claims: dict[str, dict[str, int]] = {}
        for (kind, label), number in sorted(self.claims.items(), key=lambda each: (each[0][0] or "", each[0][1])):
            claims.setdefault(kind or "none", {})[label] = number
        return {
            "id": self.id,
            "teacher": self.teacher,
            "honest": self.honest,
            "caught": self.caught,
            "episodes": self.episodes,
            "turns": self.turns,
            "words_per_turn": self.words / self.turns,
            "claims": claims,
            "held": self.held,
            "students": {
                student: {"claims": number, "false": self.falsehoods[student]}
                for student, number in self.students.items()
            },
            "withheld": {kind: self.withheld[kind] for kind in sorted(self.withheld, key=str)},
            "leaks": self.leaks,
            "contradictions": self.contradictions,
            "elsewhere": {
                kind or "none": dict(zip(("claims", "true_there", "true_here"), numbers, strict=True))
                for kind, numbers in sorted(self.displaced().items(), key=str)
            },
            "hedges": self.hedges.as_dict(),
            "information": {
                "turns": self.measured,
                "claims": {name: gain._asdict() for name, gain in sorted(self.gains.items())},
            },
            "examples": [example._asdict() for example in self.examples],
            "changes": self.changes,
            "changed": [change._asdict() for change in self.changed],
            "reworded": self.reworded,
        }


def audit(
    id: str | Subject,
    teacher: Any = "oracle",
    *,
    turns: int = 1000,
    students: Iterable[str] = STUDENTS,
    instruction_types: Iterable[str] | None = None,
    feedback_type: str | Iterable[str] = "a",
    progress: Callable[[int], None] | None = None,
    worlds: int = 0,
    **settings: Any,
) -> Audit:
    """Play students with a teacher, and check each claim by its `holds`, and by its `means` if it rests on others.

    Every other episode draws the world's options that are not given; see `World.draw_options`.

    Args:
        id: an id of `llf_teacher.ids()`, or a `Lesson`.
        teacher: a spec string, a `Personality`, a `Speaker`, or any policy for the teacher's seat. Its attributes
            `honest` and `reveals` state what it promises, as those of personalities do; both are True where they are
            missing.
        turns: number of turns, shared equally by all combinations of student and instruction type.
        students: specs of students.
        instruction_types: types of instruction to use; None for all that the environment supports; with `worlds`, for
            `b` alone.
        feedback_type: the requested feedback.
        progress: called with the number of turns so far.
        worlds: number of worlds for measuring the information of each claim and the regret that it saves, in episodes
            without drawn options; 0: no measurement. It sets the options that measuring needs.
        settings: other settings of `StudentEnv`, and options of the world.

    Raises:
        ValueError: an argument is not supported.
    """
    if turns < 1:
        raise ValueError(f"turns must be at least 1, got {turns!r}")
    teacher = parse_teacher(teacher) if isinstance(teacher, str) else teacher
    promise = teacher.arguments()["teacher"] if isinstance(teacher, Speaker) else teacher
    name = str(teacher) if isinstance(teacher, Personality | Speaker) else type(teacher).__name__
    family = id if isinstance(id, Subject) else entry(id).family
    if worlds or POSTERIOR in getattr(promise, "needs", ()):
        settings = {**family.posterior_needs, **settings}
    found = Audit(family.name if isinstance(id, Subject) else entry(id).id, name, getattr(promise, "honest", True))
    options = {name: value for name, value in settings.items() if name in family.options()}
    taught = family.for_lesson(Settings(options=options, max_turns=settings.get("max_turns")))
    types = tuple(
        instruction_types
        or ("b",) * bool(worlds)
        or taught.make_teacher(taught.make_world(**options)).oracle.instruction_types
    )
    voice = settings.get("voice", PLAIN)
    combinations = list(itertools.product(map(parse_student, students), types))
    for done, (student, type_) in enumerate(combinations, 1):
        given = {"instruction_type": type_, "feedback_type": feedback_type, "text": student.text, **settings}
        env = StudentEnv(id, teacher=teacher, **given)
        if worlds:
            family.make_information(env.session.world, 0, worlds)  # or give the reason why there is none
        policy = student.seat(env.family, env.session.world)
        for number in itertools.count():
            seed = number * len(combinations) + done - 1  # another one in each combination: hedges are of many worlds
            left = turns * done // len(combinations) - found.turns
            if left <= 0:
                break
            if patience := getattr(student, "patience", None):
                left = min(left, 1 + number % patience)
            episode = _Episode(type_, seed, left, {}, {})
            if isinstance(promise, Personality) and (done + number) % 2 == 0:
                episode = _varied(episode, env.session.world, settings, np.random.default_rng([done, seed]))
            if episode.options:
                other = StudentEnv(id, teacher=teacher, **given | {"instruction_type": "b"} | episode.options)
                if type_ in other.session.teacher.oracle.instruction_types:  # it may depend on the options
                    other.session.teacher.instruction_type = type_
                    _watch(found, other, student.seat(other.family, other.session.world), episode, worlds, voice)
                other.close()
            else:
                _watch(found, env, policy, episode, worlds, voice)
            if progress:
                progress(found.turns)
        env.close()
    return found


class _Episode(NamedTuple):
    """The settings of an episode."""

    instruction_type: str
    seed: int
    turns: int
    """Greatest number of turns of the episode."""
    options: dict[str, Any]
    """Options of the world that differ from those of the environment."""
    reset: dict[str, Any]


def _varied(episode: _Episode, world: World[Any], given: Collection[str], rng: np.random.Generator) -> _Episode:
    """The episode with drawn options of the world, except the given ones."""
    drawn = world.draw_options(rng).items()
    options = {name: value for name, value in drawn if name not in given and value != world.options[name]}
    return episode._replace(options=options, reset=world.draw_reset(rng))


def _watch(found: Audit, env: StudentEnv, student: Policy[Any], episode: _Episode, worlds: int, voice: Any) -> None:
    """Play an episode, check its claims, and add what that shows to the result."""
    teacher = env.teacher
    promise = teacher.personality if isinstance(teacher, Teacher) else teacher
    reveals = getattr(promise, "reveals", True)
    offered: Counter[tuple[Claim[Any], int]] = Counter()
    said: Counter[tuple[Claim[Any], int]] = Counter()
    moments: list[Moment[Any]] = []
    hedges: list[tuple[float, bool]] = []
    oracle: Oracle[Any, Any] | None = None  # needed if a claim rests on others
    found.episodes += 1
    worlds = 0 if episode.options or episode.reset else worlds
    book = env.family.phrasebook(voice if voice in voice_names() else PLAIN)
    recorder = Recorder(env.family.name, env.student_view)
    recorder.measure(env.family, episode.seed, worlds)
    for turn in itertools.islice(play_turns(env, student, episode.seed, episode.reset), episode.turns + 1):
        moment, atoms = turn.moment, recorder.check(turn)
        moments.append(moment)
        options = episode.options | episode.reset
        where = (str(student.spec), episode.instruction_type, options, episode.seed, moment.turn)
        found.turns += moment.turn > 0
        found.measured += worlds > 0 and moment.turn > 0
        for i, bits in recorder.measured(turn).items():
            name = claim_name(turn.atoms[i].claim, env.family.name)
            found.gains[name] = found.gains.get(name, Gain()) + Gain.of(turn.atoms[i].text, bits)
        found.words += len(turn.feedback.split())
        if isinstance(teacher, Teacher):
            offered.update((claim, moment.turn) for claim in teacher.offered)
        changes = getattr(teacher, "changes", ())
        found.changes += len(changes)
        found.changed += changes[: _EXAMPLES - len(found.changed)]
        if not atoms and turn.feedback:
            found.claims[None, Label.UNCHECKED] += 1
        elif atoms:
            found.reworded += unchecked(f"{turn.instruction} {turn.feedback}", [atom.text for atom, _ in atoms])
        for atom, label in atoms:
            if not _is_genuine(unhedged(atom.claim)):
                label = Label.DISTORTED  # its fields may equal what they do not say
            elif type(unhedged(atom.claim)) not in book.classes:
                label = Label.UNCHECKED  # a class of one's own, whose check may say anything
            found.reworded += bool(atom.text) and not book.has(atom, moment.turn)
            if isinstance(atom.claim, Grounded) and label is not Label.DISTORTED:
                if oracle is None:
                    oracle = env.family.make_teacher(env.session.world.scratch()).oracle
                    oracle.start(moments[0].after)
                if not atom.claim.means(moments[atom.about_turn], oracle):  # its ground makes it true, not its fields
                    label = Label.DISTORTED
            said[atom.claim, atom.about_turn] += 1
            kind = None if atom in getattr(turn.instruction, "atoms", ()) else atom.kind
            found.claims[kind, label] += 1
            if (there := recorder.elsewhere(atom)) is not None:
                found.elsewhere[kind, there, recorder.holds(atom, label)] += 1
            if label is Label.HEDGED:
                hedges.append((confidence(atom.claim), recorder.holds(atom, label)))
            found.students[str(student.spec)] += 1
            found.falsehoods[str(student.spec)] += label is Label.DISTORTED
            names = isinstance(unhedged(atom.claim), ActionClaim | PlanClaim | EditClaim)
            leak = kind is not None and kind not in env.session.teacher.kinds
            leak |= names and (not reveals if kind is FP else kind is None and episode.instruction_type == "b")
            found.leaks += leak
            false = there is False or (label is Label.DISTORTED and found.honest)
            for fault in ["leak"] * leak + ["false"] * false:
                _add_example(found, fault, (atom,), where)
        for pair in contradictions(atom for atom, _ in atoms):
            found.contradictions += 1
            if found.honest:
                _add_example(found, "contradiction", pair, where)
    found.hedges.add(hedges)
    found.withheld.update(claim.kind for claim, _ in (offered - said).elements())


def _is_genuine(claim: Claim[Any]) -> bool:
    """Whether the fields of a claim are what its class accepts, however it was made."""
    try:
        Claim.__post_init__(claim)
    except TypeError:
        return False
    return True


def _add_example(found: Audit, what: str, atoms: Iterable[Atom], where: tuple[Any, ...]) -> None:
    """Add a finding, if there is room for one."""
    if len(found.examples) < _EXAMPLES:
        words, claims = " ".join(atom.text for atom in atoms), "; ".join(repr(atom.claim) for atom in atoms)
        found.examples.append(Finding(what, words, claims, *where))
