"""How much power does a wheeled robot draw, when nobody told it what it carries?

The commands of ``gmr`` as functions: they run the same code, take the same logs and say the same. SI units throughout; a column's or
field's unit is the end of its name (``_s``, ``_w``, ``_kg``, ``_rad_s``).

>>> log = gmr.read("run.csv")                       # or gmr.Log(columns), of NumPy, pandas, Arrow
>>> print(gmr.inspect(log, robot="burger").summary)
>>> fit = gmr.fit(["empty.csv", "full.csv"], robot="burger")
>>> estimate = gmr.estimate(log, fit, robot="burger")
>>> estimate.windows["mass_kg"]                     # array, NaN where unknown
>>> gmr.predict(log, fit, mass=3.0).energy_j        # at a payload that is known

Logs of a fleet: `gram` and `fit_grams` on one machine, `gmr.spark` and `gmr.ray` on many.
"""

from ._commands import estimate, fit, gap, gram, inspect, predict, read, simulate
from ._error import Error, NotForBoards
from ._grams import GramFit, fit_grams
from ._log import Log
from ._progress import progress
from ._results import (
    Change,
    Coefficients,
    Effect,
    Estimate,
    Finding,
    Fit,
    Gap,
    Inspection,
    Parameter,
    Prediction,
)

__all__ = [
    "Change",
    "Coefficients",
    "Effect",
    "Error",
    "Estimate",
    "Finding",
    "Fit",
    "Gap",
    "GramFit",
    "Inspection",
    "Log",
    "NotForBoards",
    "Parameter",
    "Prediction",
    "estimate",
    "fit",
    "fit_grams",
    "gap",
    "gram",
    "inspect",
    "predict",
    "progress",
    "read",
    "simulate",
]
