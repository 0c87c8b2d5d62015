"""Roots of quadratics with single-precision coefficients, in 60 decimal digits."""

from decimal import Decimal, getcontext

import numpy as np

from emit import File, f32

getcontext().prec = 60
# Unit roundoff of single precision.
ROUNDOFF = Decimal(2) ** -24
LARGEST = Decimal(float(np.finfo(np.float32).max))


def solve(a, b, c):
    """Real roots in ascending order, and for each how far single precision may be off."""
    a, b, c = (Decimal(float(x)) for x in (a, b, c))
    if a == 0:
        return ([(-c / b, 4 * ROUNDOFF * abs(c / b))]) if b != 0 else []
    discriminant = b * b - 4 * a * c
    if discriminant < 0:
        return []
    # The discriminant's rounding errors are relative to its two terms; its root passes on half of that. Scaling,
    # root, sum and division add a few roundings.
    condition = 6 + 3 * (b * b + abs(4 * a * c)) / discriminant
    q = -(b + (discriminant.sqrt() if b >= 0 else -discriminant.sqrt())) / 2
    roots = sorted((q / a, c / q))
    return [(root, condition * ROUNDOFF * abs(root)) for root in roots if abs(root) <= LARGEST]


def make():
    rng = np.random.default_rng(24)
    named = [
        (1.0, -10000.0001, 1.0),  # the schoolbook formula loses the small root
        (1.0, 10000.0, -1.0),
        (1e-3, -0.7, 1.2),  # a power polynomial, seldom more curved than this
        (0.0, 2.0, -4.0),
        (0.0, 0.0, 1.0),
        (1.0, 0.0, 1.0),
        (1.0, 1.0, 10.0),
        (1e30, -3e30, 2e30),  # b^2 overflows
        (1e-30, -3e-30, 2e-30),  # b^2 vanishes
        (1e-38, 1.0, -3.0),  # the far root is 1e38, just within reach
        (1e-42, 1.0, -3.0),  # and here it is not: linear in all but name
        (-2.0, 3.0, 4.0),
    ]
    drawn = [
        (a, -a * (low + gap + low), a * low * (low + gap))
        for a, low, gap in zip(rng.uniform(-3, 3, 20), rng.uniform(-6, 6, 20), rng.uniform(0.5, 5, 20))
    ]
    rows = []
    for coefficients in named + drawn:
        coefficients = f32(coefficients)
        found = solve(*coefficients)
        pad = [(0.0, 0.0)] * (2 - len(found))
        roots, tolerances = zip(*[(float(root), float(tolerance)) for root, tolerance in found + pad])
        rows.append((coefficients, len(found), roots, tolerances))
    out = File(__file__)
    out.cases(
        "Case",
        [
            ("coefficients", "[f32; 3]", "a, b, c of a x^2 + b x + c"),
            ("count", "usize", "How many real roots single precision can hold"),
            ("roots", "[f64; 2]", "ascending; the first `count` count"),
            ("tolerances", "[f64; 2]", "from the conditioning of each"),
        ],
        rows,
    )
    out.write()
