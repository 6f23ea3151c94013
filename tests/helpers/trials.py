"""How long planners try an environment before they teach it, which takes a second each time."""

from importlib import import_module

from design import amount

PARTS = {
    "visible": {"_EPISODES": 60},
    "exact.exploring": {"_PLAYED": 300},
    "exact.tables": {"_LATE": 400, "_COUNTED": 2_000},
    "expert.trial": {"_EPISODES": 25, "_TOTAL": 80},
}
"""What is tried less of, by default, where an environment is in order or what is wrong with it shows soon."""


def shorten(monkeypatch):
    for name, numbers in PARTS.items():
        module = import_module(f"teachers.planning.{name}")
        for number, few in numbers.items():
            monkeypatch.setattr(module, number, amount(few, full=getattr(module, number)))
