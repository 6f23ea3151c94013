"""Picture of poems: the last one, with the number of syllables of each line."""

from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas
from worlds.pictures.themes import LARGE, SMALL
from worlds.poem import Poem, Truth, fits, lines_of, readings

__all__ = ["PoemPicture"]

_LEFT = 16
_DOTTED = 34  # least height of a line with dots
_DOTS = 20  # greatest number of dots; more syllables are shown by number only


class PoemPicture(Picture[Truth, Poem]):
    """The lines, with a dot below for each required syllable; a poem hides nothing."""

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw as many lines as fit."""
        theme, truth = canvas.theme, sight.now
        lines = lines_of(truth.draft)
        wanted = truth.pattern if not truth.free else truth.pattern * max(len(lines), 1)
        right = bool(truth.demands(len(lines)))
        count = max(len(lines), len(wanted))
        step = min((canvas.height - 62) / count, 62)
        number = "any number of lines" if truth.free else f"{len(wanted)} line{'s' * (len(wanted) > 1)}"
        canvas.text((_LEFT, 24), f"{self.lab.form}: {number}", SMALL, theme.muted, most=canvas.width - 120)
        if lines:
            tally = f"{len(lines)} written"
            width = canvas.text((canvas.width - 14, 24), tally, SMALL, theme.muted, anchor="rm")
            canvas.mark((canvas.width - 26 - width, 24), right)
        size = min(step * (0.3 if step >= _DOTTED else 0.5), LARGE)
        for i in range(count):
            y = 44 + i * step
            line = lines[i] if i < len(lines) else ""
            need = wanted[i] if i < len(wanted) else 0
            self._line(canvas, line, need, y, step, size)

    def _line(self, canvas: Canvas, line: str, need: int, y: float, step: float, size: float) -> None:
        theme, dotted = canvas.theme, step >= _DOTTED
        middle = y + step * (0.33 if dotted else 0.5)
        has = _count(line, need) if line else 0
        good = bool(line) and has == need
        label = f"{has} / {need or '-'}" if line else f"{need}"
        width = canvas.text((canvas.width - 14, middle), label, size, theme.ink if line else theme.muted, anchor="rm")
        if line:
            canvas.mark((canvas.width - 26 - width, middle), good, size * 0.36)
        room = canvas.width - 48 - width - _LEFT
        if line:
            canvas.text((_LEFT, middle), line, size, most=room)
        else:
            canvas.dashes([(_LEFT, middle + 6), (_LEFT + room * 0.6, middle + 6)], theme.faint, 1.5)
        if dotted and max(need, has) <= _DOTS:
            for j in range(max(need, has)):
                at = _LEFT + 5 + j * 15, y + step * 0.72
                colour = theme.faint if j >= has else theme.green if j < need else theme.red
                canvas.disc(at, 4.5, colour if j < has else None, colour, 1.5)

    def text(self, sight: Sight[Truth]) -> Text:
        """The lines, each with its number of syllables and the required number."""
        lines = lines_of(sight.now.draft)
        wanted = sight.now.demands(len(lines))
        pieces = []
        for i, line in enumerate(lines):
            need = wanted[i] if wanted else 0
            has = _count(line, need)
            label = f"{has}/{need}" if wanted else f"{has}"
            pieces.append((f"{label:>6}  {line}\n", "good" if wanted and has == need else "bad"))
        return tuple(pieces)


def _count(line: str, need: int) -> int:
    """The number of syllables of a line: the required one if it is possible, else the least possible one."""
    mask = readings(line)
    return need if fits(line, need) else (mask & -mask).bit_length() - 1
