"""Writes numbers as Rust constants: inputs exactly as the board's f32, references in f64 with all their digits."""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent


def f32(values):
    """What the board sees: rounded to single precision, then kept as float64."""
    return np.asarray(values, dtype=np.float32).astype(np.float64)


def literal(value):
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(literal(item) for item in value) + "]"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    assert np.isfinite(value)
    text = repr(float(value))
    return text


class File:
    """One file of constants, included by the test of the same name."""

    def __init__(self, script):
        self.path = HERE / f"{Path(script).stem}.rs"
        self.text = f"// Made by {Path(script).name}; do not edit.\n"

    def constant(self, name, kind, value, meaning):
        self.text += f"\n/// {meaning}\npub(crate) const {name}: {kind} = {literal(value)};\n"

    def cases(self, struct, fields, rows):
        """A struct with `fields`, (name, type, meaning) each, and a table of it, one row a line."""
        members = "".join(f"    /// {meaning}\n    pub(crate) {name}: {kind},\n" for name, kind, meaning in fields)
        self.text += f"\npub(crate) struct {struct} {{\n{members}}}\n"
        lines = ""
        for row in rows:
            values = ", ".join(f"{field[0]}: {literal(value)}" for field, value in zip(fields, row, strict=True))
            lines += f"    {struct} {{ {values} }},\n"
        self.text += f"\npub(crate) const {struct.upper()}S: [{struct}; {len(rows)}] = [\n{lines}];\n"

    def write(self):
        self.path.write_text(self.text)
