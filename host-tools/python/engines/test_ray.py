"""Ray Data with two workers: the same coefficients."""

import time

import pytest
import ray
from conftest import are_same, coefficients

import wheelwatt.ray

KEYS = ["robot", "day"]


@pytest.fixture(scope="module")
def cluster():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, object_store_memory=300_000_000)
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield
    ray.shutdown()


def check(runs, fleet, expected, figures, name, started):
    runs = runs.materialize()
    took = time.perf_counter() - started
    assert runs.count() == len(fleet.paths)
    print(f"{name}: {fleet.rows / took:.3g} rows/s", end="; ")
    figures[name] = fleet.rows / took
    assert are_same(coefficients(wheelwatt.ray.total(runs)), expected)


def test_logs_on_two_workers(cluster, fleet, expected, figures):
    items = [
        {"path": str(path), "robot": path.parts[-3].split("=")[1], "day": path.parts[-2].split("=")[1]}
        for path in fleet.paths
    ]
    for blocks in (2, 6):
        started = time.perf_counter()
        logs = ray.data.from_items(items, override_num_blocks=blocks)
        runs = wheelwatt.ray.grams_of_logs(logs, keys=KEYS, coefficients=fleet.coefficients)
        check(runs, fleet, expected, figures, "ray, logs, 2 workers", started)


def test_rows_on_two_workers(cluster, fleet, expected, figures):
    started = time.perf_counter()
    rows = ray.data.read_parquet(str(fleet.table))
    runs = wheelwatt.ray.grams(rows, run=["run"], keys=KEYS, coefficients=fleet.coefficients)
    check(runs, fleet, expected, figures, "ray, rows, 2 workers", started)
