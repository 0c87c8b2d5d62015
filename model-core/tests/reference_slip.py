"""Writes reference/slip.csv: the slip memory's differential equation, solved by SciPy. python3 reference_slip.py"""

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

HALF_SLIP, RELAXATION, REST, PERIOD = 0.126, 1.79, 0.05, 0.002
ROWS = 2000

t = PERIOD * np.arange(ROWS + 1)
v = 3.0 * np.clip(np.sin(1.7 * t) + 0.4, 0.0, None)
d = 1.2 * np.sin(2.9 * t + 0.3) * (t < 2.4) + 4.0 * np.clip(t - 3.0, 0.0, 1.0)
left, right = np.round(v - d / 2, 6), np.round(v + d / 2, 6)


def slope(now, s):
    l, r = np.interp(now, t, left), np.interp(now, t, right)
    difference, mean = r - l, abs(l + r) / 2
    return (difference - s * np.sqrt((HALF_SLIP * mean) ** 2 + difference ** 2 + REST ** 2)) / (HALF_SLIP * RELAXATION)


found = solve_ivp(slope, (0.0, t[-1]), [0.0], method="LSODA", t_eval=t, rtol=1e-9, atol=1e-11, max_step=2 * PERIOD)
with open(Path(__file__).parent / "reference" / "slip.csv", "w") as out:
    out.write(f"{HALF_SLIP},{RELAXATION},{REST},{PERIOD}\n")
    for l, r, s in zip(left[1:], right[1:], found.y[0][1:]):
        out.write(f"{l:g},{r:g},{s:.7g}\n")
