"""HTML for notebooks."""

from html import escape


def html_table(head: list[str], *rows: list[str], below: str = "") -> str:
    """A table of texts, and a line below it."""
    cells = ["".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row) for tag, row in [("th", head), *_tagged(rows)]]
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<table>{body}</table>" + (f"<p>{escape(below)}</p>" if below else "")


def _tagged(rows: tuple[list[str], ...]) -> list[tuple[str, list[str]]]:
    return [("td", row) for row in rows]
