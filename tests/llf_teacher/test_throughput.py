"""The table of throughput has a row for each that can be played in arrays."""

from functools import partial

import numpy as np
from rich.console import Console

from llf_teacher.registry import PREFIX
from llf_teacher.tools import throughput
from llf_teacher.tools.benchmark import player
from pz_envs.family import all_families


def test_whatever_can_be_played_in_arrays_is_timed(monkeypatch):
    monkeypatch.setattr(throughput, "EPISODES", 2)
    kinds = throughput.kinds

    def small(horizons):
        """The same with small pools."""
        for kind in kinds(horizons):
            yield kind if kind.anew is None else kind._replace(make=partial(kind.make, pool=2))

    monkeypatch.setattr(throughput, "kinds", small)
    here = lambda kind, rows: player.resident((), *throughput.call_of(kind, rows).arguments)[0]  # noqa: E731
    monkeypatch.setattr(throughput, "_memory", here)  # a process for each takes a while
    console = Console(width=200)
    with console.capture() as captured:
        console.print(throughput.throughput(lambda name: None, rows=3, horizons=1, runs=1, many=3))
    lines = captured.get().splitlines()
    for family in all_families():
        found = [line.split() for line in lines if line.startswith(PREFIX + family.showcase[0])]
        assert bool(found) == bool(family.world_batch)
        for row in found:
            numbers = [float(cell) for cell in row if cell.replace(".", "").isdigit()]
            assert len(numbers) == (4 if "pool" in family.batch_options() else 2)
            assert min(numbers) >= 0


def test_memory_is_that_of_rows_alone():
    """Whatever the process has beside them."""
    kind = next(kind for kind in throughput.kinds() if "Bandit" in kind.name)
    beside = np.ones(10_000_000)
    assert 0 < throughput._memory(kind, 5000) < beside.nbytes / 5000 / 1000
