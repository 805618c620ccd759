"""Progress of a run: a bar on a terminal, elsewhere a line every few seconds (logs of a build server)."""

import sys
import time
from typing import TextIO


class Progress:
    """Callable with the fraction done (0 to 1): `fmu.simulate(..., progress=Progress("Figure 4"))`."""

    def __init__(self, label: str, stream: TextIO | None = None):
        self.label, self.stream = label, stream or sys.stdout
        self.begin = self.spoke = time.perf_counter()
        self.bar = self.stream.isatty()
        self.shown = -1
        self.closed = False

    def __call__(self, fraction: float) -> None:
        """Shows `fraction`; 1 ends the bar with the seconds it took."""
        if self.closed:
            return
        seconds = time.perf_counter() - self.begin
        done = fraction >= 1.0
        if self.bar:
            percent = int(100 * min(fraction, 1.0))
            if percent != self.shown or done:
                filled = "#" * (percent * 30 // 100)
                end = f" {seconds:.1f} s\n" if done else ""
                self.stream.write(f"\r  {self.label:<44} [{filled:<30}] {percent:3d} %{end}")
                self.shown = percent
        elif done or self.begin + seconds > self.spoke + 5.0:
            self.stream.write(f"  {self.label:<44} {100 * min(fraction, 1.0):3.0f} %  {seconds:.1f} s\n")
            self.spoke = self.begin + seconds
        self.stream.flush()
        self.closed = done
