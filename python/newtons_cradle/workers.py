"""Who runs the cases of a sweep: this process, others of this machine, or the workers of a dask client.

Cases, what is measured and outcomes travel as bytes that are pickled one by one, so that one that cannot be pickled
costs the others nothing.
"""

import hashlib
import multiprocessing
import os
import pickle
import shutil
import time as clock
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Lock, Thread
from typing import Any

from . import archive
from .errors import CradleError, DoubtfulStart, FmuError, InvalidValue, needed, optional, warn
from .fmu import Fmu
from .interrupts import Held, blocked, ignore
from .run import Result

Case = dict[str, Any]
Measure = Callable[[Fmu, Case], Result | Mapping[str, Any]]

PARCELS = 8  # for each worker, so that all of them end at about the same time
MOST = 64  # cases in a parcel: progress is told after each
PATIENCE = 5.0  # s, with what a process has started that was killed
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
    except (Exception, SystemExit) as problem:  # whatever it is: one case does not stop the others
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
    """Another process of this machine, with an FMU of its own."""

    def __init__(self, path: Path, folder: Path, run: bytes):
        self.connection, theirs = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=work, args=(theirs, path, folder, run))
        with blocked():
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

    def answer(self) -> tuple[list[str], list[Numbered]] | None:
        """What it says to a parcel; None if it has died."""
        try:
            told, made = self.connection.recv()
            return told, made
        except (EOFError, OSError):
            return None

    def end(self) -> None:
        """Ends it, whatever it is at, and waits for processes that it has started: they end with it."""
        self.process.kill()
        self.process.join(PATIENCE)
        self.process.join()
        self.connection.close()


class Staff(AbstractContextManager["Staff"]):
    """The processes of a sweep and their folder, within a block of `held`: all that are started are ended with it."""

    def __init__(self, held: Held, path: Path, run: bytes):
        self.held, self.path, self.run = held, path, run
        self.folder, self.workers = archive.temporary(), list[Worker]()

    def hire(self, count: int) -> list[Worker]:
        """Starts so many. Raises InvalidValue, FmuError."""
        hired = []
        for _ in range(count):
            with self.held.passing(False):
                hired.append(Worker(self.path, self.folder, self.run))
                self.workers.append(hired[-1])
        for worker in hired:
            worker.check()
        return hired

    def dismiss(self, worker: Worker) -> str:
        """Of one that has died, how it has."""
        with self.held.passing(False):
            worker.end()
            self.workers.remove(worker)
        return f"its process has died (exit code {worker.process.exitcode})"

    def __exit__(self, *_: object) -> None:
        for worker in self.workers:
            worker.process.kill()
        for worker in self.workers:
            worker.end()
        shutil.rmtree(self.folder, ignore_errors=True)


def work(connection: Connection, path: Path, folder: Path, run: bytes) -> None:
    """What a worker does until it is killed, or until nobody is there any more."""
    ignore()  # the first process ends the others
    Thread(target=outlive, args=(folder,), daemon=True).start()
    archive.keep_within(folder)  # what this process leaves behind
    doubts = collected()
    try:
        measure = pickle.loads(run)
        fmu = Fmu(path)
    except CradleError as problem:
        connection.send(problem)
        return
    except Exception as problem:  # whatever is missing here
        connection.send(InvalidValue(f"measure: it cannot be read in another process ({said(problem)}); {TOP_LEVEL}"))
        return
    connection.send(None)
    while True:
        try:
            made = answers(fmu, measure, connection.recv())
            connection.send((list(doubts), made))
            doubts.clear()
        except (EOFError, OSError):
            return


def outlive(folder: Path) -> None:
    """Ends this process once the one that has started it is gone, however that has ended, with its folder."""
    parent = multiprocessing.parent_process()
    wait([parent.sentinel] if parent else [])
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def collected() -> list[str]:
    """What is said of doubtful start values in this process from now on, in place of showing it."""
    doubts: list[str] = []
    show = warnings.showwarning

    def keep(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, DoubtfulStart):
            doubts.append(str(message))
        else:
            show(message, category, *where, **more)

    warnings.showwarning = keep
    return doubts


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
    busy: dict[Any, tuple[Worker, list[Numbered]]] = {}
    with Held() as held, Staff(held, path, packed_run) as staff, held.passing():
        idle = staff.hire(min(workers, len(waiting)))
        while waiting or busy:
            while waiting and idle:
                worker, parcel = idle.pop(), waiting.popleft()
                busy[worker.connection] = worker, parcel
                with suppress(OSError):  # of one that has died; so says its answer
                    worker.connection.send(parcel)
            for connection in wait(list(busy)):
                worker, parcel = busy.pop(connection)
                if (answer := worker.answer()) is None:
                    how = staff.dismiss(worker)
                    (worker,), answer = staff.hire(1), ([], [])
                    if len(parcel) > 1:
                        waiting.extendleft([one] for one in reversed(parcel))
                    else:
                        yield parcel[0][0], Outcome(None, how, 0.0)
                idle.append(worker)
                for text in answer[0]:
                    warn(text)
                yield from unpacked(answer[1])


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
