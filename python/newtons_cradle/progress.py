"""Progress of a run: a bar on a terminal, elsewhere a line every few seconds (logs of a build server)."""

import sys
import time


class Progress:
    """Callable with the fraction done (0 to 1): `fmu.simulate(..., progress=Progress("Figure 4"))`."""

    def __init__(self, label: str):
        self.label = label
        self.begin = self.spoke = time.perf_counter()
        self.done = False

    def __call__(self, fraction: float) -> None:
        """Shows `fraction`; 1 ends the bar with the seconds it took."""
        if self.done:
            return
        now = time.perf_counter()
        self.done = fraction >= 1.0
        took, percent = f"{now - self.begin:.1f} s", int(100 * min(fraction, 1.0))
        if sys.stdout.isatty():
            end = f" {took}\n" if self.done else ""
            sys.stdout.write(f"\r  {self.label:<44} [{'#' * (percent * 30 // 100):<30}] {percent:3d} %{end}")
        elif self.done or now > self.spoke + 5.0:
            sys.stdout.write(f"  {self.label:<44} {percent:3d} %  {took}\n")
            self.spoke = now
        sys.stdout.flush()
