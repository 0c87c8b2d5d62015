"""The command ``gmr``, installed with the package."""

from __future__ import annotations

import sys

from . import _gmr


def main() -> int:
    """Runs the command with the program's arguments; gives its exit code."""
    return _gmr.main(sys.argv[1:])
