"""Holds back signals such as Ctrl-C while something begins or ends that must not stay half done."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from multiprocessing import get_start_method, resource_tracker
from typing import Any


class Held(AbstractContextManager["Held"]):
    """Holds signals back until the end of its block, except within `passing`. An exception that a signal raises there
    ends the `passing` block, and later signals are held back, so that nothing interrupts the clean-up. Python runs
    handlers in the main thread only, so in other threads this does nothing."""

    def __init__(self) -> None:
        self._open, self._came, self._owner = True, list[int](), os.getpid()
        self._handlers: dict[int, Callable[..., Any]] = {}
        self._idle = True  # outside the block: signals go straight to their handlers

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
        """Restores the previous handlers, even if one of them raises meanwhile."""
        try:
            while numbers:
                if signal.getsignal(numbers[-1]) == self._handle:  # else somebody has replaced it
                    signal.signal(numbers[-1], self._handlers[numbers[-1]])
                numbers.pop()
        finally:
            if numbers:
                self._give_back(numbers)

    def _handle(self, number: int, frame: Any) -> None:
        if self._idle or os.getpid() != self._owner:
            self._handlers[number](number, frame)
        elif self._open:
            self._open = False  # if the handler raises, the block ends, with other signals held back
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
        """Lets signals act in this block; with `passes=False` it holds them back until the block ends."""
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
    """Processes started in this block do not receive a terminal's Ctrl-C before they call `ignore`."""
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
    """Makes this process ignore Ctrl-C, which a terminal sends to all its processes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(AttributeError):  # Windows has no signal masks
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
