"""The power models: the regressors of Eq. 18, the law that they expand, and the signed torque model."""

import numpy as np

from emit import File, f32

WHEEL_RADIUS, TRACK, GYRATION_RADIUS = 0.033, 0.16, 0.09
DEAD_BAND = 0.02
# coulomb, rolling, viscous, rotor inertia, inertia gain, winding loss of a small servo
TORQUE = f32([0.04, 0.012, 0.006, 0.0081, 1.33, 6.5, 0.0])


def mass_matrix():
    """M'' = R' diag(1, k^2) R of a differential drive, per kilogram."""
    twist = np.array([[0.5, 0.5], [-1.0 / TRACK, 1.0 / TRACK]]) * WHEEL_RADIUS
    return twist.T @ np.diag([1.0, GYRATION_RADIUS**2]) @ twist


def features(w, a, inertial, gate_a, gate_k, squares):
    """The 15 features of each wheel in the order of Eq. 18; `squares` is what the print adds to the gates of a^2, K^2."""
    one, h = np.ones_like(w), np.sign(w)
    return np.array([
        one, one, one, w**2, (gate_a + squares) * a**2, (gate_k + squares) * inertial**2, abs(w), abs(w),
        gate_a * h * a, gate_a * h * a, gate_k * h * inertial, gate_k * h * inertial, gate_a * a * w,
        gate_k * inertial * w, gate_a * gate_k * inertial * a,
    ])


def regressors(w, a, inertial, mass, published):
    """X^0 ... X^14, summed over the wheels."""
    powers = np.array([0, 1, 2, 0, 0, 1 if published else 2, 0, 1, 0, 1, 1, 2, 0, 1, 1])
    gate_a, gate_k = 1.0 + np.sign(a * w), 1.0 + np.sign(inertial * w)
    each = features(w, a, inertial, gate_a, gate_k, 1.0 if published else 0.0)
    return each.sum(axis=1) * float(mass) ** powers


def gated_law(w, a, inertial, mass):
    """Eq. 15 with the torque of Eq. 16, nothing expanded: T w + kappa T^2 over the wheels."""
    p0, p1, viscous, rotor, gain, loss, _ = TORQUE
    gate_a, gate_k = 1.0 + np.sign(a * w), 1.0 + np.sign(inertial * w)
    torque = (p0 + p1 * mass) * np.sign(w) + viscous * w + rotor * gate_a * a + gain * mass * gate_k * inertial
    return np.sum(torque * w + loss * torque**2)


def expansion():
    """beta of the corrected Eq. 18 that follow from the gated law with (1 + s)^2 = 2 (1 + s)."""
    p0, p1, q, g, n, k, _ = TORQUE
    lift = 1 + 2 * k * q
    return np.array([
        k * p0**2, 2 * k * p0 * p1, k * p1**2, q + k * q**2, 2 * k * g**2, 2 * k * n**2, p0 * lift, p1 * lift,
        2 * k * p0 * g, 2 * k * p1 * g, 2 * k * p0 * n, 2 * k * p1 * n, g * lift, n * lift, 2 * k * g * n,
    ])


def signed_torque(w, a, inertial, mass):
    coulomb, rolling, viscous, rotor, gain, _, _ = TORQUE
    return (coulomb + rolling * mass) * np.sign(w) + viscous * w + rotor * a + gain * mass * inertial


def signed_power(w, a, inertial, mass):
    """Power of each wheel, unclamped; wheels within the dead band draw nothing."""
    torque = signed_torque(w, a, inertial, mass)
    return np.where(np.abs(w) > DEAD_BAND, torque * w + TORQUE[5] * torque**2, 0.0)


def case(rng, resting):
    w = f32(rng.uniform(0.5, 6.5, 2) * rng.choice([-1.0, 1.0], 2))
    a = f32(rng.uniform(0.5, 30.0, 2) * rng.choice([-1.0, 1.0], 2))
    mass = float(f32(rng.uniform(1.0, 6.0)))
    inertial = mass_matrix() @ a
    law = gated_law(w, a, inertial, mass)
    corrected = regressors(w, a, inertial, mass, published=False)
    assert np.isclose(expansion() @ corrected, law, rtol=1e-12), "the expansion is not the law"
    if resting:
        # The second wheel creeps within the dead band: only the signed model is asked.
        w = f32([w[0], 0.5 * DEAD_BAND])
    power = signed_power(w, a, inertial, mass)
    # Every term's magnitude: what single precision loses is relative to these, not to the sums.
    sizes = abs(w), abs(a), np.abs(mass_matrix()) @ abs(a)
    size = features(*sizes, 2.0, 2.0, 1.0).sum(axis=1) * max(mass, 1.0) ** 2
    return (
        w, a, mass, "true" if resting else "false", regressors(w, a, inertial, mass, published=True), corrected, size,
        law, np.maximum(power, 0.0).sum(), power.sum(), signed_power(*sizes, mass).sum(),
    )


def make():
    rng = np.random.default_rng(18)
    out = File(__file__)
    for name, value, meaning in (
        ("WHEEL_RADIUS", WHEEL_RADIUS, "m"), ("TRACK", TRACK, "m"), ("GYRATION_RADIUS", GYRATION_RADIUS, "m"),
        ("DEAD_BAND", DEAD_BAND, "rad/s"),
    ):
        out.constant(name, "f32", value, meaning)
    out.constant("TORQUE", "[f32; 7]", TORQUE, "The parameters, in the model's order.")
    out.constant("BETA", "[f64; 15]", expansion(), "Coefficients of the corrected Eq. 18 that follow from them.")
    out.cases(
        "Case",
        [
            ("speed", "[f32; 2]", "rad/s"),
            ("acceleration", "[f32; 2]", "rad/s^2"),
            ("mass", "f32", "kg"),
            ("resting", "bool", "One wheel is within the dead band: only the signed model's power is meant."),
            ("published", "[f64; 15]", "X^0 ... X^14 of Eq. 18 as printed"),
            ("corrected", "[f64; 15]", "and as they follow from Eq. 15 and 16"),
            ("size", "[f64; 15]", "Sum of the magnitudes of what is added in each, at the most"),
            ("law_w", "f64", "Eq. 15 and 16, not expanded, W"),
            ("clamped_w", "f64", "Signed torque model, each wheel at least 0, W"),
            ("free_w", "f64", "and without that clamp, W"),
            ("size_w", "f64", "Sum of the magnitudes of what is added in it, W"),
        ],
        [case(rng, resting=i % 8 == 7) for i in range(24)],
    )
    out.write()
