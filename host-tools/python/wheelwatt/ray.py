"""Sums of runs on Ray Data: as `wheelwatt.spark`. Needs ``ray[data]``, which has ``pyarrow``.

>>> logs = ray.data.from_items([{"path": path} for path in paths])
>>> runs = wheelwatt.ray.grams_of_logs(logs, coefficients="c.toml")
>>> wheelwatt.fit_grams(wheelwatt.ray.total(runs), model="eq18")
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyarrow as pa
from ray.data import Dataset
from ray.data.aggregate import Max, Min, Sum

from ._commands import CoefficientsLike, RobotLike
from ._engine import _OF_TOTAL, Recipe
from ._grams import NUMBERS

__all__ = ["grams", "grams_of_logs", "total"]


def grams(
    rows: Dataset,
    *,
    run: Sequence[str] = ("run",),
    keys: Sequence[str] = (),
    robot: RobotLike = "burger",
    coefficients: CoefficientsLike | None = None,
    cutoff: float | None = None,
    mass: float | None = None,
    **units: Any,
) -> Dataset:
    """Rows of logs to a row of sums a run: as `wheelwatt.spark.grams`."""
    recipe = Recipe.of(robot, coefficients, cutoff, mass, units)
    run, keys = list(run), list(keys)

    def one(table: pa.Table) -> pa.Table:
        return recipe.of_run(table, run, keys)

    return rows.groupby([*keys, *run]).map_groups(one, batch_format="pyarrow")


def grams_of_logs(
    logs: Dataset,
    *,
    path: str = "path",
    keys: Sequence[str] = (),
    robot: RobotLike = "burger",
    coefficients: CoefficientsLike | None = None,
    cutoff: float | None = None,
    mass: float | None = None,
    batch: int = 8,
    **units: Any,
) -> Dataset:
    """Paths of logs to a row of sums a run, `batch` logs at a time: as `wheelwatt.spark.grams_of_logs`."""
    recipe = Recipe.of(robot, coefficients, cutoff, mass, units)
    keys = list(keys)

    def some(table: pa.Table) -> pa.Table:
        return recipe.of_logs(table, path, keys)

    return logs.map_batches(some, batch_format="pyarrow", batch_size=batch)


def total(grams: Dataset) -> dict[str, list[Any]]:
    """Adds all sums up: a table of one row, for `wheelwatt.fit_grams`. Sums of different settings are refused."""
    merge = {"sum": Sum, "min": Min, "max": Max}
    found = grams.aggregate(
        *(merge[how](name, ignore_nulls=False) for name, how in NUMBERS.items()), Min("setting"), Max("setting")
    )
    setting = found["min(setting)"]
    if setting != found["max(setting)"]:
        raise ValueError("sums of different settings; expected one robot, filter and reference")
    row: dict[str, Any] = {**_OF_TOTAL, "setting": setting}
    row.update({name: found[f"{how}({name})"] for name, how in NUMBERS.items()})
    return {name: [value] for name, value in row.items()}
