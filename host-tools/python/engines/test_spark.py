"""Spark with executors that are processes of their own: the same coefficients, however the work is cut, and whoever is killed."""

import os
import pathlib
import signal
import sys
import threading
import time

import pyarrow as pa
import pyspark
import pytest
from conftest import are_same, coefficients
from pyspark.sql import SparkSession

import wheelwatt.spark

KEYS = ["robot", "day"]


def session(executors):
    """`local-cluster`: a master, and as many workers with an executor each."""
    os.environ.setdefault("SPARK_HOME", str(pathlib.Path(pyspark.__file__).parent))
    os.environ["PYSPARK_PYTHON"] = sys.executable
    builder = SparkSession.builder.master(f"local-cluster[{executors},1,1024]")
    for key, value in {
        "spark.ui.enabled": "false",
        "spark.executor.memory": "1g",
        "spark.driver.memory": "1g",
        "spark.sql.shuffle.partitions": "8",
        "spark.driver.bindAddress": "127.0.0.1",
        "spark.driver.host": "127.0.0.1",
    }.items():
        builder = builder.config(key, value)
    return builder.getOrCreate()


@pytest.fixture(scope="module", params=[1, 2, 4])
def spark(request):
    """One after the other: a program has one."""
    of = session(request.param)
    # Executors come up while the first job runs: what is measured is not their start.
    of.range(1000, numPartitions=4 * request.param).count()
    of.executors = request.param
    yield of
    of.stop()


def logs(spark, fleet, partitions):
    rows = [(str(path), path.parts[-3].split("=")[1], path.parts[-2].split("=")[1]) for path in fleet.paths]
    return spark.createDataFrame(rows, ["path", *KEYS]).repartition(partitions)


def fitted(runs):
    """The engine adds up; one row comes back."""
    return coefficients(wheelwatt.spark.total(runs).toArrow())


def check(runs, fleet, expected, figures, name, started):
    runs = runs.cache()
    assert runs.count() == len(fleet.paths)
    figures[name] = fleet.rows / (time.perf_counter() - started)
    print(f"{name}: {figures[name]:.3g} rows/s", end="; ")
    assert are_same(fitted(runs), expected)
    runs.unpersist()


def test_logs_give_the_same_coefficients(spark, fleet, expected, figures):
    """On any number of executors, in any number of partitions."""
    partitions = 3 * spark.executors
    started = time.perf_counter()
    runs = wheelwatt.spark.grams_of_logs(logs(spark, fleet, partitions), keys=KEYS, coefficients=fleet.coefficients)
    check(runs, fleet, expected, figures, f"spark, logs, {spark.executors} executors, {partitions} partitions", started)


def test_rows_give_the_same_coefficients(spark, fleet, expected, figures):
    """However they are partitioned: they lie among each other, and the engine brings a run together."""
    partitions = 2 * spark.executors + 1
    started = time.perf_counter()
    rows = spark.read.parquet(str(fleet.table)).repartition(partitions)
    runs = wheelwatt.spark.grams(rows, run=["run"], keys=KEYS, coefficients=fleet.coefficients)
    check(runs, fleet, expected, figures, f"spark, rows, {spark.executors} executors, {partitions} partitions", started)


def test_totals_by_robot_are_those_of_its_logs(spark, fleet, tmp_path):
    if spark.executors != 2:
        pytest.skip("on two executors")
    runs = wheelwatt.spark.grams_of_logs(logs(spark, fleet, 4), keys=KEYS, coefficients=fleet.coefficients)
    by_robot = wheelwatt.spark.total(runs, by=["robot"]).toPandas()
    assert sorted(by_robot["robot"]) == [str(robot) for robot in range(8)]
    of_one = [path for path in fleet.paths if "robot=3" in str(path)]
    wheelwatt.gram(of_one, tmp_path / "one.parquet", coefficients=fleet.coefficients)
    found = coefficients(by_robot[by_robot["robot"] == "3"])
    assert are_same(found, coefficients(tmp_path / "one.parquet"))


def executors_of(parent):
    """Ids of the executors' processes below this one."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            line = (process / "cmdline").read_bytes()
            above = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        if b"CoarseGrainedExecutorBackend" in line and descends(above, parent):
            found.append(int(process.name))
    return found


def descends(process, from_process):
    while process > 1:
        if process == from_process:
            return True
        try:
            process = int(pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            return False
    return False


def test_an_executor_killed_half_way_changes_nothing(spark, fleet, expected, tmp_path):
    """By its process id, when half of the logs are read; the job ends all the same, and says the same."""
    if spark.executors != 2:
        pytest.skip("on two executors")
    recipe = wheelwatt.spark.Recipe.of("burger", fleet.coefficients, None, None, {})
    marks = tmp_path / "marks"
    marks.mkdir()

    def some(batches):
        for batch in batches:
            for place in range(batch.num_rows):
                yield from recipe.of_logs(batch.slice(place, 1), "path", KEYS).to_batches()
                (marks / f"{os.getpid()}-{time.time_ns()}").touch()
                time.sleep(0.2)

    killed = []

    def kill():
        while len(list(marks.iterdir())) < len(fleet.paths) // 2:
            time.sleep(0.01)
        victim = executors_of(os.getpid())[0]
        os.kill(victim, signal.SIGKILL)
        killed.append(victim)

    started = time.perf_counter()
    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    # One log a task, so that what the dead executor had done is lost, and done again.
    frame = logs(spark, fleet, len(fleet.paths))
    runs = frame.mapInArrow(some, wheelwatt.spark._schema(KEYS)).cache()
    table = wheelwatt.spark.total(runs).toArrow()
    assert isinstance(table, pa.Table)
    killer.join(timeout=60)
    assert killed and not pathlib.Path(f"/proc/{killed[0]}/exe").exists()
    assert len(list(marks.iterdir())) > len(fleet.paths) - 1
    print(f"executor {killed[0]} killed, {time.perf_counter() - started:.1f} s", end="; ")
    assert are_same(coefficients(table), expected)
    assert runs.count() == len(fleet.paths)


def test_one_machine_without_an_engine(fleet, figures):
    figures["gmr fleet, all cores"] = fleet.alone()
