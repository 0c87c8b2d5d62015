"""A coefficient image, packed from the table in model-core/src/coefficients.rs with struct and zlib."""

import struct
import zlib

from emit import File, f32
from power import GYRATION_RADIUS, TORQUE, TRACK, WHEEL_RADIUS

NAME = "reference"
NUMBERS = {
    "GYRATION_RADIUS": GYRATION_RADIUS, "DEAD_BAND": 0.02, "CUTOFF_HZ": 2.0, "NO_LOAD": 1.0, "FULL_LOAD": 6.0,
    "STATIC_POWER": 6.393, "NOISE_DENSITY": 0.0031, "NOISE_MODEL_STD": 0.012, "RESIDUAL_STD": 0.034,
    "NOISE_TAIL": 1.25,
}


def make():
    r, o = WHEEL_RADIUS / 2, WHEEL_RADIUS / TRACK
    head = struct.pack("<4sHHBBBB24s", b"GMRC", 1, 136 + 24 + 4, 2, 1, 2, 8, NAME.encode())
    numbers = struct.pack("<10f", *NUMBERS.values()) + struct.pack("<15f", *TORQUE, *[0.0] * 8)
    rows = struct.pack("<6f", r, r, 0.0, 0.0, -o, o)
    body = head + numbers + rows
    assert len(head) == 36 and len(body) == 160
    image = body + struct.pack("<I", zlib.crc32(body))

    out = File(__file__)
    out.constant("NAME", "&str", f'"{NAME}"', "The robot's.")
    for name, value in NUMBERS.items():
        out.constant(name, "f32", float(f32(value)), "SI units.")
    out.constant("TORQUE", "[f32; 7]", TORQUE, "The signed torque model's parameters; the drive is regenerative.")
    out.constant("ROWS", "[[f32; 2]; 3]", f32([[r, r], [0.0, 0.0], [-o, o]]), "R.")
    out.constant("IMAGE", f"[u8; {len(image)}]", list(image), "All of that, encoded.")
    out.write()
