"""How much power does a wheeled robot draw, when nobody told it what it carries?

The commands of ``gmr`` as functions: they run the same code, take the same logs and say the same. SI units throughout; a column's or
field's unit is the end of its name (``_s``, ``_w``, ``_kg``, ``_rad_s``).

>>> log = wheelwatt.read("run.csv")                       # or wheelwatt.Log(columns), of NumPy, pandas, Arrow
>>> print(wheelwatt.inspect(log, robot="burger").summary)
>>> fit = wheelwatt.fit(["empty.csv", "full.csv"], robot="burger")
>>> estimate = wheelwatt.estimate(log, fit, robot="burger")
>>> estimate.windows["mass_kg"]                     # array, NaN where unknown
>>> wheelwatt.predict("route.csv", fit, mass=3.0).energy_j   # of a planned drive

Logs of a fleet: `gram` and `fit_grams` on one machine, `wheelwatt.spark` and `wheelwatt.ray` on many.
"""

from ._commands import compare, estimate, export, fit, gap, gram, inspect, look, predict, read, simulate
from ._error import Error, NotForBoards
from ._grams import GramFit, fit_grams
from ._log import Log
from ._progress import progress
from ._results import (
    Change,
    Coefficients,
    Comparison,
    Effect,
    Estimate,
    Export,
    Finding,
    Fit,
    Gap,
    Inspection,
    Look,
    Parameter,
    Prediction,
)

__all__ = [
    "Change",
    "Coefficients",
    "Comparison",
    "Effect",
    "Error",
    "Estimate",
    "Export",
    "Finding",
    "Fit",
    "Gap",
    "GramFit",
    "Inspection",
    "Log",
    "Look",
    "NotForBoards",
    "Parameter",
    "Prediction",
    "compare",
    "estimate",
    "export",
    "fit",
    "fit_grams",
    "gap",
    "gram",
    "inspect",
    "look",
    "predict",
    "progress",
    "read",
    "simulate",
]
