"""What the tests of the engines share: a small fleet, and what its sums say on one machine."""

import json
import os
import pathlib
import subprocess
import time

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

import wheelwatt
from wheelwatt._log import _columns

ROBOTS, DAYS, LENGTH_S, RATE_HZ = 8, 3, 120, 200


class Fleet:
    """Logs of robots and days as files, and as one table of rows."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program
        self.coefficients = folder / "c.toml"
        self.logs, self.table = folder / "logs", folder / "rows.parquet"
        if not (folder / "whole").exists():
            self._make()
        self.paths = sorted(self.logs.glob("**/*.parquet"))
        self.rows = sum(parquet.read_metadata(path).num_rows for path in self.paths)

    def _gmr(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def _simulate(self, out, mass, seed, length=LENGTH_S):
        out.parent.mkdir(parents=True, exist_ok=True)
        self._gmr("simulate", "--rate", RATE_HZ, "--duration", length, "--mass", mass, "--seed", seed, "--columns",
                  "command", "--force", "--out", out)

    def _make(self):
        clean = [(self.folder / "empty.csv", 1), (self.folder / "full.csv", 6)]
        for out, mass in clean:
            self._simulate(out, mass, 999983, 60)
        self._gmr("fit", "--out", self.coefficients, *(out for out, _ in clean))
        tables = []
        for robot in range(ROBOTS):
            for day in range(1, DAYS + 1):
                log = self.logs / f"robot={robot}" / f"day=2026-11-{day:02}" / "0.csv"
                self._simulate(log, 1 + (robot + day) % 6, 10 * robot + day)
                self._gmr("convert", "--force", log, "--out", log.with_suffix(".parquet"))
                log.unlink()
                table = parquet.ParquetFile(log.with_suffix(".parquet")).read()
                for name, value in (("robot", robot), ("day", f"2026-11-{day:02}"), ("run", 0)):
                    table = table.append_column(name, pa.array([str(value)] * len(table)))
                tables.append(table)
        # Rows of all runs among each other: bringing a run together is the engine's.
        rows = pa.concat_tables(tables)
        order = np.random.default_rng(1).permutation(len(rows))
        parquet.write_table(rows.take(order), self.table, row_group_size=20_000)
        (self.folder / "whole").write_text("")

    def alone(self):
        """`gmr fleet` on the same logs, from nothing: rows a second."""
        out = self.folder / f"out-{time.time_ns()}"
        started = time.perf_counter()
        self._gmr("fleet", self.logs, "--coeffs", self.coefficients, "--out", out)
        return self.rows / (time.perf_counter() - started)

    def sums(self):
        """Of all logs, by the command."""
        file = self.folder / "sums.parquet"
        self._gmr("gram", "--force", "--coeffs", self.coefficients, "--out", file, *self.paths)
        return file


@pytest.fixture(scope="session")
def fleet():
    folder = pathlib.Path(os.environ["FLEET"])
    folder.mkdir(parents=True, exist_ok=True)
    return Fleet(folder, os.environ["GMR"])


@pytest.fixture(scope="session")
def expected(fleet):
    """Coefficients from the sums that one machine made."""
    return coefficients(fleet.sums())


@pytest.fixture(scope="session")
def figures():
    """Rows a second, by name: printed at the end."""
    found = {}
    yield found
    print("\n" + json.dumps(found, indent=1))
    pathlib.Path(os.environ["FLEET"], "figures.json").write_text(json.dumps(found, indent=1) + "\n")


def coefficients(sums):
    """Of Eq. 18, of the signed model, and by how much it is off the coefficients given, by one step of Gauss and Newton."""
    eq18, signed = (wheelwatt.fit_grams(sums, model=model) for model in ("eq18", "signed"))
    return {
        "eq18": [one.value for one in eq18.parameters],
        "step": step(sums),
        "signed": [one.value for one in signed.parameters],
    }


def step(sums):
    """What solves JᵀJ δ = Jᵀe over all runs: the signed model's clamp is in these sums, and no search."""
    table = parquet.read_table(sums) if isinstance(sums, pathlib.Path) else sums
    columns = {name: np.asarray(values, dtype=np.float64) for name, values in _columns(table) if name.startswith("local_")}
    score = np.array([columns[f"local_score_{i}"].sum() for i in range(8)])
    lower = iter(columns[f"local_normal_{k}"].sum() for k in range(36))
    normal = np.zeros((8, 8))
    for i in range(8):
        for j in range(i + 1):
            normal[i, j] = normal[j, i] = next(lower)
    used = np.diag(normal) > 0
    scale = 1.0 / np.sqrt(np.diag(normal)[used])
    scaled = normal[np.ix_(used, used)] * np.outer(scale, scale)
    return list(scale * np.linalg.solve(scaled, scale * score[used]))


#: What a partitioning may change, in shares of each coefficient: what is left of the rounding of the sums.
SAME = 1e-9


def are_same(found, expected):
    """Says how far they are apart."""
    off = {
        model: max(abs(a - b) / max(abs(b), 1e-12) for a, b in zip(found[model], expected[model])) for model in expected
    }
    print({model: f"{most:.1e}" for model, most in off.items()})
    return all(most < SAME for most in off.values())
