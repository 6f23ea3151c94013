"""Frames of an episode: the picture of the world beside the student's action and the teacher's words."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from teachers.atoms import Atom, FeedbackType, Label, Moment, ParseFailure, Utterance
from teachers.oracle import Oracle
from teachers.session import Turn
from teachers.words import KIND_COLOURS, VERDICTS, kind_word
from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas, Frame, height_of
from worlds.pictures.themes import LARGE, MEDIUM, SMALL, THEMES, Theme
from worlds.world import World, WorldTurn

__all__ = ["HEIGHT", "VIEW", "WIDTH", "EpisodeRenderer", "SpokenSentence", "format_action", "tile_frames"]

WIDTH, HEIGHT = 640, 480
"""Size of a frame, in pixels."""
_BAR, _MARGIN = 38, 12
_PICTURE = 384  # width of the world's picture
_COLUMN = WIDTH - _PICTURE - _MARGIN
VIEW = (HEIGHT - _BAR, _PICTURE, 3)
"""Shape of the world's picture alone."""
_SIZES = (MEDIUM, SMALL)
_ROOM_BELOW, _MORE = 8, 20
_HEAD = 1.75  # height of a sentence's tag, in sizes of the font
_LEAST = _HEAD + 1.32  # height of a line of a sentence
_TILES = 4  # more frames than this are shown at half their size


class SpokenSentence(NamedTuple):
    """A sentence of a teacher."""

    text: str
    kind: FeedbackType | None
    verdict: Label
    speaker: str = ""
    remark: str = ""
    """A note that frames show beside the sentence's kind."""


