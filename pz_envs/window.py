"""A window in which frames are shown, by pygame, which highway-env brings along."""

from typing import Any

from worlds.pictures.canvas import Frame

__all__ = ["Window"]


class Window:
    """Opens when it is first shown something.

    Args:
        title: what stands above it.
        fps: frames a second, at most.
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
