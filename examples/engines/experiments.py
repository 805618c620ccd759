"""What this FMU predicts for published experiments with rows of balls, and how long it takes for exact rows.

    python examples/engines/experiments.py [--fmu FILE]

Prints the numbers of docs/makers/engines.md, all from start values given here, by the package's FMU or the one given.
"""

import argparse
import math
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "python"))

import newtons_cradle as nc

STEEL = nc.power_law(1.924e10, 1.5)  # balls of 1 kg: N/m^1.5
TIME = 1.7417e-6  # s, with which two of them have e = 0.95 at 1 m/s
ROWS = (  # gaps (m), and relaxation time
    ("three in touch, elastic", [0.0, 0.0], 0.0),
    ("three in touch, e = 0.95", [0.0, 0.0], TIME),
    ("three, the targets 0.1 mm apart, e = 0.95", [0.0, 1e-4], TIME),
    ("five in touch, elastic", [0.0] * 4, 0.0),
    ("five in touch, e = 0.95", [0.0] * 4, TIME),
)
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--fmu", type=Path, metavar="FILE")
GIVEN = parser.parse_args()
TIMED = ("equal-5-hertz", "siconos-monodisperse", "cradle-10-steel")


def collision(gaps: list[float], relaxation: float) -> None:
    """Velocities (m/s) of steel balls, the first of which strikes the others at 1 m/s, and how long contacts last."""
    n = len(gaps) + 1
    start = {"gravity": 0.0, "contact.gap": gaps, "x_start": [0.0] * n, "v_start[1]": 1.0, **STEEL}
    start |= {"contact.dampingLaw": "viscoelastic", "contact.relaxationTime": relaxation}
    with nc.build(balls=n, binaries=GIVEN.fmu) as fmu, fmu.start(start) as run:
        run.step(0.01)
        print("   v ", *(f"{v:.4f}" for v in run["v"]))
        for pulse in run.pulses:
            onset, release = 1e6 * pulse["onset"], 1e6 * pulse["release"]
            print(f"   contact {pulse['contact']}: {onset:.0f} to {release:.0f} µs")


def wave(speed: float) -> tuple[float, float]:
    """Beads of 1 kg with F = overlap^1.5 that a wave passes in a second, behind one that strikes at `speed` (m/s), by
    the times at which forces are largest; and its largest force (N)."""
    with (
        nc.build(balls=80, binaries=GIVEN.fmu) as fmu,
        fmu.start(nc.chain(1.5, 1, n=80) | {"v_start[1]": speed}) as run,
    ):
        run.step(70 * speed**-0.2)
        first, last = (run.pulses[run.pulses["contact"] == contact][0] for contact in (30, 50))
    return 20 / (last["peak_time"] - first["peak_time"]), last["peak"]


def shortest(name: str) -> float:
    """Time (s) for a row of the benchmark in one step: the best of a hundred runs."""
    case, times = nc.benchmark(name), []
    with nc.build(balls=case.n, binaries=GIVEN.fmu) as fmu:
        for _ in range(100):
            with fmu.start(case.values) as run:
                begin = time.perf_counter()
                run.step(case.stop)
                times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    """Prints all predictions."""
    for name, gaps, relaxation in ROWS:
        print(name)
        collision(gaps, relaxation)
    (fast, strong), (slow, weak) = wave(1.0), wave(0.01)
    print(f"solitary wave: {fast / strong ** (1 / 6):.5f} F^(1/6), {fast:.5f} v^(1/5)")
    print(f"   its exponent differs from 1/6 by {math.log(fast / slow) / math.log(strong / weak) - 1 / 6:.0e}")
    tapered = nc.benchmark("tapered-10-hertz").expected["v"][-1]
    print(f"ten tapered steel balls: {tapered:.4f}; one impact after the other: {(2 / (1 + 0.95**3)) ** 9:.4f}")
    for name in TIMED:
        print(f"{name}: {1e3 * shortest(name):.2f} ms")


if __name__ == "__main__":
    main()
