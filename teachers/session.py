"""A session: all that happens in a turn, for a world, one or several teachers, and a student.

An episode goes like this, with teachers that say what they suggest:

    session.open(seed)                     the world is reset; there is an opening moment to speak of
    session.speak()                        the teachers give the instruction and advise the first action
    while not session.done:
        session.act(action)                the world takes the student's action, which gives a moment
        session.speak()                    the teachers speak of it; `session.turn` is the record of both

In place of `act` a student may `ask`. In place of `speak` each teacher may `say` words, `say_kinds` of feedback or
`choose` one claim after the other. When every teacher has spoken, the student hears all of it. `session.phase` says
whose turn it is.

Nothing else advances a taught world or makes a teacher judge or speak. Environments, studies, pages and kits are views.
"""

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from teachers.atoms import SILENCE, Atom, Moment, ParseFailure, Utterance, atoms_of
from teachers.budget import Budget, price
from teachers.schema import Message, storable
from teachers.seeds import Seeds
from teachers.spec import is_count
from teachers.teacher import Teacher
from teachers.teacher_turn import (
    ANSWER,
    FEEDBACK,
    INSTRUCTION,
    LONGEST,
    OPENING,
    STUDENT,
    Phase,
    TeacherTurn,
    split_advice,
)
from worlds.world import World

__all__ = ["Observer", "Read", "Session", "Turn"]

Read = Callable[[Any], Any]
"""Gives a student's action in canonical form, or a `ParseFailure`; raises ValueError outside the action space."""
_new = tuple.__new__  # in place of `Moment(...)`, which takes three times as long


class Turn(NamedTuple):
    """One turn: what happened, and what the student heard of it. Turn 0 is the opening."""

    moment: Moment[Any]
    """What happened: privileged."""
    state: Any
    """The world's observation after it."""
    info: dict[str, Any]
    """The world's info, with `success`, `parse_failure` for a text that was no action, and `atoms`."""
    terminated: bool
    """Whether the episode has ended other than by its length."""
    truncated: bool
    """Whether it was cut off."""
    instruction: str
    """The instruction if it was given in this turn, else empty."""
    feedback: str
    """What the teachers said beside it."""
    atoms: tuple[Atom, ...]
    """All claims in instruction and feedback, typed."""
    asked: bool
    """Whether this is the answer to a question, and the student has yet to act."""


class Observer(Protocol):
    """What follows a session, such as a recorder or a renderer."""

    def begin(self, moment: Moment[Any], atoms: Sequence[Atom] = ()) -> None:
        """An episode begins, or is resumed; `atoms` is what has been said of that moment already."""

    def acted(self, moment: Moment[Any]) -> None:
        """The student has acted."""

    def said(self, words: str, turn: Turn) -> None:
        """The student has heard these words, which complete the turn."""


