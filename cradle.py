#!/usr/bin/env python3
"""Newton's cradle as an FMU: run the paper's experiments, or run the tests.

    python3 cradle.py paper         build the FMU, run the experiments in FMPy, write a report and pictures to out/paper
    python3 cradle.py test          run what a change needs, in minutes
    python3 cradle.py test --all    run everything that checks this project
    python3 cradle.py page          make the page without a recording, live in a browser: target/web/cradle.html
    python3 cradle.py wheel         make a wheel for pip with the FMU, cradle-fmu and the Python package
    python3 cradle.py docs          make a site of the documents, with search: out/site/index.html

They need cargo, a C compiler and Python 3.11 or newer. Everything else goes into this folder: Python packages
into .venv, compiled code into target. You can delete either at any time; it is made again.
"""

import argparse
import sys
import time
from pathlib import Path

if sys.version_info < (3, 11):  # noqa: UP036 - the script is the first thing an old Python meets
    sys.exit(f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}.")

from checkout import ENGINE, LIVE, PYTHON, SOME, Stop, check_machine, fmu_build, make_venv, run, say, stage
from checkout.page import make_page
from checkout.site import SITE, make_site
from checkout.suite import test
from checkout.wheel import make_wheel


def paper(_options) -> int:
    """Builds the FMU and runs the paper's experiments through FMPy."""
    begin = time.perf_counter()
    with stage("1/3 Python packages"):
        make_venv(SOME)
    with stage("2/3 FMU (the first time, compiling takes a minute)"):
        command, environment = fmu_build("cargo", "pack")
        run(command, env=environment)
    with stage("3/3 the paper's experiments"):
        code = run([PYTHON, "examples/paper/run_all.py"], check=False)
    if ENGINE.exists():  # then the live page can be written beside the report
        say("\nThe cradle live, in a browser:")
        run([PYTHON, "-m", "newtons_cradle", "live", "--out", "out/cradle.html"])
    else:
        say("\nThe cradle live, in a browser: `python3 cradle.py page` makes target/web/cradle.html.")
    say(f"\nTotal: {time.perf_counter() - begin:.0f} s.")
    return code


def main() -> int:
    """Parses the command line and runs the command."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="cradle.py", description=__doc__, formatter_class=form)
    commands = parser.add_subparsers(dest="command", required=True, metavar="{paper,test,page,wheel,docs}")
    commands.add_parser("paper", help=paper.__doc__).set_defaults(function=paper)
    tests = commands.add_parser("test", help=test.__doc__)
    tests.add_argument("--all", action="store_true", help="run everything that checks this project")
    strict = "fail if anything is skipped that a machine with everything installed can run, as CI does"
    tests.add_argument("--strict", action="store_true", help=strict)
    tests.set_defaults(function=test)
    pages = commands.add_parser("page", help=make_page.__doc__)
    pages.add_argument(
        "--out", type=Path, default=LIVE, metavar="FILE", help="where to write it [default: %(default)s]"
    )
    pages.add_argument(
        "--or-skip", action="store_true", help="say SKIPPED, without failing, if Rust's target is missing"
    )
    pages.set_defaults(function=lambda options: make_page(options.out, options.or_skip))
    wheels = commands.add_parser("wheel", help=make_wheel.__doc__)
    included = "the FMU to include [default: one with this platform's binary only]"
    wheels.add_argument("--fmu", type=Path, metavar="FILE", help=included)
    wheels.set_defaults(function=lambda options: make_wheel(options.fmu))
    documents = commands.add_parser("docs", help=make_site.__doc__)
    documents.add_argument(
        "--out",
        type=Path,
        default=SITE,
        metavar="FOLDER",
        help="where to write it; emptied first [default: %(default)s]",
    )
    whose = "the FMU whose variables are shown [default: one that is built]"
    documents.add_argument("--fmu", type=Path, metavar="FILE", help=whose)
    documents.set_defaults(function=lambda options: make_site(options.out, options.fmu))
    options = parser.parse_args()
    try:
        check_machine()
        return options.function(options)
    except Stop as problem:
        say(f"\n{parser.prog} {options.command} stopped: {problem}")
        return 2


if __name__ == "__main__":
    sys.exit(main())
