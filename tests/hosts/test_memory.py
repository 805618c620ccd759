"""Nothing is left behind: instances, states and the library itself come and go."""

import sys
from pathlib import Path

import newtons_cradle as nc
import pytest

pytestmark = pytest.mark.all

PAGES = Path("/proc/self/statm")


def resident() -> int:
    """Resident memory of this process, in pages."""
    return int(PAGES.read_text().split()[1])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_thousand_instances_leave_no_memory_behind(fmu):
    """FMPy loads the library for each and unloads it afterwards."""

    def once() -> None:
        with fmu.start(nc.figure5(), initialize=False) as run:
            run.initialize()
            run.step_to(0.71)
            saved = run.save()
            run.step_to(1.5)
            run.load(saved)

    for _ in range(200):
        once()
    # What a leak takes it takes again in every thousand; the heap of the process may grow once by something else.
    grown = []
    while len(grown) < 3 and (not grown or min(grown) >= 1e6):
        before = resident()
        for _ in range(1000):
            once()
        grown.append((resident() - before) * 4096)
    assert min(grown) < 1e6, "more than a kilobyte for each"
