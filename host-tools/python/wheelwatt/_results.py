"""What the commands answer, as objects. Every one keeps the command's JSON: `json()` is its text, `data` its values."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._draw import page, table

Array = NDArray[np.float64]


class Answer:
    """The command's JSON, and its drawing for a notebook."""

    _text: str
    #: The drawing, SVG; empty where there is none.
    svg: str = ""
    #: What the command said on standard error, line by line.
    said: tuple[str, ...] = ()

    def json(self) -> str:
        """What the command prints with ``--json``, byte by byte."""
        return self._text

    @property
    def data(self) -> dict[str, Any]:
        """The same as values; None stands for null."""
        data: dict[str, Any] = json.loads(self._text)
        return data

    def _repr_svg_(self) -> str | None:
        return self.svg or None


@dataclass(frozen=True)
class Parameter:
    """A fitted parameter: value and standard error (None where the data say nothing) in `unit`."""

    name: str
    value: float
    unit: str
    std_err: float | None
    #: ``determined``, ``weak`` or ``undetermined``
    verdict: str
    #: What would settle it; None where nothing has to.
    advice: str | None


@dataclass(frozen=True)
class Finding:
    """Something to know of a log."""

    #: ``problem``, ``warning`` or ``note``
    severity: str
    text: str
    #: What to do; empty if nothing.
    advice: str


@dataclass(frozen=True)
class Change:
    """A change of payload: when it was, and when it was noticed, s since the start of the log."""

    time_s: float
    noticed_s: float


@dataclass(frozen=True)
class Effect:
    """An effect that the model lacked."""

    id: str
    #: Coefficient and its standard error, in `unit`.
    coefficient: float | None
    std_err: float | None
    unit: str
    meaning: str
    #: Everything that is known of it.
    data: dict[str, Any] = field(repr=False)


class Coefficients:
    """Coefficients as `gmr fit` writes them, for `estimate`, `gap` and `gmr flash`."""

    def __init__(self, text: str) -> None:
        self.text = text

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Coefficients:
        """From a file."""
        with open(path, encoding="utf-8") as file:
            return cls(file.read())

    def save(self, path: str | os.PathLike[str]) -> None:
        """To a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.text)

    def __repr__(self) -> str:
        return f"<wheelwatt.Coefficients of {len(self.text)} bytes>"


class Fitted(Answer):
    """What a fit says, from rows or from sums: subscripted by a parameter's name, and a table in a notebook."""

    robot: str
    model: str
    r2: float | None
    rmse_w: float
    rows: int
    parameters: tuple[Parameter, ...]
    warnings: tuple[str, ...]

    def __getitem__(self, name: str) -> Parameter:
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def __repr__(self) -> str:
        r2 = "–" if self.r2 is None else f"{self.r2:.4f}"
        return f"<wheelwatt.{type(self).__name__} of {self.robot}: {self.model}, R² {r2}, RMSE {self.rmse_w:.4g} W, {self.rows} rows>"

    def _repr_html_(self) -> str:
        rows = [
            (one.name, f"{one.value:.5g}", "–" if one.std_err is None else f"{one.std_err:.2g}", one.unit, one.verdict)
            for one in self.parameters
        ]
        head = ("parameter", "value", "± standard error", "unit", "verdict")
        return table(repr(self)[1:-1], head, rows, self.warnings)


class Fit(Fitted):
    """A model and what it is worth.

    Attributes
    ----------
    r2 : share of the power's variance that it explains; None where the power never changes
    mape_percent, rmse_w : errors on the fitted rows
    parameters : one by one
    warnings : what keeps the coefficients from being what they look like, sentences
    """

    def __init__(self, text: str, said: Sequence[str], coefficients: Coefficients | Exception) -> None:
        self._text, self.said = text, tuple(said)
        data = self.data
        self.robot: str = data["robot"]
        self.model: str = data["model"]
        self.r2: float | None = data["r2"]
        self.mape_percent: float | None = data["mape_percent"]
        self.rmse_w: float = data["rmse_w"]
        self.rows: int = data["rows"]
        self.masses_kg: Array = np.array(data["masses_kg"], dtype=np.float64)
        self.filter_cutoff_hz: float = data["filter_cutoff_hz"]
        self.parameters: tuple[Parameter, ...] = tuple(Parameter(**one) for one in data["parameters"])
        self.warnings: tuple[str, ...] = tuple(warning["text"] for warning in data["warnings"])
        self._coefficients = coefficients

    @property
    def coefficients(self) -> Coefficients:
        """For `estimate` and `gap`. Raises `NotForBoards` where the command would not write them."""
        if isinstance(self._coefficients, Exception):
            raise self._coefficients
        return self._coefficients


