"""Command line: `python -m newtons_cradle page FILE`, `live`, `cases` and `judge CASE RESULT`. The program cradle-fmu
has the same commands, and hands them over."""

import argparse
import os
import signal
import sys
import zipfile
from collections.abc import Callable
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from typing import Any

from .errors import CradleError, InvalidValue
from .files import in_folder
from .page import save_page, save_site
from .progress import Progress
from .recording import LENGTH, RADIUS, Recording, RecordingError, from_csv
from .trial import CASES, judge, judge_all, write_cases
from .views import from_fmu

LONGEST = 3600.0  # s; longer runs need --force
OTHER_PYTHON = "`cradle-fmu ... --python PROGRAM` selects the Python that answers."
CODES = "Exit codes: 0 right; 1 wrong, or standard output takes no verdict; 2 not judged, such as a missing column. "
EPILOG = {"judge": CODES}


class Parser(argparse.ArgumentParser):
    """A parser that prints its help with `say`."""

    def print_help(self, file: Any = None) -> None:
        say(self.format_help().rstrip())


class OutputError(CradleError):
    """Standard output cannot be written."""


def say(text: str) -> None:
    """Prints to standard output. A closed pipe is no error. Raises OutputError."""
    try:
        print(text, flush=True)
    except OSError as problem:
        # Otherwise Python would try to write the rest again at its exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(problem, BrokenPipeError):
            raise OutputError(f"cannot write to standard output: {problem.strerror}") from None


def setting(text: str) -> tuple[str, int | str]:
    """Splits `name=value`. A whole number becomes an int, because it may be an item of an enumeration."""
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not name=value")
    return name.strip(), int(value) if value.strip().isdecimal() else value.strip()


def arguments() -> argparse.ArgumentParser:
    parser = Parser(prog="cradle-fmu", description="Looks at runs of the cradle FMU.")
    commands = parser.add_subparsers(required=True, metavar="{page,live,cases,judge}")

    def command(name: str, function: Callable[[argparse.Namespace], int | None]) -> Any:
        """Adds a command, whose help is the first line of the function's docstring."""
        about = (function.__doc__ or "").split("\n")[0]
        made = commands.add_parser(name, help=about, description=about, epilog=EPILOG.get(name, "") + OTHER_PYTHON)
        made.set_defaults(function=function)
        return made

    page = command("page", make_page)
    help = (
        "an .fmu file, which this runs with samples in every pulse, or the .csv file of a result, with time, x[i] and "
        "v[i] of every ball, and F[i] and F_peak[i] of every contact"
    )
    page.add_argument("file", type=Path, metavar="FILE", help=help)
    page.add_argument("-o", "--out", type=Path, metavar="FILE.html", help="the page (default: beside FILE)")
    run = page.add_argument_group("for an FMU").add_argument
    run("--stop", type=float, default=10.0, metavar="SECONDS", help="how long to run (default 10)")
    help = f"run longer than {LONGEST:g} s, which takes minutes and makes huge pages"
    run("--force", action="store_true", help=help)
    help = "a start value, such as contact.model=hertz; may be repeated"
    run("--set", type=setting, action="append", default=[], metavar="NAME=VALUE", help=help)
    result = page.add_argument_group("for a CSV file").add_argument
    result("--pulses", type=Path, metavar="FILE.csv", help="the run's table of pulses")
    help = "number of balls; needed if it is 1 (default: as in the file)"
    result("--balls", type=int, metavar="N", help=help)
    for name, default, meaning in (("length", LENGTH, "pendulum length"), ("radius", RADIUS, "ball radius")):
        help = f"{meaning} in m, for the drawing (default {default})"
        result(f"--{name}", type=float, default=default, help=help)
    place = command("live", make_live).add_mutually_exclusive_group().add_argument
    help = "default: %(default)s"
    place("-o", "--out", type=Path, default=Path("cradle.html"), metavar="FILE.html", help=help)
    help = "as index.html in a folder for a web server: browsers can install it, and keep it without a network"
    place("--site", type=Path, metavar="FOLDER", help=help)
    cases = command("cases", make_cases)
    cases.add_argument("-o", "--out", type=Path, required=True, metavar="FOLDER", help="where to put them")
    help = "an FMU whose binaries they get (default: the one of this package)"
    cases.add_argument("--from", type=Path, dest="binaries", metavar="FILE.fmu", help=help)
    judged = command("judge", make_judgement)
    judged.add_argument("folder", type=Path, metavar="CASE", help="the folder of a case, or the one of all cases")
    help = "what the tool has recorded; for all cases a folder with NAME.csv for each (default: CASE/result.csv)"
    judged.add_argument("result", type=Path, nargs="?", metavar="RESULT.csv", help=help)
    return parser


