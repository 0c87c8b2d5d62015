"""The whole pipeline on a recorded drive, in f64 from SciPy's parts: filter, torque model, mass by minimisation."""

import numpy as np
from scipy import optimize

import filter as low_pass
from emit import File, f32
from power import DEAD_BAND, TORQUE, mass_matrix, signed_power, signed_torque

RATE_HZ = 20.0
CUTOFF_HZ = 2.0
DURATION_S = 25
LIGHT, HEAVY = 1.0, 6.0
TRUE_MASS = 4.7
NOISE_W = 0.05
# Samples until the filter counts as settled: two periods of the cutoff.
SETTLING = round(2.0 * RATE_HZ / CUTOFF_HZ)
# Samples for which the filter remembers a clamp: one period.
CLAMP_MEMORY = round(RATE_HZ / CUTOFF_HZ)


def drive():
    """Speeds that start, turn, stop and reverse, in a servo's steps, and the power that TRUE_MASS then draws."""
    rng = np.random.default_rng(25)
    t = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    knots = np.arange(0.0, DURATION_S + 1.0, 0.9)
    speeds = np.array([np.interp(t, knots, rng.choice([-5.0, -2.5, 0.0, 3.0, 6.0], len(knots))) for _ in range(2)])
    acceleration = np.gradient(speeds, 1.0 / RATE_HZ, axis=1)
    power = [
        np.maximum(signed_power(w, a, mass_matrix() @ a, TRUE_MASS), 0.0).sum()
        for w, a in zip(speeds.T, acceleration.T)
    ]
    step = 0.229 * 2.0 * np.pi / 60.0
    return f32(np.round(speeds / step) * step), f32(np.array(power) + rng.normal(0.0, NOISE_W, len(t)))


def may_clamp(w, a):
    """Whether some moving wheel's torque opposes its motion at a mass of the range."""
    moving = np.abs(w) > DEAD_BAND
    along = [signed_torque(w, a, mass_matrix() @ a, mass) * np.sign(w) for mass in (LIGHT, HEAVY)]
    return np.any(moving & (np.minimum(*along) < 0.0))


def make():
    speeds, power = drive()
    filtered = np.array([low_pass.run(w, False, CUTOFF_HZ, RATE_HZ) for w in speeds]).T
    derivative = np.array([low_pass.run(w, True, CUTOFF_HZ, RATE_HZ) for w in speeds]).T
    smooth = low_pass.run(power, False, CUTOFF_HZ, RATE_HZ)

    settled = np.arange(len(power)) >= SETTLING
    clamped = settled & [may_clamp(w, a) for w, a in zip(filtered, derivative)]
    used = [i for i in np.flatnonzero(settled) if not clamped[max(0, i - CLAMP_MEMORY + 1): i + 1].any()]

    def residuals(mass):
        model = [signed_power(filtered[i], derivative[i], mass_matrix() @ derivative[i], mass[0]).sum() for i in used]
        return smooth[used] - model

    fit = optimize.least_squares(residuals, [3.5], bounds=([LIGHT], [HEAVY]), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    sensitivity = np.sqrt(np.mean(fit.jac**2))
    energy = np.maximum(smooth, 0.0).sum() / RATE_HZ
    print(f"estimator: mass {fit.x[0]:.6f} kg of {TRUE_MASS}, {len(used)} of {settled.sum()} samples used, "
          f"dP/dm {sensitivity:.3f} W/kg rms, residual {np.std(fit.fun):.3f} W rms")

    out = File(__file__)
    out.constant("PERIOD_S", "f64", 1.0 / RATE_HZ, "Between samples.")
    out.constant("CUTOFF_HZ", "f32", CUTOFF_HZ, "Of the filter.")
    out.constant("BUCKETS", "usize", DURATION_S, "Seconds in the drive, one bucket each.")
    out.constant("MASSES", "[f32; 2]", [LIGHT, HEAVY], "No load and full load, kg.")
    out.constant("NOISE_STD", "f32", NOISE_W, "Of the power before the filter, W.")
    out.constant("MASS", "f64", fit.x[0], "Where the sum of squares is least, kg.")
    out.constant("ENERGY", "f64", energy, "Integral of the positive part of the filtered power, J.")
    out.cases(
        "Sample",
        [("speed", "[f32; 2]", "rad/s"), ("power", "f32", "W")],
        [(w, p) for w, p in zip(speeds.T, power)],
    )
    out.write()
