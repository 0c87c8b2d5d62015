"""How far work is: told to whoever wants to know."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, Union

#: Called with what is being done, how much of it is done, and of how much (0: unknown).
Heard = Callable[[str, int, int], Any]

_callback: Union[Heard, None, bool] = True


def progress(callback: Heard | None | bool) -> None:
    """Sets who hears how far work is, some times a second: ``callback(what, done, total)`` with bytes or pieces, `total` 0 where nobody
    knows. What it raises ends the work. None: nobody. True, as it is at first: a line on standard error in notebooks, after a second; in a
    terminal there are bars anyway.
    """
    global _callback
    _callback = callback


def heard() -> Heard | None:
    """Who hears of the work that begins now."""
    if callable(_callback):
        return _callback
    return _Line() if _callback and "ipykernel" in sys.modules else None


class _Line:
    """One line that is written over."""

    def __init__(self) -> None:
        self._started = time.monotonic()

    def __call__(self, what: str, done: int, total: int) -> None:
        if time.monotonic() - self._started > 1.0:
            share = f"{done / total:6.1%}" if total else ""
            print(f"\rgmr: {what} {share}   ", end="\r" if done == total else "", file=sys.stderr, flush=True)
