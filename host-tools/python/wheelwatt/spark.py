"""Sums of runs on Spark: runs are summed up where their rows lie, and the engine adds the sums. Needs ``pyspark`` and ``pyarrow``.

>>> rows = spark.read.parquet("s3a://logs")                             # robot, day, run, time_s, wheel1_rad_s, …, power_w
>>> runs = wheelwatt.spark.grams(rows, run=["run"], keys=["robot", "day"], coefficients="c.toml")
>>> runs.write.parquet("s3a://grams")                                   # a row a run: gmr fit --grams reads it
>>> total = wheelwatt.spark.total(runs)                                       # or by=["robot"]
>>> wheelwatt.fit_grams(total.toPandas(), model="eq18")
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pyarrow as pa
from pyspark.sql import DataFrame
from pyspark.sql.types import DoubleType, StringType, StructField, StructType

from ._commands import CoefficientsLike, RobotLike
from ._engine import Recipe, added
from ._grams import NUMBERS, TEXTS

__all__ = ["grams", "grams_of_logs", "total"]


def grams(
    rows: DataFrame,
    *,
    run: Sequence[str] = ("run",),
    keys: Sequence[str] = (),
    robot: RobotLike = "burger",
    coefficients: CoefficientsLike | None = None,
    cutoff: float | None = None,
    mass: float | None = None,
    **units: Any,
) -> DataFrame:
    """Rows of logs to a row of sums a run. Spark brings a run's rows together, in whatever partitions they lie.

    rows : with the columns of a log (SI; ``time_s`` in s), and those that tell runs apart
    run, keys : the columns that tell runs apart; `keys` are kept as columns, to group by
    coefficients, cutoff (Hz) : one of them, so that sums add up; as of `wheelwatt.gram`, and so are the others
    """
    recipe = Recipe.of(robot, coefficients, cutoff, mass, units)
    run, keys = list(run), list(keys)

    def one(table: pa.Table) -> pa.Table:
        return recipe.of_run(table, run, keys)

    return rows.groupBy(*keys, *run).applyInArrow(one, _schema(keys))


def grams_of_logs(
    logs: DataFrame,
    *,
    path: str = "path",
    keys: Sequence[str] = (),
    robot: RobotLike = "burger",
    coefficients: CoefficientsLike | None = None,
    cutoff: float | None = None,
    mass: float | None = None,
    **units: Any,
) -> DataFrame:
    """Paths of logs to a row of sums a run: whoever works reads them (CSV, Parquet, MCAP, …), and no row travels.

    logs : a column of paths that every worker sees, and `keys`; as many partitions as are to be worked on at once
    """
    recipe = Recipe.of(robot, coefficients, cutoff, mass, units)
    keys = list(keys)

    def some(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            yield from recipe.of_logs(batch, path, keys).to_batches()

    return logs.select(path, *keys).mapInArrow(some, _schema(keys))


def total(grams: DataFrame, by: Sequence[str] = ()) -> DataFrame:
    """Adds sums up, by these columns or all: for `wheelwatt.fit_grams`. Sums of different settings are refused."""
    by = list(by)

    def some(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        of = list(batches)
        if of:
            yield from added(pa.Table.from_batches(of), by).to_batches()

    parts = grams.select(*by, *TEXTS, *NUMBERS).mapInArrow(some, _schema(by))
    return parts.repartition(1).mapInArrow(some, _schema(by))


def _schema(keys: Sequence[str]) -> StructType:
    texts = [StructField(name, StringType()) for name in [*keys, *TEXTS]]
    return StructType(texts + [StructField(name, DoubleType()) for name in NUMBERS])
