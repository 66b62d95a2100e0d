"""C and reports from the templates beside this: each reads as what comes of it.

A template has `${name}` for a text, and for lines alone in a line, which are all written with what stands before them there
(an indent, or ` * `).  A line that ends with `//? CONDITION` is written where that holds, one with `//* NAME in LIST` for each, up
to its closing brace if it opens one; alone in a line they are of the paragraph after it.  `{% if ... %}` and `{% for ... %}`
are Jinja's.  Of C, what depends on the lines that Python has made is
added last: `(void)x;` for a parameter that no line reads, and the routines that the functions call.
"""

from __future__ import annotations

import re
import textwrap
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Optional, Sequence

from kalmanq.errors import counted

if TYPE_CHECKING:
    from jinja2 import Environment

LINES = re.compile(r"^([^\n\0]*)\0([^\0]*)\0\n", re.M)
FUNCTION = re.compile(r"^(\w[^\n]*\))\n\{\n(.*?)^\}$", re.M | re.S)
CALL = re.compile(r"^( *)(if \(!status\) .*)$", re.M)
GUARDED = [re.compile(one, re.M | re.S) for one in (  # a paragraph after the guard, what is in braces, a line
    r"^()()//(?P<sign>[?*]) (?P<when>[^\n]*)\n(?P<rest>.*?\n\n)", r"^( +)([^\n]*\{) //(?P<sign>[?*]) (?P<when>[^\n]*)(?P<rest>\n.*?^\1\}\n)",
    r"^()([^\n]*?) *//(?P<sign>[?*]) (?P<when>[^\n]*)(?P<rest>\n)")]
ROUTINES = "/* routines */\n"  # the line of a template in whose place they come
INDENT = "    "


@lru_cache(maxsize=None)
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # here: most commands write no C
    from jinja2.ext import Extension

    class Guards(Extension):
        def preprocess(self, source: str, name: Optional[str], filename: Optional[str] = None) -> str:
            for guarded in GUARDED:
                source = guarded.sub(_guard, source)
            return source

    made = Environment(loader=FileSystemLoader(Path(__file__).parent, encoding="utf-8"), undefined=StrictUndefined, trim_blocks=True,
                       lstrip_blocks=True, keep_trailing_newline=True, variable_start_string="${", variable_end_string="}",
                       finalize=_marked, extensions=[Guards])
    made.filters.update(lines=_lines, aligned=_aligned, chained=_chained, counted=counted, wrapped=textwrap.wrap)
    return made


def rendered(template: str, given: dict[str, Any], block: str = "") -> str:
    """block: that alone"""
    of = _environment().get_template(template)
    return _placed("".join(of.blocks[block](of.new_context(given))) if block else of.render(given)).rstrip("\n") + "\n"


def rendered_c(template: str, given: dict[str, Any], routines: Callable[[str], str]) -> str:
    """NAME.c; routines: of a text that calls them"""
    text = FUNCTION.sub(lambda one: "\n".join([one[1], "{", *_finished(one[1], one[2].splitlines()), "}"]), rendered(template, given))
    before, mark, after = CALL.sub(_wrapped, text).partition(ROUTINES)
    return before + routines(after) + after if mark else before


def _guard(found: re.Match[str]) -> str:
    word = "if" if found["sign"] == "?" else "for"
    return f"{{% {word} {found['when']} %}}\n{found[1]}{found[2]}{found['rest']}{{% end{word} %}}\n"


# ---- lines


def _marked(value: Any) -> Any:
    """Lines, until it is known what stands before them"""
    return "\0" + "\n".join(value) + "\0" if isinstance(value, (list, tuple)) else value


def _placed(text: str) -> str:
    return LINES.sub(lambda one: "".join(f"{one[1]}{line}".rstrip() + "\n" for line in one[2].split("\n")) if one[2] else "", text)


def _lines(text: str) -> list[str]:
    return _placed(text).splitlines()


def _aligned(text: str) -> list[str]:
    """Calls, each with what it is for after //, in a column"""
    rows = [line.partition(" // ") for line in text.splitlines()]
    width = max(len(call) for call, _, _ in rows) + 4
    return [f"{call:<{width}}{what}".rstrip() for call, _, what in rows]


def _chained(text: str) -> list[str]:
    """The body of a function that calls one after the other as long as each is right"""
    first, *others = text.splitlines()
    if not others:
        return [f"return {first};"]
    return [f"kq_status status = {first};", *(f"if (!status) status = {one};" for one in others), "return status;"]


# ---- C


def _wrapped(call: re.Match[str]) -> str:
    """A call of the library may be long"""
    return "\n".join(call[1] + line for line in textwrap.wrap(call[2], 124, subsequent_indent=INDENT))


def _finished(head: str, body: Sequence[str]) -> list[str]:
    """The body of a function, which reads each parameter, and nothing for itself alone"""
    used = _used(body)
    unused = [f"{INDENT}(void){name};" for name in re.findall(r"(\w+)(?:\[\d+\])?[,)]", head) if not _mentions(used, name)]
    return [*unused, *used]


def _used(body: Sequence[str]) -> list[str]:
    """Without measurements that a row of zeros does not read; a control is looked at all the same"""
    made = []
    for line in body:
        found = re.fullmatch(r"( *)const \w+ ([zu]\d+) = (.*);(?: /\*.*\*/)?", line)
        if found is None or sum(_mentions([other], found[2]) for other in body) > body.count(line):
            made.append(line)
        elif found[2][0] == "u":
            made.append(f"{found[1]}(void){found[3]};")
    return made


def _mentions(lines: Sequence[str], name: str) -> bool:
    return any(re.search(rf"\b{name}\b", line.split("/*")[0]) for line in lines)
