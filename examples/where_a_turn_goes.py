"""Which parts of a taught turn take how much of its time, in four families: the table of docs/internals/speed.md.

A profile makes calls dearer than they are, so that it shows shares and no times:

    python examples/where_a_turn_goes.py
"""

import argparse
import cProfile
import time
from statistics import median
from types import CodeType

from llf_teacher.tools.benchmark.measuring import Writer
from llf_teacher.tools.benchmark.player import student

IDS = ("llf-highway-parking-v0", "llf-reco-movie-v0", "llf-poem-Haiku-v0", "llf-optimization-Booth-v0")
PARTS = {"advance": "worlds/", "_hindsight": "teachers/oracles/", "_advice": "teachers/oracles/", "say": "/teacher.py"}
"""Functions of a turn, and where their modules lie."""
WHOLE = dict.fromkeys(("reset", "step"), "/student_env.py")
"""What the student calls; a teacher speaks in both."""


def shares(id: str, actions: str, steps: int, profiles: int) -> list[int]:
    """Per part the median share of an episode's CPU time, in percent.

    Args:
        id: of the environment.
        actions: the student whose actions are played.
        steps: of each profile.
        profiles: their number.
    """
    writer, found = Writer(id, actions), []
    for _ in range(profiles):
        profile = cProfile.Profile(time.process_time)
        profile.runcall(student, writer.write(steps), id, "a")
        seconds = dict.fromkeys([*PARTS, *WHOLE], 0.0)
        for entry in profile.getstats():
            file, name = (c.co_filename, c.co_name) if isinstance(c := entry.code, CodeType) else ("", "")
            if name in seconds and (PARTS | WHOLE)[name] in file:
                seconds[name] += entry.totaltime
        whole = sum(seconds[name] for name in WHOLE)
        found.append([100 * seconds[name] / whole for name in PARTS])
    return [round(median(each)) for each in zip(*found, strict=True)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ids", nargs="*", default=IDS)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--profiles", type=int, default=5)
    given = parser.parse_args()
    heads = "world (`advance`)", "verdicts (`_hindsight`)", "advice and warning (`_advice`)", "words (`say`)"
    print("| environment | actions |", " | ".join(heads), "|")
    print("|---|---|---|---|---|---|")
    for id in given.ids:
        for actions in ("random", "obedient"):
            print("|", " | ".join(map(str, (id, actions, *shares(id, actions, given.steps, given.profiles)))), "|")
