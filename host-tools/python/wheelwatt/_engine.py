"""Sums of runs on engines of many machines: what `wheelwatt.spark` and `wheelwatt.ray` share. Whole runs are the unit; adding is the engine's."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pyarrow as pa

from . import _gmr
from ._commands import CoefficientsLike, RobotLike, _Call
from ._grams import NUMBERS, TEXTS

#: Columns of text of a row of sums whose values a total has none of.
OF_TOTAL = {"run": "", "keys": "{}", "summary_masses": "[]"}


@dataclass(frozen=True)
class Recipe:
    """How runs are summed up: everything that a worker needs, files by their text, as workers have none of ours.

    robot : a robot.toml, or burger, warthog, husky
    coefficients : signed; their filter, delay and slip memory, and sums near them
    cutoff : of the filter, Hz; one of both has to be given, so that sums of all machines add up
    mass : total mass of logs without a mass_kg column, kg
    """

    robot: str = "burger"
    robot_text: str | None = None
    coefficients_text: str | None = None
    cutoff: float | None = None
    mass: float | None = None
    units: tuple[tuple[str, Any], ...] = field(default=())

    @classmethod
    def of(
        cls,
        robot: RobotLike,
        coefficients: CoefficientsLike | None,
        cutoff: float | None,
        mass: float | None,
        units: dict[str, Any],
    ) -> Recipe:
        if coefficients is None and cutoff is None:
            raise ValueError("neither coefficients nor cutoff; expected one of them, so that sums of all machines add up")
        text = None
        if coefficients is not None:
            with _Call("gram") as call, open(call.coefficients(coefficients), encoding="utf-8") as file:
                text = file.read()
        robot_text = None
        if os.path.exists(robot):
            with open(robot, encoding="utf-8") as file:
                robot_text = file.read()
        return cls(os.fspath(robot), robot_text, text, cutoff, mass, tuple(units.items()))

    def sums(self) -> _gmr.Sums:
        """As this process has it: made once, whatever tasks it is given."""
        # Units may hold a list, which has no hash.
        key = repr(self)
        if key not in _SUMS:
            with _Call("gram", json=False) as call:
                call.add("--robot", self._file(call, "robot.toml", self.robot_text) or self.robot)
                call.add("--coeffs", self._file(call, "coefficients.toml", self.coefficients_text))
                call.add("--cutoff", self.cutoff if self.coefficients_text is None else None)
                call.add("--mass", self.mass).add("--out", "unwritten").units(dict(self.units))
                _SUMS[key] = _gmr.Sums([*call.arguments, "log"])
        return _SUMS[key]

    @staticmethod
    def _file(call: _Call, name: str, text: str | None) -> str | None:
        if text is None:
            return None
        with open(call.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return call.path(name)

    def of_run(self, table: pa.Table, run: Sequence[str], keys: Sequence[str]) -> pa.Table:
        """A row of sums of a whole run's rows, in whatever order they come."""
        told = {name: str(table.column(name)[0].as_py()) for name in [*keys, *run]}
        numbers = [name for name in table.column_names if name not in told and _is_number(table.schema.field(name).type)]
        rows = table.select(numbers).cast(pa.schema([(name, pa.float64()) for name in numbers]))
        name = "/".join(told.values()) or "log"
        return pa.table(self.sums().of_rows(name, rows, list(keys), [told[key] for key in keys]))

    def of_logs(self, batch: pa.RecordBatch | pa.Table, path: str, keys: Sequence[str]) -> pa.Table:
        """Rows of sums of the logs whose paths a column has: read where they lie, by whoever works."""
        rows = batch.select([path, *keys]).to_pylist()
        values = [[str(row[key]) for key in keys] for row in rows]
        return pa.table(self.sums().of_logs([row[path] for row in rows], list(keys), values))


#: What recipes have become in this process.
_SUMS: dict[str, _gmr.Sums] = {}


def _is_number(of: pa.DataType) -> bool:
    return pa.types.is_floating(of) or pa.types.is_integer(of) or pa.types.is_boolean(of)


def schema(keys: Sequence[str]) -> pa.Schema:
    """Of rows of sums: the keys, the texts, the numbers. What a run has none of is NaN, which adds up to NaN: a part that one run lacks, the total lacks."""
    texts = [(name, pa.string()) for name in [*keys, *TEXTS]]
    return pa.schema(texts + [(name, pa.float64()) for name in NUMBERS])


def added(rows: pa.Table, by: Sequence[str] = ()) -> pa.Table:
    """Rows of sums added up, by these columns or all: by a worker what it has, and then what workers have. Engines' own sums of 640
    columns are programs that take seconds to compile."""
    by = list(by)
    # By one thread: groups and what they add up to would else come in another order each time.
    groups = rows.group_by([*by, "setting"], use_threads=False).aggregate([(name, how) for name, how in NUMBERS.items()])
    if len(groups) > (len(groups.group_by(by).aggregate([])) if by else 1):
        raise ValueError("sums of different settings; expected one robot, filter and reference")
    columns = {name: pa.repeat(pa.scalar(text), len(groups)) for name, text in OF_TOTAL.items()}
    columns |= {name: groups[name] for name in [*by, "setting"]}
    columns |= {name: groups[f"{name}_{how}"] for name, how in NUMBERS.items()}
    return pa.table([columns[name] for name in schema(by).names], schema=schema(by))