class Session:
    """A world, its teachers and a student, turn by turn.

    Args:
        world: what is taught.
        teachers: at least one; each speaks once a turn.
        max_turns: actions of the student after which the episode is truncated, at least 1.
        budgets: what the teachers may say, one each; several can be the same. None: no limits.
        instructs: whether `open` gives the first teacher's instruction, free of charge; it always does so if there are
            several teachers. If False, the teacher's first words, also words of its own, contain the instruction.
        until_success: whether success terminates the episode; it does not where the task is `repeated`.
        repeated: whether success is that of a single action, so that a text which is no action does not keep it.
        ask_cost: what the student pays for asking, at least 0; None: it cannot ask.
        failure_reward: reward of a text that is no action; None: the world's own.
        read: reads the student's actions; None: `world.legal`.
        observer: follows all that happens.
    """

    def __init__(
        self,
        world: World[Any, Any, Any],
        teachers: Sequence[Teacher],
        *,
        max_turns: int,
        budgets: Sequence[Budget] | None = None,
        instructs: bool = False,
        until_success: bool = False,
        repeated: bool = False,
        ask_cost: float | None = None,
        failure_reward: float | None = None,
        read: Read | None = None,
        observer: Observer | None = None,
    ) -> None:
        if not is_count(max_turns):
            raise ValueError(f"max_turns must be an integer of at least 1, got {max_turns!r}")
        max_turns = int(max_turns)  # one of NumPy would make `truncated` one, too
        self.world, self.teacher, self.max_turns, self.repeated = world, teachers[0], max_turns, repeated
        budgets = budgets or [Budget(0.0) for _ in teachers]
        if len(budgets) != len(teachers):
            raise ValueError(f"budgets must be one for each of {len(teachers)} teachers, got {len(budgets)}")
        several = len(teachers) > 1
        seats = [f"teacher_{number}" if several else "" for number in range(len(teachers))]
        self.teacher_turns = tuple(
            TeacherTurn(*each, max_turns, ask_cost is not None) for each in zip(teachers, budgets, seats, strict=True)
        )
        """What each of the teachers may say of the moment."""
        self._listeners = [teacher for teacher in teachers if teacher.listens]
        self._instructs = instructs or several
        self.until_success = until_success and not repeated
        self.ask_cost, self.failure_reward = ask_cost, failure_reward
        self.observer = observer
        self.read: Read = world.legal if read is None else read
        """Reads the student's actions."""
        self._spoken: list[str] = []  # what several teachers have said of the moment, in the order of speaking
        self.seeds = Seeds()
        """The streams of the episodes, beside the world's."""
        self.phase = OPENING if self._instructs else INSTRUCTION
        """Whose turn it is, and what teachers speak of."""
        self.moment: Moment[Any]
        """What happened last: privileged."""
        self.state: Any = None
        """The world's observation; each action makes a new one."""
        self.info: dict[str, Any]
        """The world's info, with `success`, and `atoms` once the student has heard; new in each turn."""
        self.terminated = self.truncated = False
        self.instruction: str = SILENCE
        """The episode's instruction."""
        self.feedback: str = SILENCE
        """What the student heard last beside it."""
        self.atoms: tuple[Atom, ...] = ()
        """The claims that the student has heard since it last acted or asked."""
        self.asked = False
        """Whether the student has asked in this turn."""

    # The beginning of an episode.

    def open(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Moment[Any]:
        """Begin an episode with full budgets; without a seed the random streams go on.

        Args:
            seed: of the world and of all other streams.
            options: those of the world's `reset`.

        Returns:
            The opening moment.
        """
        moment = self._begin(seed, options, None)
        for each in self.teacher_turns:
            each.budget.spent = each.trimmed = 0
        return moment

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> Moment[Any]:
        """Begin another episode of the same lesson: the streams go on, and what was spent of a budget stays spent.

        Args:
            start: the truth to begin with; None: as a reset of the world draws it.
            options: those of the world's `reset`.
        """
        return self._begin(None, options, start)

    def resume_from(self, moment: Moment[Any], terminated: bool = False, past: Sequence[Moment[Any]] = ()) -> None:
        """Go on from a moment of an episode that was played elsewhere; the teachers are the next to speak.

        Call `open` before: the random streams are those that it has begun.

        Args:
            moment: with the world's truths.
            terminated: whether the episode has ended there other than by its length.
            past: the moments of the episode before, from the opening on, for personalities that remember them.
        """
        self.world.restore(moment.after)
        self.state = self.world.observe()
        self._open_lesson()
        if not moment.turn:
            return
        first = self.teacher_turns[0]
        if self.phase is INSTRUCTION:
            first.suggestion()  # the oracle starts with the instruction
        if past:
            self.teacher.begin(self.seeds, 0, first.numbers)
            for earlier in past:
                self.teacher.judge(earlier)
        self.follow(moment, terminated)
        if self.observer is not None:
            self.observer.begin(moment)

    def follow(self, moment: Moment[Any], terminated: bool = False) -> None:
        """Take a turn of the student that was played elsewhere; the world does not change.

        Args:
            moment: of that turn, with the world's truths.
            terminated: whether the episode ended there other than by its length.
        """
        self.moment, self.terminated = moment, terminated
        self.truncated = moment.over and not terminated
        self.info, self.atoms, self.asked = {"success": moment.success}, (), False
        self._await_teachers(FEEDBACK if moment.turn else self._opening_phase)

    def _begin(self, seed: int | None, options: dict[str, Any] | None, start: Any) -> Moment[Any]:
        world = self.world
        self.state, self._reset_info = world.reset(seed=seed, options=options)
        if seed is None:
            self.seeds.episode += 1
        else:
            self.seeds = Seeds(seed)
        if start is not None:
            world.restore(start)
            self.state = world.observe()
        self._open_lesson()
        return self.moment

    def _open_lesson(self) -> None:
        """Begin the teachers' random streams and show them the opening moment; maybe give the instruction."""
        self.terminated = self.truncated = self.asked = False
        self.instruction = self.feedback = SILENCE
        self.moment = Moment.opening(self.world.truth)._replace(ask_cost=self.ask_cost)
        self.info, self.atoms = {**self._reset_info, "atoms": ()}, ()
        for number, each in enumerate(self.teacher_turns):
            each.teacher.begin(self.seeds, number, each.numbers)
            if self._instructs:
                instruction = each.teacher.open(self.moment)  # each oracle starts with it
                if not number:
                    self.instruction = instruction
                    self.atoms = self.info["atoms"] = instruction.atoms
        self._await_teachers(self._opening_phase)
        if self.observer is not None:
            self.observer.begin(self.moment, self.atoms)

    @property
    def _opening_phase(self) -> Phase:
        return OPENING if self._instructs else INSTRUCTION

    # The student's half of a turn.

    def act(self, action: Any) -> Moment[Any]:
        """The student acts; the teachers are the next to speak.

        Args:
            action: what `read` takes, or a `ParseFailure`: the world does not step, and the turn counts.

        Raises:
            ValueError: the action is outside the action space; nothing has changed.
        """
        if self.terminated or self.truncated:
            raise ValueError("the episode has ended; open another one")
        if isinstance(action, str):
            action = storable(action)
        if type(action) is not ParseFailure:
            action = self.read(action)
        world, last = self.world, self.moment
        turn = last.turn + 1
        if type(action) is ParseFailure:
            terminated, truncated = False, turn >= self.max_turns
            reward = world.failure_reward if self.failure_reward is None else self.failure_reward
            success = last.success and not self.repeated
            moment = Moment.unread(last.after, action, reward, success, turn, truncated)
            self.state = copy.deepcopy(self.state)  # each observation is new, also if nothing happened
            self.info = {"success": success, "parse_failure": action}
        else:
            self.state, reward, terminated, truncated, self.info = world.advance(action)
            success = self.info["success"]
            if success and self.until_success:
                terminated = True
            truncated = not terminated and (truncated or turn >= self.max_turns)
            over = terminated or truncated
            moment = _new(Moment, (last.after, action, reward, world.truth, success, turn, over, None))
        self.moment, self.terminated, self.truncated = moment, terminated, truncated
        self.atoms, self.asked = (), False
        self._await_teachers(FEEDBACK)
        if self.observer is not None:
            self.observer.acted(moment)
        return moment

    def ask(self) -> float:
        """The student asks for advice on what it sees, once a turn; nothing else happens.

        Returns:
            The student's reward.

        Raises:
            ValueError: it cannot ask, or has asked in this turn.
        """
        if self.ask_cost is None or self.asked:
            why = "it has asked in this turn" if self.asked else "there is no ask_cost"
            raise ValueError(f"the student cannot ask: {why}; let it act")
        if self.phase is not STUDENT or self.over:
            raise ValueError("the student cannot ask now: the teachers have yet to speak, or the episode has ended")
        self.asked = True
        self.state = copy.deepcopy(self.state)
        self.info = {key: value for key, value in self.info.items() if key not in ("atoms", "parse_failure")}
        self.atoms = ()
        self._await_teachers(ANSWER)
        return -self.ask_cost

    def _await_teachers(self, phase: Phase) -> None:
        self.phase = phase
        self._spoken.clear()
        moment = self.moment
        for each in self.teacher_turns:
            each.see(moment, phase)

    # The teachers' half of a turn.

    def suggest(self, teacher: int = 0) -> Utterance:
        """All that a teacher has to say now, in its words."""
        return self.teacher_turns[teacher].suggestion()

    def speak(self) -> None:
        """Every teacher that has yet to speak says what it suggests, as much as its budget allows."""
        acted = self.moment.before is not None
        for each in self.teacher_turns:
            if each.said is None:
                said = each.suggestion()
                if acted and each.budget.limit is None:
                    self._take(each, said, len(said.atoms))  # all of them are feedback
                else:
                    self._take(each, each.allowed(said))

    def say(self, words: str | Mapping[str, Any] | Message, teacher: int = 0) -> float:
        """A teacher says words of its own: those that feedback type and budget allow.

        Args:
            words: an `Utterance` brings its atoms along; `{"claims": [...], "text": ...}` is made into one, see
                `teachers.schema.Vocabulary`.
            teacher: the number of the teacher, as for all methods.

        Returns:
            The teacher's reward, as for all methods.

        Raises:
            ValueError: it is no text, or too long; nothing has changed.
        """
        speaking = self._next_to_speak(teacher)
        if not self._instructs:
            speaking.suggestion()  # keeps random draws identical, shown or not; the oracle starts with the instruction
        elif self.phase is not ANSWER:
            speaking.claims()  # a personality sees each moment
        if self.phase is OPENING and type(words) is Utterance:
            words = Utterance.of([atom for atom in words.atoms if atom.kind is not None])
        speaking.unbuilt = ()
        if isinstance(words, Mapping):
            words = speaking.vocabulary.read(words, self.moment)
        if isinstance(words, Message):
            words = speaking.compose(words)
        return self._take(speaking, speaking.allowed(words))

    def say_kinds(self, subset: int, teacher: int = 0) -> float:
        """A teacher says its claims of a subset of the kinds; arguments as in `say`.

        Raises:
            ValueError: it is no subset's number; nothing has changed.
        """
        speaking = self._next_to_speak(teacher)
        said = speaking.of_kinds(subset)
        return self._take(speaking, said, len(said.atoms) if self.moment.before is not None else None)

    def choose(self, choice: int, teacher: int = 0) -> float:
        """A teacher chooses one more claim to say, or with 0 none; the others as in `say`.

        The chosen claims are said when the teacher chooses 0, or when no other claim can be chosen.

        Raises:
            ValueError: it is no choice; nothing has changed.
        """
        speaking = self._next_to_speak(teacher)
        before = len(speaking.chosen)
        done = speaking.choose(choice)
        reward = speaking.budget.pay(len(speaking.chosen) - before)
        if done:
            self._take(speaking, speaking.of_chosen(), 0)
        return reward

    def _next_to_speak(self, teacher: int) -> TeacherTurn:
        """The turn of a teacher that has yet to speak of the moment.

        Raises:
            ValueError: there is no such teacher, or it has spoken.
        """
        if not 0 <= teacher < len(self.teacher_turns):
            raise ValueError(f"teacher must be a number from 0 to {len(self.teacher_turns) - 1}, got {teacher!r}")
        speaking = self.teacher_turns[teacher]
        if speaking.said is not None:
            raise ValueError("the teacher has spoken of this moment; the student, or another teacher, is next")
        return speaking

    def _take(self, speaking: TeacherTurn, said: str, atoms: int | None = None) -> float:
        """Take what a teacher says; the student hears it when all have spoken.

        Args:
            speaking: the teacher's turn.
            said: its words.
            atoms: the atoms that it pays for; None: those of feedback.

        Returns:
            The teacher's reward.
        """
        if len(said) > LONGEST:
            said = _fitting(said)
            atoms = None if atoms is None else len(said.atoms)
        words = said
        if self.phase is INSTRUCTION:
            self.instruction, said = split_advice(words)
        elif speaking.seat:
            said = speaking.sign(words, self._spoken)
        speaking.said = said
        reward = speaking.budget.pay(price(said) if atoms is None else atoms)
        if speaking.seat:
            self._spoken.append(said)
            if len(self._spoken) < len(self.teacher_turns):
                return reward
            said = words = self.said_so_far()
        self.feedback, self.phase = said, STUDENT
        if type(words) is Utterance:
            self.atoms += words.atoms
        self.info["atoms"] = self.atoms
        for teacher in self._listeners:
            teacher.hear(self.atoms)
        if self.observer is not None:
            self.observer.said(words, self.turn)
        return reward

    def said_so_far(self) -> Utterance:
        """What several teachers have said since the student acted, in the order of speaking."""
        said = [words for words in self._spoken if words]
        words = Utterance(" ".join(said), tuple(atom for words in said for atom in atoms_of(words)))
        return words if len(words) <= LONGEST else _fitting(words)

    def origin(self, atom: Atom) -> Moment[Any] | None:
        """The moment elsewhere from which a teacher took a claim; None if the claim is about this lesson."""
        found = (each.teacher.origin(atom) for each in self.teacher_turns if each.seat == atom.speaker)
        return next((moment for moment in found if moment is not None), None)

    @property
    def turn(self) -> Turn:
        """The record of the turn, which is complete once the student has heard all teachers."""
        return Turn(
            self.moment,
            self.state,
            self.info.copy(),
            self.terminated,
            self.truncated,
            SILENCE if self.moment.turn or self.asked else self.instruction,
            self.feedback if self.heard else SILENCE,
            self.atoms,
            self.asked,
        )

    @property
    def heard(self) -> bool:
        """Whether the student has heard all teachers since it last acted or asked."""
        return self.phase is STUDENT

    # The end of an episode.

    @property
    def over(self) -> bool:
        """Whether the episode has ended; the teachers may have a last word yet."""
        return self.terminated or self.truncated

    @property
    def solved(self) -> bool:
        """Whether the episode has ended, or the task is solved and not asked repeatedly: evaluations stop there."""
        return self.moment.over or (self.moment.success and not self.repeated)

    @property
    def done(self) -> bool:
        """Whether the session is `solved`, and the student has heard the last words."""
        return self.heard and self.solved


def _fitting(words: str) -> Utterance:
    """As many claims as fit into a text observation, from the first on."""
    return Utterance(words, atoms_of(words)).within(LONGEST)
