"""Results in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray


def table(
    title: str, head: Sequence[str], rows: Sequence[Sequence[str]], notes: Iterable[str] = (), svg: str = ""
) -> str:
    """A title, a table (none without rows), lines below it, a drawing. All but the drawing is text, and escaped."""
    parts = [f"<p><b>{escape(title)}</b></p>"]
    if rows:
        cells = "".join(f"<th>{escape(cell)}</th>" for cell in head)
        lines = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        parts.append(f"<table><thead><tr>{cells}</tr></thead><tbody>{lines}</tbody></table>")
    parts += [f"<p>{escape(note)}</p>" for note in notes]
    if svg:
        parts.append(f'<div style="max-width:1000px">{svg}</div>')
    return "".join(parts)


#: Of lines, one after the other: apart for people who see few colours (Okabe and Ito).
_COLOURS = ("#56b4e9", "#d55e00", "#009e73", "#cc79a7")


def lines(title: str, x: NDArray[np.float64], series: Mapping[str, NDArray[np.float64]]) -> str:
    """A drawing (SVG) of values over x, at most some 2,000 of each; where there is none, the line is broken."""
    width, height, left, top = 900.0, 300.0, 60.0, 30.0
    values = np.concatenate(list(series.values()))
    values = values[np.isfinite(values)]
    if len(x) < 2 or len(values) == 0:
        return ""
    low, high = float(values.min()), float(values.max())
    high = high if high > low else low + 1.0
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" font-family="sans-serif" font-size="12">',
        f'<text x="{left:g}" y="18">{escape(title)}</text>',
        f'<text x="4" y="{top + 10:g}">{high:.4g}</text><text x="4" y="{height - 20:g}">{low:.4g}</text>',
        f'<text x="{left:g}" y="{height - 4:g}">{x[0]:.4g}</text>',
        f'<text x="{width - 4:g}" y="{height - 4:g}" text-anchor="end">{x[-1]:.4g}</text>',
    ]
    every = slice(None, None, max(1, len(x) // 2000))
    across = left + (width - left - 10.0) * (x[every] - x[0]) / (x[-1] - x[0])
    for place, (name, of) in enumerate(series.items()):
        colour = _COLOURS[place % len(_COLOURS)]
        up = height - 20.0 - (height - 20.0 - top) * (of[every] - low) / (high - low)
        known = np.isfinite(up)
        begins = known & ~np.concatenate([[False], known[:-1]])
        path = "".join(f"{'M' if b else 'L'}{a:.1f} {u:.1f}" for a, u, k, b in zip(across, up, known, begins) if k)
        parts.append(f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.2"/>')
        parts.append(f'<text x="{left + 150.0 + 110.0 * place:g}" y="18" fill="{colour}">{escape(name)}</text>')
    return "".join(parts) + "</svg>"


def page(html: str) -> str:
    """A page of its own within another, whose styles do not mix."""
    source = escape(html, quote=True)
    return f'<iframe srcdoc="{source}" style="width:100%;height:800px;border:0" sandbox="allow-scripts"></iframe>'
