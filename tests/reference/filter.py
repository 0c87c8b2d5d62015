"""The causal filter and its derivative, by SciPy's own design and filtering, from analogue poles and zeros."""

import numpy as np
from scipy import signal

from emit import File, f32

RATE_HZ = 200.0
CUTOFF_HZ = 2.0


def sections(derivative, cutoff_hz, rate_hz):
    """Second-order sections of a fifth-order Butterworth low-pass, times s for its derivative; bilinear, prewarped."""
    warped = 2.0 * rate_hz * np.tan(np.pi * cutoff_hz / rate_hz)
    zeros, poles, gain = signal.butter(5, warped, analog=True, output="zpk")
    if derivative:
        zeros = np.append(zeros, 0.0)
    return signal.zpk2sos(*signal.bilinear_zpk(zeros, poles, gain, fs=rate_hz))


def run(x, derivative, cutoff_hz, rate_hz):
    """Filters x as if its first value had been its past."""
    sos = sections(derivative, cutoff_hz, rate_hz)
    return signal.sosfilt(sos, x, zi=signal.sosfilt_zi(sos) * x[0])[0]


def make():
    """Speeds of a wheel: stand, speed up, wobble, reverse, with a sensor's steps of 0.229 rev/min."""
    t = np.arange(600) / RATE_HZ
    speed = np.interp(t, [0.0, 0.3, 0.8, 1.6, 2.1, 3.0], [0.7, 0.7, 6.4, 6.4, -5.0, -5.0])
    speed += 0.4 * np.sin(2.0 * np.pi * 1.3 * t)
    step = 0.229 * 2.0 * np.pi / 60.0
    x = f32(np.round(speed / step) * step)

    out = File(__file__)
    out.constant("RATE_HZ", "f64", RATE_HZ, "Samples per second.")
    out.constant("CUTOFF_HZ", "f64", CUTOFF_HZ, "-3 dB.")
    out.cases(
        "Sample",
        [
            ("input", "f32", "rad/s"),
            ("filtered", "f64", "rad/s"),
            ("derivative", "f64", "of the filtered speed, rad/s^2"),
        ],
        list(zip(x, run(x, False, CUTOFF_HZ, RATE_HZ), run(x, True, CUTOFF_HZ, RATE_HZ))),
    )
    out.write()
