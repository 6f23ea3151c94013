"""The state of a lesson for a seat, as JSON values."""

import io
from itertools import zip_longest
from typing import Any

import jinja2
from gymnasium import spaces
from PIL import Image

from llf_teacher.episodes.live import WATCHER
from llf_teacher.episodes.record import pack_turns, unpack_turns
from llf_teacher.escaping import escape_control_chars
from llf_teacher.theme import prepare_turns
from llf_teacher.theme.turns import bits_words, read_sentence
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.open_lessons import NAMES, OpenLesson
from pz_envs.seats import STUDENT, TEACHER
from teachers.atoms import FeedbackType, Label
from teachers.words import VERDICTS, VerdictWord

_MANY_WORDS = 24  # greatest number of words or actions of a world that get buttons


def state(opened: OpenLesson, seat: str, pages: jinja2.Environment, since: str = "") -> dict[str, Any]:
    """The state of a lesson for a seat.

    Args:
        opened: the lesson.
        seat: the seat.
        pages: the templates, with the macro of a turn.
        since: the `mark` of an earlier state, whose turns are left out; empty: all turns.
    """
    lesson = opened.lesson
    renderer = lesson.renderer(seat)
    checked = seat != STUDENT or lesson.over
    epoch, _, known = since.partition(".")
    now = f"{lesson.undone}{'c' if checked else 'p'}"
    first = min(int(known), len(lesson.rows)) if epoch == now and known.isdecimal() else 0
    mine = lesson.to_move == seat
    moment = lesson.session.moment
    _, (did, _), *world = renderer.text(lesson.view.description())
    last = lesson.rows[-1].atoms if lesson.rows and renderer.heard and checked else []
    told = {atom["text"]: bits_words(atom["information"]) for atom in last if "information" in atom}
    own = _own_words(lesson, pages) if renderer.heard and checked else []
    return {
        "version": opened.version,
        "mark": f"{now}.{len(lesson.rows)}",
        "first": first,
        "turns": _drawn(lesson, first, checked, pages),
        "seat": NAMES.get(seat, seat),
        "turn": moment.turn,
        "most": lesson.session.max_turns,
        "total": round(sum(each.reward for each in renderer.moments), 6) + 0.0,
        "success": moment.success,
        "over": lesson.over,
        "mine": mine,
        "waits": "" if mine or lesson.over else NAMES.get(lesson.to_move, ""),
        "now": escape_control_chars("".join(piece for piece, _ in world)),
        "did": escape_control_chars(did.strip()),
        "said": [
            _sentence(
                pages, spoken.kind, spoken.text, VERDICTS.get(spoken.verdict), moment.turn == 0, told.get(spoken.text)
            )
            for spoken in renderer.sentences
            if renderer.heard and not (own and spoken.verdict is Label.UNCHECKED)
        ]
        + own,
        "heard": renderer.heard,
        "unmeasured": lesson.unmeasured if checked else "",
        "undo": bool(lesson.moves) and lesson.moves[-1][0] == seat,
        **(_to_teach(lesson, pages) if seat == TEACHER and mine else {}),
        **(_to_learn(lesson) if seat == STUDENT else {}),
    }


def _drawn(lesson: PlannedLesson, first: int, checked: bool, pages: jinja2.Environment) -> list[str]:
    """The turns from `first` on, as HTML."""
    macro = pages.get_template("theme/episode.html.j2").module.one_turn  # type: ignore[attr-defined]  # a macro of it
    turns = prepare_turns(unpack_turns(pack_turns(lesson.rows[first:])), lesson.family.name)
    return [escape_control_chars(str(macro(turn, checked))) for turn in turns]


def _sentence(
    pages: jinja2.Environment,
    kind: FeedbackType | None,
    text: str,
    verdict: VerdictWord | None = None,
    opening: bool = False,
    bits: str | None = None,
    code: str = "",
) -> dict[str, str]:
    """A sentence with its kind, its verdict, its information and its claim, and all of these as HTML."""
    macro = pages.get_template("theme/episode.html.j2").module.sentence  # type: ignore[attr-defined]  # a macro of it
    return {
        "kind": f"{kind or ''}",
        "text": escape_control_chars(text),
        "mark": f"{verdict or ''}",
        "html": escape_control_chars(str(macro(kind, text, verdict, opening, code, bits or ""))),
    }


def _own_words(lesson: PlannedLesson, pages: jinja2.Environment) -> list[dict[str, str]]:
    """A person's last own words, sentence by sentence: the claim that was read, and whether it holds."""
    if not lesson.rows:
        return []
    last = lesson.rows[-1]
    said = (read_sentence(each, last.turn, lesson.family.name) for each in last.readings or ())
    return [
        _sentence(pages, each["kind"], each["text"], VERDICTS.get(each["label"]), False, each["note"], each["code"])
        for each in said
    ]


def _to_teach(lesson: PlannedLesson, pages: jinja2.Environment) -> dict[str, Any]:
    """The choices of a teaching person."""
    if lesson.settings.speech == "message":
        return {"suggestion": escape_control_chars(lesson.suggestion()), "understood": _own_words(lesson, pages)}
    listed = lesson.listed()
    measured = lesson.weigh(listed)
    return {
        "claims": [
            _sentence(pages, claim.kind, sentence, bits=bits.described if bits else None)
            for claim, sentence, bits in zip_longest(listed, lesson.sentences(), measured)
        ]
    }


def _to_learn(lesson: PlannedLesson) -> dict[str, Any]:
    """The actions of a learning person."""
    world = lesson.session.world
    words, space = list(world.action_words), world.action_space
    if not words and isinstance(space, spaces.Discrete):
        words = [f"{space.start + number}" for number in range(space.n)]
    return {
        "words": words if len(words) <= _MANY_WORDS else [],
        "expected": escape_control_chars(world.action_syntax),
        "lines": world.several_lines,
    }


def picture(lesson: PlannedLesson, seat: str, theme: str) -> bytes:
    """The world for a seat as a PNG, without the words, which the page shows.

    Raises:
        ValueError: there is no such theme.
    """
    frame = lesson.renderer(seat).with_theme(theme).fine_view(lesson.view.description())
    file = io.BytesIO()
    Image.fromarray(frame).save(file, "png", compress_level=1)  # fast, and a third larger
    return file.getvalue()


def links(opened: OpenLesson, seat: str) -> dict[str, str]:
    """The addresses of the other seats with people, by the names of the seats."""
    shares = opened.lesson.plan.seat == seat and seat != WATCHER
    return {NAMES[other]: f"/seat/{token}" for other, token in opened.tokens.items() if other != seat and shares}
