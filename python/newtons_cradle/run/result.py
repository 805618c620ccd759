"""The result of a run: samples and pulses, as NumPy arrays, data frame, data set, Parquet file or plot."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidValue, UnknownName, did_you_mean, needed, number, optional, shown as shown_value
from ..files import in_folder
from ..markup import html_table
from ..pulses import Array, pulse_table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .model import Model

NARROW = 0.01  # of the time before it, or of its values: a narrower view is shown from an offset

LEGEND = 10  # names in a column of a legend


class Result(Mapping[str, Array]):
    """Samples of a run and its pulses: a mapping from names to arrays with a value for each sample.

    `result["x[1]"]` is one variable, `result["x"]` all elements of an array, shape (samples, elements); `result.time`
    in s. `samples`: structured array with `time` and one field per recorded variable; `pulses`: structured array of
    dtype `PULSE`, finished pulses only, by onset; `units`: of the recorded variables, by name; `dims`: by array,
    whether its elements belong to a `ball` or a `contact`; `model`: what was run, and `given`: its parameters and
    inputs at the end, by name, if known. Results are equal if their samples, pulses and units are.
    """

    def __init__(
        self,
        samples: Array,
        pulses: Array | bytes,
        units: dict[str, str] | None = None,
        dims: dict[str, str] | None = None,
        model: "Model | None" = None,
        given: Callable[[], dict[str, Any]] = dict,
    ):
        """`pulses`: a table, or the text of a log. `given`: a function that returns the dict, called at first use."""
        self.samples, self._pulses = samples, pulses
        self.units, self.dims, self.model, self._given = units or {}, dims or {}, model, given

    @cached_property
    def pulses(self) -> Array:
        return pulse_table(self._pulses) if isinstance(self._pulses, bytes) else self._pulses

    @cached_property
    def given(self) -> dict[str, Any]:
        return self._given()

    def __copy__(self) -> "Result":
        made = Result.__new__(type(self))
        vars(made).update(vars(self))
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> "Result":
        """Copies the arrays; the model is shared."""
        made = copy(self)
        made.samples, made.pulses, made.given = self.samples.copy(), self.pulses.copy(), dict(self.given)
        made.units, made.dims = dict(self.units), dict(self.dims)
        return made

    def __getstate__(self) -> dict[str, Any]:
        """For another process: everything but the model, which belongs to this one."""
        return vars(self) | {"model": None, "given": self.given, "_given": dict}

    def __repr__(self) -> str:
        return f"Result({self._summary()})"

    def _summary(self) -> str:
        time, vectors = self.time, ", ".join(self.vectors())
        span = f" from {time[0]:.9g} s to {time[-1]:.9g} s" if len(time) else ""
        return f"{len(time)} samples{span} of {vectors}; {len(self.pulses)} pulses"

    def _repr_html_(self) -> str:
        rows = []
        for name in self.vectors():
            values, columns = self[name], self.columns(name)
            ends = [f"{end:.6g}" for end in (values.min(), values.max())] if values.size else ["", ""]
            shown = name if columns == [name] else f"{columns[0]} to [{columns[-1].rpartition('[')[2]}"
            rows.append([shown, self.units.get(columns[0], ""), *ends])
        return html_table(["name", "unit", "smallest", "largest"], *rows, below=self._summary())

    def vectors(self) -> list[str]:
        """The recorded names, arrays as a whole."""
        return list(dict.fromkeys(name.partition("[")[0] for name in self._names[1:]))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Result):
            return NotImplemented
        same_names = self._names == other._names and self.units == other.units
        tables = (self.samples, other.samples), (self.pulses, other.pulses)
        return same_names and all(equal(mine, others) for mine, others in tables)

    __hash__ = None  # type: ignore[assignment]

    def __contains__(self, name: object) -> bool:
        """Whether this variable, or an element of this array, was recorded."""
        return any(name in (column, column.partition("[")[0]) for column in self._names)

    def __iter__(self) -> Iterator[str]:
        """The recorded names, `time` first."""
        return iter(self._names)

    def __len__(self) -> int:
        """The number of recorded names, with `time`."""
        return len(self._names)

    def _ipython_key_completions_(self) -> list[str]:
        return list(dict.fromkeys([*self.vectors(), *self._names]))

    @property
    def time(self) -> Array:
        """The time of each sample, s."""
        time: Array = self.samples["time"]
        return time

    @property
    def _names(self) -> list[str]:
        return list(self.samples.dtype.names or ())

    def __getitem__(self, name: str) -> Array:
        """One variable, shape (samples,), or all elements of an array, (samples, elements). Raises UnknownName."""
        columns = self.columns(name)
        one: Array = self.samples[columns[0]]
        return one if columns == [name] else np.column_stack([self.samples[column] for column in columns])

    def columns(self, name: str) -> list[str]:
        """The recorded variables that a name stands for: itself, or the elements of a vector."""
        needed("name", name, str, "a variable's, such as 'x[1]',")
        found = [column for column in self._names if column == name or column.startswith(f"{name}[")]
        if not found:
            vectors = ["time", *self.vectors()]
            hint = did_you_mean(name, [*vectors, *self._names])
            recorded = f"recorded: {', '.join(vectors)}; others by `record=[...]`"
            raise UnknownName(f"{name} was not recorded{hint} ({recorded})")
        return found

    def to_dataframe(self) -> "pd.DataFrame":
        """The samples as a pandas data frame: index `time` (s), a column for each variable, units in `attrs["units"]`.

        The pulses are a table of their own, `result.pulses.to_dataframe()`. Raises PackageMissing without pandas.
        """
        pandas = optional("pandas", "data")
        frame = pandas.DataFrame({name: self.samples[name] for name in self._names}).set_index("time")
        frame.attrs["units"] = {name: self.units[name] for name in self._names if name in self.units}
        return frame

    def to_xarray(self) -> "xr.Dataset":
        """The samples as an xarray data set: `x(time, ball)`, `F(time, contact)`, balls and contacts from 1, `units` in
        the attributes of each. Raises PackageMissing without xarray."""
        xarray = optional("xarray", "data")
        time = {"time": ("time", self.time, {"units": "s"})}
        arrays = {}
        for name in self.vectors():
            dims, coords, about = self.labels(name)
            arrays[name] = xarray.DataArray(self[name], coords=time | coords, dims=dims, attrs=about)
        found: xr.Dataset = xarray.Dataset(arrays, coords=time)
        return found

    def labels(self, name: str) -> tuple[list[str], dict[str, Any], dict[str, str]]:
        """The dimensions of an array or a variable in a data set, its coordinates besides time, and its attributes."""
        columns = self.columns(name)
        about = {"units": self.units.get(columns[0], "")}
        if columns == [name]:
            return ["time"], {}, about
        dim = self.dims.get(name, f"{name}_element")
        return ["time", dim], {dim: [int(column.rpartition("[")[2].rstrip("]")) for column in columns]}, about

    def to_parquet(self, path: str | Path) -> None:
        """Writes the data frame as a Parquet file, which pandas reads with units. Raises PackageMissing
        without pyarrow, FileMissing without the folder."""
        path = in_folder(path)
        frame = self.to_dataframe()
        optional("pyarrow", "data")
        frame.to_parquet(path, engine="pyarrow")

    def plot(self, *signals: str, origin: float | None = None, ax: "Axes | Sequence[Axes] | None" = None) -> "Figure":
        """A plot with a strip for each signal: `plot("x", "F[2]").savefig("run.png")`.

        A signal is a variable or an array, whose elements share a strip; the first are drawn wider, so that equal ones
        all show. Without signals, it shows the positions x or, if those were not recorded, everything that was.
        `origin`: the time (s) that the axis counts from; if None, 0, or the first sample of a view that is much shorter
        than the time before it. `ax`: axes of your own to draw in, one for each signal. Raises UnknownName,
        InvalidValue, and PackageMissing without matplotlib.
        """
        optional("matplotlib", "plot")
        from matplotlib import pyplot
        from matplotlib.ticker import EngFormatter

        vectors = self.vectors()
        shown = signals or (vectors if vectors and "x" not in vectors else ["x"])
        columns = [self.columns(signal) for signal in shown]  # raises before there is a figure
        time = self.time
        if origin is None:
            origin = float(time[0]) if len(time) and time[-1] - time[0] < NARROW * time[0] else 0.0
        origin = number("origin", origin, "s")
        beside = max(map(len, columns)) // LEGEND + 1  # columns of a legend
        if ax is None:
            size = (8.0 + beside, 1.0 + 1.8 * len(shown))
            figure, axes = pyplot.subplots(len(shown), figsize=size, sharex=True, squeeze=False, layout="constrained")
            strips = list(axes.flat)
        else:
            strips = list(np.atleast_1d(np.asarray(ax, dtype=object)).flat)
            if not all(hasattr(strip, "get_figure") for strip in strips):
                raise InvalidValue(f"ax: axes of matplotlib are needed, not {shown_value(ax)}")
            if len(strips) != len(shown):
                raise InvalidValue(f"ax: {len(strips)} axes for {len(shown)} signals; needed: one for each")
            figure = strips[0].get_figure(root=True)
        for axis, signal, names in zip(strips, shown, columns, strict=True):
            for place, name in enumerate(names, start=1):
                width = 1.0 + 3.0 * (1 - place / len(names))
                axis.plot(time - origin, self.samples[name], label=name, linewidth=width)
            axis.set_ylabel(signal)
            if self.samples.dtype[names[0]].kind == "b":
                axis.set_yticks([0, 1])
            elif (unit := self.units.get(names[0], "1")) not in ("", "1"):
                low, high = axis.dataLim.intervaly
                if high - low > NARROW * max(abs(low), abs(high)):
                    axis.yaxis.set_major_formatter(EngFormatter(unit))
                else:  # matplotlib's own formatter writes only once what all ticks share
                    axis.set_ylabel(f"{signal}, {unit}")
            axis.grid(alpha=0.3)
            if len(names) > 1:
                axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), ncols=beside, fontsize="x-small")
        strips[-1].set_xlabel(f"time after {origin:.12g} s" if origin else "time")
        strips[-1].xaxis.set_major_formatter(EngFormatter("s"))
        return figure

    def page(self, path: str | Path) -> int:
        """Writes the run as a page for a browser, one HTML file; returns its size in bytes.

        It takes x, v and F of all balls and contacts, samples that follow the balls, and energies if they were
        recorded; `resolved` samples within the pulses as well. Raises RecordingError, which says what is missing,
        FileMissing or OSError.
        """
        from ..page import save_page
        from ..recording import from_result

        columns = {name: self.samples[name] for name in self._names}
        return save_page(path, from_result(columns, self.pulses, self.model, self.given))


def equal(one: Array, other: Array) -> bool:
    """Whether two arrays are equal; NaN equals NaN."""
    if one.dtype.names:
        names = one.dtype.names
        return names == other.dtype.names and all(equal(one[name], other[name]) for name in names)
    return np.array_equal(one, other, equal_nan="f" == one.dtype.kind == other.dtype.kind)
