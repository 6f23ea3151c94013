"""Picture of movies: the wishes, and the titles that were recommended last."""

from collections.abc import Sequence

import numpy as np

from worlds.movies import ATTRIBUTES, Movies, Profile, Truth, draw_profile, titles_of
from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas
from worlds.pictures.themes import MEDIUM, SMALL
from worlds.world import WorldTurn

__all__ = ["MoviesPicture"]

_COLUMN = 46
_ROWS = 12


class MoviesPicture(Picture[Truth, Movies]):
    """A row per title, a column per wish: whether it is met, as far as it is known; if privileged, in all cells."""

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the stated wishes and the first titles; the unstated wish only if privileged."""
        theme, (profile, unsaid, _, answer, _) = canvas.theme, sight.now
        wishes = [each for each in ATTRIBUTES if each in profile.wishes and (sight.privileged or each != unsaid)]
        y = 20.0
        for wish in wishes:
            hidden = wish == unsaid
            colour = theme.orange if hidden else theme.blue
            width = canvas.tag((14, y), wish, colour)
            words = profile.words(wish) + (" (not said)" if hidden else "")
            canvas.text((22 + width, y), words, MEDIUM, most=canvas.width - width - 40)
            y += 24
        titles = titles_of(answer)
        canvas.line([(14, y), (canvas.width - 14, y)], theme.faint)
        left = canvas.width - 14 - _COLUMN * len(wishes)
        y += 18
        for i, wish in enumerate(wishes):
            name = "rated" if " " in wish else wish
            canvas.text((left + (i + 0.5) * _COLUMN, y), name, SMALL, theme.muted, anchor="mm")
        if titles:
            met = round((sight.turns[-1].reward + 1) * len(titles))
            canvas.text((14, y), f"{met} of {len(titles)} meet all", SMALL, theme.muted)
        else:
            canvas.text((14, y), "no titles yet" if len(sight.turns) < 2 else "an empty list", SMALL, theme.muted)
        for title in titles[:_ROWS]:
            y += 27
            canvas.line([(14, y - 13), (canvas.width - 14, y - 13)], theme.faint)
            canvas.text((14, y), title, MEDIUM, most=left - 24)
            for i, wish in enumerate(wishes):
                met_it = self._meets(sight, title, wish)
                at = left + (i + 0.5) * _COLUMN, y
                if met_it is None:
                    canvas.text(at, "?", SMALL, theme.muted, anchor="mm")
                else:
                    canvas.mark(at, met_it)
        if len(titles) > _ROWS:
            canvas.text((14, y + 25), f"… {len(titles) - _ROWS} more", SMALL, theme.muted)

    def _meets(self, sight: Sight[Truth], title: str, wish: str) -> bool | None:
        """Whether a title meets a wish; None if unknown, since the reward only tells how many titles fit."""
        if sight.privileged:
            return self.lab.catalogue.meets(title, (sight.now.profile.wishes[wish],))
        return True if sight.turns[-1].reward == 0.0 else None

    def text(self, sight: Sight[Truth]) -> Text:
        """The request, and the titles below it."""
        titles = titles_of(sight.now.answer)
        role = "good" if titles and sight.turns[-1].reward == 0.0 else ""
        return (f"{sight.seen}\n", ""), *((f"  {title}\n", role) for title in titles)

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """A user with another unstated wish."""
        profile, unsaid = turns[0].truth.profile, turns[0].truth.unsaid
        while unsaid not in (other := draw_profile(rng)).wishes:
            pass
        name = dict(zip(ATTRIBUTES, Profile._fields, strict=True))[unsaid]
        changed = profile._replace(**{name: getattr(other, name)})
        return [turn._replace(truth=turn.truth._replace(profile=changed)) for turn in turns]
