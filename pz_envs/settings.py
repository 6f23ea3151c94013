"""The settings of a lesson: one frozen value, which every door takes, or its fields as keywords."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ParamSpec, Self, TypedDict, TypeVar

import numpy as np

from teachers.spec import check_cost, is_count, unknown

if TYPE_CHECKING:
    from pz_envs.numbers import Embed
    from pz_envs.rewards import TeacherReward
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase
    from teachers.teacher import Teacher
    from teachers.voice import Voice

__all__ = ["SPEECHES", "Settings", "SettingsKeywords", "TeacherKeywords", "check_flags", "takes_settings"]

SPEECHES = ("message", "kinds", "claims")
"""What a teacher's action can be: its own words, kinds of feedback to voice, or one claim after the other."""
RENDER_MODES = ("ansi", "human", "rgb_array")
"""What an environment can render: text, a window, an array."""
THEMES = ("light", "dark")

P = ParamSpec("P")
R = TypeVar("R")


class TeacherKeywords(TypedDict, total=False):
    """The fields of `Settings` that make a teacher, as keywords."""

    instruction_type: str
    feedback_type: str | Iterable[str]
    voice: "Voice"
    paraphrase: "Paraphrase"


class SettingsKeywords(TeacherKeywords, total=False):
    """The fields of `Settings` as keywords, for editors and type checkers."""

    teacher: "str | Personality | Teacher | Any"
    max_turns: int | None
    text: bool
    visual: bool
    numbers: bool
    embed: "Embed | None"
    speech: str
    cost: float
    budget: int | None
    teacher_reward: "str | TeacherReward"
    teacher_numbers: bool
    until_success: bool
    ask_cost: float | None
    failure_reward: float | None
    render_mode: str | None
    privileged_info: bool
    theme: str
    options: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What a lesson is, but for its environment.

    Doors take such a value as `settings`, or its fields as keywords, and with both the
    keywords count. They take a world's options as keywords, too; type checkers know these only within `options`.

    Raises:
        ValueError: a field's value is not allowed.
    """

    teacher: "str | Personality | Teacher | Any" = "oracle"
    """A personality's spec string, a `Personality` or a `Teacher`, which brings the next four along. In the student's
    environments also any policy with `reset(rng)` and `act(observation, info)` for the teacher's seat.
    """
    instruction_type: str = "b"
    """`b` basic, `p` with hindsight on some tried actions, `c` complete."""
    feedback_type: str | Iterable[str] = "a"
    """What may be said: `a` all kinds, `n` none, `m` a random subset each turn, or kinds among r, hp, hn, fp, fn, as
    `"r+hp"`, a set, a list or a tuple.
    """
    voice: "Voice" = "plain"
    """The tone: `plain`, `curt`, `socratic`, `warm`, the path of a voice of your own, or a function that rewrites a
    sentence.
    """
    paraphrase: "Paraphrase" = "random"
    """How a wording is chosen: `"random"`, an index, or a function `(templates, **slots) -> str`."""
    max_turns: int | None = None
    """Actions of the student after which an episode is truncated, at least 1; None: the family's number. PettingZoo's
    doors call it `max_cycles`.
    """
    text: bool = False
    """Text in, text out for the student."""
    visual: bool = False
    """Images for the student: those of the world itself if it has any; with `text` an `image` beside the text, of every
    family that is drawn.
    """
    numbers: bool = False
    """One flat array of numbers for the student, as most learners want it; see `pz_envs.numbers`."""
    embed: "Embed | None" = None
    """With `numbers`, a function that gives the vector of a text, always of the same length; environments whose states
    or actions are texts need it.
    """
    speech: str = "message"
    """What the teacher's action is: `message`, `kinds` or `claims`. With the last two the personality says what can be
    chosen, with `message` it makes suggestions.
    """
    cost: float = 0.01
    """Paid by the teacher per atom of feedback, at least 0."""
    budget: int | None = None
    """Atoms of feedback that the teacher may say in an episode, or in a lifetime; None: any number."""
    teacher_reward: "str | TeacherReward" = "student_reward"
    """The teacher's reward of a student's turn: `student_reward`, `student_progress`, `success_minus_cost`, or a
    function of the `Moment` and the `Oracle`; see `pz_envs.rewards`.
    """
    teacher_numbers: bool = False
    """One flat array of numbers for a teacher that chooses; see `pz_envs.numbers.Flat`. The mask of its actions is in
    the info, which in PettingZoo's environments has no `moment` or claims then, but numbers alone.
    """
    until_success: bool = False
    """Whether success ends the episode; it never does where a task is asked repeatedly."""
    ask_cost: float | None = None
    """What the student pays for asking, at least 0; None: it cannot ask. See `pz_envs.text.questions`."""
    failure_reward: float | None = None
    """Reward of a text that is no action, in the world's `reward_range`; None: the world's own, too low to exploit."""
    render_mode: str | None = None
    """None, `ansi`, `rgb_array` or `human`, a window."""
    privileged_info: bool = False
    """Show the truth in frames, and whether what was said holds; in the student's environments also put the `moment`
    into the info, and `changes`, what a rewriting voice did to numbers and names.
    """
    theme: str = "light"
    """Of frames: `light` or `dark`."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """The world's options; a copy is kept."""

    def __post_init__(self) -> None:
        if not isinstance(self.options, Mapping):
            raise ValueError(f"options must be a mapping of the world's options, got {self.options!r}")
        object.__setattr__(self, "options", {**self.options})
        check_flags(**{name: getattr(self, name) for name in _FLAGS})
        if self.text and self.numbers:
            raise ValueError("text=True and numbers=True exclude each other; set one of them")
        if self.embed is not None and not self.numbers:
            raise ValueError("embed= makes numbers of words; it needs numbers=True")
        if self.max_turns is not None and not is_count(self.max_turns):
            raise ValueError(f"max_turns (or max_cycles) must be an integer of at least 1, got {self.max_turns!r}")
        for name, allowed in (("speech", SPEECHES), ("theme", THEMES)):
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} {getattr(self, name)!r} is unknown; allowed: {', '.join(allowed)}")
        if self.render_mode not in (None, *RENDER_MODES):
            allowed_modes = ", ".join(RENDER_MODES)
            raise ValueError(f"render_mode {self.render_mode!r} is unknown; allowed: None, {allowed_modes}")
        check_cost("cost", self.cost)
        if self.ask_cost is not None:
            check_cost("ask_cost", self.ask_cost)
        if self.budget is not None and not is_count(self.budget):
            raise ValueError(f"budget must be None or an integer of at least 1, got {self.budget!r}")

    def with_teacher(self, teacher: "str | Personality | Teacher | Any") -> Self:
        """The same with another teacher."""
        return replace(self, teacher=teacher)

    @property
    def wording(self) -> TeacherKeywords:
        """What makes a teacher of a personality, as keywords."""
        return {
            "instruction_type": self.instruction_type,
            "feedback_type": self.feedback_type,
            "voice": self.voice,
            "paraphrase": self.paraphrase,
        }

    @classmethod
    def of(
        cls,
        where: str,
        keywords: Mapping[str, Any],
        options: Iterable[str],
        *,
        given: Self | None = None,
        others: Iterable[str] = (),
        refused: Iterable[str] = (),
        elsewhere: Callable[[str], str] = lambda _: "",
        **defaults: Any,
    ) -> Self:
        """The settings that a door was given.

        Args:
            where: what takes them, for errors.
            keywords: fields and options of the world.
            options: the options that the world has.
            given: settings that the keywords change; None: the defaults. Where they have the default of a field, the
                door's own default counts.
            others: what the door takes besides, for errors.
            refused: fields that the door does not take.
            elsewhere: says of an unknown keyword what takes it, to complete the message.
            defaults: fields whose defaults are others at this door.

        Raises:
            ValueError: a keyword is unknown, or a value is not allowed.
        """
        refused = set(refused)
        names = FIELDS - refused
        own = {name: value for name, value in keywords.items() if name in names}
        if not isinstance(own.get("options", {}), Mapping):
            raise ValueError(f"options must be a mapping of the world's options, got {own['options']!r}")
        more = {name: value for name, value in keywords.items() if name not in names}
        known = set(options)
        if unknown_names := [name for name in more if name not in known | refused]:
            allowed = sorted((names | known | set(others)) - {"options"})
            hint = f"{unknown('option', unknown_names[0], allowed)}{elsewhere(unknown_names[0])}"
            raise ValueError(f"{where} does not take these options: {hint}")
        if given is not None and not isinstance(given, cls):
            raise ValueError(f"settings must be a {cls.__name__}, got {given!r}")
        base = cls() if given is None else given
        base = replace(base, **{n: value for n, value in defaults.items() if getattr(base, n) == getattr(_DEFAULT, n)})
        changed = {name for name in refused if getattr(base, name) != getattr(_DEFAULT, name)}
        if unused := sorted(changed | (refused & keywords.keys())):
            raise ValueError(f"{where} does not use {unused[0]} from this seat; leave it out")
        world = {**base.options, **own.pop("options", {}), **more}
        return replace(base, **own, options=world)


