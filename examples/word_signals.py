"""Learning from words without a model: the worlds, what a signal makes of a teacher's words, and the stored rows.

`learn_from_words.py` has the experiment and its rules, `word_training.py` the model in training.
"""

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from llf_teacher import make, rollout
from llf_teacher.gym import StudentEnv
from pz_envs.text.actions import parse_action
from pz_envs.text.answer_formats import worded, written
from pz_envs.text.claims import ClaimReader
from teachers.atoms import FP, HN, HP, ActionClaim, ParseFailure
from worlds.bandits import levels_of
from worlds.gridworld import DIRECTIONS, NO_DOOR, kind_of

Message = dict[str, Any]
Policy = Callable[[list[list[Message]]], list[str]]
"""Gives an answer to each of some conversations."""

HELD_OUT = 10_000_000
"""First seed of the worlds of tests; training begins at 0."""
TRAINING_PHRASES, HELD_OUT_PHRASE = (0, 1, 2), 3
"""Indices of paraphrases; each claim has at least four."""
TRAINING_VOICE, HELD_OUT_VOICE = "plain", "curt"
KINDS = "fp+hp+hn"
"""What the teacher says in training: advice before the action, praise or blame after it."""
DOORS = 3  # of the first room of a house, at least
_TEACHER = "Teacher: "  # the feedback's paragraph of a prompt begins so


def _house(world: Any) -> bool:
    """Whether the treasure is behind one of at least `DOORS` doors of the first room."""
    room, _, layout = world.truth
    doors = [behind for behind in layout.doors[room] if behind != NO_DOOR]
    return len(doors) >= DOORS and layout.treasure in doors


def _house_shares(town: "Town", seed: int) -> Sequence[float]:
    room, _, layout = town.truth(seed)
    doors = layout.doors[room]
    seen = [side for side in DIRECTIONS if doors[side] != NO_DOOR]
    lawful = [side for side in seen if kind_of(layout.names[doors[side]]) == layout.law]
    right = {side for side in seen if doors[side] == layout.treasure}
    return [len(right & {*some}) / len(some) for some in (DIRECTIONS, seen, lawful)]


def _arm_shares(town: "Town", seed: int) -> Sequence[float]:
    truth = town.truth(seed)
    levels = levels_of(truth.looks, truth.law)
    arms = range(len(levels))
    lawful = [arm for arm in arms if levels[arm] == max(levels)]
    return [len({*truth.best} & {*some}) / len(some) for some in (arms, arms, lawful)]


def _title_shares(town: "Town", seed: int) -> Sequence[float]:
    truth, catalogue = town.truth(seed), town.world.catalogue
    wishes = truth.profile.wishes
    said = [wish for name, wish in wishes.items() if name != truth.unsaid]
    return [catalogue.count(wishes.values()) / catalogue.count(some) for some in ((), said, wishes.values())]


def _command_shares(town: "Town", seed: int) -> Sequence[float]:
    """Of first commands; a command is right if it is as near to the goal as the oracle's."""
    _, info = town.world.reset(seed=seed)
    commands = [*info[town.world.actions_key]]
    steps = town.judge([seed] * len(commands), [response(command) for command in commands])
    right = {command for command, step in zip(commands, steps, strict=True) if not step.regret}
    moves = [command for command in commands if command.startswith(_MOVE)]
    task = re.findall(r"[a-z]+", steps[0].prompt[-1]["content"].partition(_TASK)[2].partition("\n")[0])
    keeper = next(town.world.law[word] for word in task if word in town.world.law)
    lawful = [move for move in moves if move.removeprefix(_MOVE).rpartition(" ")[0] == keeper]
    return [len(right & {*some}) / len(some) for some in (commands, moves, lawful or moves)]


_MOVE, _TASK = "go to ", "Your task is to: "
REFERENCES = ("random", "possible", "law")
"""Success without a teacher, computed from the worlds: of any action by chance, of any action that could be right, and
of an action by the town's law. In gridworld and bandits the last is the best that is possible without feedback.
"""


class OneMove(NamedTuple):
    """Where one decision is made: an environment, and which of its worlds take part."""

    id: str
    options: Mapping[str, Any]
    shares: Callable[["Town", int], Sequence[float]]
    """The success of each of `REFERENCES` in the world of a seed."""
    fits: Callable[[Any], bool] = bool
    """Whether a world takes part; decided by its truth, before anything is played."""
    longest: int = 32
    """Tokens of an answer."""


PLACES = {
    "gridworld": OneMove(
        "llf-gridworld-v0", {"num_rooms": 6, "num_objects": 0, "min_goal_dist": 1}, _house_shares, _house, 12
    ),
    "bandits": OneMove("llf-bandits-BanditTenArmedUniformDistributedReward-v0", {"arms": 4}, _arm_shares, longest=12),
    "movies": OneMove("llf-reco-movie-v0", {}, _title_shares),
    "alfworld": OneMove("llf-alfworld-v0", {}, _command_shares),
}
"""By name. In a town its law makes the right action follow from what is seen, in ALFWorld in most houses."""


