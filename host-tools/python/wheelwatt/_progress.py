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
    knows. What it raises ends the work. None: nobody. True, as it is at first: a line in notebooks, after a second; in a terminal there are bars anyway.
    """
    global _callback
    _callback = callback


def heard() -> Heard | None:
    """Who hears of the work that begins now."""
    if callable(_callback):
        return _callback
    return _Line() if _callback and "ipykernel" in sys.modules else None


class _Line:
    """One line of a notebook, written over and empty at the end. Standard error would be red there."""

    def __init__(self) -> None:
        self._started = time.monotonic()
        self._line: Any = None

    def __call__(self, what: str, done: int, total: int) -> None:
        if time.monotonic() - self._started <= 1.0:
            return
        share = f"{done / total:.1%}" if total else ""
        line = {"text/plain": "" if done == total else f"{what} {share}"}
        if self._line is None:
            from IPython.display import display

            self._line = display(line, raw=True, display_id=True)
        else:
            self._line.update(line, raw=True)
