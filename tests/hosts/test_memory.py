"""Nothing is left behind: instances, states and the library itself come and go."""

import sys
from pathlib import Path

import pytest
from fmi3_host import Cradle

pytestmark = pytest.mark.all


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

    def kept() -> float:
        """Bytes that each of a hundred calls has added to the resident memory of this process."""
        memory = Path("/proc/self/statm")
        before = int(memory.read_text().split()[1])
        for _ in range(100):
            once()
        return (int(memory.read_text().split()[1]) - before) * 4096 / 100

    # What a leak takes it takes again. A heap that other tests have used may grow for some hundred calls.
    assert any(kept() < 1000 for _ in range(10))
