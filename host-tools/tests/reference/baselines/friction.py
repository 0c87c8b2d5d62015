"""LuGre friction by SciPy's stiff solver, from the differential equation of 1995 with z in metres."""

import numpy as np
from scipy.integrate import solve_ivp

RADIUS = 0.033
COULOMB, STATIC, VISCOUS, STRIBECK = 0.02, 0.03, 1e-3, 1.7
# Published beside Fc = 1 N: 1e5 N/m and sqrt(1e5) N s/m; a deflection of 1e-5 m and a damping time of 3.16 ms.
DEFLECTION, DAMPING_S = 1e-5, 1 / np.sqrt(1e5)
PERIOD_S = 0.05


def steady(w):
    return COULOMB + (STATIC - COULOMB) * np.exp(-((w / STRIBECK) ** 2))


def bend(z, w, seconds, at):
    """Deflection after a time at constant speed, where bristles slip at `at` metres."""
    v = RADIUS * w
    solved = solve_ivp(lambda _, z: v - abs(v) * z / at, (0, seconds), [z], method="Radau", rtol=1e-9, atol=1e-16)
    assert solved.success, solved.message
    return solved.y[0, -1]


def curve():
    """The Stribeck curve as the end of bending: torque at constant speeds from creeping to fast."""
    speeds = np.round(np.geomspace(0.02, 8.0, 60), 6)
    torques = []
    for w in speeds:
        deflection = DEFLECTION * steady(w) / COULOMB
        # 40 time constants: exp(-40) is nothing.
        z = bend(0.0, w, 40 * deflection / (RADIUS * w), deflection)
        torques.append(COULOMB / DEFLECTION * z + VISCOUS * w)
    return speeds.tolist(), torques


def creep():
    """Torque while a wheel creeps to and fro, each speed held for one period; and how far the model is from it whose
    deflection follows the speed and whose damping acts on the last instant."""
    speeds = np.round(0.01 * np.sin(0.21 * np.arange(80) + 0.3), 6)
    sigma = COULOMB / DEFLECTION
    torques, z, full, z_full = [steady(speeds[0]) + VISCOUS * speeds[0]], DEFLECTION, [], None
    z_full = DEFLECTION * steady(speeds[0]) / COULOMB
    for w in speeds[1:]:
        before, z = z, bend(z, w, PERIOD_S, DEFLECTION)
        share = (z + DAMPING_S * (z - before) / PERIOD_S) / DEFLECTION
        torques.append(steady(w) * share + VISCOUS * w)
        slipping = DEFLECTION * steady(w) / COULOMB
        z_full = bend(z_full, w, PERIOD_S, slipping)
        rate = RADIUS * (w - abs(w) * z_full / slipping)
        full.append(sigma * (z_full + DAMPING_S * rate) + VISCOUS * w)
    apart = np.abs(np.array(full) - torques[1:]) / STATIC
    print(f"LuGre with a deflection of its own at each speed: {apart.mean():.3f} of Fs apart, {apart.max():.3f} at most")
    return speeds.tolist(), torques


def reference():
    (speeds, torques), (creeping, creep_torques) = curve(), creep()
    return {
        "stribeck": {"speeds": speeds, "torques": torques},
        "creep": {"speeds": creeping, "torques": creep_torques},
        "constants": [COULOMB, STATIC - COULOMB, VISCOUS, STRIBECK],
    }
