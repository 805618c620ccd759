"""Runs the cases of a sweep: in this process, in others of this machine (see `processes`), or in the workers of a dask
client.

Cases and outcomes are pickled one by one, so that one that cannot be pickled costs the others nothing.
"""

import hashlib
import pickle
import shutil
import time as clock
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any

from . import archive
from .errors import InvalidValue, needed, optional
from .fmu import Fmu
from .run import Result

Case = dict[str, Any]
Measure = Callable[[Fmu, Case], Result | Mapping[str, Any]]

PARCELS = 8  # for each worker, so that all of them end at about the same time
MOST = 64  # cases in a parcel: progress is told after each
TOP_LEVEL = "define it by `def` in a module, not as a lambda or within a function, or take `workers=1`"
PLAIN = "numbers, arrays and results can be"


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case: a result, a dict of what was measured, or an error. `seconds`: how long it took."""

    found: Result | dict[str, Any] | None
    error: str
    seconds: float


Numbered = tuple[int, Any]  #: The number of a case, with the case or its outcome, either of them perhaps pickled.


def said(problem: BaseException) -> str:
    """An error in words."""
    return f"{type(problem).__name__}: {problem}"


def outcome(fmu: Fmu, run: Measure, case: Case) -> Outcome:
    """Runs a case; what it raises becomes the error of its outcome."""
    begin = clock.perf_counter()
    try:
        found = run(fmu, case)
        needed("measure", found, Mapping, 'a returned result, or a dict of numbers such as {"peak": 5.0},')
        return Outcome(found if isinstance(found, Result) else dict(found), "", clock.perf_counter() - begin)
    except (Exception, SystemExit) as problem:  # one case must not stop the others
        return Outcome(None, said(problem), clock.perf_counter() - begin)


def answers(fmu: Fmu, run: Measure, parcel: list[Numbered]) -> list[Numbered]:
    """The outcomes of some cases, in a worker."""

    def read(fmu: Fmu, case: Any) -> Result | Mapping[str, Any]:
        return run(fmu, pickle.loads(case))

    return [(number, packed(outcome(fmu, read, case))) for number, case in parcel]


def packed(made: Outcome) -> bytes:
    """An outcome as bytes; an error where it cannot be pickled."""
    try:
        return pickle.dumps(made)
    except Exception as problem:  # pickling may raise anything
        words = f"what was measured cannot be sent from a worker ({said(problem)}); {PLAIN}"
        return pickle.dumps(Outcome(None, words, made.seconds))


def parcels(cases: list[Case], workers: int) -> tuple[deque[list[Numbered]], list[Numbered]]:
    """The cases with their numbers, in parcels; and the outcomes of those that cannot be pickled."""
    sent: list[Numbered] = []
    failed: list[Numbered] = []
    for number, case in enumerate(cases):
        try:
            sent.append((number, pickle.dumps(case)))
        except Exception as problem:  # pickling may raise anything
            words = f"the case cannot be sent to a worker ({said(problem)}); numbers, arrays and text can be"
            failed.append((number, Outcome(None, words, 0.0)))
    size = max(1, min(MOST, len(sent) // (PARCELS * workers)))
    return deque(sent[i : i + size] for i in range(0, len(sent), size)), failed


def unpacked(answer: list[Numbered]) -> Iterator[Numbered]:
    """The outcomes in an answer."""
    for number, made in answer:
        try:
            yield number, pickle.loads(made)
        except Exception as problem:  # unpickling may raise anything
            yield number, Outcome(None, f"what was measured cannot be read here ({said(problem)}); {PLAIN}", 0.0)


_opened: dict[str, Fmu] = {}  # the FMUs of a dask worker by file name, which has the checksum
_opening = Lock()  # a worker may have several threads


def parcel_of_dask(name: str, run: Measure, parcel: list[Numbered]) -> list[Numbered]:
    """The outcomes of some cases, in a worker of dask, which removes its folder itself."""
    folder = Path(optional("distributed", "study").get_worker().local_directory)
    with _opening:
        if name not in _opened:
            _opened[name] = Fmu(folder / name, archive.temporary(folder))
    return answers(_opened[name], run, parcel)


def by_dask(client: Any, path: Path, run: Measure, cases: list[Case]) -> Generator[Numbered, None, None]:
    """The outcomes, as they come from the workers of a client. The FMU is sent to them. Raises InvalidValue."""
    distributed = optional("distributed", "study")
    name = f"{path.stem}-{hashlib.sha256(path.read_bytes()).hexdigest()}.fmu"
    folder = archive.temporary()
    try:
        client.upload_file(str(shutil.copy(path, folder / name)), load=False)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    waiting, failed = parcels(cases, max(1, len(client.ncores())))
    yield from failed
    task = partial(parcel_of_dask, name, run)
    try:
        jobs = client.map(task, waiting, pure=False)
    except Exception as problem:  # of dask, which cannot pickle it
        words = f"it cannot be sent to the workers ({said(problem)[:200]}); {TOP_LEVEL}"
        raise InvalidValue(f"measure: {words}") from None
    of_key = {job.key: parcel for job, parcel in zip(jobs, waiting, strict=True)}
    coming = distributed.as_completed(jobs, with_results=True, raise_errors=False)
    for job, result in coming:
        parcel = of_key.pop(job.key)
        if job.status != "error":
            yield from unpacked(result)
        elif len(parcel) == 1:  # not the case's own failure: its workers died
            yield parcel[0][0], Outcome(None, f"lost: {result[1]}", 0.0)
        else:
            for one, again in zip(parcel, client.map(task, [[one] for one in parcel], pure=False), strict=True):
                of_key[again.key] = [one]
                coming.add(again)