class EpisodeRenderer:
    """Observes a session and renders its episode, as a frame or as text.

    Args:
        name: the subject's name.
        picture: draws the world.
        oracle: plans, if the truth is shown; not the teacher's oracle, since a query may change its state.
        lab: a scratch world for checks of claims.
        max_turns: the student's turns in an episode.
        theme: `light` or `dark`.
        privileged: whether frames show the truth, and whether each claim holds.

    Raises:
        ValueError: there is no such theme.
    """

    def __init__(
        self,
        name: str,
        picture: Picture[Any],
        oracle: Oracle[Any, Any],
        lab: World[Any],
        *,
        max_turns: int,
        theme: str = "light",
        privileged: bool = False,
    ) -> None:
        self.name, self.picture, self.oracle, self.lab = name, picture, oracle, lab
        self.max_turns, self.theme, self.privileged = max_turns, _theme(theme), privileged
        self.moments: list[Moment[Any]] = []
        self.sentences: tuple[SpokenSentence, ...] = ()
        """The teacher's last sentences."""
        self.turns: list[WorldTurn[Any]] = []
        """The moments in the form that the picture takes."""
        self.heard = False
        """Whether `sentences` are about the last turn."""

    def begin(self, moment: Moment[Any], atoms: Sequence[Atom] = ()) -> None:
        """An episode begins or is resumed; the teacher has already said `atoms` about its last moment."""
        self.moments, self.turns = [moment], [WorldTurn(None, 0.0, moment.after, moment.success)]
        self.oracle.start(moment.after)
        self.sentences, self.heard = self._checked(atoms), bool(atoms)

    def acted(self, moment: Moment[Any]) -> None:
        """The student has acted."""
        self.moments.append(moment)
        action = None if moment.before is None else moment.action
        self.turns.append(WorldTurn(action, moment.reward, moment.after, moment.success))
        self.heard = False

    def said(self, words: str, turn: Turn) -> None:
        """The student has heard these words, which complete the turn."""
        own = words.atoms if isinstance(words, Utterance) else ()
        atoms = turn.atoms
        self.sentences, self.heard = self._checked(atoms), True
        if words and words != Utterance.of(own):  # words without atoms cannot be checked
            self.sentences = (
                *self._checked(atoms[: len(atoms) - len(own)]),
                SpokenSentence(words, None, Label.UNCHECKED),
            )

    def remark(self, remarks: Mapping[str, str]) -> None:
        """Set what frames show beside the last sentences, by their texts."""
        self.sentences = tuple(each._replace(remark=remarks.get(each.text, "")) for each in self.sentences)

    def _checked(self, atoms: Sequence[Atom]) -> tuple[SpokenSentence, ...]:
        return tuple(SpokenSentence(atom.text, atom.kind, self._verdict(atom), atom.speaker) for atom in atoms)

    def _verdict(self, atom: Atom) -> Label:
        """The label of a claim, if labels are shown and all turns of the episode are known."""
        moments = self.moments
        known = len(moments) == moments[-1].turn + 1
        return atom.label(moments, self.lab) if self.privileged and known else Label.UNCHECKED

    def without_truth(self) -> "EpisodeRenderer":
        """A copy that shows only what the student may see; valid until the session goes on."""
        plain = copy.copy(self)
        plain.privileged = False
        plain.sentences = tuple(spoken._replace(verdict=Label.UNCHECKED) for spoken in self.sentences)
        return plain

    def with_theme(self, theme: str) -> "EpisodeRenderer":
        """A copy in a theme; valid until the session goes on.

        Raises:
            ValueError: there is no such theme.
        """
        shown = copy.copy(self)
        shown.theme = _theme(theme)
        return shown

    def sight(self, seen: str) -> Sight[Any]:
        """The input of the picture; `seen` is the text that the student observes."""
        reach = self.picture.reach if self.privileged else 0
        plan = self.oracle.plan(self.moments[-1].after, reach) if reach else ()
        return Sight(tuple(self.turns), seen, self.privileged, tuple(plan))

    def text(self, seen: str) -> Text:
        """The turn, the student's action and the world as text, in pieces, each with its style."""
        moment = self.moments[-1]
        left = self.max_turns - moment.turn
        status = f"Turn {moment.turn} of {self.max_turns}, {left} left; reward {self._total_reward():.4g} in all\n"
        did = (
            ""
            if not moment.turn
            else f"The student: {format_action(moment.action, self.lab)} (reward {moment.reward + 0.0:.4g})\n"
        )
        return (status, "muted"), (did, "action"), *self.picture.text(self.sight(seen))

    def _total_reward(self) -> float:
        return sum(moment.reward for moment in self.moments) + 0.0  # avoids -0.0

    def view(self, seen: str) -> Frame:
        """The world alone, without the truth, uint8 of the shape `VIEW`."""
        canvas = Canvas(VIEW[1], VIEW[0], self.theme)
        self.picture.draw(canvas, Sight(tuple(self.turns), seen))
        return canvas.pixels()

    def fine_view(self, seen: str) -> Frame:
        """The world alone at twice that size, with the truth if frames show it; for pages with words of their own."""
        canvas = Canvas(VIEW[1], VIEW[0], self.theme)
        self.picture.draw(canvas, self.sight(seen))
        return canvas.fine_pixels()

    def frame(self, seen: str) -> Frame:
        """The frame of the last turn, uint8 (480, 640, 3)."""
        canvas = Canvas(WIDTH, HEIGHT, self.theme)
        self.draw(canvas, seen)
        return canvas.pixels()

    def draw(self, canvas: Canvas, seen: str) -> None:
        """Draw the frame on a canvas of the frame's size."""
        self.picture.draw(canvas.part(0, _BAR, _PICTURE, HEIGHT - _BAR), self.sight(seen))
        # The bar and the column cover what a picture has drawn beyond its edges.
        canvas.box((_PICTURE, _BAR), (WIDTH - _PICTURE, HEIGHT - _BAR), self.theme.card)
        canvas.line([(_PICTURE, _BAR), (_PICTURE, HEIGHT)], self.theme.faint)
        self._bar(canvas)
        self._column(canvas.part(_PICTURE + _MARGIN, _BAR, _COLUMN - _MARGIN, HEIGHT - _BAR))

    def _bar(self, canvas: Canvas) -> None:
        """The bar: name, turn and rewards."""
        theme, moment = self.theme, self.moments[-1]
        canvas.box((0, 0), (WIDTH, _BAR), theme.card)
        canvas.line([(0, _BAR), (WIDTH, _BAR)], theme.faint)
        middle = _BAR / 2
        width = canvas.text((_MARGIN, middle), self.name, LARGE, bold=True, most=_PICTURE - 110)
        if moment.success:
            canvas.tag((_MARGIN * 2 + width, middle), "solved", theme.green)
        elif moment.over:
            canvas.tag((_MARGIN * 2 + width, middle), "over", theme.muted)
        canvas.text((_PICTURE + _MARGIN, middle), f"turn {moment.turn} of {self.max_turns}", MEDIUM)
        canvas.text((WIDTH - _MARGIN, middle), f"total {self._total_reward():.4g}", MEDIUM, theme.muted, anchor="rm")

    def _column(self, canvas: Canvas) -> None:
        """The column: the student's action and the teacher's sentences."""
        theme, moment, y = self.theme, self.moments[-1], 10.0
        if moment.turn:
            canvas.text((0, y), "The student", SMALL, theme.muted, anchor="lt")
            canvas.text((canvas.width, y), f"reward {moment.reward + 0.0:.4g}", SMALL, theme.muted, anchor="rt")
            y = canvas.paragraph((0, y + 17), format_action(moment.action, self.lab), canvas.width, 44, MEDIUM)
            y += _ROOM_BELOW
            canvas.line([(0, y), (canvas.width, y)], theme.faint)
            y += _ROOM_BELOW
        if self.sentences or self.heard:
            canvas.text(
                (0, y), "The teacher" if self.heard else "The teacher had said", SMALL, theme.muted, anchor="lt"
            )
            y += 21
        if self.heard and not self.sentences:
            canvas.text((0, y), "(silence)", MEDIUM, theme.muted, anchor="lt")
        room, width = canvas.height - y - _ROOM_BELOW, canvas.width
        size = next((size for size in _SIZES if self._height(size, width) <= room), _SIZES[-1])
        for i, sentence in enumerate(self.sentences):
            left = canvas.height - y - _ROOM_BELOW - (_MORE if i + 1 < len(self.sentences) else 0)
            if left < size * _LEAST:
                canvas.text((0, y), f"… {len(self.sentences) - i} more", SMALL, theme.muted, anchor="lt")
                return
            y = self._sentence(canvas, y, sentence, size, left)

    def _height(self, size: float, width: float) -> float:
        return sum(size * 2.3 + height_of(sentence.text, size, width) for sentence in self.sentences)

    def _sentence(self, canvas: Canvas, y: float, sentence: SpokenSentence, size: float, room: float) -> float:
        """A sentence below its tag; returns the y of the next one."""
        theme, middle = self.theme, y + size * 0.72
        colour = getattr(theme, KIND_COLOURS[sentence.kind]) if self.heard else theme.muted
        x = canvas.tag((0, middle), kind_word(sentence.kind, self.moments[-1].turn == 0), colour, SMALL - 1)
        if beside := " ".join(filter(None, (sentence.speaker, sentence.remark))):
            canvas.text((x + 6, middle), beside, SMALL, theme.muted)
        if (verdict := VERDICTS.get(sentence.verdict)) is not None:
            ink = {True: theme.green, False: theme.red, None: theme.muted}[verdict.holds]
            bold = verdict.holds is False
            taken = canvas.text((canvas.width, middle), verdict.word, SMALL, ink, anchor="rm", bold=bold)
            if verdict.holds is not None:
                canvas.mark((canvas.width - taken - 9, middle), verdict.holds, 4.5)
        ink = theme.ink if self.heard else theme.muted
        below = canvas.paragraph((0, y + size * _HEAD), sentence.text, canvas.width, room - size * _HEAD, size, ink)
        return below + size * 0.55


