"""A session: all that happens in a turn, for a world, one or several teachers, and a student.

An episode goes like this, with teachers that say what they suggest:

    session.open(seed)                     the world is reset; there is an opening moment to speak of
    session.speak()                        the teachers give the instruction and advise the first action
    while not session.done:
        session.act(action)                the world takes the student's action, which gives a moment
        session.speak()                    the teachers speak of it; `session.turn` is the record of both

In place of `act` a student may `ask`. In place of `speak` each teacher may `say` words, `say_kinds` of feedback or
`choose` one claim after the other. When every teacher has spoken, the student hears all of it.

Nothing else advances a taught world or makes a teacher judge or speak. Environments, studies, pages and kits are views.
"""

import copy
import operator
from collections.abc import Callable, Mapping, Sequence, Set
from functools import cached_property
from typing import Any, NamedTuple, Protocol

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    KINDS,
    SILENCE,
    ActionClaim,
    Atom,
    Claim,
    FeedbackType,
    Moment,
    ParseFailure,
    Utterance,
)
from teachers.schema import Message, Vocabulary, holds, in_own_words, storable
from teachers.seeds import Seeds
from teachers.spec import check_cost, is_count
from teachers.teacher import Teacher
from worlds.world import World

__all__ = [
    "BIT",
    "CLAIMS",
    "LONGEST",
    "SUBSETS",
    "Observer",
    "Offer",
    "Purse",
    "Read",
    "Session",
    "Turn",
    "price",
    "within",
]

SUBSETS = 2 ** len(KINDS)
"""Number of subsets of the kinds: bit i of a subset's number is kind i in the order r, hp, hn, fp, fn."""
BIT = {kind: 1 << i for i, kind in enumerate(KINDS)}
"""Per kind the subset of it alone."""
CLAIMS = 32
"""Greatest number of claims of a moment to choose from."""
LONGEST = 65_536
"""Greatest length of a teacher's words, in characters."""
_NEAR = 1e-9  # differences of values below this are rounding

Read = Callable[[Any], Any]
"""Gives a student's action in canonical form, or a `ParseFailure`; raises ValueError outside the action space."""


class Turn(NamedTuple):
    """One turn: what happened, and what the student heard of it. Turn 0 is the opening."""

    moment: Moment[Any]
    """What happened: privileged."""
    state: Any
    """What the world shows now: its observation."""
    info: dict[str, Any]
    """What the world says beside that, with `success`, `parse_failure` for a text that was no action, and `atoms`."""
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


class Purse:
    """What a teacher may still say in an episode, and what saying it costs.

    Args:
        cost: paid per atom of feedback, or per text without atoms, at least 0.
        budget: atoms of feedback that may be said; what exceeds it is not said. None: any number.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(self, cost: float = 0.01, budget: int | None = None) -> None:
        check_cost("cost", cost)
        if budget is not None and not is_count(budget):
            raise ValueError(f"budget must be None or an integer of at least 1, got {budget!r}")
        self.cost, self.budget, self.spent = cost, budget, 0

    @property
    def left(self) -> int:
        """Atoms that can still be said; without a budget, more than there can be in a turn."""
        return 1 + CLAIMS if self.budget is None else max(self.budget - self.spent, 0)

    @property
    def share(self) -> float:
        """Share of the budget that is left, 0 to 1; 1 without a budget."""
        return self.left / self.budget if self.budget else 1.0

    def pay(self, atoms: int) -> float:
        """Spend; the teacher's reward for that."""
        self.spent += atoms
        return -self.cost * atoms


