"""Signals such as Ctrl-C, held back while something is begun or ended that must not stay half done."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from multiprocessing import get_start_method, resource_tracker
from typing import Any


class Held(AbstractContextManager["Held"]):
    """Within this block, signals wait for its end, except within its `passing`. What a signal raises there ends that
    block, and holds later ones back, so that nothing interrupts the clean-up. Handlers in Python run in the main
    thread, so in others there is nothing to do."""

    def __init__(self) -> None:
        self._open, self._came, self._owner = True, list[int](), os.getpid()
        self._handlers: dict[int, Callable[..., Any]] = {}
        self._idle = True  # before and behind the block: signals are handed on as if this were not here

    def __enter__(self) -> "Held":
        try:
            if threading.current_thread() is threading.main_thread():
                for number in signal.valid_signals():
                    if callable(handler := signal.getsignal(number)):
                        self._handlers[number] = handler
                        signal.signal(number, self._handle)
            self._open = self._idle = False
        except BaseException:
            self._give_back([*self._handlers])
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._give_back([*self._handlers])
        finally:
            self._idle = True
        for number in self._came:
            signal.raise_signal(number)

    def _give_back(self, numbers: list[int]) -> None:
        """Sets the handlers that were before, whatever those raise meanwhile that are set."""
        try:
            while numbers:
                if signal.getsignal(numbers[-1]) == self._handle:  # else somebody has set another one
                    signal.signal(numbers[-1], self._handlers[numbers[-1]])
                numbers.pop()
        finally:
            if numbers:
                self._give_back(numbers)

    def _handle(self, number: int, frame: Any) -> None:
        if self._idle or os.getpid() != self._owner:
            self._handlers[number](number, frame)
        elif self._open:
            self._open = False  # what it may raise ends the block, and nothing interrupts that
            self._handlers[number](number, frame)
            self._open = True
        else:
            self._came.append(number)

    def _pass_on(self) -> None:
        self._open = True
        while self._came:
            signal.raise_signal(self._came.pop(0))

    @contextmanager
    def passing(self, passes: bool = True) -> Iterator[None]:
        """Signals act in this block; or they wait for its end, if it is within such a block."""
        before = self._open
        try:
            self._open = False
            if passes:
                self._pass_on()
            yield
        finally:
            self._open = False
            if before:
                self._pass_on()


@contextmanager
def blocked() -> Iterator[None]:
    """Processes that are started in this block get no Ctrl-C of a terminal until they call `unblock`."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    if get_start_method() != "fork":
        resource_tracker.ensure_running()  # some versions of Python unblock the signal when they start it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def ignore() -> None:
    """From now on, this process ignores Ctrl-C, which a terminal sends to all."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(AttributeError):  # on Windows
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