def make_page(options: argparse.Namespace) -> None:
    """Makes the page of a run: one HTML file for a browser that needs no network."""
    kind = options.file.suffix.lower()
    out = in_folder(options.out or options.file.with_suffix(".html"), "--out")  # before the work is done
    if kind == ".fmu":
        if options.stop > LONGEST and not options.force:
            raise InvalidValue(f"--stop {options.stop:g} is refused; allowed: up to {LONGEST:g} s, more with --force")
        progress = Progress(f"Running {options.file.name} for {options.stop:g} s")
        progress(0.0)
        recording = from_fmu(options.file, dict(options.set), stop=options.stop, progress=progress)
    elif kind == ".csv":
        recording = from_csv(
            options.file, options.pulses, balls=options.balls, length=options.length, radius=options.radius
        )
    else:
        raise RecordingError(f"{options.file}: only .fmu and .csv files can be shown")
    save(out, recording)


def make_live(options: argparse.Namespace) -> None:
    """Writes the page of the live cradle: one HTML file for a browser, no network needed."""
    if options.site:
        if options.site.is_file():
            raise InvalidValue(f"--site: {options.site} is a file; name a folder for a web server")
        written(options.site, save_site(options.site), "put this folder on a web server")
    else:
        save(in_folder(options.out, "--out"))


def make_cases(options: argparse.Namespace) -> None:
    """Writes small FMUs with known answers, to try out a tool that imports FMUs, each into a folder."""
    for folder in write_cases(options.out, options.binaries):
        say(f"{folder}: {CASES[folder.name].title}")


def make_judgement(options: argparse.Namespace) -> int:
    """Says what a tool did right or wrong in the cases, one verdict a line.

    Returns 0 if all is right, 1 if something is wrong, else 2 if something could not be judged."""
    if options.folder.resolve().name in CASES or not any((options.folder / name).is_dir() for name in CASES):
        lines = judge(options.folder, options.result)
        say("\n".join(lines))
    else:
        lines = []
        for name, verdicts in judge_all(options.folder, options.result):
            lines += verdicts
            say("\n".join(f"{name}: {line}" for line in verdicts))
    return (
        1
        if any(line.startswith("wrong") for line in lines)
        else 2 * any(line.startswith("not judged") for line in lines)
    )


def save(out: Path, recording: Recording | None = None) -> None:
    if out.exists():
        print(f"Replacing {out}", file=sys.stderr)
    written(out, save_page(out, recording))


def written(out: Path, size: int, advice: str = "open it in a browser") -> None:
    say(f"{out} ({size / 1e6:.1f} MB): {advice}")


def main() -> int:
    """Returns the exit code. 0: success; 1: an error, or a wrong result; 2: a mistake in the command, such as a missing
    file, or a result that could not be judged. Errors are printed to standard error."""
    judging = False
    try:
        options = arguments().parse_args()
        judging = options.function is make_judgement
        return options.function(options) or 0
    except (CradleError, OSError, zipfile.BadZipFile) as problem:
        with suppress(OSError):  # standard error may be closed
            print(f"error: {problem}", file=sys.stderr, flush=True)
        unjudged = judging and not isinstance(problem, OutputError)
        return 2 if unjudged or isinstance(problem, (FileNotFoundError, InvalidValue)) else 1


if __name__ == "__main__":
    # sys.exit lets unpacked FMUs be removed; the status is the one that shells show for this signal.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    if isinstance(sys.stdout, TextIOWrapper):  # None if it was closed from the start
        sys.stdout.reconfigure(errors="backslashreplace")  # for characters that the locale cannot encode
    sys.exit(main())
