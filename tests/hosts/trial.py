"""The hosts on trial: the cases of the package in every host that is installed, as a table of verdicts.

.venv/bin/python tests/hosts/trial.py [FMU]      prints the table of docs/makers/hosts.md
"""

import json
import re
import subprocess
import sys
import tempfile
from contextlib import redirect_stdout
from functools import partial
from importlib import metadata
from io import StringIO
from pathlib import Path

import fmpy
import numpy as np
from fmpy.util import write_csv
from newtons_cradle import Fmu, files
from newtons_cradle.trial import CASES, judge, write_cases
from newtons_cradle.trial.master import interpolated
from other_hosts import command, container

ROOT = Path(__file__).resolve().parents[2]
FMI_SIM = ROOT / "target/hosts/debug/fmi-sim"
FMI_RS = ROOT / "target/hosts/debug/run"


def version(package: str) -> str:
    """The version of a Python package; the short test has not installed all."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "missing"


def program(command, **options) -> str:
    """What a host that is a program says. Raises RuntimeError with the last line if it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=300, **options)
    if done.returncode:
        said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        told = [line for line in said if re.search("panicked|[Ee]rror", line)] or said[-1:] or [done.returncode]
        raise RuntimeError(told[0])
    return done.stdout


def families(case) -> list[str]:
    """The variables to record, arrays of FMI 3.0 as a whole."""
    return list(dict.fromkeys(name.split("[")[0] if case.fmi == 3 else name for name in case.record))


def table_of(case) -> np.ndarray | None:
    """The inputs as FMPy takes them."""
    for name, points in case.inputs.items():
        if case.fmi == 3:
            array, balls = name.split("[")[0], case.balls
            rows = [(time, [value] + [0.0] * (balls - 1)) for time, value in points]
            return np.array(rows, dtype=[("time", "f8"), (array, "f8", (balls,))])
        return np.array(list(points), dtype=[("time", "f8"), (name, "f8")])
    return None


def by_fmpy(case, folder, fmu=None):
    """FMPy, in model exchange its CVODE."""
    result = fmpy.simulate_fmu(
        str(fmu or folder / "cradle.fmu"),
        fmi_type="ModelExchange" if case.exchange else "CoSimulation",
        stop_time=case.stop,
        output_interval=case.step,
        relative_tolerance=(case.tolerance or 1e-8) if case.exchange else None,
        output=families(case),
        input=table_of(case),
        set_input_derivatives=case.slopes,
        use_event_mode=case.events,
        early_return_allowed=case.early,
        start_values=dict(case.settings),
    )
    return {column: list(result[column]) for column in result.dtype.names}


def by_hand(case, folder):
    """FMPy's classes, in a few lines for what no simulation loop offers."""

    def act(_environment, time, *_):
        if not acted:
            acted.append(time)
            run.set(case.act)

    def value(key):
        order = 0 if key in run.slave.variables else key.count("der(")
        if not order:
            return run.slave.get(key)
        place = run.slave.references(key.replace("der(", "").rstrip(")"))
        return run.slave.getRealOutputDerivatives(place, [order])[0]

    acted, options = [], {"intermediateUpdate": act} if case.act else {}
    with Fmu(folder / "cradle.fmu") as fmu, fmu.start(initialize=False, **options) as run:
        for key, start in case.settings.items():
            run.slave.resize(start) if key == "n" else run.slave.set(key, start)
        run.initialize()
        rows = [[0.0, *map(value, case.record)]]
        for k in range(1, round(case.stop / case.step) + 1):
            if case.trial and k == round(case.trial[0] / case.step) + 1:
                saved = run.save()
                run.set(case.trial[1])
                run.step_to(k * case.step)
                run.load(saved)
                run.step_to((k - 0.5) * case.step)
            for key, points in case.inputs.items():
                now, then = (interpolated(points, time * case.step) for time in (k - 1, k))
                run[key] = now
                run.slave.setRealInputDerivatives(run.slave.references(key), [1], [(then - now) / case.step])
            run.step_to(k * case.step)
            rows.append([k * case.step, *map(value, case.record)])
    return by_name(case, rows)


def by_name(case, rows) -> dict:
    """Columns by name, of rows with the time and the variables to record."""
    return dict(zip(("time", *case.record), zip(*rows, strict=True), strict=True))


def by_fmi_sim(case, folder):
    """fmi-sim, in FMI 3.0 with scalars instead of arrays; in model exchange by its Euler method."""
    fmu, out = folder / "cradle.fmu", folder / "fmi-sim.csv"
    if case.fmi == 3:
        scalars = folder / "scalars.fmu"
        starts = [f"--set={key}={written(value)}" for key, value in case.start.items()]
        build = [files.producer(), "build", "--fmi", "3", "--scalars", "--from", fmu, "--out", scalars]
        clocks = [] if folder.name == "clocks" else ["--clocks", "none"]
        program([*build, "--balls", case.balls, *clocks, *starts])
        fmu = scalars
    command = [FMI_SIM, "--model", fmu, "-o", out]
    command += ["-i", folder / "inputs.csv"] if case.inputs else []
    command += ["model-exchange" if case.exchange else "co-simulation"]
    command += ["--event-mode-used"] if case.events else []
    command += ["--early-return-allowed"] if case.early else []
    step = case.step / 512 if case.exchange else case.step  # its Euler steps by the interval of the output
    program([*command, "-f", case.stop, "--output-interval", step])
    return out


