"""Tutoring: a teacher and a student take turns over a world."""

from typing import Any

from pz_envs.assembly import Parts, assemble
from pz_envs.global_state import Seated
from pz_envs.seats import STUDENT, TEACHER, OneSessionEnv
from pz_envs.settings import Settings
from pz_envs.subject import Seating, Subject

__all__ = ["SEATING", "Tutoring", "TutoringEnv"]


class TutoringEnv(OneSessionEnv):
    """An AEC environment with the agents `teacher_0` and `student_0`: the two seats of a `teachers.session.Session`.

    The teacher is first; then student and teacher alternate, and the teacher is last: after the student's final action
    the episode ends when the teacher has spoken.

    Student:
        Observation: Dict of `state` (the world's space; `Prose` with `text=True`), `instruction` and `feedback`
        (`Prose`), the teacher's last words, and `image`, if there is one. In an opening utterance with atoms the advice
        for the first action is feedback and the rest is the instruction. Action: the world's space; `Prose` with
        `text=True`. A text that is not an action is a `ParseFailure` (in the info as `parse_failure`): the world does
        not step, the turn counts. Info: the world's, with `success`, and `atoms`, the claims heard last. With
        `numbers=True` the observation is one flat Box, float32, of the state and the claims; see `pz_envs.numbers`, and
        `student_view.fields` for its layout. The action is the world's, the info has no `atoms`.

    Teacher, `speech="message"`:
        Observation: Dict of `state` and `action` (`Prose`), the world and the student's last action as text.
        Action: `Prose`; an `Utterance` brings its atoms along, and the student hears the atoms that `feedback_type`
        allows. `{"claims": [...], "text": ...}` becomes an utterance: the info's `vocabulary` makes each claim, and the
        voice words it if there is no text. Info: the privileged `moment`, `suggestion`, the utterance of the session's
        teacher, `vocabulary`, a `teachers.schema.Vocabulary` of the claims that can be said, and `unbuilt`, the reason
        for each claim of its last message that could not be made.

    Teacher, `speech="kinds"`:
        Observation: Dict of
            `available`, MultiBinary(5): the kinds with a claim, in the order r, hp, hn, fp, fn;
            `features`, Box (5,) float32: turn / max_turns, 0 to 1; the last reward, in the world's `reward_range`;
            importance of the next action, 0 to the oracle's `max_importance`; share of the budget that is left, 0 to 1,
            1 without a budget; 1 if the episode is over, else 0;
            `action_mask`, int8 (32,).
        The claims are those of the session's teacher after its personality; they may be false if the personality errs.
        Action: Discrete(32), the subset of kinds to say, bit i for kind i; kinds without a claim are skipped. The
        instruction is given by `reset`. Info: the privileged `moment`, and `trimmed`, the kinds of its last action that
        could not be said, as a subset's number.

    Teacher, `speech="claims"`:
        Observation: as with `kinds`, with `action_mask` int8 (33,), and `claims`, Box (32, 8) int8: per claim
        its kind, one of five, and whether it is about an action, a plan, or an edit of a text.
        Action: Discrete(33): i says claim i - 1, and the teacher acts again; 0, or a masked action, ends the teacher's
        turn, which also ends when no other claim can be said. The student hears all claims at once, in speaking order.
        Info: the privileged `moment`; `claims`, in the order of the numbers; and `sentences`, one wording of each.

    Asking, with `ask_cost`: in place of an action the student may ask, once a turn; `pz_envs.text.questions` has the
    action. The world does not step and the turn does not count; the teacher gives advice (fp, fn) on the moment, with
    one more entry `asked`, MultiBinary(1), in its observation and `asked` in its info; then the student acts. A second
    question in a turn counts as a text that is not an action: it costs the turn.

    Rewards: at the student's step it gets the world's reward, or pays `ask_cost` for a question, and the teacher gets
    its `teacher_reward`; at its own step the teacher pays `cost` for each atom of feedback, one for a text without any.

    Seeds: `reset(seed)` seeds the bare world; all other streams come from `teachers.seeds.Seeds`. Without a seed all
    streams go on.

    Args:
        parts: the parts of a session, from `pz_envs.assembly.assemble`.
        settings: the settings of the session.
        name: the environment's first label.
    """

    def __init__(self, parts: Parts, settings: Settings, name: str = "tutoring") -> None:
        session, student_view, (self.teacher_view,) = parts
        super().__init__(session, student_view, name, settings.speech, settings.render_mode)
        self.possible_agents = [TEACHER, STUDENT]
        for agent, view in ((TEACHER, self.teacher_view), (STUDENT, self.student_view)):
            self.observation_spaces[agent], self.action_spaces[agent] = view.observation_space, view.action_space

    @property
    def seated(self) -> list[Seated]:
        """The student with its teacher."""
        return [Seated(STUDENT, self.student_view, {TEACHER: self.teacher_view})]

    def _observe(self, agent: str) -> Any:
        if agent == STUDENT:
            return self.student_view.observe()
        return self.teacher_view.observe(self.agent_selection == TEACHER)

    def _describe_seats(self) -> str:
        return f"{self.session.teacher!r}"

    def _enter(self) -> None:
        super()._enter()
        self._select_teacher()

    def _act(self, agent: str, action: Any) -> None:
        if agent == STUDENT:
            reward = self.student_view.act(action)
            paid = self.teacher_view.reward()
            # Rewards between two turns of an agent add up; the sum is never -0.0.
            self.rewards = {TEACHER: paid, STUDENT: reward}
            self._cumulative_rewards[TEACHER] += paid
            self._cumulative_rewards[STUDENT] = 0.0 + reward
            self.infos[STUDENT] = self.student_view.info()
            self._select_teacher()
        else:
            cost = self.teacher_view.act(action)
            self.rewards = {TEACHER: cost, STUDENT: 0.0}
            self._cumulative_rewards[TEACHER] = 0.0 + cost
            if self.speech == "kinds" and self.teacher_view.teacher_turn.trimmed != self.infos[TEACHER]["trimmed"]:
                self.infos[TEACHER] = {**self.infos[TEACHER], "trimmed": self.teacher_view.teacher_turn.trimmed}
            if self.session.heard:
                self._select_student()

    def _select_teacher(self) -> None:
        self.infos[TEACHER] = self.teacher_view.info()
        self.agent_selection = TEACHER


class Tutoring(Seating):
    """One teacher, one student."""

    def raw_env(self, subject: Subject, settings: Settings) -> TutoringEnv:
        """The bare AEC environment; see `TutoringEnv`.

        Raises:
            ValueError: a setting is not allowed.
        """
        return TutoringEnv(assemble(subject, settings), settings, subject.name)


SEATING = Tutoring()
