"""The table of throughput has a row for each that can be played in arrays."""

from rich.console import Console

from llf_teacher.registry import PREFIX
from llf_teacher.tools import throughput
from pz_envs.family import all_families


def test_whatever_can_be_played_in_arrays_is_timed(monkeypatch):
    monkeypatch.setattr(throughput, "EPISODES", 2)
    kinds = throughput._kinds
    few = {"pool": 2}

    def small(horizons):
        """The same with small pools."""
        for kind in kinds(horizons):
            make = kind.make
            yield kind if kind.anew is None else kind._replace(make=lambda rows, make=make, **o: make(rows, **few | o))

    monkeypatch.setattr(throughput, "_kinds", small)
    console = Console(width=200)
    with console.capture() as captured:
        console.print(throughput.throughput(lambda name: None, rows=3, horizons=1, runs=1))
    lines = captured.get().splitlines()
    for family in all_families():
        found = [line.split() for line in lines if line.startswith(PREFIX + family.showcase[0])]
        assert bool(found) == bool(family.world_batch)
        for row in found:
            numbers = [float(cell) for cell in row if cell.replace(".", "").isdigit()]
            assert len(numbers) == (6 if "pool" in family.batch_options() else 4)
            assert min(numbers) >= 0
