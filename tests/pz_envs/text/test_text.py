"""Reading text needs no seats."""

import subprocess
import sys

PROGRAM = """
import pkgutil, sys
import pz_envs.text as text
before = {name for name in sys.modules if name.partition(".")[0] in ("pettingzoo", "pz_envs")}
for module in pkgutil.iter_modules(text.__path__):
    __import__(f"pz_envs.text.{module.name}")
print(*sorted(name for name in set(sys.modules) - before if name.startswith(("pettingzoo", "pz_envs"))))
print(*sorted(name for name in sys.modules if name in ("pz_envs.seats", "pz_envs.lesson")))
"""


def test_reading_text_loads_no_seats_and_nothing_of_pettingzoo():
    """What `import pz_envs` itself loads, to register with PettingZoo, is there before."""
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    loaded, seats = done.stdout.splitlines()
    assert loaded.split()
    assert all(name.startswith("pz_envs.text.") for name in loaded.split())
    assert seats == ""
