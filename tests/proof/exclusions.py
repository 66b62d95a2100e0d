"""excluded.txt: what is not reached, and why it need not be.  A row is

    ARITHMETICS | FILE | FUNCTION | TEXT | WHAT | WHY

and leaves out, in these arithmetics (* for all), the statement, or the side (true, false) of the condition with that text.
A side brings along what only it chooses, and the condition, which cannot decide without it; a statement what is within it.
WHAT `decides` leaves out the condition's MC/DC alone, `never` both sides of it and the condition; TEXT * is all of a function
that is not reached."""

from pathlib import Path

from places import arm, is_within, text_of

FILE = Path(__file__).parent / "excluded.txt"


ALL = ("f32", "f64", "q31")


class Row:
    def __init__(self, line):
        arithmetics, self.file, self.function, *text, self.what, self.why = line.split(" | ")
        self.arithmetics = ALL if arithmetics == "*" else arithmetics.split()
        self.text = " | ".join(text)
        self.line, self.counts = line, dict.fromkeys(self.arithmetics, 0)

    def places(self, items):
        """place: the items there that the row names, of a place where none of them is reached"""
        found = {}
        for item in items:
            if (item.place[0], item.function) == (self.file, self.function) and self.text in ("*", text_of(item.place)):
                found.setdefault("*" if self.text == "*" else item.place, []).append(item)
        named = ([item for item in of if self._leaves_out(item)] for of in found.values())
        return [of for of in named if of and not any(item.is_reached for item in of)]

    def _leaves_out(self, item):
        return self.text == "*" or item.what == self.what or self.what in ("true", "false", "never") and item.what == "decides" or \
            self.what == "never" and item.kind == "sides"


class Exclusions:
    def __init__(self):
        self.rows = [Row(line) for line in FILE.read_text().splitlines() if line and not line.startswith("#")]

    def apply(self, arithmetic, items, regions):
        for row in self.rows:
            if arithmetic in row.arithmetics:
                for item in (item for of in row.places(items) for item in of):
                    row.counts[arithmetic] += leave_out(row, item, items, regions)

    def failures(self):
        for row in self.rows:
            for arithmetic, count in row.counts.items():
                if not count:
                    yield f"excluded.txt excludes nothing in {arithmetic} by: {row.line}"

    def table(self):
        yield "| excluded | in | items | why |"
        yield "|---|---|---:|---|"
        for row in self.rows:
            text = f"{row.file} {row.function}: `{row.text}` {row.what}".replace("|", "\\|")
            yield f"| {text} | {', '.join(row.arithmetics)} | {sum(row.counts.values())} | {row.why} |"


def leave_out(row, item, items, regions):
    """The item, and what only it chooses or what is within it; how many"""
    inside = item.place if item.what == "statement" else arm(item.place, item.what, regions) if item.kind == "sides" else None
    count = 0
    for other in items:
        if other is item or inside and is_within(other.place, inside) and not other.is_reached:
            count += not other.why
            other.why = row.why
    return count
