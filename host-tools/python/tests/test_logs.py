"""Logs in memory are logs."""

import numpy as np
import pytest

import wheelwatt

COLUMNS = {
    "time_s": np.arange(400) * 0.05,
    "wheel1_rad_s": np.linspace(0.0, 5.0, 400),
    "wheel2_rad_s": np.linspace(0.0, 4.0, 400),
    "power_w": 1.0 / (1.0 + np.arange(400)),
    "mass_kg": np.full(400, 2.0),
}


def test_columns_survive_the_file(tmp_path):
    power = COLUMNS["power_w"].copy()
    power[3] = np.nan
    log = wheelwatt.Log({**COLUMNS, "power_w": power, "run": ["a, b"] * 200 + ["c"] * 200})
    log.save(tmp_path / "log.csv")
    again = wheelwatt.read(tmp_path / "log.csv")
    assert list(again) == list(log) and again.rows == 400
    for column in log:
        np.testing.assert_array_equal(again[column], log[column])
    assert list(again.runs) == list(log.runs) == ["a, b"] * 200 + ["c"] * 200


def test_a_log_in_memory_is_inspected_as_its_file(tmp_path):
    log = wheelwatt.Log(COLUMNS, name="mine")
    log.save(tmp_path / "mine")
    in_memory, of_file = wheelwatt.inspect(log, plot=False).data, wheelwatt.inspect(tmp_path / "mine", plot=False).data
    assert in_memory.pop("log") != of_file.pop("log")
    assert in_memory == of_file


class Column:
    """As Arrow's: numbers behind a method."""

    def __init__(self, values):
        self.values, self.chunks = values, [values]

    def to_numpy(self):
        return self.values

    def to_pylist(self):
        return list(self.values)


class Table:
    """As Arrow's, of which the tests need no library."""

    column_names = list(COLUMNS)

    def column(self, place):
        return Column(COLUMNS[self.column_names[place]])


def test_tables_are_taken_by_their_columns():
    log = wheelwatt.Log(Table())
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(log[name], values)


def test_columns_cannot_be_changed_behind_its_back():
    log = wheelwatt.Log(COLUMNS)
    with pytest.raises(ValueError):
        log["time_s"][0] = 1.0
    with pytest.raises(ValueError, match="one length"):
        wheelwatt.Log({"time_s": [0.0, 1.0], "power_w": [1.0]})


def test_errors_name_the_log_and_the_place():
    times = COLUMNS["time_s"].copy()
    times[7] = times[6]
    with pytest.raises(wheelwatt.Error) as caught:
        wheelwatt.inspect(wheelwatt.Log({**COLUMNS, "time_s": times}, name="stuck clock"), plot=False)
    error = caught.value
    assert (error.file, error.line, error.column, error.exit_code) == ("stuck clock", 9, "time_s", 1)
    assert str(error).startswith("stuck clock:9:time_s: time 0.3")
