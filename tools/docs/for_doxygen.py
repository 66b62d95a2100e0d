#!/usr/bin/env python3
"""A header with its comments as Doxygen takes them: the first sentence is text, what is in columns stays so.  for_doxygen.py HEADER"""

import re
import sys
from pathlib import Path


def comment(found: re.Match[str]) -> str:
    stars = re.search(r"^ \*", found.group(1), re.M)
    lines = [re.sub(r"^ *\* ?" if stars else r"^ {4}", "", line).rstrip() for line in found.group(1).split("\n")]
    at = next((k for k, line in enumerate(lines) if k and (not line or line.startswith("  "))), len(lines))
    intro, rest = " ".join(line.strip() for line in lines[:at]), "\n".join(lines[at:]).strip("\n")
    intro = intro.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("#", "\\#")
    intro = re.sub(r"`([^`]*)`", r"<code>\1</code>", intro)
    return f"/** {intro}\n@verbatim\n{rest}\n@endverbatim */" if rest.strip() else f"/** {intro} */"


print(re.sub(r"/\*\*(?!<)(.*?)\*/", comment, Path(sys.argv[1]).read_text(encoding="utf-8"), flags=re.S))
