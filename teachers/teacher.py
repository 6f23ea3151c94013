"""The teacher: an oracle, a personality and a voice."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from teachers.atoms import FN, FP, SILENCE, Atom, Claim, FeedbackType, Moment, ParseFailure, Utterance
from teachers.common import MayAsk, NotUnderstood
from teachers.feedback import ALL, MIXED, draw_kinds, format_kinds, parse_kinds
from teachers.information import PosteriorContext
from teachers.oracle import POSTERIOR, Oracle
from teachers.personality import Personality, Pipeline, View, check_said, check_served, parse_personality, stages_of
from teachers.phrasebook import Drawn, Draws, Paraphrase, Phrasebook, Rewriting, check_paraphrase
from teachers.seeds import Seeds
from teachers.voice import Change
from teachers.witness import abilities_of

_RAISES = "instruction type {!r} is not supported; allowed: {}"


class Teacher:
    """States claims about a student's turns and words them. Nothing else makes atoms.

    In a lesson `teachers.session.Session` calls it. It also serves as a policy for a teacher's seat: `reset(rng)`, then
    `act(observation, info)` with the privileged `moment` in the info.

    Args:
        oracle: states what is true.
        voice: the phrases.
        personality: a spec string such as `mistake(eps=0.1) | delayed(turns=2)`, or a `Personality`.
        instruction_type: `b`, `p` or `c`.
        feedback_type: `a`, `n`, `m`, or kinds as `"r+hp"`, a set, a list or a tuple. It is applied last and bounds
            what any personality may say.
        paraphrase: `"random"`, an integer or a callable `(templates, **slots) -> str`.
        posterior_context: infers what the student can know, for personalities that need a posterior.

    Raises:
        ValueError: an argument is not supported, or the oracle lacks an ability that the personality needs.
    """

    def __init__(
        self,
        oracle: Oracle,
        voice: Phrasebook,
        personality: str | Personality = "oracle",
        *,
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        paraphrase: Paraphrase = "random",
        posterior_context: PosteriorContext | None = None,
    ) -> None:
        if not isinstance(oracle, Oracle):
            raise ValueError(f"oracle must be a teachers.oracle.Oracle, got {oracle!r}")
        self.oracle = oracle
        self.voice = voice
        self.personality = parse_personality(personality)
        check_served(self.personality, oracle, abilities_of(posterior_context.posterior) if posterior_context else ())
        self.posterior_context = posterior_context
        self.paraphrase = paraphrase
        self.instruction_type = instruction_type
        self.feedback_type = feedback_type
        self._offered: tuple[Claim, ...] = ()
        self._brief: tuple[Claim, ...] = ()
        self._unasked: tuple[Moment, frozenset[FeedbackType]] | None = None  # where the oracle need not be asked

    def __repr__(self) -> str:
        settings = f"instruction_type={self.instruction_type!r}, feedback_type={self.feedback_type!r}"
        return f"Teacher({type(self.oracle).__name__}, {str(self.personality)!r}, {settings})"

    @property
    def instruction_type(self) -> str:
        """`b`, `p` or `c`; takes effect at the next reset."""
        return self._instruction_type

    @instruction_type.setter
    def instruction_type(self, value: str) -> None:
        if value not in self.oracle.instruction_types:
            raise ValueError(_RAISES.format(value, ", ".join(self.oracle.instruction_types)))
        self._instruction_type = value

    @property
    def feedback_type(self) -> str:
        """The bound on what is said, as text."""
        return self._feedback_type

    @feedback_type.setter
    def feedback_type(self, value: str | Iterable[str]) -> None:
        kinds, text = parse_kinds(value), format_kinds(value)
        able = self.oracle.feedback_types
        if text not in (ALL, MIXED) and not kinds <= set(able):
            raise ValueError(f"feedback type {value!r} is not supported; allowed: a, n, m, and of {', '.join(able)}")
        self._kinds, self._feedback_type = kinds, text
        self._able = kinds.intersection(able)
        self._mixed = text == MIXED

    @property
    def kinds(self) -> frozenset[FeedbackType]:
        """The kinds that the feedback type allows."""
        return self._kinds

    @property
    def offered(self) -> tuple[Claim, ...]:
        """The claims that the personality last chose from; empty if it passes on all claims."""
        return self._offered if self._unasked is None else self.oracle.judge(*self._unasked)

    @property
    def paraphrase(self) -> Paraphrase:
        """How a paraphrase is chosen."""
        return self._paraphrase

    @paraphrase.setter
    def paraphrase(self, value: Paraphrase) -> None:
        self._paraphrase = check_paraphrase(value)

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode, with random streams spawned from a generator."""
        (seed,) = rng.bit_generator.seed_seq.spawn(1)  # type: ignore[attr-defined]  # NumPy's stubs leave it out
        self.begin(Seeds(int(seed.generate_state(1, np.uint64)[0])))

    def begin(self, seeds: Seeds, seat: int = 0, numbers: Callable[..., tuple[float, ...]] | None = None) -> None:
        """Begin an episode, with separate random streams for oracle, personality, mixing and voice.

        Args:
            seeds: the seeds of the environment.
            seat: number of the teacher if there are several.
            numbers: what its seat in a lesson observes in numbers, see `teachers.teacher_turn.TeacherTurn.numbers`.
        """
        self._seeds, self._seat = seeds, seat
        self._draws = Draws(self._stream("voice"))
        self._mix_rng: np.random.Generator | None = None
        self._stage = None
        if not self.personality.transparent:
            self._view = View(self.oracle, self.voice.words, numbers)
            if self.listens:
                self._view.infer_from(self.posterior_context, self._stream("choice"))
            # Always as a pipeline, so that a lone personality draws what it draws as the first of several.
            self._stage = Pipeline(stages_of(self.personality)).start(self._stream("personality"))

    @property
    def listens(self) -> bool:
        """Whether the personality must know what the student hears."""
        return POSTERIOR in self.personality.needs

    def hear(self, atoms: Sequence[Atom]) -> None:
        """Note all that the student has heard in this turn, other teachers included."""
        self._view.hear([atom for atom in atoms if atom.claim not in self._brief])

    def origin(self, atom: Atom) -> Moment | None:
        """The moment elsewhere from which the personality took a claim; None if the claim is about this lesson."""
        return None if self._stage is None else self._view.origin(atom.claim, atom.about_turn)

    def _stream(self, name: str) -> np.random.Generator:
        """A random stream of the episode, from its start; making one is slow, so call this only when needed."""
        return self._seeds.stream(name, self._seat)

    def act(self, observation: Any, info: dict[str, Any]) -> Utterance:
        """The utterance about the info's `moment`."""
        return self.speak(info["moment"])

    def speak(self, moment: Moment) -> Utterance:
        """The utterance of one turn.

        At the opening the instruction comes first, then advice for the first action. After a text that did not parse,
        a notice of what was expected comes first.
        """
        notice = self.notice(moment) if moment.before is None else ()
        said = self.say(notice + self.judge(moment), moment.turn)
        if self.listens:
            self.hear(said.atoms)
        return said

    def open(self, moment: Moment) -> Utterance:
        """The instruction alone."""
        return self.say(self.notice(moment), moment.turn)

    def notice(self, moment: Moment) -> tuple[Claim, ...]:
        """The claims that no personality changes: the instruction, or the notice that a text did not parse."""
        action = moment.action
        if action is None:
            self.oracle.start(moment.after)
            rng = self._stream("oracle") if self._instruction_type == "p" else None
            brief = self._brief = self.oracle.brief(moment.after, self._instruction_type, rng)
            return brief if moment.ask_cost is None else (*brief, MayAsk(cost=float(moment.ask_cost)))
        if type(action) is ParseFailure:
            return (NotUnderstood(got=action.got, expected=action.expected, why=action.why),)
        return ()

    def judge(self, moment: Moment) -> tuple[Claim, ...]:
        """The claims of this turn after personality and feedback type. Call it once a turn."""
        kinds = self._mix() if self._mixed else self._kinds
        if self._stage is None:
            return self.oracle.judge(moment, kinds) if kinds else ()
        if self.personality.mute:
            self._unasked = moment, kinds
            return ()
        self._view.see(moment, self._able)
        if moment.action is None and self.listens:
            self._view.hear([Atom(claim, "", moment.turn) for claim in self._brief])
        return self._choose(moment, kinds)

    def answer(self, moment: Moment) -> tuple[Claim, ...]:
        """The advice of this turn, after personality and feedback type, for a student that asks."""
        kinds = self._kinds & {FP, FN}
        if self._stage is None:
            return self.oracle.judge(moment, kinds) if kinds else ()
        if self.personality.mute:
            return ()
        self._view.ask()
        return self._choose(moment, kinds)

    def _choose(self, moment: Moment, kinds: frozenset[FeedbackType]) -> tuple[Claim, ...]:
        """The claims that the personality makes of the oracle's claims."""
        assert self._stage is not None  # noqa: S101  # a personality that is not transparent has one
        self._offered = self.oracle.judge(moment, kinds)
        said = check_said(self._stage.speak(self._offered, self._view), self._stage)
        return tuple(claim for claim in said if claim.kind in kinds)

    def _mix(self) -> frozenset[FeedbackType]:
        """A random subset of the kinds for this turn."""
        if self._mix_rng is None:
            self._mix_rng = self._stream("mixing")
        return draw_kinds(self._able, self._mix_rng)

    @property
    def changes(self) -> tuple[Change, ...]:
        """The numbers and names that a rewriting voice changed in the last utterance; empty for other voices."""
        return self.voice.changes if isinstance(self.voice, Rewriting) else ()

    def draw(self, count: int) -> list[float]:
        """Draw the numbers with which `say` chooses the words of `count` claims."""
        begin = self._draws.take(count)
        return self._draws.numbers[begin : begin + count]

    def say(self, claims: tuple[Claim, ...], turn: int, numbers: Sequence[float] | None = None) -> Utterance:
        """Put claims into words.

        Args:
            claims: the claims.
            turn: the number of the turn.
            numbers: from `draw`, one for each claim; None draws them now.
        """
        if claims or type(self.voice) is Rewriting:  # which has to know that this time it changed nothing
            draws = self._draws if numbers is None else Drawn(numbers)
            return self.voice.say(claims, turn, draws, self._paraphrase)
        return SILENCE
