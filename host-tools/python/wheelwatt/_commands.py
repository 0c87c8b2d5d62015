"""The commands of ``gmr`` as functions. A command's own help says more of each argument; its name there is the one here, with dashes."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Union

from . import _gmr, _progress
from ._error import Error, NotForBoards
from ._log import Log, LogLike, read
from ._results import Coefficients, Comparison, Estimate, Export, Fit, Gap, Inspection, Look, Prediction

#: A robot.toml, or burger, warthog, husky.
RobotLike = Union[str, "os.PathLike[str]"]
#: A fit, its coefficients, or the path of a coefficients.toml.
CoefficientsLike = Union[Fit, Coefficients, str, "os.PathLike[str]"]

__all__ = ["compare", "estimate", "export", "fit", "gap", "gram", "inspect", "look", "predict", "read", "simulate"]


def inspect(log: LogLike, *, robot: RobotLike = "burger", plot: bool = True, **units: Any) -> Inspection:
    """Says what a log is worth before anything is fitted to it.

    log : a `Log`, or the path of one
    plot : draw the static power and its states (`Inspection.svg`)
    units : ``speed_unit`` ("rad/s", "rpm", "rev/s", "deg/s", "m/s"), ``power_unit`` ("W", "mW", "kW"), ``mass_unit`` ("kg", "g", "lb"),
        ``flip_wheel`` (a list of wheels, from 1), where the columns are not what their names say
    """
    with _Call("inspect") as call:
        call.add("--robot", robot).units(units).log(log)
        svg = call.output("--plot", "inspect.svg") if plot else None
        text, said = call.run()
        return Inspection(text, said, _text(svg))


def fit(
    logs: LogLike | Sequence[LogLike],
    *,
    robot: RobotLike = "burger",
    model: str = "signed",
    method: str | None = None,
    mass: float | None = None,
    learning_rate: float | None = None,
    momentum: float | None = None,
    iterations: int | None = None,
    no_gyro: bool = False,
    starts: int = 0,
    **units: Any,
) -> Fit:
    """Fits the power model to logs with known payload: two of them, empty and fully loaded, at least.

    model : ``signed``, ``eq18`` or ``eq18-published``
    method : ``physical`` (signed), ``nnls``, ``pgd`` (Eq. 18); the model's own unless given
    mass : total mass of logs without a mass_kg column, kg; the robot's without payload unless given
    learning_rate, momentum, iterations : of pgd
    starts : search again from so many random starts, and say how far below the fit's cost they end
    no_gyro : leave a gyro's yaw_rate_rad_s alone: for boards, plans and whatever else has none
    units : as of `inspect`
    """

    def call_with(out: bool) -> tuple[str, Sequence[str], str]:
        with _Call("fit") as call:
            call.add("--robot", robot).add("--model", model).add("--method", method).add("--mass", mass)
            call.add("--learning-rate", learning_rate).add("--momentum", momentum).add("--iterations", iterations)
            call.flag("--no-gyro", no_gyro).add("--starts", starts or None).units(units).logs(logs)
            file = call.output("--out", "coefficients.toml") if out else None
            text, said = call.run()
            return text, said, _text(file)

    try:
        text, said, coefficients = call_with(out=True)
        return Fit(text, said, Coefficients(coefficients))
    except NotForBoards as refused:
        # The command would not write them, but its figures are there.
        text, said, _ = call_with(out=False)
        return Fit(text, said, refused)


def estimate(
    log: LogLike,
    coefficients: CoefficientsLike,
    *,
    robot: RobotLike = "burger",
    mass: float | None = None,
    window: float | None = None,
    payload: str | None = None,
    schedule: str | None = None,
    every: float | None = None,
    changes: Sequence[float] = (),
    detection: bool = True,
    plot: bool = True,
    **units: Any,
) -> Estimate:
    """Finds mass, power and energy of a run with the pipeline that the board runs.

    mass : total mass, kg, where it is known: power and energy at it are given beside (`Estimate.data["told"]`)
    window : its length, s (25)
    payload : ``window`` or ``roots``, how the mass is found; the model's own unless given
    schedule : ``moving``, ``cumulative``, ``known`` or ``periodic``; `every` is a round of the last, s
    changes : known times of payload changes, s since the start of the log
    detection : watch for payload changes
    plot : draw power and mass over time (`Estimate.svg`)
    units : as of `inspect`
    """
    with _Call("estimate") as call:
        call.add("--robot", robot).add("--coeffs", call.coefficients(coefficients)).add("--mass", mass)
        call.add("--window", window).add("--payload", payload).add("--schedule", schedule).add("--every", every)
        call.add("--changes", ",".join(repr(float(time)) for time in changes) or None)
        call.flag("--no-detection", not detection).units(units).log(log)
        svg = call.output("--plot", "estimate.svg") if plot else None
        power = call.output("--power", "power.csv")
        text, said = call.run()
        return Estimate(text, said, _text(svg), read(power))


def look(log: LogLike, *, page: bool = True) -> Look:
    """What is in a log, where the robot's energy goes, and which sensor would show more. No robot.toml needed.

    log : a `Log`, or the path of one: a bag, ULog, Parquet or CSV
    page : make the page with plots (`Look.page`)
    """
    with _Call("look") as call:
        call.log(log)
        html = call.output("--page", "look.html") if page else None
        text, said = call.run()
        return Look(text, said, _text(html))


def predict(
    plan: LogLike,
    coefficients: CoefficientsLike,
    *,
    mass: float,
    robot: RobotLike = "burger",
    mass_interval: tuple[float, float] | None = None,
    static_power: float | None = None,
    static_std: float | None = None,
    charge: float | None = None,
    charge_std: float | None = None,
    reserve: float | None = None,
    resistance: float | None = None,
    **units: Any,
) -> Prediction:
    """Predicts the energy of a planned drive with its 95 % interval, and whether the battery has it.

    plan : columns time_s, v_m_s, omega_rad_s (slope_rad, leg), or a leg a row: distance_m, speed_m_s (turn_rad, slope_rad, pause_s, leg);
        as a file, or as a `Log`. A log's speeds are taken as planned, and its power is given beside.
    mass : total mass, kg; `mass_interval`: its 95 % interval, kg
    static_power, static_std : what the robot draws besides driving, W, and its standard deviation
    charge, charge_std, reserve : of the battery, 0 to 1; resistance : of the pack, Ohm
    units : as of `inspect`
    """
    with _Call("predict") as call:
        call.add("--robot", robot).add("--coeffs", call.coefficients(coefficients)).add("--mass", mass)
        if mass_interval is not None:
            call.add("--mass-interval", ",".join(repr(float(end)) for end in mass_interval))
        call.add("--static-power", static_power).add("--static-std", static_std).add("--charge", charge)
        call.add("--charge-std", charge_std).add("--reserve", reserve).add("--resistance", resistance)
        call.units(units).add("--plan", call.file(plan))
        return Prediction(*call.run())


def export(
    coefficients: CoefficientsLike,
    target: str,
    *,
    robot: RobotLike = "burger",
    mass: float | None = None,
    static_power: float | None = None,
    speed: float | None = None,
    charge: float | None = None,
) -> Export:
    """A fit in the terms of another program, with what that program cannot express.

    target : ``rmf``, ``vda5050``, ``sdf`` or ``mjcf``; the other arguments as of ``gmr export``
    """
    with _Call("export") as call:
        call.arguments.append(target)
        call.add("--robot", robot).add("--coeffs", call.coefficients(coefficients))
        call.add("--mass", mass).add("--static-power", static_power).add("--speed", speed).add("--charge", charge)
        written = call.output("--out", "exported")
        text, said = call.run()
        return Export(text, said, _text(written))


def compare(
    train: LogLike | Sequence[LogLike],
    test: LogLike | Sequence[LogLike] = (),
    *,
    robot: RobotLike = "burger",
    models: Sequence[str] = (),
    block: float | None = None,
    window: float | None = None,
    mass: float | None = None,
    no_perceptron: bool = False,
    plot: bool = True,
    **units: Any,
) -> Comparison:
    """Fits every model of the literature and ours to the same logs, and evaluates all on the same others.

    test : logs to evaluate on; one in three blocks of the training logs, held out, unless given
    models : their names; all that robot and logs allow unless given
    block, window : length of held-out blocks, and of the payload window, s
    mass : total mass of logs without a mass_kg column, kg
    plot : draw predicted against measured power (`Comparison.svg`)
    units : as of `inspect`
    """
    with _Call("compare") as call:
        call.add("--robot", robot).add("--block", block).add("--window", window).add("--mass", mass)
        call.add("--models", ",".join(models) or None).flag("--no-perceptron", no_perceptron).units(units)
        svg = call.output("--plot", "compare.svg") if plot else None
        call.arguments.append("--train")
        call.logs(train)
        if isinstance(test, (Log, str, os.PathLike)) or len(test) > 0:
            call.arguments.append("--test")
            call.logs(test)
        text, said = call.run()
        return Comparison(text, said, _text(svg))


def gap(
    logs: Sequence[LogLike],
    coefficients: CoefficientsLike | None = None,
    *,
    base: Sequence[LogLike] = (),
    robot: RobotLike = "burger",
    mass: float | None = None,
    effects: str | os.PathLike[str] | None = None,
    plant: str | None = None,
    profile: str | os.PathLike[str] | None = None,
    report: bool = True,
    **units: Any,
) -> Gap:
    """Finds where model and measurement disagree, and which effect is missing. Four runs at least.

    coefficients : of an earlier clean fit; without, base and effects are fitted together
    base : the clean runs that they were fitted to, if they are no longer where they were (logs that were in memory only are not)
    effects : a file with effects of your own
    plant : ``servo``, ``table3`` or ``gearmotor``: drive a simulated robot with these motors along as well
    profile : where the drive that parts the rivals of a tie is written; nowhere unless given
    report : make the page (`Gap.page`)
    units : as of `inspect`
    """
    with _Call("gap") as call:
        call.add("--robot", robot).add("--mass", mass).add("--effects", effects).add("--plant", plant)
        call.units(units)
        page = extended = None
        if coefficients is not None:
            call.add("--coeffs", call.coefficients(coefficients))
            extended = call.output("--out", "extended.toml")
        page = call.output("--report", "gap.html") if report else None
        call.add("--profile", profile if profile is not None else call.path("profile.csv"))
        call.logs(logs)
        if base:
            call.arguments.append("--base")
            call.logs(base)
        text, said = call.run()
        text_of_extended = _text(extended)
        return Gap(text, said, _text(page), Coefficients(text_of_extended) if text_of_extended else None)


def gram(
    logs: LogLike | Sequence[LogLike],
    out: str | os.PathLike[str],
    *,
    robot: RobotLike = "burger",
    coefficients: CoefficientsLike | None = None,
    cutoff: float | None = None,
    mass: float | None = None,
    **units: Any,
) -> list[dict[str, Any]]:
    """Sums logs up: all that fits need to know of them (docs/fleet.md), for `fit_grams`. Gives the lines of the file as dictionaries, a
    run each; none of a file ``….parquet``, whose rows pandas, Polars and Arrow read.

    out : where they go: JSON, a run a line, or Parquet, a run a row
    coefficients : signed: take their filter, delay and slip memory, and sums near them, too
    cutoff : of the filter, Hz; that of `fit` for these logs unless given
    """
    with _Call("gram") as call:
        call.add("--robot", robot).add("--out", out).add("--cutoff", cutoff).add("--mass", mass)
        if coefficients is not None:
            call.add("--coeffs", call.coefficients(coefficients))
        call.units(units).logs(logs)
        call.run()
    if os.fspath(out).lower().endswith(".parquet"):
        return []
    with open(out, encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def simulate(**arguments: Any) -> Log:
    """A log of the simulated robot: the arguments of ``gmr simulate`` by their names, with ``_`` for ``-``.

    ``duration`` (s), ``mass`` (kg, or steps as "1@0,6@100"), ``rate`` (Hz), ``plant``, ``profile``, ``sensors``, ``seed``, ``effect``
    (one, or a list), ``columns`` (a list) and so on; True sets a flag. What was simulated is in `Log.simulated`.
    """
    with _Call("simulate") as call:
        for name, value in arguments.items():
            flag = "--" + name.replace("_", "-")
            if isinstance(value, bool):
                call.flag(flag, value)
            elif isinstance(value, Iterable) and not isinstance(value, (str, os.PathLike)):
                for one in value:
                    call.add(flag, one)
            else:
                call.add(flag, value)
        out = call.output("--out", "simulated.csv")
        text, _ = call.run()
        log = read(out)
    log.name = "simulated"
    log.simulated = json.loads(text)
    log.simulated.pop("file", None)
    return log


class _Call:
    """A command's arguments, and a folder for what it writes."""

    def __init__(self, command: str, json: bool = True) -> None:
        self.arguments = [command, "--json"] if json else [command]
        self._positions: list[str] = []
        #: Names of the logs in memory, by the paths of their files.
        self._names: dict[str, str] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="gmr-")

    def __enter__(self) -> _Call:
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def path(self, name: str) -> str:
        return os.path.join(self._folder.name, name)

    def add(self, flag: str, value: Any) -> _Call:
        if value is not None:
            self.arguments.append(f"{flag}={os.fspath(value) if isinstance(value, os.PathLike) else value}")
        return self

    def flag(self, flag: str, is_set: bool) -> _Call:
        if is_set:
            self.arguments.append(flag)
        return self

    def output(self, flag: str, name: str) -> str:
        self.add(flag, self.path(name))
        return self.path(name)

    def units(self, units: Mapping[str, Any]) -> _Call:
        known = ("speed_unit", "power_unit", "mass_unit", "flip_wheel")
        for name, value in units.items():
            if name not in known:
                raise TypeError(f"unexpected argument {name!r}")
            if name == "flip_wheel" and not isinstance(value, int):
                value = ",".join(str(wheel) for wheel in value)
            self.add("--" + name.replace("_", "-"), value)
        return self

    def file(self, log: LogLike) -> str:
        """The path of a log, in memory or not."""
        if isinstance(log, Log):
            path = log._path()
            self._names[path] = log.name
            return path
        return os.fspath(log)

    def log(self, log: LogLike) -> _Call:
        self.arguments.append(self.file(log))
        return self

    def logs(self, logs: LogLike | Sequence[LogLike]) -> _Call:
        for log in [logs] if isinstance(logs, (Log, str, os.PathLike)) else logs:
            self.log(log)
        return self

    def coefficients(self, coefficients: CoefficientsLike) -> str:
        if isinstance(coefficients, Fit):
            coefficients = coefficients.coefficients
        if isinstance(coefficients, Coefficients):
            file = self.path("coefficients.toml")
            coefficients.save(file)
            return file
        return os.fspath(coefficients)

    def run(self) -> tuple[str, Sequence[str]]:
        try:
            text, said = _gmr.run(self.arguments, _progress.heard())
        except Error as error:
            for path, name in self._names.items():
                error.message = error.message.replace(path, name)
                if error.file == path:
                    error.file = name
            raise
        for path, name in self._names.items():
            said = [line.replace(path, name) for line in said]
        return text, said


def _text(file: str | None) -> str:
    """What a command wrote; nothing where it wrote nothing."""
    if file is None or not os.path.exists(file):
        return ""
    with open(file, encoding="utf-8") as opened:
        return opened.read()
