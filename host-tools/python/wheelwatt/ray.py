"""Sums of runs on Ray Data: as `wheelwatt.spark`. Needs ``ray[data]``, which has ``pyarrow``.

>>> logs = ray.data.from_items([{"path": path} for path in paths])
>>> runs = wheelwatt.ray.grams_of_logs(logs, coefficients="c.toml")
>>> wheelwatt.fit_grams(wheelwatt.ray.total(runs), model="eq18")
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyarrow as pa
import ray
from ray.data import Dataset

from ._commands import CoefficientsLike, RobotLike
from ._engine import Recipe, added

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


def total(grams: Dataset) -> pa.Table:
    """Adds all sums up: a table of one row, for `wheelwatt.fit_grams`. Sums of different settings are refused."""
    parts = grams.map_batches(added, batch_format="pyarrow", batch_size=None)
    return added(pa.concat_tables(ray.get(parts.to_arrow_refs())))