def written(value) -> str:
    return ",".join(map(repr, value)) if isinstance(value, list) else str(value)


def by_fmi_rs(case, folder):
    """The crate fmi-rs, in model exchange by its Euler method."""
    inputs, out = "-", folder / "fmi-rs.csv"
    if case.inputs:
        inputs = folder / "table.csv"
        write_csv(inputs, table_of(case))  # it reads arrays as FMPy writes them
    options = [option for option in ("exchange", "events", "early") if getattr(case, option)]
    options += [f"{key}={' '.join(map(str, np.atleast_1d(value)))}" for key, value in case.settings.items()]
    program([FMI_RS, folder / "cradle.fmu", out, inputs, ";".join(families(case)), case.step, case.stop, *options])
    return out


def stepping(case, folder, host):
    """libcosim or ecos, in a process of its own: co-simulation of FMI 2.0."""
    names = [f"cradle.{variable}" for variable in case.record]
    request = {"step": case.step, "count": round(case.stop / case.step), "names": names}
    request["inputs"] = {f"cradle.{variable}": list(points) for variable, points in case.inputs.items()}
    return by_name(case, json.loads(program(command(host, folder / "cradle.fmu", **request)).splitlines()[-1]))


def by_container(case, folder):
    """The FMU within an FMU container of the FMU Manipulation Toolbox, run by FMPy."""
    inside = folder / "container"
    inside.mkdir(exist_ok=True)
    outputs = [name for name in case.record if name not in case.inputs]
    program(container(folder / "cradle.fmu", inside, case.step, case.inputs, outputs), cwd=inside)
    return by_fmpy(case, folder, inside / "outer.fmu")


BY_NO_LOOP = {"rollback", "derivatives", "intermediate"}
BY_HAND = BY_NO_LOOP | {"slopes", "arrays"}
OF_MASTERS = {"grid", "inputs", "getters"}  # what co-simulation of FMI 2.0 in steps can do
HOSTS = {  # how each runs a case, and which it does not offer
    f"FMPy {version('fmpy')}": (by_fmpy, BY_NO_LOOP | {"binary"}),
    "its classes, by hand": (by_hand, CASES.keys() - BY_HAND),
    "fmi-sim 0.7.0": (by_fmi_sim, BY_NO_LOOP | {"slopes", "nominals", "located", "arrays", "binary"}),
    "crate fmi-rs 0.3.4": (by_fmi_rs, BY_NO_LOOP | {"slopes", "nominals", "located"}),
    f"libcosimpy {version('libcosimpy')}": (partial(stepping, host="libcosim"), CASES.keys() - OF_MASTERS),
    f"ecos {version('ecospy')}": (partial(stepping, host="ecos"), CASES.keys() - OF_MASTERS),
    f"container, fmutool {version('fmu-manipulation-toolbox')}": (by_container, CASES.keys() - OF_MASTERS),
}


def verdict(host, folder) -> str:
    """The verdict on a host in the case of this folder, in a line."""
    run, missing = HOSTS[host]
    if folder.name in missing:
        return "not offered"
    try:
        with redirect_stdout(StringIO()):  # FMPy warns there
            result = run(CASES[folder.name], folder)
    except Exception as problem:  # whatever it is, it is the host's
        return f"stops: {problem}"
    lines = judge(folder, result)
    return "; ".join(line for line in lines if not re.match("not judged: no rows at 1 of .* at 0 s$", line))


def short(line) -> str:
    """A verdict for the table."""
    line = re.sub(r"((wrong|right, but).*?); [^;]* (differs|ends) .*$", r"\1", line)
    line = re.sub(r'error: Parameter\("| \([\d.]+\)|"\)$', "", line)
    for pattern, words in (
        (r"not offered", "-"),
        (r".*right to the last bit.*", "same bits"),
        (r".*right within the method: .* by up to (\S+) of its.*", r"right, \1"),
        (r"wrong: less exact .* by up to (\S+) of its.*", r"less exact, \1"),
        (r"right, but (.*)", r"right; \1"),
        (r"stops: thread.*|stops: (.*)", r"stops: \1"),
        (r"wrong.*known mistake: (.*)", r"**wrong**: \1"),
        (r"wrong: (.*)", r"**\1**"),
    ):
        if re.fullmatch(pattern, line):
            return re.sub(pattern, words, line)
    return line


def main() -> None:
    """Prints the table."""
    fmu = sys.argv[1] if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as out:
        folders = {folder.name: folder for folder in write_cases(out, fmu)}
        print("\n".join(["| case |" + "".join(f" {host} |" for host in HOSTS), "|---|" + "---|" * len(HOSTS)]))
        for name, folder in folders.items():
            verdicts = [short(verdict(host, folder)) for host in HOSTS]
            print(f"| `{name}` |" + "".join(f" {line} |" for line in verdicts), flush=True)


if __name__ == "__main__":
    main()