_FLAGS = ("privileged_info", "visual", "text", "numbers", "teacher_numbers", "until_success")
FIELDS = frozenset(each.name for each in fields(Settings))
"""The names of the fields."""


def check_flags(**flags: Any) -> None:
    """Check switches.

    Raises:
        ValueError: one is neither True nor False.
    """
    for name, value in flags.items():
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"{name} must be True or False, got {value!r}")


_DEFAULT = Settings()


def takes_settings(
    *, without: Iterable[str] = (), names: Mapping[str, str] = MappingProxyType({}), **defaults: Any
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator of doors: their signature shows the fields of `Settings` in place of `**settings`.

    Args:
        without: fields that the door does not take.
        names: fields that have another name there.
        defaults: fields that have another default there.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)
        own = [each for each in signature.parameters.values() if each.kind != each.VAR_KEYWORD]
        whole = [own.pop([each.name for each in own].index("settings"))]
        taken = {each.name for each in own} | set(without)
        shown = [
            inspect.Parameter(
                names.get(each.name, each.name),
                inspect.Parameter.KEYWORD_ONLY,
                default=defaults.get(each.name, getattr(_DEFAULT, each.name)),
                annotation=each.type,
            )
            for each in fields(Settings)
            if each.name not in taken and each.name != "options"
        ]
        rest = inspect.Parameter("options", inspect.Parameter.VAR_KEYWORD, annotation=Any)
        function.__signature__ = signature.replace(parameters=[*own, *shown, *whole, rest])  # type: ignore[attr-defined]  # what `inspect.signature` looks for
        return function

    return decorate