class Offer:
    """What one teacher has to say of the last moment, and how much of it it may say.

    Args:
        teacher: its oracle sees the truth; its personality chooses the claims.
        purse: several offers can share one.
        speaker: the seat of the teacher, where several teachers speak; else empty.
        max_turns: the student's turns in an episode.
        answers: whether the student can ask.
    """

    def __init__(self, teacher: Teacher, purse: Purse, speaker: str, max_turns: int, answers: bool) -> None:
        self.teacher, self.purse, self.speaker = teacher, purse, speaker
        self.max_turns, self.answers = max_turns, answers
        self.moment: Moment[Any]
        self.said: str | None = None
        """What the teacher has said of the moment; None if it has yet to speak."""
        self.asked = False
        """Whether the student asks for advice on the moment."""
        self.trimmed = 0
        """The kinds that were asked for last and of which nothing could be said, as a subset's number."""
        self.chosen: tuple[int, ...] = ()
        """Indices into `listed` that have been chosen in this turn."""
        self.unbuilt: tuple[str, ...] = ()
        """For each claim of its last message that could not be made the reason."""
        self._briefs = False
        self._notice: tuple[Claim[Any], ...] | None = None  # with which the oracle starts
        self._claims: tuple[Claim[Any], ...] | None = None
        self._suggestion: Utterance | None = None
        self._numbers: list[float] | None = None  # one for each claim, by which its words are drawn
        self._kinds = -1

    def see(self, moment: Moment[Any], asked: bool = False, briefs: bool = False) -> None:
        """The moment to speak of; `briefs`: the suggestion of this moment begins with the instruction."""
        self.moment, self.asked, self._briefs = moment, asked, briefs
        self.said = self._claims = self._suggestion = self._notice = None
        self.chosen, self._kinds, self._numbers = (), -1, None

    def claims(self) -> tuple[Claim[Any], ...]:
        """The claims of this moment, notices included; the teacher is asked once a moment, when they are needed."""
        if self._claims is None:
            moment, teacher = self.moment, self.teacher
            if self._briefs:
                self._notice = teacher.notice(moment)
            if self.asked:
                self._claims = teacher.answer(moment)
            else:
                claims = teacher.judge(moment)
                unread = moment.before is None and moment.turn
                self._claims = teacher.notice(moment) + claims if unread else claims
        return self._claims

    def suggestion(self) -> Utterance:
        """All that the teacher has to say of this moment, in its words."""
        said = self._suggestion
        if said is None:
            claims = self.claims()
            if self._notice:
                claims = self._notice + claims
            said = self._suggestion = self.teacher.say(claims, self.moment.turn)
        return said

    @property
    def prepared(self) -> tuple[bool, bool, bool]:
        """Whether claims, suggestion and sentences of this moment were made; `undo` makes them again.

        So streams stay equal.
        """
        return self._claims is not None, self._suggestion is not None, self._numbers is not None

    def prepare(self, claims: bool, suggestion: bool, sentences: bool) -> None:
        """Ask for them."""
        if claims:
            self.claims()
        if suggestion:
            self.suggestion()
        if sentences:
            self._drawn(())

    def available(self) -> int:
        """The kinds that can be said now, as a subset's number."""
        if self._kinds < 0:
            self._kinds = kinds_of(self.claims())
        return self._kinds if self.purse.budget is None or self.purse.left else 0

    def features(self, moment: Moment[Any]) -> tuple[float, float, float, float, float]:
        """Turn / max_turns, the last reward, importance of the next action, share of the budget left, 1 if over."""
        oracle, reward = self.teacher.oracle, moment.reward
        importance, most, (low, high) = oracle.importance(moment.after), oracle.max_importance, oracle.lab.reward_range
        if not low <= reward <= high:
            reward = low if reward < low else high
        importance = importance if importance <= most else most
        return moment.turn / self.max_turns, reward, importance, self.purse.share, moment.over

    def numbers(self, moment: Moment[Any], kinds: Set[FeedbackType | None], asked: bool) -> tuple[float, ...]:
        """What a seat with `teacher_numbers=True` observes of a moment with claims of these kinds."""
        left = self.purse.left > 0
        return *((asked,) if self.answers else ()), *(left and kind in kinds for kind in KINDS), *self.features(moment)

    def of_kinds(self, subset: Any) -> Utterance:
        """The claims of a subset of the kinds in words, as many as the budget allows; notices are always said.

        Raises:
            ValueError: it is no subset's number.
        """
        if type(subset) is not int or not 0 <= subset < SUBSETS:
            subset = _index(subset, SUBSETS)
        said, available = self.claims(), self._kinds
        if available < 0 or self.purse.budget is not None:
            available = self.available()
        self.trimmed = subset & ~available
        if available & ~subset:
            said = tuple([claim for claim in said if claim.kind is None or subset & BIT[claim.kind]])
        if self.purse.budget is not None:
            said = tuple(within(self.purse.left, said))
            self.trimmed = subset & ~kinds_of(said)
        return self.teacher.say(said, self.moment.turn)

    def listed(self) -> list[Claim[Any]]:
        """The claims to choose from, at most `CLAIMS`: those of the moment that are feedback, in speaking order."""
        return [claim for claim in self.claims() if claim.kind is not None][:CLAIMS]

    def sentences(self) -> tuple[str, ...]:
        """Each of those in the words in which it is said if it is chosen; a voice that rewrites is asked only then."""
        teacher, listed = self.teacher, self.listed()
        return teacher.voice.sentences_of(listed, self._drawn(listed), teacher.paraphrase)

    def _drawn(self, claims: Sequence[Claim[Any]]) -> list[float]:
        """The numbers that draw the words of some claims of this moment; all are drawn once, whatever is chosen."""
        known = self.claims()
        if self._numbers is None:
            self._numbers = self.teacher.draw(len(known))
        wanted = {id(claim) for claim in claims}
        return [number for claim, number in zip(known, self._numbers, strict=True) if id(claim) in wanted]

    def choices(self) -> list[int]:
        """The choices that are legal, in order: 0 ends the turn, i says claim i - 1 of `listed`."""
        listed = range(1, 1 + len(self.listed())) if self.purse.left else ()
        return [0, *(i for i in listed if i - 1 not in self.chosen)]

    def choose(self, choice: Any) -> bool:
        """Choose one more claim, or none with 0; whether the turn is over, since nothing else can be said.

        A choice that is not legal says nothing and ends the turn.

        Raises:
            ValueError: it is no choice.
        """
        if type(choice) is not int or not 0 <= choice <= CLAIMS:
            choice = _index(choice, 1 + CLAIMS)
        if not choice or choice not in self.choices():
            return True
        self.chosen += (choice - 1,)
        return self.purse.left <= 1 or len(self.chosen) == len(self.listed())

    def of_chosen(self) -> Utterance:
        """What has been chosen in words, in speaking order; notices are always said."""
        listed = self.listed()
        kept = {id(listed[i]) for i in self.chosen}
        said = [claim for claim in self.claims() if claim.kind is None or id(claim) in kept]
        return self.teacher.say(tuple(said), self.moment.turn, self._drawn(said))

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """The claims that a message can have."""
        return Vocabulary.of(self.teacher.oracle)

    def composed(self, message: Message) -> str:
        """A message of claims in words, its own or the voice's, behind the notices, which are always said.

        Claims that cannot be made, checked or worded are left out, for reasons that `unbuilt` has, and so are those
        that feedback type and budget do not allow. If one of the latter is left out, the voice words the rest.
        """
        moment, teacher = self.moment, self.teacher
        notices = [claim for claim in (*(self._notice or ()), *self.claims()) if claim.kind is None]
        problems, made, left = [*message.problems], [], LONGEST // 2  # the rest is for notices, or for its own words
        for claim in message.claims:
            try:
                holds(claim, moment, teacher.oracle, teacher.voice)
                if (size := 1 + max(map(len, teacher.voice.sentences(claim)))) > left:
                    raise ValueError(f"{claim!r:.100} makes the words longer than {LONGEST // 2} characters")
            except ValueError as error:
                problems.append(f"{error}")
            else:
                made.append(claim)
                left -= size
        self.unbuilt = tuple(problems)
        claims = within(self.purse.left, [claim for claim in made if claim.kind in teacher.kinds])
        said = teacher.say((*notices, *claims), moment.turn)
        if not message.text or len(claims) < len(made):
            return said
        given, own = said.atoms[: len(notices)], said.atoms[len(notices) :]
        words = in_own_words(own, message.text, teacher.voice)
        return Utterance(" ".join([*(atom.text for atom in given), words]), (*given, *words.atoms))

    def allowed(self, words: Any) -> str:
        """As much of some words as the feedback type and the budget allow.

        Text without atoms is of no kind: it passes unless no feedback is wanted at all.

        Raises:
            ValueError: it is no text, or too long.
        """
        if not isinstance(words, str) or len(words) > LONGEST:
            raise ValueError(f"the teacher must say a string of at most {LONGEST} characters, got {words!r:.80}")
        if (kept := storable(words)) != words:
            words = Utterance(kept, tuple(atom._replace(text=storable(atom.text)) for atom in _atoms(words)))
        wanted, purse, turn = self.teacher.kinds, self.purse, self.moment.turn
        if type(words) is not Utterance or not words.atoms:
            return words if (wanted or not turn) and purse.left else SILENCE
        if len(wanted) < len(KINDS) and any(atom.kind not in wanted for atom in words.atoms if atom.kind is not None):
            words = Utterance.of([atom for atom in words.atoms if atom.kind is None or atom.kind in wanted])
        return words if purse.budget is None else Utterance.of(within(purse.left, words.atoms))


