"""The page of a family: its task, pictures, spaces, rewards and options, and every claim with an example."""

import inspect
import re
from pathlib import Path
from typing import Any

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import PREFIX
from llf_teacher.students.parsing import parse_student
from llf_teacher.theme import kind_mark
from llf_teacher.tools.film import film, save
from llf_teacher.tools.markdown import escape, table
from pz_envs.family import Family
from teachers.atoms import ActionClaim, Claim, EditClaim, PlanClaim
from teachers.oracle import claims_of
from teachers.words import INSTRUCTIONS, KIND_WORDS

__all__ = ["examples", "family_page", "write_film"]

_SEEDS, _TURNS = range(4), 8
_MOST = 200_000  # bytes in a film
_ROLES = {ActionClaim: "an action", PlanClaim: "a plan", EditClaim: "an edit"}


def family_page(family: Family, film: str = "") -> str:
    """The page of a family in MyST's Markdown; Sphinx adds the docstring of the world's class.

    Args:
        family: an installed family.
        film: path of its film, relative to the page; empty if there is none.
    """
    name = family.showcase[0]
    world = family.make_world(**family.environments[name])
    oracle = family.oracle_class()
    kinds = ", ".join(f"{KIND_WORDS[kind]} (`{kind}`)" for kind in oracle.feedback_types)
    facts = [
        ("observation", f"`{world.observation_space}`"),
        ("action", f"`{world.action_space}`; as text {world.action_syntax}"),
        ("reward of a turn", "`{:g}` to `{:g}`".format(*world.reward_range)),
        ("turns", f"{family.max_turns}, {'asked anew in each' if family.repeated else 'or until the world ends it'}"),
        ("instructions", ", ".join(f"{INSTRUCTIONS[each]} (`{each}`)" for each in oracle.instruction_types)),
        ("feedback", kinds),
        ("regret counts", family.regret_unit),
        ("what rewards alone teach", f"`{family.learning}`"),
    ]
    shown = f"![An episode of {PREFIX}{name}]({film})\n\n" if film else ""
    return (
        f"# {family.name}\n\n{family.summary[:1].upper()}{family.summary[1:]}. {_sentence(oracle)}\n\n{shown}"
        f"## The world\n\n```{{eval-rst}}\n.. autoclass:: {type(world).__module__}.{type(world).__name__}\n```\n\n"
        f"{table(('of `' + PREFIX + name + '`', ''), facts)}\n"
        f"## Environments\n\n{_environments(family)}\n"
        f'## Options\n\nThey go through `make`, as in `llf_teacher.make("{PREFIX}{name}", ...)`; the world\'s '
        f"description says what they mean.\n\n{_options(type(world))}\n"
        f"## What its teachers say\n\nEvery claim class, when such a claim is true, and a sentence of one that was "
        f"made; where none was made in a few episodes, a wording with its slots.\n\n{_claims(family)}"
    )


def write_film(family: Family, path: Path) -> None:
    """Write a film of an episode of a family's first showcase, with as many turns as fit into 200 kB."""
    frames = film(
        f"{PREFIX}{family.showcase[0]}",
        student="obedient",
        seed=1,
        teacher="mistake(eps=0.25)" if family.serves("mistake") else "oracle",
        privileged_info=True,
        max_turns=_TURNS,
    )
    while True:
        save(frames, path, 1.2)
        if path.stat().st_size <= _MOST or len(frames) == 1:
            return
        frames = frames[: max(1, len(frames) * 3 // 4)]


def examples(family: Family) -> dict[type[Claim[Any]], str]:
    """A sentence for each class of claims that occurs in a few episodes, clues included, in the first wording."""
    found: dict[type[Claim[Any]], str] = {}
    oracle, book = family.oracle_class(), family.phrasebook()
    wanted = set(claims_of(oracle.__module__))
    for environment in family.showcase:
        for seed in _SEEDS[:1] if family.slow else _SEEDS:
            for spec, instruction in (("random", "p"), ("obedient", "c"), ("wayward(habit='contrary')", "b")):
                if wanted <= found.keys():
                    return found
                if instruction not in oracle.instruction_types:
                    instruction = next(iter(oracle.instruction_types))
                student = parse_student(spec)
                env = StudentEnv(
                    f"{PREFIX}{environment}",
                    instruction_type=instruction,
                    paraphrase=0,
                    text=student.text,
                    max_turns=_TURNS,
                    privileged_info=True,
                )
                for turn in play_turns(env, student.seat(env.family, env.session.world), seed):
                    for atom in turn.atoms:
                        found.setdefault(type(atom.claim), atom.text)
                    for clue in env.session.teacher.oracle.clues(turn.moment.after):
                        found.setdefault(type(clue), book.sentences(clue)[0])
                env.close()
    return found


def _sentence(cls: type) -> str:
    return " ".join((inspect.getdoc(cls) or "").partition("\n\n")[0].split())


def _environments(family: Family) -> str:
    rows = [
        (f"`{PREFIX}{name}`", f"`llf/{name}`", ", ".join(f"`{key}={value!r}`" for key, value in options.items()))
        for name, options in family.environments.items()
    ]
    return table(("Gymnasium", "PettingZoo", "options of the world"), rows)


def _options(world: type) -> str:
    rows = []
    for each in inspect.signature(world).parameters.values():
        if each.name != "render_mode":
            default = "" if each.default is each.empty else f"`{each.default!r}`"
            kind = each.annotation if isinstance(each.annotation, str) else inspect.formatannotation(each.annotation)
            rows.append((f"`{each.name}`", f"`{kind}`" if each.annotation is not each.empty else "", default))
    return table(("option", "type", "default"), rows) if rows else "There are none.\n"


def _claims(family: Family) -> str:
    made, book = examples(family), family.phrasebook()
    rows = []
    for cls in claims_of(family.oracle_class().__module__):
        kind = "as its fields say" if cls.kind and not isinstance(cls.kind, str) else kind_mark(cls.kind)
        role = next((name for base, name in _ROLES.items() if issubclass(cls, base)), "")
        sentence = escape(made.get(cls, book.templates(cls)[0]))
        rows.append((f"`{cls.__name__}`", kind, role, cls.scope, escape(_meaning(cls)), sentence))
    return table(("claim", "kind", "about", "reaches the", "is true if", "for example"), rows)


def _meaning(cls: type) -> str:
    """The first sentence of a class's docstring, or of the nearest base with a docstring in the same module."""
    text = _sentence(cls)
    if issubclass(cls, Claim) and cls.__doc__ is None:
        text = _sentence(next(base for base in cls.__mro__ if base.__doc__ and base.__module__ == cls.__module__))
    return re.sub(r"\s+", " ", text)
