"""Agents that raise, hang, exit, eat memory or answer what cannot be written down."""

import contextlib
import os
import re
import sys
import time
from pathlib import Path

KEPT = []


def spoil(number):
    """What a task does that was interrupted: the next one ends the process."""
    from llf_teacher.studies.execution.executors import Process

    Process.spoiled = True
    return number


def square(number):
    if number in (37, 61):
        os._exit(0)
    return number**2


class Agent:
    def __init__(self, fault="none", seconds=0.0):
        self.fault = fault
        self.seconds = seconds

    def act(self, observation):
        time.sleep(self.seconds)
        getattr(self, self.fault)()
        return "north"

    def none(self):
        pass

    def raises(self):
        raise KeyError("no idea")

    def unspeakable(self):
        class Unspeakable(BaseException):
            def __repr__(self):
                raise ValueError

        raise Unspeakable

    def sleeps(self):
        time.sleep(600)

    def deaf(self):
        while True:
            with contextlib.suppress(BaseException):
                time.sleep(600)

    def loops(self):
        """Hang in a loop of C that keeps all other threads from running."""
        Path("looping.pid").write_text(f"{os.getpid()}")
        re.match("(a+)+$", "a" * 60 + "b")

    def leaves(self):
        sys.exit(3)

    def exits(self):
        os._exit(0)

    def eats(self):
        while True:
            KEPT.append(bytes(1 << 25))


class Sleepy:
    """A policy that hangs in few episodes."""

    def reset(self, rng):
        self._hangs = rng.random() > 0.9

    def act(self, observation, info):
        time.sleep(600 * self._hangs)
        return 0


class Odd:
    def __init__(self, answer):
        self.answer = answer

    def act(self, observation):
        return getattr(self, self.answer)()

    def circle(self):
        circle = []
        circle.append(circle)
        return circle

    def deep(self):
        deep = []
        for _ in range(100_000):
            deep = [deep]
        return deep

    def keys(self):
        return {(1, 2): 3}

    def octets(self):
        return b"Response: north"

    def inside(self):
        return {"action": b"north"}

    def shown(self):
        class Shown:
            def __repr__(self):
                return "north"

        return Shown()

    def leaving(self):
        class Leaving:
            def __getattribute__(self, name):
                raise SystemExit(3)

        return Leaving()

    def ending(self):
        class Ending:
            def __getattribute__(self, name):
                raise BaseException(name)

        return Ending()

    def nine(self):
        return 9

    def nan(self):
        return float("nan")

    def unspeakable(self):
        class Unspeakable:
            def __getattr__(self, name):
                raise KeyError(name)

            __repr__ = __eq__ = __lt__ = __getattr__

        return Unspeakable()


class Native(Odd):
    def reset(self, rng):
        pass

    def act(self, observation, info):
        return super().act(observation)
