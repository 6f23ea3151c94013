"""The settings of a lesson: one frozen value; functions that make environments take it, or its fields as keywords."""

import difflib
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
"""The forms of a teacher's action: its own words, kinds of feedback to voice, or one claim after the other."""
RENDER_MODES = ("ansi", "human", "rgb_array")
"""The modes of rendering: text, a window, an array."""
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
    """The settings of a lesson, apart from its environment.

    Functions that make environments take such a value as `settings`, or its fields as keywords; with both the keywords
    count. They also take a world's options as keywords; type checkers know these only within `options`.

    Raises:
        ValueError: a field's value is not allowed.
    """

    teacher: "str | Personality | Teacher | Any" = "oracle"
    """A personality's spec string, a `Personality` or a `Teacher`, which brings the next four along. In the student's
    environments also any policy with `reset(rng)` and `act(observation, info)` for the teacher's seat, and its spec
    string, such as `my_package.my_module:MyPolicy` or `llm_teacher(model='...')`.
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
    functions call it `max_cycles`.
    """
    text: bool = False
    """Text in, text out for the student."""
    visual: bool = False
    """Images for the student: the world's own images, if it has any; with `text` an `image` beside the text, in every
    family with pictures.
    """
    numbers: bool = False
    """One flat array of numbers for the student, as most learners require; see `pz_envs.numbers`."""
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
    """One flat array of numbers for a teacher that chooses; see `pz_envs.numbers.Flat`. The action mask is in the info;
    in PettingZoo's environments the info then has only numbers, no `moment` or claims.
    """
    until_success: bool = False
    """Whether success ends the episode; it never does where a task is asked repeatedly."""
    ask_cost: float | None = None
    """The student's price of asking, at least 0; None: it cannot ask. See `pz_envs.text.questions`."""
    failure_reward: float | None = None
    """Reward of a text that is no action, in the world's `reward_range`; None: the world's own, too low to exploit."""
    render_mode: str | None = None
    """None, `ansi`, `rgb_array` or `human`, a window."""
    privileged_info: bool = False
    """Show the truth in frames, and whether each claim holds; in the student's environments also put the `moment` into
    the info, and `true`, a tuple beside `atoms`: whether each is true (None: neither, or it cannot be checked), and
    `changes`, the numbers and names that a rewriting voice changed.
    """
    theme: str = "light"
    """The theme of frames: `light` or `dark`."""
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
            raise ValueError("embed= needs numbers=True; set it, or leave out embed=")
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
        for name in ("max_turns", "budget"):  # one of NumPy may overflow
            if (count := getattr(self, name)) is not None:
                object.__setattr__(self, name, int(count))

    def with_teacher(self, teacher: "str | Personality | Teacher | Any") -> Self:
        """The same with another teacher."""
        return replace(self, teacher=teacher)

    @property
    def wording(self) -> TeacherKeywords:
        """The fields that make a teacher of a personality, as keywords."""
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
        """The settings for a function that makes environments.

        Args:
            where: the function's name, for errors.
            keywords: fields and options of the world.
            options: the options that the world has.
            given: settings that the keywords change; None: the defaults. Fields at their default get the function's own
                default.
            others: further arguments of the function, for errors.
            refused: fields that the function does not take.
            elsewhere: names what takes an unknown keyword, to complete the message.
            defaults: fields with other defaults in this function.

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
            taken = elsewhere(unknown_names[0])
            # where it is taken elsewhere, it is probably spelled right
            near = difflib.get_close_matches(unknown_names[0], allowed, cutoff=0.8) if taken else None
            hint = f"{unknown('option', unknown_names[0], allowed, near=near)}{taken}"
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
        ValueError: a value is neither True nor False.
    """
    for name, value in flags.items():
        if not isinstance(value, bool | np.bool_):
            raise ValueError(f"{name} must be True or False, got {value!r}")


_DEFAULT = Settings()


def takes_settings(
    *, without: Iterable[str] = (), names: Mapping[str, str] = MappingProxyType({}), **defaults: Any
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator of functions that make environments: the signature shows the fields of `Settings` for `**settings`.

    Args:
        without: fields that the function does not take.
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
        function.__signature__ = signature.replace(parameters=[*own, *shown, *whole, rest])  # type: ignore[attr-defined]  # for `inspect.signature`
        return function

    return decorate