class Session:
    """A world, its teachers and a student, turn by turn.

    Args:
        world: what is taught.
        teachers: at least one; each speaks once a turn.
        max_turns: actions of the student after which the episode is truncated, at least 1.
        purses: what the teachers may say, one each; several can be the same. None: no limits.
        instructs: whether the first teacher's instruction is given by `open`, free of charge; else it is the first part
            of what that teacher suggests at the opening, and its own words there may contain an instruction.
        until_success: whether success terminates the episode; it does not where the task is `repeated`.
        repeated: whether success is that of a single action, so that a text which is no action does not keep it.
        ask_cost: what the student pays for asking, at least 0; None: it cannot ask.
        failure_reward: reward of a text that is no action; None: the world's own.
        read: reads the student's actions; None: `world.legal`.
        observer: follows all that happens.
        undoable: whether inputs are kept, for `undo`.
    """

    def __init__(
        self,
        world: World[Any, Any, Any],
        teachers: Sequence[Teacher],
        *,
        max_turns: int,
        purses: Sequence[Purse] | None = None,
        instructs: bool = False,
        until_success: bool = False,
        repeated: bool = False,
        ask_cost: float | None = None,
        failure_reward: float | None = None,
        read: Read | None = None,
        observer: Observer | None = None,
        undoable: bool = False,
    ) -> None:
        self.world, self.teacher, self.max_turns, self.repeated = world, teachers[0], max_turns, repeated
        if not is_count(max_turns):
            raise ValueError(f"max_turns must be an integer of at least 1, got {max_turns!r}")
        purses = purses or [Purse(0.0) for _ in teachers]
        if len(purses) != len(teachers):
            raise ValueError(f"purses must be one for each of {len(teachers)} teachers, got {len(purses)}")
        seats = [f"teacher_{number}" for number in range(len(teachers))] if len(teachers) > 1 else [""]
        parts = zip(teachers, purses, seats, strict=True)
        self.offers = tuple(Offer(*each, max_turns, ask_cost is not None) for each in parts)
        """What each of the teachers has to say."""
        self._several = len(teachers) > 1
        self._listeners = [teacher for teacher in teachers if teacher.listens]
        self.instructs, self.until_success = instructs, until_success and not repeated
        self.ask_cost, self.failure_reward = ask_cost, failure_reward
        self.observer = observer
        self.read: Read = world.legal if read is None else read
        """Reads the student's actions."""
        self._undoable = undoable
        self._spoken: list[str] = []  # of several teachers
        self.seeds = Seeds()
        """The streams of the episodes, beside the world's."""
        self.moment: Moment[Any]
        """What happened last: privileged."""
        self.state: Any = None
        """What the world shows now: its observation; each action makes a new one."""
        self.info: dict[str, Any]
        """What the world says beside that, with `success`, and `atoms` once the student has heard; new in each turn."""
        self.terminated = self.truncated = False
        self.instruction: str = SILENCE
        """The episode's instruction."""
        self.feedback: str = SILENCE
        """What the student heard last beside it."""
        self.atoms: tuple[Atom, ...] = ()
        """The claims that the student has heard since it last acted or asked."""
        self.asked = False
        """Whether the student has asked in this turn."""
        self._inputs: list[tuple[Callable[..., Any], tuple[Any, ...], list[tuple[bool, bool, bool]]]] | None = None
        self.heard = False
        """Whether the student has heard all teachers since it last acted or asked."""

    # The beginning of an episode.

    def open(self, seed: int | None = None, options: dict[str, Any] | None = None) -> Moment[Any]:
        """Begin an episode with full purses; without a seed the random streams go on.

        Args:
            seed: of the world and of all other streams.
            options: those of the world's `reset`.

        Returns:
            The opening moment.
        """
        moment = self._begin(seed, options, None)
        for offer in self.offers:
            offer.purse.spent = offer.trimmed = 0
        self._inputs = None
        if self._undoable and seed is not None:
            self._inputs, self._opened = [], (seed, options)
        return moment

    def start_next_episode(self, start: Any = None, options: dict[str, Any] | None = None) -> Moment[Any]:
        """Begin another episode of the same lesson: the streams go on, and what was spent of a budget stays spent.

        Args:
            start: the truth to begin with; None: as a reset of the world draws it.
            options: those of the world's `reset`.
        """
        moment = self._begin(None, options, start)
        self._inputs = None
        return moment

    def resume_from(self, moment: Moment[Any], terminated: bool = False, past: Sequence[Moment[Any]] = ()) -> None:
        """Go on from a moment of an episode that was played elsewhere; the teachers are the next to speak.

        Call `open` before: the random streams are those that it has begun.

        Args:
            moment: with the world's truths.
            terminated: whether the episode has ended there other than by its length.
            past: the moments of the episode before, from the opening on, for personalities that remember them.
        """
        self._inputs = None
        self.world.restore(moment.after)
        self.state = self.world.observe()
        self._open_lesson()
        if moment.turn:
            if not self.instructs:
                self.offers[0].suggestion()  # with the instruction its oracle starts
            if past:
                self.teacher.begin(self.seeds, 0, self.offers[0].numbers)
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
        self._await_teachers()

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
        self.terminated = self.truncated = self.asked = False
        self.instruction = self.feedback = SILENCE
        self.moment = Moment.opening(self.world.truth)._replace(ask_cost=self.ask_cost)
        self.info, self.atoms = {**self._reset_info, "atoms": ()}, ()
        for number, offer in enumerate(self.offers):
            offer.teacher.begin(self.seeds, number, offer.numbers)
            if self.instructs or number:
                opening = offer.teacher.open(self.moment)  # with which each oracle starts
                if not number:
                    self.instruction = opening
                    self.atoms = self.info["atoms"] = opening.atoms
        self._await_teachers()
        if self.observer is not None:
            self.observer.begin(self.moment, self.atoms)

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
        given = action = storable(action) if isinstance(action, str) else action
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
            self.state, reward, terminated, truncated, info = world.advance(action)
            success = info["success"]
            if success and self.until_success:
                terminated = True
            truncated = not terminated and (truncated or turn >= self.max_turns)
            moment = Moment(last.after, action, reward, world.truth, success, turn, terminated or truncated)
            self.info = info
        if self._inputs is not None:
            self._keep(Session.act, copy.deepcopy(given))
        self.moment, self.terminated, self.truncated = moment, terminated, truncated
        self.atoms, self.asked = (), False
        self._await_teachers()
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
        if not self.heard or self.over:
            raise ValueError("the student cannot ask now: the teachers have yet to speak, or the episode has ended")
        self.asked = True
        self.state = copy.deepcopy(self.state)
        self.info = {key: value for key, value in self.info.items() if key not in ("atoms", "parse_failure")}
        self.atoms = ()
        if self._inputs is not None:
            self._keep(Session.ask)
        self._await_teachers()
        return -self.ask_cost

    def _await_teachers(self) -> None:
        moment, asked = self.moment, self.asked
        self.heard = False
        self._opening = opening = not (moment.turn or asked)
        if self._several:
            self._spoken.clear()
        for offer in self.offers:
            offer.see(moment, asked, opening and not self.instructs)

    # The teachers' half of a turn.

    def suggest(self, teacher: int = 0) -> Utterance:
        """What a teacher would say now: all that it has to say, in its words."""
        return self.offers[teacher].suggestion()

    def speak(self) -> None:
        """Every teacher that has not spoken says what it suggests, as far as its budget allows."""
        if self._inputs is not None:
            self._keep(Session.speak)
        moment = self.moment
        for offer in self.offers:
            if offer.said is None:
                said = offer.suggestion()
                if offer.purse.budget is None and moment.before is not None:
                    self._put(offer, said, len(said.atoms))  # all of them are feedback
                else:
                    self._put(offer, offer.allowed(said))

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
        offer = self._next_to_speak(teacher)
        if not self.instructs:
            offer.suggestion()  # the oracle starts with the instruction, and a personality sees each moment
        elif not self.asked:
            offer.claims()
            if type(words) is Utterance and not self.moment.turn:
                words = Utterance.of([atom for atom in words.atoms if atom.kind is not None])
        given: Any = words
        offer.unbuilt = ()
        if isinstance(words, Mapping | Message):
            given = offer.vocabulary.read(words, self.moment) if isinstance(words, Mapping) else words
            words = offer.composed(given)
        words = offer.allowed(words)
        if self._inputs is not None:
            self._keep(Session.say, given, teacher)
        return self._put(offer, words)

    def say_kinds(self, subset: int, teacher: int = 0) -> float:
        """A teacher says its claims of a subset of the kinds; arguments as in `say`.

        Raises:
            ValueError: it is no subset's number; nothing has changed.
        """
        offer = self._next_to_speak(teacher)
        said = offer.of_kinds(subset)
        if self._inputs is not None:
            self._keep(Session.say_kinds, subset, teacher)
        return self._put(offer, said, len(said.atoms) if self.moment.before is not None else None)

    def choose(self, choice: int, teacher: int = 0) -> float:
        """A teacher chooses one more claim to say, or with 0 none; the others as in `say`.

        The chosen claims are said when the teacher chooses 0, or when no other claim can be chosen.

        Raises:
            ValueError: it is no choice; nothing has changed.
        """
        offer = self._next_to_speak(teacher)
        before = len(offer.chosen)
        done = offer.choose(choice)
        if self._inputs is not None:
            self._keep(Session.choose, choice, teacher)
        reward = offer.purse.pay(len(offer.chosen) - before)
        if done:
            self._put(offer, offer.of_chosen(), 0)
        return reward

    def _next_to_speak(self, teacher: int) -> Offer:
        """A teacher that has yet to speak of the moment.

        Raises:
            ValueError: there is no such teacher, or it has spoken.
        """
        if not 0 <= teacher < len(self.offers):
            raise ValueError(f"teacher must be a number from 0 to {len(self.offers) - 1}, got {teacher!r}")
        offer = self.offers[teacher]
        if offer.said is not None:
            raise ValueError("the teacher has spoken of this moment; the student, or another teacher, is next")
        return offer

    def _put(self, offer: Offer, said: str, atoms: int | None = None) -> float:
        """What a teacher says, and the atoms that it pays for, by default those of feedback; its reward.

        The student hears it when all have spoken.
        """
        words, several = said, self._several
        if several:
            said = self._signed(offer.speaker, said)
        elif self._opening and not self.instructs:
            self.instruction, said = _parted(said)
        offer.said = said
        reward = offer.purse.pay(price(said) if atoms is None else atoms)
        if several:
            self._spoken.append(said)
            if len(self._spoken) < len(self.offers):
                return reward
            said = words = self.said_so_far()
        self.feedback, self.heard = said, True
        if self._opening:
            self.atoms += _atoms(said if self.instructs else words)
        else:
            self.atoms = said.atoms if type(said) is Utterance else ()
        self.info["atoms"] = self.atoms
        for teacher in self._listeners:
            teacher.hear(self.atoms)
        if self.observer is not None:
            self.observer.said(words, self.turn)
        return reward

    def said_so_far(self) -> Utterance:
        """What several teachers have said since the student acted, in the order of speaking."""
        said = [words for words in self._spoken if words]
        return Utterance(" ".join(said), tuple(atom for words in said for atom in _atoms(words)))

    def _signed(self, speaker: str, said: str) -> Utterance:
        """Words whose atoms name their speaker; a notice that was given in this turn is left out."""
        atoms = _atoms(said)
        given = [atom.claim for words in self._spoken for atom in _atoms(words) if atom.kind is None]
        if any(atom.claim in given for atom in atoms):
            said = Utterance.of(atoms := tuple(atom for atom in atoms if atom.claim not in given))
        return Utterance(said, tuple(atom._replace(speaker=speaker) for atom in atoms))

    @property
    def turn(self) -> Turn:
        """The record of the turn, which is complete once the student has heard all teachers."""
        return Turn(
            self.moment,
            self.state,
            self.info.copy(),
            self.terminated,
            self.truncated,
            self.instruction if self._opening else SILENCE,
            self.feedback if self.heard else SILENCE,
            self.atoms,
            self.asked,
        )

    # The end of an episode, and the way back.

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
        """Whether it is `solved`, and the last word has been said."""
        return self.heard and self.solved

    def undo(self, teachers: bool = False, before_act: Callable[[], object] | None = None) -> None:
        """Take back the student's last action or question and all that came after: the rest is played again.

        Args:
            teachers: take back the teachers' last words instead of the student's last action, and what came after.
            before_act: called before each action or question that is played again, for a policy that lives through it.

        Raises:
            ValueError: there is nothing to take back, or the session keeps no inputs: it was made without `undoable`,
                opened without a seed, or resumed.
        """
        if self._inputs is None:
            raise ValueError("no turn can be taken back: that needs undoable=True and an episode opened with a seed")
        inputs = self._inputs
        ends = [i for i, (method, _, _) in enumerate(inputs) if method in (Session.act, Session.ask)]
        if teachers:
            ends = [i + 1 for i in (-1, *ends) if i + 1 < len(inputs) and i + 1 not in ends]
        if not ends:
            raise ValueError("there is no turn to take back")
        self.open(*self._opened)
        for method, arguments, asked_for in inputs[: ends[-1]]:
            for offer, needed in zip(self.offers, asked_for, strict=True):
                offer.prepare(*needed)
            if method in (Session.act, Session.ask) and before_act is not None:
                before_act()
            method(self, *arguments)

    def _keep(self, method: Callable[..., Any], *arguments: Any) -> None:
        """Note an input, and what the teachers have been asked for before it."""
        assert self._inputs is not None  # noqa: S101  # or nothing is kept
        self._inputs.append((method, arguments, [offer.prepared for offer in self.offers]))

    def mistake(self, action: Any) -> bool:
        """Whether an action of the student would be a mistake now.

        Where actions have values, a mistake is worth less than another action. Elsewhere the oracle tries the action
        out, and it is a mistake if the oracle blames it; without verdicts on actions, any hn claim counts.

        Raises:
            ValueError: the action is outside the action space.
        """
        if type(action) is ParseFailure or type(action := self.read(action)) is ParseFailure:
            return True
        oracle = self.teacher.oracle
        values = oracle.values(self.moment.after)
        if values is not None:
            return bool(values[action] < max(values) - _NEAR)
        if HN not in oracle.feedback_types:
            return False
        found = oracle.judge(oracle.try_out(self.moment, action), {HP, HN})
        verdicts = [claim for claim in found if isinstance(claim, ActionClaim)] or found
        return any(claim.kind is HN for claim in verdicts)