class Step(NamedTuple):
    """One decision, and what was said before and after it."""

    seed: int
    prompt: list[Message]
    """Without feedback."""
    heard: list[Message]
    """With the teacher's advice, if there was any."""
    advice: str
    answer: str
    reward: float
    regret: float
    success: bool
    failure: str | None
    """Why the answer is no action."""
    verdict: str
    """What the teacher said of the answer."""


class Town:
    """A place in the town of this number: its worlds, and the words that are said there."""

    def __init__(self, name: str, number: int) -> None:
        self.name, self.place, self.number = name, PLACES[name], number
        self.options = {**self.place.options, "town": number}

    @cached_property
    def _env(self) -> StudentEnv:
        return make(self.place.id, text=True, options=self.options)

    @property
    def world(self) -> Any:
        """A world for reading actions, and for its truth."""
        return self._env.session.world

    def seeds(self, first: int, count: int) -> list[int]:
        """The first seeds from `first` on whose worlds take part."""
        return [seed for seed, _ in zip(self._fitting(first), range(count), strict=False)]

    def _fitting(self, seed: int) -> Iterator[int]:
        while True:
            self.world.reset(seed=seed)
            if self.place.fits(self.world):
                yield seed
            seed += 1

    def truth(self, seed: int) -> Any:
        """The truth of the world of a seed."""
        self.world.reset(seed=seed)
        return self.world.truth

    def references(self, seeds: Sequence[int]) -> dict[str, float]:
        """The mean success of each of `REFERENCES` in some worlds."""
        means = np.mean([self.place.shares(self, seed) for seed in seeds], axis=0)
        return dict(zip(REFERENCES, means.tolist(), strict=True))

    def play(
        self,
        policy: Policy,
        seeds: Sequence[int],
        *,
        hears: bool,
        feedback: str = KINDS,
        teacher: str = "oracle",
        voice: str = TRAINING_VOICE,
        phrases: Sequence[int] = TRAINING_PHRASES,
    ) -> list[Step]:
        """Play one turn in the world of each seed, in the order of the seeds.

        Args:
            policy: gives the answers.
            seeds: repeated seeds make a group, whose prompts are equal.
            hears: whether the policy's prompts have the advice.
            feedback, teacher, voice: as in `llf_teacher.make`.
            phrases: indices of paraphrases; the seed decides among them.
        """
        steps: list[Step | None] = [None] * len(seeds)

        def answer(conversations: list[list[Message]]) -> list[str]:
            return policy(conversations if hears else [bare(each) for each in conversations])

        for phrase in phrases:
            places = [place for place, seed in enumerate(seeds) if _phrase(seed, phrases) == phrase]
            if not places:
                continue
            played = rollout(
                answer,
                self.place.id,
                [seeds[place] for place in places],
                batch=BATCH,
                thought=0,
                max_turns=1,
                feedback_type=feedback,
                teacher=teacher,
                voice=voice,
                paraphrase=phrase,
                options=self.options,
            )
            for place, each in zip(places, played, strict=True):
                (turn,) = each.turns
                steps[place] = Step(
                    each.seed,
                    bare(turn.prompt),
                    turn.prompt,
                    advice_in(turn.prompt),
                    turn.answer,
                    turn.reward,
                    turn.regret,
                    turn.success,
                    turn.failure,
                    turn.feedback,
                )
        return [step for step in steps if step is not None]

    def judge(self, seeds: Sequence[int], answers: Sequence[str]) -> list[Step]:
        """Play given answers, one in the world of each seed, as `play` does in training."""
        given = iter(
            [
                answer
                for phrase in TRAINING_PHRASES
                for answer, seed in zip(answers, seeds, strict=True)
                if _phrase(seed) == phrase
            ]
        )
        return self.play(lambda conversations: [next(given) for _ in conversations], seeds, hears=False)

    @cached_property
    def _reader(self) -> ClaimReader:
        return ClaimReader(self._env.family, self.world)

    def advised(self, advice: str) -> str | None:
        """The action that advice names, as an answer; None if it names none. Only the words are read."""
        self._reader.did(None, 0)
        for sentence in self._reader.read(advice):
            if sentence.claim is not None and sentence.claim.kind is FP and isinstance(sentence.claim, ActionClaim):
                return response(worded(self.world, sentence.claim.action))
        return None

    def praised(self, step: Step) -> bool | None:
        """Whether the verdict praises the answer; False if it blames it or finds no action, None if it says neither."""
        action = parse_action(step.answer, self.world)
        if type(action) is ParseFailure:
            return False
        self._reader.did(None, 0)
        self._reader.did(action, 1)
        kinds = {each.claim.kind for each in self._reader.read(step.verdict) if each.claim is not None}
        return True if HP in kinds else False if HN in kinds else None

    def follows(self, step: Step) -> bool:
        """Whether the answer is the action that the advice names."""
        named = self.advised(step.advice)
        if named is None or step.failure is not None:
            return False
        return bool(np.all(parse_action(step.answer, self.world) == parse_action(named, self.world)))

    def random_answer(self, rng: np.random.Generator) -> str:
        """A random action as an answer."""
        return response(written(self.world, rng))


