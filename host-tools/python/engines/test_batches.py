"""Rows as Arrow batches, without an engine: the sums that the command makes of their log."""

import json

import numpy as np
import pyarrow as pa
import pytest
from conftest import are_same, coefficients

import wheelwatt
from wheelwatt import _gmr
from wheelwatt._engine import added


@pytest.fixture(scope="module")
def sums(fleet):
    return _gmr.Sums(["gram", f"--coeffs={fleet.coefficients}", "--out=none", "log"])


@pytest.fixture(scope="module")
def rows(fleet):
    return pa.table(dict(wheelwatt.read(fleet.paths[0])))


def test_sums_of_rows_are_those_of_the_log(fleet, sums, rows, tmp_path):
    """To the bit, in batches of any length and in any order; and a table of them is a file of them."""
    wheelwatt.gram(fleet.paths[0], tmp_path / "g.parquet", coefficients=fleet.coefficients)
    expected = wheelwatt.fit_grams(tmp_path / "g.parquet").json()
    keys = {"robot": "7", "day": "1"}
    told = list(keys), list(keys.values())
    shuffled = rows.take(np.random.default_rng(1).permutation(len(rows)))
    batches = [pa.Table.from_batches(of.to_batches(100)) for of in (rows, shuffled)]
    found = [sums.of_logs([fleet.paths[0]], told[0], [told[1]])]
    found += [sums.of_rows(fleet.paths[0], of, *told) for of in batches]
    for table in map(pa.table, found):
        assert wheelwatt.fit_grams(table).json() == expected
        assert table.column_names[:2] == ["robot", "day"] and json.loads(table["keys"][0].as_py()) == keys


def test_an_empty_field_is_none(sums, rows):
    """Left out as where a log has an empty field, and counted."""
    power = rows["power_w"].to_pylist()
    power[7] = None
    place = rows.column_names.index("power_w")
    table = pa.table(sums.of_rows("log", rows.set_column(place, "power_w", pa.array(power)), [], []))
    left_out = [name for name in table.column_names if name.startswith("summary_exclusions_")]
    assert sum(table[name][0].as_py() == 1 for name in left_out) == 1


def test_what_is_no_column_of_numbers_is_refused(sums, rows):
    texts = rows.set_column(rows.column_names.index("power_w"), "power_w", rows["power_w"].cast(pa.string()))
    with pytest.raises(wheelwatt.Error, match="is of type Utf8; expected float64"):
        sums.of_rows("log", texts, [], [])
    with pytest.raises(AttributeError, match="__arrow_c_stream__"):
        sums.of_rows("log", [1.0], [], [])


def test_sums_add_up_by_any_parts_and_only_of_one_setting(fleet, sums, tmp_path):
    """What workers have added, added again, is all added at once; by keys too."""
    logs = fleet.paths[:4]
    rows = pa.table(sums.of_logs(logs, ["robot"], [["1"], ["2"], ["1"], ["2"]]))
    wheelwatt.gram(logs, tmp_path / "g.parquet", coefficients=fleet.coefficients)
    parts = pa.concat_tables([added(rows[:3], ["robot"]), added(rows[3:], ["robot"])])
    assert are_same(coefficients(added(parts)), coefficients(tmp_path / "g.parquet"))
    by_robot = added(parts, ["robot"])
    assert by_robot["robot"].to_pylist() == ["1", "2"]
    assert by_robot["summary_rows"].to_pylist() == [sum(rows["summary_rows"].to_pylist()[k::2]) for k in (0, 1)]
    place = rows.column_names.index("setting")
    others = rows.set_column(place, "setting", pa.array(["one", "other", "one", "other"]))
    assert len(added(others, ["robot"])) == 2
    with pytest.raises(ValueError, match="sums of different settings"):
        added(others)