def price(said: str) -> int:
    """Atoms of feedback in what is said; 1 for a text without atoms, 0 for silence."""
    atoms = _atoms(said)
    return sum([atom.claim.kind is not None for atom in atoms]) if atoms else int(said != "")


def kinds_of(claims: Sequence[Claim[Any]]) -> int:
    """The kinds of claims, as a subset's number."""
    kinds = 0
    for claim in claims:
        kind = claim.kind
        if kind is not None:
            kinds |= BIT[kind]
    return kinds


def _atoms(said: str) -> tuple[Atom, ...]:
    return said.atoms if type(said) is Utterance else ()


def _parted(said: str) -> tuple[str, str]:
    """An opening utterance as instruction and feedback: advice for the first action is feedback."""
    atoms = _atoms(said)
    advice = [atom for atom in atoms if atom.kind in (FP, FN)]
    if not advice:
        return said, SILENCE
    return Utterance.of([atom for atom in atoms if atom.kind not in (FP, FN)]), Utterance.of(advice)


def within(left: int, items: Sequence[Any]) -> list[Any]:
    """The first `left` claims or atoms that are feedback, and all that are not."""
    kept = []
    for item in items:
        if item.kind is None or left > 0:
            kept.append(item)
            left -= item.kind is not None
    return kept


def _index(value: Any, count: int) -> int:
    """An integer from 0 on, below `count`, NumPy's included.

    Raises:
        ValueError: it is none.
    """
    try:
        index = operator.index(value)
    except TypeError:
        index = -1
    if not 0 <= index < count:
        raise ValueError(f"the teacher's action must be an integer from 0 to {count - 1}, got {value!r}")
    return index
