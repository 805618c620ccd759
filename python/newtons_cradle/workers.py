"""Who runs the cases of a sweep: this process, others of this machine, or the workers of a dask client.

Cases, what is measured and outcomes travel as bytes that are pickled one by one, so that one that cannot be pickled
costs the others nothing.
"""

import hashlib
import multiprocessing
import pickle
import shutil
import signal
import time as clock
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Lock
from typing import Any

from . import archive
from .errors import CradleError, FmuError, InvalidValue, needed, optional
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
    """What has come of a case: a result, or what was measured, or an error. `seconds` that it took."""

    found: Result | dict[str, Any] | None
    error: str
    seconds: float


Numbered = tuple[int, Any]  #: A case with its number, or an outcome with that of its case, or the bytes of them.


def said(problem: BaseException) -> str:
    """An error in words."""
    return f"{type(problem).__name__}: {problem}"


def outcome(fmu: Fmu, run: Measure, case: Case) -> Outcome:
    """What comes of a case."""
    begin = clock.perf_counter()
    try:
        found = run(fmu, case)
        needed("measure", found, Mapping, 'a returned result, or a dict of numbers such as {"peak": 5.0},')
        return Outcome(found if isinstance(found, Result) else dict(found), "", clock.perf_counter() - begin)
    except Exception as problem:  # whatever it is: one case does not stop the others
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
    except Exception as problem:  # whatever an object raises
        words = f"what was measured cannot be sent from a worker ({said(problem)}); {PLAIN}"
        return pickle.dumps(Outcome(None, words, made.seconds))


def parcels(cases: list[Case], workers: int) -> tuple[deque[list[Numbered]], list[Numbered]]:
    """The cases with their numbers, in parcels; and the outcomes of those that cannot be pickled."""
    sent: list[Numbered] = []
    failed: list[Numbered] = []
    for number, case in enumerate(cases):
        try:
            sent.append((number, pickle.dumps(case)))
        except Exception as problem:  # whatever an object raises
            words = f"the case cannot be sent to a worker ({said(problem)}); numbers, arrays and text can be"
            failed.append((number, Outcome(None, words, 0.0)))
    size = max(1, min(MOST, len(sent) // (PARCELS * workers)))
    return deque(sent[i : i + size] for i in range(0, len(sent), size)), failed


def unpacked(answer: list[Numbered]) -> Iterator[Numbered]:
    """The outcomes in an answer."""
    for number, made in answer:
        try:
            yield number, pickle.loads(made)
        except Exception as problem:  # whatever an object raises
            yield number, Outcome(None, f"what was measured cannot be read here ({said(problem)}); {PLAIN}", 0.0)


class Worker:
    """Another process of this machine, with an FMU of its own. It ends when this is closed."""

    def __init__(self, path: Path, folder: Path, run: bytes):
        self.connection, theirs = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=work, args=(theirs, path, folder, run))
        self.process.start()
        theirs.close()

    def check(self) -> None:
        """Waits until it is ready. Raises InvalidValue, FmuError."""
        try:
            problem = self.connection.recv()
        except (EOFError, OSError):
            cure = "in a script, call `nc.sweep` below `if __name__ == '__main__':`, or take `workers=1`"
            raise FmuError(f"the processes of a sweep cannot start; {cure}") from None
        if problem is not None:
            raise problem

    def close(self) -> None:
        self.process.kill()  # what it was at is not wanted any more
        self.process.join()
        self.connection.close()


def work(connection: Connection, path: Path, folder: Path, run: bytes) -> None:
    """What a worker does until nobody wants its answers any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to all; the first process ends the others
    try:
        measure = pickle.loads(run)
        fmu = Fmu(path, archive.temporary(folder))  # this process may be killed; the first one removes the folder
    except CradleError as problem:
        connection.send(problem)
        return
    except Exception as problem:  # whatever is missing here
        connection.send(InvalidValue(f"measure: it cannot be read in another process ({said(problem)}); {TOP_LEVEL}"))
        return
    connection.send(None)
    while True:
        try:
            connection.send(answers(fmu, measure, connection.recv()))
        except (EOFError, OSError):
            return


def by_processes(workers: int, path: Path, run: Measure, cases: list[Case]) -> Generator[Numbered, None, None]:
    """The outcomes, as they come from processes of this machine. Where one dies, its parcel is done again, case by
    case. Raises InvalidValue, FmuError."""
    try:
        packed_run = pickle.dumps(run)
    except Exception as problem:  # whatever an object raises
        words = f"measure: it cannot be sent to other processes ({said(problem)}); {TOP_LEVEL}"
        raise InvalidValue(words) from None
    waiting, failed = parcels(cases, workers)
    yield from failed
    import_module(".run.slaves", __package__)  # with FMPy: once, before the processes part
    folder = archive.temporary()
    staff: list[Worker] = []
    busy: dict[Any, tuple[Worker, list[Numbered]]] = {}

    def hire(count: int) -> list[Worker]:
        for _ in range(count):
            staff.append(Worker(path, folder, packed_run))
        for worker in staff[-count:]:
            worker.check()
        return staff[-count:]

    try:
        idle = hire(min(workers, len(waiting))) if waiting else []
        while waiting or busy:
            while waiting and idle:
                worker, parcel = idle.pop(), waiting.popleft()
                busy[worker.connection] = worker, parcel
                with suppress(OSError):  # of one that has died; so says its answer
                    worker.connection.send(parcel)
            for connection in wait(list(busy)):
                worker, parcel = busy.pop(connection)
                try:
                    answer = worker.connection.recv()
                except (EOFError, OSError):
                    worker.close()
                    (worker,), answer = hire(1), []
                    if len(parcel) > 1:
                        waiting.extendleft([one] for one in reversed(parcel))
                    else:
                        yield parcel[0][0], Outcome(None, "its process has died", 0.0)
                idle.append(worker)
                yield from unpacked(answer)
    finally:
        for worker in staff:
            worker.close()
        shutil.rmtree(folder, ignore_errors=True)


_opened: dict[str, Fmu] = {}  # of this worker of dask, by the name of the file, which has its checksum
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
