"""Runs the cases of a sweep in processes of this machine, which are started, watched and ended here."""

import multiprocessing
import os
import pickle
import shutil
import warnings
from collections.abc import Generator
from contextlib import AbstractContextManager, suppress
from importlib import import_module
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Thread
from typing import Any

from . import archive
from .errors import CradleError, DoubtfulStart, FmuError, InvalidValue, warn
from .fmu import Fmu
from .interrupts import Held, blocked, ignore
from .workers import TOP_LEVEL, Case, Measure, Numbered, Outcome, answers, parcels, said, unpacked

PATIENCE = 5.0  # s, to wait for the children of a killed process


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
        """Its warnings about start values, and its outcomes of a parcel; None if it has died."""
        try:
            told, made = self.connection.recv()
            return told, made
        except (EOFError, OSError):
            return None

    def end(self) -> None:
        """Kills it, and waits for its end and (with a timeout) its children's, which share the sentinel and end by
        themselves."""
        self.process.kill()
        self.process.join(PATIENCE)
        self.process.join()
        self.connection.close()


class Staff(AbstractContextManager["Staff"]):
    """The processes of a sweep and their folder; the end of the block ends and removes them. `held`: the signals held
    back."""

    def __init__(self, held: Held, path: Path, run: bytes):
        self.held, self.path, self.run = held, path, run
        self.folder, self.workers = archive.temporary(), list[Worker]()

    def hire(self, count: int) -> list[Worker]:
        """Starts `count` workers. Raises InvalidValue, FmuError."""
        hired = []
        for _ in range(count):
            with self.held.passing(False):
                hired.append(Worker(self.path, self.folder, self.run))
                self.workers.append(hired[-1])
        for worker in hired:
            worker.check()
        return hired

    def dismiss(self, worker: Worker) -> str:
        """Removes a worker that has died; returns how it died, for a message."""
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
    """The main loop of a worker, until it is killed or the sweep's process is gone."""
    ignore()  # the sweep's process ends its workers
    Thread(target=outlive, args=(folder,), daemon=True).start()
    archive.keep_within(folder)  # which `Staff` removes when this process is killed
    doubts = collected()
    try:
        measure = pickle.loads(run)
        fmu = Fmu(path)
    except CradleError as problem:
        connection.send(problem)
        return
    except Exception as problem:  # such as a module that is missing here
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
    """Waits until the parent process is gone, however it ended; then removes the folder and ends this process."""
    parent = multiprocessing.parent_process()
    wait([parent.sentinel] if parent else [])
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def collected() -> list[str]:
    """A list that collects warnings about doubtful start values from now on, in place of showing them."""
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
    """Yields outcomes as they come from processes of this machine. If a process dies, its parcel runs again, case by
    case. Raises InvalidValue, FmuError."""
    try:
        packed_run = pickle.dumps(run)
    except Exception as problem:  # pickling may raise anything
        words = f"measure: it cannot be sent to other processes ({said(problem)}); {TOP_LEVEL}"
        raise InvalidValue(words) from None
    waiting, failed = parcels(cases, workers)
    yield from failed
    import_module(".run.slaves", __package__)  # imports FMPy once, before the processes fork
    busy: dict[Any, tuple[Worker, list[Numbered]]] = {}
    with Held() as held, Staff(held, path, packed_run) as staff, held.passing():
        idle = staff.hire(min(workers, len(waiting)))
        while waiting or busy:
            while waiting and idle:
                worker, parcel = idle.pop(), waiting.popleft()
                busy[worker.connection] = worker, parcel
                with suppress(OSError):  # it has died, as `answer` will tell
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
