"""What a worker of the study does: one cradle, given by a few parameters, run for ten seconds.

`study.py` sends this file and the FMU to the workers of dask, which need Python with `newtons_cradle`, FMPy and
distributed, but no copy of these files.
"""

import newtons_cradle as nc

STOP, STEP = 10.0, 0.01  # s, of each run
AMPLITUDE = 0.1  # m, by which the balls are lifted
SPEED = AMPLITUDE * 5.0**0.5  # m/s, at which a lifted ball passes x = 0: g/L = 5 1/s2
LARGEST = 1e-6  # m, largest overlap of two balls of 1 kg that meet at SPEED, for every order
SAMPLES = 64  # of the forces, in each pulse of the first click
PERIOD = 2.81  # s, a little more than the cradle's period


def given(n: int) -> dict:
    """Start values that are the same in every run: the FMU must have been built with them, and runs set them again."""
    return {
        "gravity": 9.81,
        "pendulum.length": 1.962,
        "pendulum.drag": 0.0,
        "ball.mass": 1.0,
        "contact.model": "powerLaw",
        "solver.method": "eventDriven",
        "ball.massRatio": [1.0] * n,
        "pendulum.lengthRatio": [1.0] * n,
        "contact.stiffnessRatio": [1.0] * (n - 1),
        "contact.gap": [0.0] * (n - 1),
    }


def start_values(order: float, dead_band: float, damping: float, lifted: int, n: int) -> dict:
    """The FMU's start values.

    `order`: p of the force law; `dead_band` in units of the largest overlap, to which the stiffness is
    tuned for each order; `damping`: alpha of Hunt and Crossley, s/m; `lifted`: balls lifted to the left.
    """
    stored = 0.25 * SPEED**2  # J, half of the striking ball's energy is relative motion
    varied = {
        "contact.exponent": order,
        "contact.overlapRef": LARGEST,
        "contact.stiffness": stored * (order + 1.0) / LARGEST**2,
        "contact.deadBand": dead_band * LARGEST,
        "contact.dampingLaw": "huntCrossley",
        "contact.huntCrossley": damping,
    }
    return given(n) | nc.lifted(lifted, n=n, amplitude=AMPLITUDE) | varied


def measure(fmu: nc.Fmu, case: dict) -> dict:
    """Runs one case.

    overlap: impulse shared by neighbouring pulses of the first click, mean over the pairs, 0 to 1;
    last_ball: share of the energy that the last ball has after the first click;
    middle_ball: largest deflection of the middle ball in the last period over the amplitude;
    energy_left: energy after ten seconds over the energy at the start;
    energy_error: the solver's own, over the largest energy; pulses: how many there were.
    """
    n = fmu.balls
    values, middle, last = start_values(**case, n=n), f"x[{(n + 1) // 2}]", n
    run = fmu.simulate(values, stop=STOP, step=STEP, record=[middle, "E_total", "E_residual"])
    if len(run.pulses) == 0:
        raise nc.FmuError("no contact ever closes")
    first = nc.impact_sequences(run.pulses)[0]
    end = first["release"].max()
    record = [*(f"F[{i}]" for i in range(1, n)), f"E_kinetic[{last}]", f"E_gravity[{last}]", "E_total"]
    click = fmu.simulate(values, times=nc.sample_times(first, stop=end, step=end, per_pulse=SAMPLES), record=record)
    energy = click[f"E_kinetic[{last}]"] + click[f"E_gravity[{last}]"]
    return {
        "overlap": float(nc.overlaps(click).mean()),
        "last_ball": float(energy[-1] / click["E_total"][-1]),
        "middle_ball": float(abs(run[middle][run["time"] > STOP - PERIOD]).max() / AMPLITUDE),
        "energy_left": float(run["E_total"][-1] / run["E_total"][0]),
        "energy_error": nc.energy_error(run),
        "pulses": len(run.pulses),
    }
