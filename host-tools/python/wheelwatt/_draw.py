"""Results in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


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


def page(html: str) -> str:
    """A page of its own within another, whose styles do not mix."""
    source = escape(html, quote=True)
    return f'<iframe srcdoc="{source}" style="width:100%;height:800px;border:0" sandbox="allow-scripts"></iframe>'
