"""Sums of runs: their columns, and fits from them alone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _gmr
from ._commands import RobotLike, _Call
from ._log import _columns
from ._results import Fitted, Parameter

_TEXTS, _NUMBERS = _gmr.gram_columns()

#: Columns of text of a row of sums.
TEXTS: tuple[str, ...] = tuple(_TEXTS)

#: Columns of numbers, and what becomes of each when runs are added up: ``sum``, ``min`` or ``max``.
NUMBERS: dict[str, str] = dict(_NUMBERS)


class GramFit(Fitted):
    """A model fitted to sums alone.

    Attributes
    ----------
    r2, rmse_w : on the rows in the sums; r2 is None where the power never changes
    rows, left_out_rows : in the sums, and behind the filter but not in them (signed: where a wheel can be clamped)
    parameters : one by one; standard errors are drawn from how runs differ
    left_out : of each run, R² and RMSE by what the others say; empty unless asked for
    warnings : what sums cannot tell
    """

    def __init__(self, text: str, said: Sequence[str]) -> None:
        self._text, self.said = text, tuple(said)
        data = self.data
        self.robot: str = data["robot"]
        self.model: str = data["model"]
        self.r2: float | None = data["r2"]
        self.rmse_w: float = data["rmse_w"]
        self.rows: int = data["rows"]
        self.left_out_rows: int = data["left_out_rows"]
        self.parameters: tuple[Parameter, ...] = tuple(Parameter(**one) for one in data["parameters"])
        self.left_out: tuple[dict[str, Any], ...] = tuple(data["left_out"] or ())
        self.warnings: tuple[str, ...] = tuple(data["warnings"])


def fit_grams(
    grams: Any, *, robot: RobotLike = "burger", model: str = "signed", leave_one_out: bool = False
) -> GramFit:
    """Fits a model to sums, without the logs.

    grams : files of `gram`; or their rows as a table (pandas, Polars, Arrow) with the columns `TEXTS` and `NUMBERS`, one a run or a total
    model : ``signed``, ``eq18`` or ``eq18-published``
    leave_one_out : also how well each run is predicted by the others (not signed)
    """
    with _Call("fit") as call:
        call.add("--robot", robot).add("--model", model).flag("--leave-one-out", leave_one_out)
        files = [grams] if isinstance(grams, (str, os.PathLike)) else grams
        if not (isinstance(files, (list, tuple)) and all(isinstance(one, (str, os.PathLike)) for one in files)):
            files = [call.path("grams.parquet")]
            _gmr.write_grams(files[0], _rows(grams))
        call.arguments += ["--grams", *(os.fspath(file) for file in files)]
        return GramFit(*call.run())


def _rows(grams: Any) -> list[tuple[list[str], list[float]]]:
    """Texts and numbers of a table, row by row."""
    columns = {name: np.asarray(values) for name, values in _columns(grams)}
    missing = [name for name in [*TEXTS, *NUMBERS] if name not in columns]
    if missing:
        raise ValueError(f"column {missing[0]} is missing; expected the columns of wheelwatt.gram")
    texts = zip(*(columns[name] for name in TEXTS))
    numbers = np.column_stack([np.asarray(columns[name], dtype=np.float64) for name in NUMBERS])
    return [([str(text) for text in row], list(values)) for row, values in zip(texts, numbers.tolist())]
