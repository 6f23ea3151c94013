"""Rendering: text, an array, or a window of pygame, which is installed with highway-env."""

from collections.abc import Callable
from typing import Any

from gymnasium import logger

from worlds.pictures.canvas import Frame

__all__ = ["FPS", "Renderer", "Window"]

FPS = 4
"""Greatest number of frames per second in a window."""


class Renderer:
    """The `render` of an environment.

    Args:
        mode: None, `ansi`, `rgb_array` or `human`.
        title: of the window.
        as_text: gives the text.
        frame: gives the frame, uint8 (height, width, 3).
    """

    def __init__(self, mode: str | None, title: str, as_text: Callable[[], str], frame: Callable[[], Frame]) -> None:
        self.mode, self._as_text, self._frame = mode, as_text, frame
        self._window = Window(title, FPS)

    def render(self) -> str | Frame | None:
        """In mode `ansi` return the text, in mode `rgb_array` the frame; in mode `human` show the frame in a window.

        Raises:
            RuntimeError: in mode `human` there is no display.
        """
        if self.mode is None:
            logger.warn(
                "render() shows nothing without a render mode; make the environment with one, as in "
                "render_mode='rgb_array'"
            )
            return None
        if self.mode == "ansi":
            return self._as_text()
        if self.mode == "rgb_array":
            return self._frame()
        self._window.show(self._frame())
        return None

    def close(self) -> None:
        """Close the window, if it is open."""
        self._window.close()


class Window:
    """A window, which opens with its first frame.

    Args:
        title: its title.
        fps: greatest number of frames per second.
    """

    def __init__(self, title: str, fps: int) -> None:
        self.title, self.fps = title, fps
        self._screen: Any = None

    def show(self, frame: Frame) -> None:
        """Show a frame.

        Raises:
            RuntimeError: there is no display.
            ModuleNotFoundError: pygame is not installed.
        """
        try:
            import pygame
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                "render_mode='human' opens a window by pygame, which is not installed; run: pip install pygame-ce, or "
                "use render_mode='rgb_array'",
                name=error.name,
            ) from error
        size = frame.shape[1], frame.shape[0]
        try:
            if self._screen is None or self._screen.get_size() != size:
                pygame.display.init()
                self._screen = pygame.display.set_mode(size)
                pygame.display.set_caption(self.title)
                self._clock = pygame.time.Clock()
            pygame.event.pump()
            self._screen.blit(pygame.surfarray.make_surface(frame.swapaxes(0, 1)), (0, 0))
            pygame.display.flip()
        except pygame.error as error:
            self._screen = None
            raise RuntimeError(
                f"render_mode='human' opens a window, which failed with {error}; it needs a display: on Linux DISPLAY "
                "or WAYLAND_DISPLAY must be set; without one use render_mode='rgb_array' or 'ansi'"
            ) from error
        self._clock.tick(self.fps)

    def close(self) -> None:
        """Close the window, if it is open."""
        if self._screen is not None:
            import pygame

            pygame.display.quit()
            self._screen = None
