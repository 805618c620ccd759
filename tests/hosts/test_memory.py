"""Nothing is left behind: instances, states and the library itself come and go."""

import sys
from pathlib import Path

import pytest
from fmi3_host import Cradle

pytestmark = pytest.mark.all


def resident() -> int:
    """Resident memory of this process, in pages."""
    return int(Path("/proc/self/statm").read_text().split()[1])


def grown(once, times: int) -> float:
    """Bytes that each call keeps: what a leak takes it takes again. A heap that other tests have used may grow for some
    hundred calls."""
    for _ in range(50):
        once()
    least = float("inf")
    for _ in range(10):
        before = resident()
        for _ in range(times):
            once()
        least = min(least, (resident() - before) * 4096 / times)
        if least < 1000:
            break
    return least


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_instances_of_fmi_3_leave_no_memory_behind(fmu3):
    """FMPy loads the library for each and unloads it afterwards: what it keeps in statics is lost. What FMI 2.0 might
    keep besides, AddressSanitizer finds in tests/rust/ffi."""

    def once() -> None:
        exchange = Cradle(fmu3, balls=7, exchange=True)
        exchange.updateDiscreteStates()
        exchange.enterContinuousTimeMode()
        exchange.setTime(0.1)
        exchange.go_to(exchange.to_bytes())
        exchange.freeInstance()
        cradle = Cradle(fmu3, balls=7, eventModeUsed=True)
        cradle.walk(0.0, 1.0)
        cradle.go_to(cradle.to_bytes())
        cradle.terminate()
        cradle.freeInstance()

    assert grown(once, 100) < 1000
