"""The seats of tutoring: who sits there, what is seen from them, and how an episode begins."""

import copy
from abc import abstractmethod
from typing import Any

from gymnasium import spaces

from pz_envs.asking import asking_space
from pz_envs.numbers import Embed, Field, Numbers
from pz_envs.rewards import TeacherReward, check_prices, parse_teacher_reward, student_reward
from pz_envs.seatings.tutoring.words import words_space
from pz_envs.seats import STUDENT, TEACHER, SeatsEnv, check_flags, known_options
from pz_envs.teacher_seat import CHOICES, PROSE, Purse, TeacherSeat, is_count, message_space
from teachers.atoms import SILENCE, Atom, Moment, ParseFailure
from teachers.seeds import Seeds
from teachers.teacher import Teacher
from worlds.spaces import Prose
from worlds.world import World

__all__ = ["TutoringSeats"]


class TutoringSeats(SeatsEnv):
    """All of a `TutoringEnv`, which has the arguments, but for its turns."""

    def __init__(
        self,
        world: World[Any, Any, Any],
        teacher: Teacher,
        *,
        name: str = "tutoring",
        max_cycles: int = 30,
        repeated: bool = False,
        speech: str = "message",
        text: bool = False,
        image: spaces.Space[Any] | None = None,
        numbers: bool = False,
        embed: Embed | None = None,
        cost: float = 0.01,
        budget: int | None = None,
        purse: Purse | None = None,
        teacher_reward: str | TeacherReward = student_reward,
        until_success: bool = False,
        ask_cost: float | None = None,
        failure_reward: float | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(name, speech, render_mode)
        check_flags(text=text, numbers=numbers, until_success=until_success)
        if text and numbers:
            raise ValueError("text=True and numbers=True exclude each other; set one of them")
        if embed is not None and not numbers:
            raise ValueError("embed= makes numbers of words; it needs numbers=True")
        if not is_count(max_cycles):
            raise ValueError(f"max_cycles (or max_turns) must be an integer of at least 1, got {max_cycles!r}")
        check_prices(ask_cost, failure_reward, world.reward_range)
        self.name, self.world, self.teacher = name, world, teacher
        self.max_turns, self.text, self.ask_cost = max_cycles, text, ask_cost
        self.visual = image is not None
        self.repeated, self.until_success = repeated, until_success and not repeated
        self.purse, self.failure_reward = purse or Purse(cost, budget), failure_reward
        self.seat = TeacherSeat(teacher, self.purse, max_cycles, world.reward_range, ask_cost is not None)
        self.teacher_reward = parse_teacher_reward(teacher_reward)
        self._own_reward = self.teacher_reward is not student_reward
        self._at_once = not (self._own_reward or ask_cost is not None or self.purse.budget or speech != "message")
        self.possible_agents = [TEACHER, STUDENT]
        self._texts = text or isinstance(world.action_space, spaces.Text)
        self._numbers = Numbers(world, max_cycles, embed) if numbers else None
        self.student_space = spaces.Dict(
            {
                "state": Prose(PROSE) if text else copy.deepcopy(world.observation_space),
                "instruction": Prose(PROSE),
                "feedback": Prose(PROSE),
                **({} if image is None else {"image": image}),
            }
        )
        """What the student observes, if not in numbers."""
        self.moment: Moment[Any]
        """The last turn."""
        self.observation_spaces[STUDENT] = self._numbers.space if self._numbers else self.student_space
        acts = Prose(PROSE) if text else copy.deepcopy(world.action_space)
        self.action_spaces[STUDENT] = acts if ask_cost is None else asking_space(acts)
        if speech == "message":
            self.observation_spaces[TEACHER] = words_space()
            self.action_spaces[TEACHER] = message_space()
        else:
            self.observation_spaces[TEACHER] = self.seat.view_space(speech)
            self.action_spaces[TEACHER] = spaces.Discrete(CHOICES[speech])
        self.said: tuple[Atom, ...] = ()
        """What the student was told last."""
        self.seeds = Seeds()
        """The streams of this environment's episodes, beside the world's."""

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; without a seed the random streams go on. `options` are the world's."""
        self._begin(seed, options, None)
        self.purse.spent = self.seat.trimmed = 0
        self._open_lesson()

    def go_on(self, start: Any = None, options: dict[str, Any] | None = None) -> None:
        """Begin another episode of the same lesson; see `SeatsEnv`."""
        self._begin(None, options, start)
        self._open_lesson()

    @property
    def truth_now(self) -> Any:
        """The world's truth as it is."""
        return self.moment.after

    def take_up(self, moment: Moment[Any], terminated: bool = False) -> None:
        """Go on from a moment of an episode that was played elsewhere; the teacher is the next to speak.

        Call `reset` before: the random streams are those that it has begun.

        Args:
            moment: with the world's truths.
            terminated: whether the episode has ended there other than by its length.
        """
        self.world.restore(moment.after)
        self._state = self.world.observe()
        self._open_lesson()
        if moment.turn:
            self.turn, self.moment = moment.turn, moment
            self.ended = terminated, moment.over and not terminated
            self.infos[STUDENT], self.said = {"success": moment.success}, ()
            self._pass_to_teacher()

    def _begin(self, seed: int | None, options: dict[str, Any] | None, start: Any) -> None:
        world = self.world
        self._state, self._told = world.reset(seed=seed, options=known_options(options, world))
        if seed is None:
            self.seeds.episode += 1
        else:
            self.seeds = Seeds(seed)
        if start is not None:
            world.restore(start)
            self._state = world.observe()

    def _open_lesson(self) -> None:
        self._open()
        self.turn = 0
        self.ended = (False, False)
        self._asked = False
        self.instruction: str = SILENCE
        self.feedback: str = SILENCE
        self.moment = Moment.opening(self.world.truth)._replace(ask_cost=self.ask_cost)
        self.infos[STUDENT], self.said = self._told.copy(), ()
        self.teacher.begin(self.seeds)
        if self.speech != "message":
            opening = self.instruction = self.teacher.open(self.moment)
            self.said = opening.atoms
        if self._numbers is None:
            self.infos[STUDENT]["atoms"] = self.said
        self._pass_to_teacher()

    @property
    def fields(self) -> tuple[Field, ...]:
        """What the numbers are that the student observes; none without `numbers=True`."""
        return () if self._numbers is None else self._numbers.fields

    @property
    def state_now(self) -> Any:
        """The world's observation as the student sees it; made anew by each action, and handed out as it is."""
        return self.world.describe(self._state) if self.text else self._state

    def observe(self, agent: str) -> Any:
        """What an agent sees now."""
        if agent == STUDENT:
            state = self.world.describe(self._state) if self.text else self._state
            if self._numbers is not None:
                return self._numbers.of(state, self.turn, self.instruction, self.feedback, self.said)
            state = state.copy() if type(state) is dict else copy.copy(state)
            seen = {"state": state, "instruction": self.instruction, "feedback": self.feedback}
            return seen | {"image": self.image()} if self.visual else seen
        if self.speech == "message":
            return self.describe()
        return self.seat.observe(self.speech, self.agent_selection == TEACHER)

    def image(self) -> Any:
        """The image that the student sees beside the text, uint8 (height, width, 3)."""
        return self._state["image"]

    def describe(self) -> dict[str, str]:
        """The world and the student's last action as text."""
        action = self.moment.action
        action = action.got if type(action) is ParseFailure else action
        return {"state": self.world.describe(self._state), "action": "" if action is None else f"{action}"}

    def _company(self) -> str:
        return f"{self.teacher!r}"

    def moment_of(self, student: str) -> Moment[Any]:
        """The student's last turn."""
        return self.moment

    def as_text(self) -> str:
        """The world and the teacher's last words."""
        return f"{self.world.describe(self._state)}\nTeacher: {self.feedback or self.instruction}".lstrip("\n")

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    @abstractmethod
    def _pass_to_teacher(self) -> None:
        """Let the teacher see what there is to speak of; its turn is next."""
