"""NAME.h of a filter: what its template (templates/filter.h.j2) is given."""

from __future__ import annotations

from typing import Optional

from kalmanq.compiler.algorithm.arithmetic import Arithmetic
from kalmanq.compiler.given.names import plain
from kalmanq.compiler.templates.engine import rendered
from kalmanq.compiler.text import delayed
from kalmanq.compiler.text.emit import Text


def header(text: Text, late: Optional[delayed.Delayed] = None) -> str:
    given, a, options, n = text.given, text.a, text.given.options, text.given.of.n
    return rendered(text.header, {
        **text.names(), "includes": a.includes, "enumerators": a.enumerators(), "fields": a.fields, "mean_type": a.mean_type,
        "nis_fields": a.nis_fields() if options.nis else [], "likelihood": a.likelihood() if options.nis else None,
        "means": [a.mean_text(i) for i in range(len(given.carried))], "quantities": _quantities(a), "refused_start": a.refused_start,
        "lagged": [a.lagged(i, f"l->x[{options.lag}][{i}]") for i in range(n)] if options.lag else [],
        "events": a.events, "late": late.names() if late else None})


def _quantities(a: Arithmetic) -> list[str]:
    rows = [("", "name", "unit", "range", "format")]
    for which in ("states", "measurements", "controls"):
        for k, one in enumerate(getattr(a.model, "inputs" if which == "controls" else which)):
            rows.append((f"{which[:-1]} {k}", plain(one.name), plain(one.unit), one.span, a.format_of(which, k)))
    rows = rows if rows[1][-1] else [row[:-1] for row in rows]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows]
