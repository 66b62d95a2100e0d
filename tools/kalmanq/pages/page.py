"""The text of a page: its template and the elements that stand in it.  What is given as text is escaped."""

from __future__ import annotations

import html
import re
from pathlib import Path
from string import Template
from typing import Optional, Sequence

from kalmanq.pages.verdict import Finding

MANY = 9  # columns of a table, beyond which its print is small
STATES = {"good": "fits", "edge": "nearly", "bad": "does not", "note": "note"}


def escaped(text: object) -> str:
    return html.escape(str(text), quote=True)


def with_code(text: str) -> str:
    """Escaped; what is between ` is a command."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escaped(text))


def page(title: str, facts: Sequence[str], sections: Sequence[str], footer: str) -> str:
    template = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    return template.substitute(title=escaped(title), facts=" · ".join(map(escaped, facts)),
                               sections="\n".join(sections), footer=escaped(footer))


def section(heading: str, *content: str, name: str = "", kind: str = "") -> str:
    """name: that of the section on the page; content: elements."""
    style = f' class="{kind}"' if kind else ""
    return (f'<section{style} aria-labelledby="{name}">\n<h2 id="{name}">{escaped(heading)}</h2>\n'
            + "\n".join(one for one in content if one) + "\n</section>")


def paragraph(text: str, kind: str = "") -> str:
    style = f' class="{kind}"' if kind else ""
    return f"<p{style}>{with_code(text)}</p>"


def figure(caption: str, pictures: str) -> str:
    return f"<figure>\n<figcaption>{escaped(caption)}</figcaption>\n{pictures}\n</figure>"


def small(figures: Sequence[str]) -> str:
    """Side by side where there is room."""
    return '<div class="small">\n' + "\n".join(figures) + "\n</div>"


def legend(entries: Sequence[tuple[str, str]]) -> str:
    return '<ul class="legend">' + "".join(
        f'<li class="{kind}">{escaped(text)}</li>' for kind, text in entries) + "</ul>"


def finding_list(found: Sequence[Finding]) -> str:
    return '<ul class="findings">\n' + "\n".join(map(_finding, found)) + "\n</ul>"


def _finding(one: Finding) -> str:
    advice = f'\n<p class="advice">{with_code(one.advice)}</p>' if one.advice else ""
    return (f'<li><span class="state {one.state}">{STATES[one.state]}</span>'
            f"<p><strong>{escaped(one.subject)}</strong>: {with_code(one.said)}</p>{advice}</li>")


def table(caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]],
          text_columns: Optional[Sequence[int]] = None) -> str:
    """The first cell of a row is its header; cells of text_columns are words."""
    words = text_columns or ()
    head = "".join(f'<th scope="col"{_kind(k, words)}>{escaped(one)}</th>' for k, one in enumerate(columns))
    body = "\n".join(_row(row, words) for row in rows)
    many = ' class="many"' if len(columns) > MANY else ""
    return (f'<div class="wide-table" tabindex="0" role="group" aria-label="{escaped(caption)}"><table{many}>\n'
            f"<caption>{escaped(caption)}</caption>\n"
            f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>")


def _row(row: Sequence[str], words: Sequence[int]) -> str:
    cells = "".join(f"<td{_kind(k, words)}>{escaped(cell)}</td>" for k, cell in enumerate(row[1:], 1))
    return f'<tr><th scope="row">{escaped(row[0])}</th>{cells}</tr>'


def _kind(column: int, words: Sequence[int]) -> str:
    return ' class="text"' if column in words else ""


def folded(summary: str, *content: str) -> str:
    return f"<details>\n<summary>{escaped(summary)}</summary>\n" + "\n".join(content) + "\n</details>"


def verbatim(text: str) -> str:
    return f'<pre tabindex="0">{escaped(text)}</pre>'
