"""Pictures: the canvas, and what each family's picture knows."""

import numpy as np
import pytest

from worlds.alfworld.world import Alfworld
from worlds.bandits import Bandit
from worlds.gridworld import Direction, Gridworld
from worlds.movies import Movies, answer_of
from worlds.optimization import world as optimization
from worlds.pictures import Sight
from worlds.pictures.alfworld import AlfworldPicture
from worlds.pictures.bandits import BanditPicture
from worlds.pictures.canvas import Canvas, cut, height_of, listed, measure, wrap
from worlds.pictures.gridworld import GridworldPicture
from worlds.pictures.movies import MoviesPicture
from worlds.pictures.optimization import OptimizationPicture
from worlds.pictures.poem import PoemPicture
from worlds.pictures.testing import picture_of
from worlds.pictures.themes import MEDIUM, THEMES, contrast
from worlds.poem import Poem
from worlds.world import WorldTurn

WORDS = "Keep away from [0.02, 0.69, 0.22, 1], which would take the hand far from where it is wanted. A\n\nnew line."


def played(world, *actions, seed=0):
    """The steps of a world with these actions."""
    world.reset(seed=seed)
    steps = [WorldTurn(None, 0.0, world.truth)]
    for action in actions:
        legal = world.legal(action)
        _, reward, _, _, info = world.advance(legal)
        steps.append(WorldTurn(legal, reward, world.truth, info["success"]))
    return tuple(steps)


def text(picture, steps, **settings):
    return "".join(piece for piece, _ in picture.text(Sight(steps, "(seen)", **settings)))


def canvas(theme="light"):
    return Canvas(100, 60, THEMES[theme])


@pytest.mark.parametrize("width", [40, 90, 300])
def test_no_line_is_wider_than_it_may_be(width):
    lines = wrap(WORDS, 13, width)
    assert all(measure(line, 13) <= width + 1 for line in lines)
    assert "".join("".join(lines).split()) == "".join(WORDS.split())
    assert height_of(WORDS, 13, width) == pytest.approx(len(lines) * 13 * 1.32)


def test_words_that_are_too_long_are_cut():
    assert cut("a short one", 13, 500) == "a short one"
    assert cut("a line that is too long", 13, 60).endswith("…")
    assert measure(cut("a line that is too long", 13, 60), 13) <= 60
    assert cut("anything", 13, 1) == ""
    assert cut("\x1b[31m\u202e", 13, 500) == "\N{REPLACEMENT CHARACTER}[31m\N{REPLACEMENT CHARACTER}"


def test_parts_are_drawn_on_the_whole():
    whole = canvas()
    whole.part(50, 20, 30, 30).box((0, 0), (10, 10), "#ff0000")
    pixels = whole.pixels()
    assert pixels.shape == (60, 100, 3)
    red = np.argwhere((pixels == (255, 0, 0)).all(2))
    assert red.min(0).tolist() == [20, 50]
    assert red.max(0).tolist() == [29, 59]


def test_a_paragraph_keeps_to_its_room():
    page = canvas()
    assert page.paragraph((0, 0), WORDS, 90, 40) == pytest.approx(2 * MEDIUM * 1.32)
    assert (page.pixels()[40:] == page.pixels()[59, 99]).all()


def test_a_dash_is_as_long_as_it_is_said_to_be():
    page = canvas()
    page.dashes([(0, 30), (100, 30)], "#000000", 2, dash=10, gap=10)
    dark = (page.pixels()[30] < 128).all(1)
    assert 40 <= dark.sum() <= 60
    page.dashes([(5, 5), (5, 5)], "#000000")  # of no length


def test_what_does_not_fit_a_line_is_counted():
    rooms = ["a bowl", "a cup", "a plate"]
    assert listed(rooms, 12, 500) == "a bowl, a cup, a plate"
    assert listed(rooms, 12, measure("a bowl, +2", 12) + 1) == "a bowl, +2"
    assert listed(rooms, 12, 50) == "3 in all"
    assert listed([], 12, 50) == ""


@pytest.mark.parametrize("mode", THEMES)
def test_tags_are_legible(mode):
    """Their text is black or white, whichever has more contrast with the theme's colours."""
    theme = THEMES[mode]
    for colour in (theme.blue, theme.green, theme.orange, theme.red, theme.purple, theme.muted):
        tag = Canvas(60, 20, theme)
        tag.tag((2, 10), "III", colour)
        shown = {tuple(pixel) for pixel in tag.pixels()[5:15, 8:30].reshape(-1, 3).tolist()}
        inks = [ink for ink, pixel in (("#000000", (0, 0, 0)), ("#ffffff", (255, 255, 255))) if pixel in shown]
        assert [contrast(ink, colour) >= 4.5 for ink in inks] == [True]


