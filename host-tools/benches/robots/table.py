"""The figures as text."""

import numpy as np

OWN = "signed"
# Other models by what they know of the mass and of the past: on whose terms they predict.
LINES = 118


def number(value, form):
    return "–" if value is None or not np.isfinite(value) else format(value, form)


def mean_r2(folds, name):
    values = [f[name]["r2"] for f in folds if "error" not in f and name in f and f[name]["r2"] is not None]
    return float(np.mean(values)) if values and len(values) == len(folds) else None


def masses(rows):
    out = [
        "Masses that nobody told: trained on the empty and the full robot, tested on six masses between, windows of 25 s",
        "",
        f"{'plant':34} {'method':24} {'error %':>16} {'95 % interval':>14} {'R² of':>8} {'windows':>9}",
        f"{'':34} {'':24} {'mean':>8}{'worst':>8} {'holds':>14} {'power':>8} {'(none)':>9}",
    ]
    for row in rows:
        name = row["name"]
        for method, s in row["methods"].items():
            if s is None:
                out.append(f"{name:34} {method:24} no figures: {'; '.join(sorted(set(row['failed'])))[:60]}")
            else:
                unknown = f" ({s['unknown']})"
                out.append(f"{name:34} {method:24} {s['mean_percent']:8.2f}{s['worst_percent']:8.2f} {s['inside_percent']:12.1f} %"
                           f" {s['r2']:8.4f} {s['windows']:>5}{unknown}")
            name = ""
        if row["note"] != "foreign simulator":
            out.append(f"  ({row['note']})")
    return out


def measured(rows):
    if rows is None:
        return ["Measured robots: skipped, no measured data (../shared/data is not there)"]
    out = ["Measured robots: R² of power, one in three 5 s blocks held out (three offsets), and three folds of whole runs", ""]
    for row in rows:
        names = [n for n in dict.fromkeys(n for f in [*row["blocks"], *row["runs"]] for n in f if n != "error")]
        first = [(mean_r2(row["blocks"], n), mean_r2(row["runs"], n)) for n in names]
        scored = sorted(zip(first, names), key=lambda p: [-(r2 if r2 is not None else -1e9) for r2 in p[0]])
        out += [f"{row['name']} ({row['note']})", f"  {'':30} {'blocks':>28}   {'whole runs':>28}"]
        for k, (_, n) in enumerate(scored):
            each = "  ".join(number(f.get(n, {}).get("r2"), "6.3f") for f in row["blocks"])
            runs = "  ".join(number(f.get(n, {}).get("r2"), "6.3f") for f in row["runs"])
            out.append(f"  {n:30} {number(mean_r2(row['blocks'], n), '7.3f')} ({each})   "
                       + (f"{number(mean_r2(row['runs'], n), '7.3f')} ({runs})" if row["runs"] else "one run only"))
        out.append(f"  {training(row['training'])}")
        out.append("")
    return out


def training(t):
    if "error" in t:
        return f"training: {t['error']}"
    return (f"training R²: gmr fit {t['r2_fit']:.3f}, independent least squares ({t['starts']} starts) {t['r2_independent']:.3f}; "
            f"cost above the best {100.0 * t['cost_above_best']:.2f} %\n"
            f"  its own cost above the lowest of {t['restarts']['starts']} random starts, within its bounds: "
            f"{100.0 * t['restarts']['cost_above_share']:.4f} %")


def text(result):
    return "\n".join([*masses(result["masses"]), "", *measured(result["measured"])])