class Inspection(Answer):
    """What a log is worth.

    Attributes
    ----------
    summary : what it is good for, one line
    duration_s, rate_hz : length, and median sample rate (None where no row continues the one before)
    findings : what is wrong with it, and what mends that
    """

    def __init__(self, text: str, said: Sequence[str], svg: str) -> None:
        self._text, self.said, self.svg = text, tuple(said), svg
        data = self.data
        self.robot: str = data["robot"]
        self.rows: int = data["rows"]
        self.duration_s: float = data["duration_s"]
        self.rate_hz: float | None = data["rate_hz"]
        self.summary: str = data["verdict"]
        self.findings: tuple[Finding, ...] = tuple(
            Finding(one["severity"], one["text"], one["advice"]) for one in data["findings"]
        )

    def __repr__(self) -> str:
        return f"<wheelwatt.Inspection of {self.robot}: {self.rows} rows, {self.duration_s:.1f} s: {self.summary}>"

    def _repr_html_(self) -> str:
        rows = [(one.severity, one.text, one.advice) for one in self.findings]
        return table(repr(self)[1:-1], ("", "finding", "what to do"), rows, (), self.svg)


class Estimate(Answer):
    """What a robot carried and drew.

    Attributes
    ----------
    windows : arrays of one length, a window each: ``t0_s``, ``t1_s``, ``mass_kg``, ``low_kg``, ``high_kg`` (95 %); NaN where unknown
    changes : changes of payload that were noticed
    power : over time, arrays of one length: ``time_s``, ``measured_w``, ``predicted_w`` (at the mass estimated), ``told_w`` (at the mass that
        the log or `mass` gives), ``mass_kg``, ``low_kg``, ``high_kg``; NaN where unknown
    energy_j : measured energy
    r2, mape_percent, rmse_w : of the power predicted at the estimated masses; None where no mass was known
    """

    def __init__(self, text: str, said: Sequence[str], svg: str, power: Mapping[str, Array]) -> None:
        self._text, self.said, self.svg, self.power = text, tuple(said), svg, power
        data = self.data
        self.rows: int = data["rows"]
        self.r2: float | None = data["r2"]
        self.mape_percent: float | None = data["mape_percent"]
        self.rmse_w: float | None = data["rmse_w"]
        self.energy_j: float = data["energy_j"]
        self.changes: tuple[Change, ...] = tuple(
            Change(one["time_s"], one["noticed_s"]) for one in data["changes"]
        )
        keys = ("t0_s", "t1_s", "mass_kg", "low_kg", "high_kg")
        self.windows: dict[str, Array] = {
            key: np.array([window.get(key) for window in data["windows"]], dtype=np.float64) for key in keys
        }

    def __repr__(self) -> str:
        mass = self.windows["mass_kg"]
        known = mass[np.isfinite(mass)]
        of = f"median {np.median(known):.3f} kg" if len(known) else "unknown"
        return f"<wheelwatt.Estimate: mass {of}, known in {len(known)} of {len(mass)} windows; {self.energy_j:.1f} J>"

    def _repr_html_(self) -> str:
        rows = [(f"{one.time_s:.1f}", f"{one.noticed_s:.1f}") for one in self.changes]
        head = ("payload changed at, s", "noticed at, s")
        return table(repr(self)[1:-1], head, rows, (), self.svg)


class Prediction(Answer):
    """The energy of a planned drive.

    Attributes
    ----------
    energy_j, low_j, high_j : with the static power, where it is known, and its 95 % interval
    duration_s, distance_m : of the plan
    legs : its legs as dictionaries, with the same fields
    """

    def __init__(self, text: str, said: Sequence[str]) -> None:
        self._text, self.said = text, tuple(said)
        data = self.data
        self.energy_j: float = data["energy_j"]
        self.low_j: float = data["low_j"]
        self.high_j: float = data["high_j"]
        self.duration_s: float = data["duration_s"]
        self.distance_m: float = data["distance_m"]
        self.legs: tuple[dict[str, Any], ...] = tuple(data["legs"])

    def __repr__(self) -> str:
        return f"<wheelwatt.Prediction: {self.energy_j:.1f} J ({self.low_j:.1f} to {self.high_j:.1f}, 95 %)>"

    def _repr_html_(self) -> str:
        names = ("leg", "duration_s", "distance_m", "energy_j", "low_j", "high_j")
        rows = [[leg["leg"], *(f"{leg[name]:.1f}" for name in names[1:])] for leg in self.legs]
        return table(repr(self)[1:-1], names, rows, self.said)