def test_a_map_has_the_rooms_that_one_knows():
    world = Gridworld()
    picture = GridworldPicture(world.scratch())
    world.reset(seed=7)
    way = [d for d in Direction if world.truth.layout.doors[world.truth.room][d] >= 0][:1]
    steps = played(world, *way, seed=7)
    layout, (before, now) = world.truth.layout, (step.truth.room for step in steps)
    shown = text(picture, steps)
    assert f"[{layout.names[now]}]" in shown
    known = {before, now, *layout.doors[before], *layout.doors[now]} - {-1}
    assert {name for name in layout.names if name in shown} == {layout.names[room] for room in known}
    assert layout.names[layout.treasure] not in shown
    whole = text(picture, steps, privileged=True)
    assert f"*{layout.names[layout.treasure]}*" in whole
    assert all(name in whole for name in layout.names)


def test_arms_have_their_pulls_and_payouts():
    world = Bandit("TwoArmedDeterministicFixed")
    steps = played(world, 0, 1, 1)
    told = [f"arm {arm}: pulls {count}, mean payout {world.truth.means[arm]:g}\n" for arm, count in ((0, 1), (1, 2))]
    assert text(BanditPicture(world), steps) == "".join(told)


def test_lines_have_their_syllables():
    world = Poem()
    picture = PoemPicture(world)
    steps = played(world, "rain taps on the tin\nsnow\none cup on the sill")
    assert text(picture, steps) == "   5/5  rain taps on the tin\n   1/7  snow\n   5/5  one cup on the sill\n"
    assert [role for _, role in picture.text(Sight(steps, ""))] == ["good", "bad", "good"]
    assert text(picture, played(world, "snow")) == "     1  snow\n"


def test_titles_are_marked_when_all_of_them_fit():
    world = Movies()
    world.reset(seed=0)
    fitting = world.catalogue.fitting(world.truth.profile.wishes.values())
    right = answer_of([world.catalogue.items[i].label for i in fitting[:2]])
    picture = MoviesPicture(world.scratch())
    for answer, role in ((right, "good"), (answer_of(["Nothing of the Kind"]), "")):
        _, *titles = picture.text(Sight(played(world, answer), "please"))
        assert {each for _, each in titles} == {role}


def test_the_unsaid_wish_is_for_the_privileged():
    world = Movies()
    picture = MoviesPicture(world.scratch())
    steps = played(world, answer_of(["Heat"]))
    plain, privileged = (picture_of(picture, Sight(steps, "", each)) for each in (False, True))
    assert not np.array_equal(plain, privileged)


def test_places_are_known_when_one_has_looked_into_them():
    world = Alfworld(games="generated")
    world.reset(seed=3)
    picture = AlfworldPicture(world.scratch())
    house = world._engine.house
    closed = next(each for each in house.place if each in house.openable)
    name = house.name[closed]
    for commands, known in ((["look"], False), ([f"go to {name}"], False), ([f"go to {name}", f"open {name}"], True)):
        steps = played(world, *commands, seed=3)
        assert (f"{name}: " in text(picture, steps)) == known, commands
    inside = [house.name[each] for each in world._engine.inside[closed]]
    assert f"{name}: {', '.join(inside) or 'nothing'}\n" in text(picture, steps)


def test_the_map_of_a_loss_is_darkest_where_it_is_least():
    world = optimization.Optimization("Booth")
    steps = played(world)
    picture = OptimizationPicture(world.scratch())
    plain, seen = (picture_of(picture, Sight(steps, "", each)) for each in (False, True))
    (low1, low2), (high1, high2), (x1, x2) = world.lows, world.highs, world.loss.minimisers[0]
    side = min(384 - 62, 442 - 92)
    row, column = 18 + (high2 - x2) / (high2 - low2) * side, 46 + (x1 - low1) / (high1 - low1) * side
    near, far = seen[int(row) + 14, int(column) + 14], seen[18 + 5, 46 + 5]
    assert near.sum() < far.sum()
    assert (plain[int(row) + 14, int(column) + 14] == plain[18 + 5, 46 + 5]).all()
