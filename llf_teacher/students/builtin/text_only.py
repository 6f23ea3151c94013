"""text_only: does what the teacher's words say, by the phrases of every voice, without claims."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gymnasium import spaces

from llf_teacher.students.advice import AdviceTaker, Believer
from pz_envs.text.actions import read_exactly
from pz_envs.text.phrases import Reader
from teachers.atoms import FP, HN, HP, ActionClaim, Claim, EditClaim, ParseFailure, PlanClaim
from teachers.voice import voice_names

_BLANK = "..."  # a line without words so far
_LINE = re.compile(r"[1-9]\d?\d?", re.ASCII)  # digits of a line's number; bounds the number of blank lines


class _Policy(AdviceTaker["TextOnly"]):
    """Learns from sentences."""

    def begin(self) -> None:
        """Begin an episode; make the reader in the first."""
        super().begin()
        if not hasattr(self, "_reader"):
            self._reader = Reader(self.family.phrasebook, voice_names(), self._is_action)
        self._draft = ""
        self._actions: list[Any] = []

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Learn from the recognised sentences, then act."""
        turn = self.arrive(observation)
        self._read(observation["feedback"] if turn else f"{observation['instruction']} {observation['feedback']}", turn)
        action = self.decide()
        self._actions.append(None)
        self.did(action)
        return action

    def did(self, action: Any) -> None:
        """Note the action of this turn."""
        self._actions[-1] = self.world.legal(action)
        if isinstance(self.world.action_space, spaces.Text):
            self._draft = action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the last words, for later episodes."""
        self._read(observation["feedback"], len(self._actions))

    def _read(self, text: str, turn: int) -> None:
        """Learn from a text.

        Args:
            text: the teacher's words.
            turn: number of turns so far.
        """
        for heard in self._reader.read(text):
            claim, slots = heard.claim, heard.slots
            at = turn if heard.about_turn is None else heard.about_turn
            if issubclass(claim, ActionClaim) and claim.action_slot in slots:
                self._hear(claim, [slots[claim.action_slot]], at, endless=True)
            elif issubclass(claim, PlanClaim) and claim.plan_slot in slots:
                steps = slots[claim.plan_slot].split(claim.separator)
                self._hear(claim, [_unquoted(step) for step in steps], at)
            elif issubclass(claim, EditClaim):
                if _LINE.fullmatch(number := slots[claim.line_slot]):
                    words = None if claim.cuts else slots[claim.words_slot]
                    self.learn(FP, self._correct(int(number), words), turn)
            elif issubclass(claim, ActionClaim) and claim.kind in (HP, HN) and 0 < at <= len(self._actions):
                self.learn(claim.kind, self._actions[at - 1], at)

    def _hear(self, claim: type[Claim[Any]], words: Sequence[str], turn: int, endless: bool = False) -> None:
        """Learn from a list of action names, if all of them name actions."""
        actions = [read_exactly(word, self.world) for word in words]
        if not any(type(action) is ParseFailure for action in actions):
            self.hear(claim.kind, actions, turn, endless)

    def _is_action(self, text: str) -> bool:
        return type(read_exactly(text, self.world)) is not ParseFailure

    def _correct(self, number: int, words: str | None) -> str:
        """The last text with one line replaced; without words, the text up to this line."""
        lines = [line for line in self._draft.splitlines() if line.strip()]
        if words is None:
            return "\n".join(lines[:number])
        lines += [_BLANK] * (number - len(lines))
        lines[number - 1] = words
        return "\n".join(lines)


@dataclass(frozen=True)
class TextOnly(Believer):
    """Believes every sentence of the family that it recognises, in all named voices.

    It reads names of actions; lists of actions, which are a plan, or in feedback advice to take the first; corrections
    of a line or of the end of its last text; and verdicts without an action, which are about its own action.
    """

    reads = "words"
    policy = _Policy


def _unquoted(text: str) -> str:
    """A text without the quotes around it."""
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text