class Look(Answer):
    """What is in a log.

    Attributes
    ----------
    rows, duration_s : its length
    energy_per_m_j : energy per metre, standing included; None where the log does not show it
    page : the page of ``gmr look --page``, HTML that needs nothing else
    """

    def __init__(self, text: str, said: Sequence[str], html: str) -> None:
        self._text, self.said, self.page = text, tuple(said), html
        data = self.data
        self.rows: int = data["rows"]
        self.duration_s: float = data["duration_s"]
        self.energy_per_m_j: float | None = data["energy_per_m_j"]

    def __repr__(self) -> str:
        per_m = "energy per metre unknown" if self.energy_per_m_j is None else f"{self.energy_per_m_j:.4g} J/m"
        return f"<wheelwatt.Look: {per_m}; {self.rows} rows, {self.duration_s:.1f} s>"

    def _repr_html_(self) -> str:
        return page(self.page) if self.page else table(repr(self)[1:-1], (), (), self.said)


class Export(Answer):
    """A fit in the terms of another program.

    Attributes
    ----------
    text : what ``gmr export --out`` writes
    """

    def __init__(self, text: str, said: Sequence[str], written: str) -> None:
        self._text, self.said, self.text = text, tuple(said), written

    def save(self, path: str | os.PathLike[str]) -> None:
        """To a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.text)

    def __repr__(self) -> str:
        return f"<wheelwatt.Export of {len(self.text)} bytes>"


class Comparison(Answer):
    """Every model on the same split.

    Attributes
    ----------
    models : dictionaries with ``name``, ``r2``, ``mape_percent``, ``rmse_w`` and more, the smallest error first
    left_out : those that robot or logs do not allow, and why
    """

    def __init__(self, text: str, said: Sequence[str], svg: str) -> None:
        self._text, self.said, self.svg = text, tuple(said), svg
        data = self.data
        self.models: tuple[dict[str, Any], ...] = tuple(sorted(data["models"], key=lambda model: model["rmse_w"]))
        self.left_out: tuple[dict[str, Any], ...] = tuple(data["left_out"])

    def __repr__(self) -> str:
        best = f"{self.models[0]['name']} is best" if self.models else "no model"
        return f"<wheelwatt.Comparison of {len(self.models)} models: {best}>"

    def _repr_html_(self) -> str:
        names = ("name", "r2", "mape_percent", "rmse_w")
        rows = [
            [model["name"], *("–" if model[name] is None else f"{model[name]:.4g}" for name in names[1:])]
            for model in self.models
        ]
        return table(repr(self)[1:-1], names, rows, (), self.svg)


class Gap(Answer):
    """Where model and measurement disagree.

    Attributes
    ----------
    verdict : ``none``, ``named``, ``ambiguous`` or ``unexplained``
    effects : what the model lacked
    ambiguous_with : ids of effects that explain as much
    gap_before_w, gap_after_w : RMS of measured less predicted power on runs not seen, without and with the effects
    page : the page of ``gmr gap --report``, HTML that needs nothing else
    extended : coefficients with the effects; None without coefficients to extend, or without effects
    profile : where the drive that parts the rivals of a tie was written, if there is one
    """

    def __init__(self, text: str, said: Sequence[str], html: str, extended: Coefficients | None) -> None:
        self._text, self.said, self.page, self.extended = text, tuple(said), html, extended
        data = self.data
        self.verdict: str = data["verdict"]
        self.effects: tuple[Effect, ...] = tuple(
            Effect(
                one["id"], one.get("coefficient"), one.get("std_err"), one.get("unit", ""), one.get("meaning", ""), one
            )
            for one in data["effects"]
        )
        self.ambiguous_with: tuple[str, ...] = tuple(data["ambiguous_with"])
        self.gap_before_w: float | None = data["gap_before_w"]
        self.gap_after_w: float | None = data["gap_after_w"]
        self.next_steps: tuple[str, ...] = tuple(data["next_steps"])
        self.profile: str | None = data["suggested_profile"]

    def __repr__(self) -> str:
        named = ", ".join(effect.id for effect in self.effects) or "no effect"
        return f"<wheelwatt.Gap: {self.verdict}: {named}>"

    def _repr_html_(self) -> str:
        if self.page:
            return page(self.page)
        rows = [(one.id, f"{one.coefficient}", f"{one.std_err}", one.unit, one.meaning) for one in self.effects]
        return table(repr(self)[1:-1], ("effect", "coefficient", "±", "unit", ""), rows, self.next_steps)