BATCH = 32
"""Conversations at once; results depend on it in the last digits."""


def _phrase(seed: int, phrases: Sequence[int] = TRAINING_PHRASES) -> int:
    return phrases[seed % len(phrases)]


def response(action: str) -> str:
    """An answer in the form that prompts ask for."""
    return f"Response: {action}"


def bare(messages: list[Message]) -> list[Message]:
    """A conversation of one question without the paragraph of feedback."""
    *before, last = messages
    content: str = last["content"]
    if content.startswith(_TEACHER):
        content = content.partition("\n\n")[2]
    return [*before, {**last, "content": content}]


def advice_in(messages: list[Message]) -> str:
    """The feedback in the last question; empty if there is none."""
    content: str = messages[-1]["content"]
    return content.partition("\n\n")[0].removeprefix(_TEACHER) if content.startswith(_TEACHER) else ""


class Signal(NamedTuple):
    """What a model learns from."""

    title: str
    trainer: str
    """`grpo`, `sft` or `dpo`, of TRL."""
    group: int = 1
    """Answers to the same prompt."""
    hears: bool = False
    """Whether the model in training has the advice in its prompt when it acts."""
    teacher: str = "oracle"


SIGNALS = {
    "a": Signal("reward only", "grpo", group=4),
    "b": Signal("imitate the advised action", "sft"),
    "c": Signal("prefer praised to blamed answers", "dpo", group=4),
    "d": Signal("act on advice, distil what was praised", "sft", hears=True),
    "e": Signal("as b, with words about other worlds", "sft", teacher="misaligned"),
    "f": Signal("format alone", "sft"),
    "g": Signal("imitate own rewarded answers", "sft"),
}
"""By letter."""


def examples(letter: str, town: Town, steps: Sequence[Step], rng: np.random.Generator) -> list[dict[str, Any]]:
    """The rows for TRL that a signal makes of some steps: prompts with completions, or with pairs of them.

    (a) needs none: TRL's trainer asks for the reward itself. Pairs, and answers with two prompts, are at most half as
    many as steps, so that all signals learn from about as many texts.
    """
    if letter in "be":
        named = [(step, town.advised(step.advice)) for step in steps]
        return [imitated(step.prompt, answer) for step, answer in named if answer is not None]
    if letter == "c":
        return [*islice(_preferred(town, steps), len(steps) // 2)]
    if letter == "d":
        liked = [step for step in steps if town.praised(step)][: len(steps) // 2]
        return [imitated(prompt, step.answer) for step in liked for prompt in (step.heard, step.prompt)]
    if letter == "f":
        return [imitated(step.prompt, town.random_answer(rng)) for step in steps]
    if letter == "g":
        mean = np.mean([step.reward for step in steps])
        return [imitated(step.prompt, step.answer) for step in steps if step.reward >= mean > 0]
    raise ValueError(f"signal must be one of b, c, d, e, f, g, got {letter!r}; a has no examples")


def _preferred(town: Town, steps: Sequence[Step]) -> Iterator[dict[str, Any]]:
    """In each group as many pairs as the greater of the numbers of praised and of blamed answers."""
    for seed in dict.fromkeys(step.seed for step in steps):
        group = [step for step in steps if step.seed == seed]
        verdicts = [town.praised(step) for step in group]
        good = [step for step, praised in zip(group, verdicts, strict=True) if praised is True]
        bad = [step for step, praised in zip(group, verdicts, strict=True) if praised is False]
        for number in range(max(len(good), len(bad)) if good and bad else 0):
            chosen, rejected = good[number % len(good)], bad[number % len(bad)]
            yield {
                "prompt": chosen.prompt,
                "chosen": [_said(chosen.answer)],
                "rejected": [_said(rejected.answer)],
            }


def imitated(prompt: list[Message], answer: str) -> dict[str, Any]:
    """The row for SFT of an answer to a prompt."""
    return {"prompt": prompt, "completion": [_said(answer)]}


def _said(answer: str) -> Message:
    return {"role": "assistant", "content": answer}


class Rows:
    """The rows of a run, one JSON object a line. Those behind a checkpoint's end are cut off when the run goes on."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def end(self) -> int:
        """Where the file ends, in bytes."""
        return self.path.stat().st_size if self.path.exists() else 0

    def cut(self, end: int) -> None:
        """Drop what was written behind a checkpoint.

        Raises:
            ValueError: the file is shorter: rows are missing.
        """
        if self.end < end:
            raise ValueError(
                f"{self.path} must have at least {end} bytes, got {self.end}; delete its folder and run again"
            )
        if self.end > end:
            os.truncate(self.path, end)

    def add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Append rows, on the disk when it returns."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.writelines(json.dumps(row, ensure_ascii=False) + "\n" for row in rows)
            file.flush()
            os.fsync(file.fileno())

    def read(self) -> list[dict[str, Any]]:
        """All rows."""
        if not self.path.exists():
            return []
        *whole, _ = self.path.read_text("utf-8").split("\n")  # what follows the last end of a line is not whole
        return [json.loads(line) for line in whole]