def _theme(name: str) -> Theme:
    if name not in THEMES:
        raise ValueError(f"theme {name!r} is unknown; allowed: {', '.join(THEMES)}")
    return THEMES[name]


def format_action(action: Any, world: World[Any]) -> str:
    """A student's action as text, by its name if the world names its actions."""
    if isinstance(action, ParseFailure):
        return f"(not understood) {action.got}"
    names = getattr(world, "names", None)
    if isinstance(names, Mapping) and action in names:
        return str(names[action])
    if isinstance(action, tuple) and all(isinstance(each, float) for each in action):
        return f"[{', '.join(f'{each:.3g}' for each in action)}]"
    return f"{action}"


def tile_frames(frames: Sequence[Frame]) -> Frame:
    """Frames side by side, in rows; more than four at half their size."""
    if len(frames) > _TILES:
        shrunk = [np.asarray(Image.fromarray(frame).reduce(2)) for frame in frames]
    else:
        shrunk = list(frames)
    columns = int(np.ceil(np.sqrt(len(shrunk))))
    rows = -(-len(shrunk) // columns)
    shrunk += [np.zeros_like(shrunk[0])] * (rows * columns - len(shrunk))
    return np.concatenate([np.concatenate(shrunk[i * columns : (i + 1) * columns], 1) for i in range(rows)])
