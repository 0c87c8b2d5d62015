"""A log in memory."""

from __future__ import annotations

import os
import re
import tempfile
import weakref
from collections.abc import Iterator, Mapping
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _gmr

Array = NDArray[np.float64]


class Log(Mapping[str, Array]):
    """Columns of a run, or of several, as arrays of equal length.

    Parameters
    ----------
    columns : a mapping of names to numbers, a pandas or Polars data frame, an Arrow table or record batch. Needed by most functions:
        ``time_s`` (increasing within a run), ``wheel1_rad_s … wheelN_rad_s`` (positive forward) and ``power_w``; README.md lists the
        others. A column ``run`` tells runs apart: numbers or text. NaN stands for an empty field. Numbers are kept as float64,
        shape (rows,), read-only.
    name : what errors and results call it

    A mapping of its columns without ``run``; `runs` has the run of each row.
    """

    def __init__(self, columns: Any, name: str = "log") -> None:
        self.name = name
        #: What reading left out of the file, in words; empty for columns that were no file.
        self.excluded = ""
        #: Of `simulate`: what was simulated. Else empty.
        self.simulated: dict[str, Any] = {}
        self._runs: list[str] | None = None
        self._columns: dict[str, Array] = {}
        for column, values in _columns(columns):
            if column == "run":
                self._runs = [_run_name(run) for run in values]
                continue
            numbers = np.array(values, dtype=np.float64)
            if numbers.ndim != 1:
                raise ValueError(f"column {column} has shape {numbers.shape}; expected (rows,)")
            numbers.flags.writeable = False
            self._columns[column] = numbers
        lengths = {len(values) for values in self._columns.values()}
        if self._runs is not None:
            lengths.add(len(self._runs))
        if len(lengths) > 1:
            raise ValueError(f"columns of {sorted(lengths)} rows; expected one length")
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    @property
    def runs(self) -> NDArray[np.str_] | None:
        """Name of each row's run, shape (rows,); None where there is one run only."""
        return None if self._runs is None else np.array(self._runs, dtype=np.str_)

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(next(iter(self._columns.values()), ()))

    def __getitem__(self, column: str) -> Array:
        return self._columns[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<wheelwatt.Log {self.name!r}: {self.rows} rows of {', '.join(self._columns)}>"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as CSV, whole or not at all; numbers so that reading gives the same back."""
        columns = [values.tobytes() for values in self._columns.values()]
        _gmr.write_log(os.fspath(path), list(self._columns), columns, self._runs)

    def _path(self) -> str:
        """It as a file, which lives as long as it does: commands read files."""
        if self._folder is None:
            folder = tempfile.TemporaryDirectory(prefix="gmr-")
            weakref.finalize(self, folder.cleanup)
            self.save(os.path.join(folder.name, self._file_name()))
            self._folder = folder
        return os.path.join(self._folder.name, self._file_name())

    def _file_name(self) -> str:
        return re.sub(r"[^\w.-]", "_", os.path.basename(self.name)) or "log"


#: A log in memory, or the path of one.
LogLike = Union[Log, str, "os.PathLike[str]"]


def _columns(table: Any) -> Iterator[tuple[str, Any]]:
    """Names and values of whatever has columns."""
    if isinstance(table, Log) and table.runs is not None:
        yield "run", table.runs
    # An Arrow table, or a record batch.
    if hasattr(table, "column_names") or hasattr(table, "schema") and hasattr(table, "column"):
        names = getattr(table, "column_names", None) or table.schema.names
        for place, name in enumerate(names):
            column = table.column(place)
            if name == "run":
                yield name, column.to_pylist()
            elif hasattr(column, "chunks"):
                yield name, column.to_numpy()
            else:
                # Of a batch, where empty fields have to be copied to become NaN.
                yield name, column.to_numpy(zero_copy_only=False)
        return
    names = table.keys() if isinstance(table, Mapping) else table.columns
    for name in names:
        column = table[name]
        yield str(name), column.to_numpy() if hasattr(column, "to_numpy") else column


def _run_name(run: Any) -> str:
    """Text as it is; numbers as short as they are."""
    if isinstance(run, str):
        return run
    if isinstance(run, bytes):
        return run.decode()
    return f"{float(run):g}" if float(run).is_integer() else repr(float(run))


def read(path: str | os.PathLike[str]) -> Log:
    """Reads a log: every column as numbers, rows without a time left out (`Log.excluded` counts them).

    Raises `Error` with file, line and column where it is none.
    """
    path = os.fspath(path)
    names, columns, run_names, runs, excluded = _gmr.read_log(path)
    table: dict[str, Any] = {name: np.frombuffer(column) for name, column in zip(names, columns)}
    if runs:
        table["run"] = [run_names[run] for run in runs]
    log = Log(table, name=path)
    log.excluded = excluded
    return log
