"""The figures as text."""

import numpy as np

METHODS = (("ours", "ours"), ("paper", "paper's"), ("recursive", "recursive"))


def figures(rows):
    """Of windows: errors in percent, share that holds the mass, 95th percentile of |error| / half-width, middle half-width in percent."""
    known = [r for r in rows if r["mass"] is not None]
    if not known:
        return None
    error = np.array([r["mass"] - r["truth"] for r in known])
    percent = 100.0 * error / np.array([r["truth"] for r in known])
    half = np.array([0.5 * (r["high"] - r["low"]) if r["low"] is not None else np.nan for r in known])
    wide = 100.0 * half / np.array([r["truth"] for r in known])
    holds = [r["low"] is not None and r["low"] - 1e-9 <= r["truth"] <= r["high"] + 1e-9 for r in known]
    return {"mean": np.abs(percent).mean(), "rms": np.sqrt((percent**2).mean()), "worst": np.abs(percent).max(),
            "holds": 100.0 * np.mean(holds), "ratio": np.percentile(np.abs(error) / np.maximum(half, 1e-12), 95),
            "half": np.nanmedian(wide) if np.isfinite(wide).any() else np.nan, "windows": len(rows), "none": len(rows) - len(known)}


def energy_figures(rows):
    """Of drives: mean size of the error and its mean with its sign in percent, share of intervals that hold."""
    percent = np.array([100.0 * (r["energy"] / r["joules"] - 1.0) for r in rows])
    return np.abs(percent).mean(), percent.mean(), 100.0 * np.mean([r["low"] <= r["joules"] <= r["high"] for r in rows])


def line(name, rows, energies):
    of = {m: figures([r for r in rows if r["method"] == m]) for m in ("ours", "paper", "recursive", "bound")}
    ours = of["ours"]
    if ours is None:
        return f"{name:26} none"
    rival = lambda m: f"{of[m]['mean']:8.1f} {of[m]['holds']:4.0f} %" if of[m] else f"{'–':>8} {'–':>6}"
    mean, bias, holds = energy_figures(energies)
    return (f"{name:26}{ours['mean']:7.2f}{ours['rms']:7.2f}{ours['worst']:7.1f} {ours['holds']:5.0f} % {ours['ratio']:5.2f} {ours['half']:6.2f}"
            f" {of['bound']['rms']:7.2f} {ours['windows']:6d} ({ours['none']}){rival('paper'):>17}{rival('recursive'):>17}"
            f" {mean:7.2f} [{bias:+.2f}] {holds:4.0f} %")


HEAD = (f"{'':26}{'mass, ours: error %':^21} {'95 %':>7} {'':5} {'':6} {'bound':>7} {'windows':>9} {'paper’s method':>18}{'recursive l. s.':>16} {'energy of plans':>22}\n"
        f"{'':26}{'mean':>7}{'rms':>7}{'worst':>7} {'holds':>7} {'ratio':>5} {'± %':>6} {'rms %':>7} {'(none)':>9} {'mean %':>11} {'holds':>6}{'mean %':>10} {'holds':>6}"
        f" {'mean %':>8} {'bias':>6} {'holds':>6}")


def text(rows, energies, seeds):
    names = lambda key: list(dict.fromkeys(r[key] for r in rows))
    out = ["Mass and energy on robots that are not ours: fitted to a mixed drive of the empty and the full robot, driven in six kinds at three masses",
           "between, seen by six sensor chains. Windows of 25 s. ratio: 95th percentile of |error| / half-width; ±: middle half-width. bound: Cramér and Rao's,",
           f"by the noise of the power sensor alone (the coefficients and speeds known). Energy: gmr predict on the true motion and mass. Seeds {seeds.start} to {seeds.stop - 1}.", "", HEAD]

    def group(key):
        for name in names(key):
            own = lambda table: [r for r in table if r[key] == name]
            out.append(line(name, own(rows), own(energies)))
        out.append("")

    for key in ("robot", "kind", "chain"):
        group(key)
    out.append(line("all", rows, energies))
    out += ["", "mean error of the mass, %; coverage, %", f"{'':18}" + "".join(f"{kind:>16}" for kind in names("kind"))]
    for robot in names("robot"):
        out.append(robot)
        for chain in names("chain"):
            cells = []
            for kind in names("kind"):
                f = figures([r for r in rows if r["method"] == "ours" and (r["robot"], r["chain"], r["kind"]) == (robot, chain, kind)])
                cells.append(f"{'–':>16}" if f is None else f"{f['mean']:9.2f} {f['holds']:4.0f} %")
            out.append(f"  {chain:16}" + "".join(cells))
    return "\n".join(out)
