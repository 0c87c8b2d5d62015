"""Spark and Ray beside `gmr fleet` on the same logs, in turn: what the bench `engines` runs.

    python engines.py LOGS COEFFICIENTS.toml GMR OUT

LOGS holds Parquet files robot=…/day=…/….parquet, one run each. Every engine is a process of its own with 1, 2 and 4 executors of a core
each; its start-up (until each executor has summed up a log) is told apart. Paths travel, and whoever works reads; then a tenth of the
logs as a table of rows, which the engine brings together by run. Last, one of two executors is killed half-way. All have to say what
`gmr fleet`'s sums say. Prints a table; seconds of processor are of all processes of an engine.
"""

import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

LOGS_A_TASK = 50
TICKS = os.sysconf("SC_CLK_TCK")
#: What the processes call themselves that do the work, and those that are killed.
WORKERS = {"spark": "pyspark.daemon", "ray": "ray::MapBatches"}
EXECUTORS = {"spark": "CoarseGrainedExecutorBackend", "ray": "ray::MapBatches"}


def processes():
    """This one and all below it: id, command line, seconds of processor, MB."""
    above, found = {}, {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            line = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            stat = (folder / "stat").read_text().rsplit(")", 1)[1].split()
            resident = int((folder / "statm").read_text().split()[1]) * 4096e-6
        except (OSError, IndexError):
            continue
        above[int(folder.name)] = int(stat[1])
        found[int(folder.name)] = (line, (int(stat[11]) + int(stat[12])) / TICKS, resident)

    def is_below(process):
        while process not in (0, os.getpid()):
            process = above.get(process, 0)
        return process == os.getpid()

    return {process: of for process, of in found.items() if is_below(process)}


class Watch(threading.Thread):
    """What processes take meanwhile, those that end before as well."""

    def __init__(self, engine):
        super().__init__(daemon=True)
        self.engine, self.over, self.seen = engine, threading.Event(), []
        self.before = {process: of[1] for process, of in processes().items()}
        self.cpu = dict(self.before)

    def run(self):
        while not self.over.wait(0.25):
            self.look()

    def look(self):
        found = processes()
        self.cpu.update((process, of[1]) for process, of in found.items())
        self.seen.append(max((of[2] for of in found.values() if WORKERS[self.engine] in of[0]), default=0.0))

    def end(self):
        """Seconds of processor; the greatest worker, MB, in the first quarter of the time and in all of it."""
        self.over.set()
        self.join()
        self.look()
        early = self.seen[: 1 + len(self.seen) // 4]
        return sum(self.cpu.values()) - sum(self.before.values()), max(early), max(self.seen)


def kill_later(engine, seconds, killed):
    def kill():
        time.sleep(seconds)
        victim = None
        while victim is None:
            victim = next((process for process, of in processes().items() if EXECUTORS[engine] in of[0]), None)
        os.kill(victim, signal.SIGKILL)
        killed.append(victim)

    threading.Thread(target=kill, daemon=True).start()


class Spark:
    def __init__(self, executors):
        import pyspark
        from pyspark.sql import SparkSession

        os.environ.setdefault("SPARK_HOME", str(pathlib.Path(pyspark.__file__).parent))
        os.environ["PYSPARK_PYTHON"] = sys.executable
        builder = SparkSession.builder.master(f"local-cluster[{executors},1,1024]")
        for key, value in {
            "spark.ui.enabled": "false",
            "spark.executor.memory": "1g",
            "spark.driver.memory": "1g",
            "spark.sql.shuffle.partitions": str(8 * executors),
            "spark.driver.bindAddress": "127.0.0.1",
            "spark.driver.host": "127.0.0.1",
        }.items():
            builder = builder.config(key, value)
        self.session, self.executors = builder.getOrCreate(), executors
        self.session.sparkContext.setLogLevel("ERROR")

    def of_logs(self, paths, coefficients, tasks):
        import wheelwatt.spark

        frame = self.session.createDataFrame([(str(path),) for path in paths], ["path"]).repartition(tasks)
        runs = wheelwatt.spark.grams_of_logs(frame, coefficients=coefficients)
        return wheelwatt.spark.total(runs).toArrow()

    def of_rows(self, paths, coefficients):
        from pyspark.sql import functions as sql

        import wheelwatt.spark

        table = self.session.read.option("basePath", str(paths[0].parents[2])).parquet(*map(str, paths))
        # The file's own name: robot and day are the folders'.
        rows = table.withColumn("run", sql.substring_index(sql.input_file_name(), "/", -1))
        runs = wheelwatt.spark.grams(rows, keys=["robot", "day"], coefficients=coefficients)
        return wheelwatt.spark.total(runs).toArrow()


class Ray:
    def __init__(self, executors):
        # Its workers give way to whatever else the machine does, unless told.
        os.environ["RAY_worker_niceness"] = "0"
        import ray

        ray.init(num_cpus=executors, include_dashboard=False, log_to_driver=False, object_store_memory=2_000_000_000)
        context = ray.data.DataContext.get_current()
        context.enable_progress_bars = False
        context.default_hash_shuffle_parallelism = 8 * executors
        self.ray = ray

    def of_logs(self, paths, coefficients, tasks):
        import wheelwatt.ray

        logs = self.ray.data.from_items([{"path": str(path)} for path in paths], override_num_blocks=tasks)
        batch = -(-len(paths) // tasks)
        return wheelwatt.ray.total(wheelwatt.ray.grams_of_logs(logs, coefficients=coefficients, batch=batch))

    def of_rows(self, paths, coefficients):
        import pyarrow as pa
        import pyarrow.parquet as parquet

        import wheelwatt.ray

        def read(batch):
            path = batch["path"][0].as_py()
            table = parquet.ParquetFile(path).read()
            return table.append_column("run", pa.repeat(pa.scalar("/".join(path.split("/")[-3:])), len(table)))

        logs = self.ray.data.from_items([{"path": str(path)} for path in paths], override_num_blocks=len(paths))
        rows = logs.map_batches(read, batch_format="pyarrow", batch_size=1)
        return wheelwatt.ray.total(wheelwatt.ray.grams(rows, coefficients=coefficients))


ENGINES = {"spark": Spark, "ray": Ray}


def of_engine(arguments):
    """One engine in this process: what it took, and what it found."""
    started = time.perf_counter()
    paths = sorted(pathlib.Path(arguments.logs).glob("**/*.parquet"))[: arguments.first]
    engine = ENGINES[arguments.of](arguments.executors)
    # As many tasks as executors: all are up, have imported what they need and know their recipe.
    engine.of_logs(paths[: 4 * arguments.executors], arguments.coefficients, 2 * arguments.executors)
    start_s, killed = time.perf_counter() - started, []
    watch = Watch(arguments.of)
    watch.start()
    if arguments.kill:
        kill_later(arguments.of, arguments.kill, killed)
    begun = time.perf_counter()
    if arguments.rows:
        table = engine.of_rows(paths, arguments.coefficients)
    else:
        table = engine.of_logs(paths, arguments.coefficients, -(-len(paths) // LOGS_A_TASK))
    took = time.perf_counter() - begun
    cpu_s, early_mb, peak_mb = watch.end()
    rows = int(table["summary_rows"][0].as_py())
    found = {"start_s": start_s, "seconds": took, "cpu_s": cpu_s, "rows": rows, "early_mb": early_mb, "peak_mb": peak_mb,
             "killed": bool(killed), "coefficients": coefficients(table)}
    pathlib.Path(arguments.out).write_text(json.dumps(found))


def coefficients(sums):
    import wheelwatt

    return {model: [one.value for one in wheelwatt.fit_grams(sums, model=model).parameters] for model in ("eq18", "signed")}


def off(found, expected):
    """Of the greatest coefficient of each model."""
    most = {model: max(map(abs, expected[model])) for model in expected}
    return max(abs(a - b) / most[model] for model in expected for a, b in zip(found[model], expected[model]))


class Bench:
    def __init__(self, arguments):
        self.logs, self.coefficients = arguments.logs, arguments.coefficients
        self.gmr, self.out = arguments.gmr, pathlib.Path(arguments.out)
        self.cores = len(os.sched_getaffinity(0))

    def fleet(self, cores):
        """`gmr fleet` from nothing on so many cores: rows a second and core."""
        subprocess.run(["rm", "-rf", self.out], check=True)
        before, begun = os.times(), time.perf_counter()
        command = [self.gmr, "fleet", self.logs, "--coeffs", self.coefficients, "--out", self.out, "--json"]
        pinned = ["taskset", "--cpu-list", f"0-{cores - 1}"]
        done = subprocess.run([*pinned, *map(str, command)], capture_output=True, text=True, check=True)
        took, after = time.perf_counter() - begun, os.times()
        cpu_s = after.children_user + after.children_system - before.children_user - before.children_system
        rows = json.loads(done.stdout)["rows"]
        self.alone = rows / took / cores, cpu_s / rows
        name = f"gmr fleet, {cores} core{'s' if cores > 1 else ''}"
        self.say(name, rows, 0.0, took, cpu_s, cores, "")

    def say(self, name, rows, start_s, took, cpu_s, cores, rest):
        share = rows / took / cores / self.alone[0], self.alone[1] / (cpu_s / rows)
        print(f"{name:<32} {rows:.2e} rows; start {start_s:4.1f} s, then {took:6.1f} s: {rows / took:.2e} rows/s, {rows / took / cores:.2e} a core, "
              f"{share[0]:.2f} of gmr fleet; {1e6 * cpu_s / rows:.2f} µs of processor a row, {share[1]:.2f} of gmr fleet{rest}", flush=True)

    def engine(self, engine, executors, expected, *, rows=False, first=None, kill=0.0):
        out = self.out.with_name("engine.json")
        command = [sys.executable, __file__, self.logs, self.coefficients, self.gmr, out, "--of", engine, "--executors", executors]
        command += ["--rows"] if rows else []
        command += ["--first", first] if first else []
        command += ["--kill", kill] if kill else []
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL, stderr=self.log())
        found = json.loads(out.read_text())
        apart = off(found["coefficients"], expected)
        assert apart < 1e-9, (engine, executors, apart)
        assert found["killed"] or not kill, "it was over before it was killed"
        name = f"{engine}, {'rows' if rows else 'logs'}, {executors} executor{'s' if executors > 1 else ''}{', one killed' if kill else ''}"
        rest = f"; a worker {found['early_mb']:.0f} MB in the first quarter, {found['peak_mb']:.0f} MB at most; coefficients differ by {apart:.0e}"
        self.say(name, found["rows"], found["start_s"], found["seconds"], found["cpu_s"], min(executors, self.cores), rest)
        return found["seconds"]

    def log(self):
        return open(self.out.with_name("engines.log"), "a", encoding="utf-8")

    def sums(self, first):
        """What one machine says of the first logs."""
        import wheelwatt

        file = self.out.with_name("tenth.parquet")
        file.unlink(missing_ok=True)
        paths = sorted(pathlib.Path(self.logs).glob("**/*.parquet"))[:first]
        wheelwatt.gram([str(path) for path in paths], file, coefficients=self.coefficients)
        return coefficients(str(file))

    def run(self):
        half = {}
        for executors in (1, 2, 4):
            # In turn: the machine is not the same from minute to minute.
            self.fleet(min(executors, self.cores))
            expected = coefficients(str(self.out / "grams.jsonl"))
            for engine in ENGINES:
                half[engine, executors] = self.engine(engine, executors, expected) / 2
        logs = len(list(pathlib.Path(self.logs).glob("**/*.parquet")))
        tenth = max(1, logs // 10)
        of_tenth = self.sums(tenth)
        self.fleet(min(2, self.cores))
        for engine in ENGINES:
            self.engine(engine, 2, expected, kill=half[engine, 2])
            self.engine(engine, 2, of_tenth, rows=True, first=tenth)


def main():
    parser = argparse.ArgumentParser()
    for name in ("logs", "coefficients", "gmr", "out"):
        parser.add_argument(name)
    parser.add_argument("--of", choices=ENGINES)
    parser.add_argument("--executors", type=int)
    parser.add_argument("--rows", action="store_true")
    parser.add_argument("--first", type=int)
    parser.add_argument("--kill", type=float, default=0.0)
    arguments = parser.parse_args()
    # Workers run elsewhere.
    for name in ("logs", "coefficients", "gmr", "out"):
        setattr(arguments, name, os.path.abspath(getattr(arguments, name)))
    of_engine(arguments) if arguments.of else Bench(arguments).run()


if __name__ == "__main__":
    main()
