"""text_only: does what the teacher's words say; it knows the phrases of every voice but sees no atoms."""

from dataclasses import dataclass
from typing import Any

from gymnasium import spaces

from llf_teacher.students.advice import AdviceTaker
from llf_teacher.students.reading import Reader
from llf_teacher.students.student import Student
from pz_envs.text_mode import parse_action
from teachers.atoms import FP, ParseFailure
from teachers.common import Right, Wrong
from teachers.voice import voice_names

_BLANK = "..."  # a line that is yet to be written


@dataclass(frozen=True)
class TextOnly(Student):
    """Believes every sentence it understands: those of the family, in all voices that have a name.

    It takes actions by their names, as the `target` to go to, or as the first of some `steps`, lists of them as a plan,
    a line in quotes as a correction of its last text, and right or wrong as said of its action.
    """

    reads = "words"

    class Policy(AdviceTaker):
        """Learns from sentences."""

        def begin(self) -> None:
            """Learn to read, once; have nothing written."""
            super().begin()
            if not hasattr(self, "_reader"):
                self._reader = Reader(self.family.phrasebook, voice_names(), self._is_action)
            self._draft = ""
            self._actions: list[Any] = []

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """Obey what is understood."""
            turn = self.arrive(observation)
            text = observation["feedback"] if turn else f"{observation['instruction']} {observation['feedback']}"
            for claim, slots, about in self._reader.read(text):
                named = slots.get("action") or slots.get("target") or _first(slots.get("steps", ""))
                if claim in (Right, Wrong) and self._actions:
                    of = turn if about is None else about
                    self.learn(claim.kind, self._actions[of - 1], of)
                elif named:
                    action = parse_action(named, self.world)
                    if type(action) is ParseFailure:
                        continue
                    if claim.kind is None:
                        self.follow((action,), endless=True)
                    else:
                        self.learn(claim.kind, action, turn if about is None else about)
                elif "listing" in slots:
                    actions = [parse_action(word, self.world) for word in slots["listing"].split(", ")]
                    if not any(type(action) is ParseFailure for action in actions):
                        self.follow(actions)
                elif claim.kind is FP and {"line", "words"} <= slots.keys():
                    self.learn(FP, self._correct(int(slots["line"]), slots["words"]), turn)
            action = self.decide()
            self._actions.append(self.world.legal(action))
            if isinstance(self.world.action_space, spaces.Text):
                self._draft = action
            return action

        def _is_action(self, text: str) -> bool:
            return type(parse_action(text, self.world)) is not ParseFailure

        def _correct(self, number: int, words: str) -> str:
            """The last text with one line replaced."""
            lines = [line for line in self._draft.splitlines() if line.strip()]
            lines += [_BLANK] * (number - len(lines))
            lines[number - 1] = words
            return "\n".join(lines)


def _first(steps: str) -> str:
    """The first of steps that are told one after the other."""
    step = steps.partition(", then ")[0]
    return step[1:-1] if step.startswith('"') else step
