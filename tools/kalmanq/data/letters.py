"""The letters of a text: UTF-8, UTF-16 and UTF-32 with their marks, Latin-1; what is no text is refused."""

from __future__ import annotations

import codecs
import io
import re
import sys
from contextlib import contextmanager
from typing import Any, Iterator, TextIO

from kalmanq.data.layouts import Source, TableError

HEAD = 4096  # bytes that tell how the text is written
XML = re.compile(rb"(\xef\xbb\xbf)?\s*<(\?xml|!|html|kml|\w+ xmlns)", re.I)


def _latin_1(problem: UnicodeError) -> tuple[str, int]:
    """What is no UTF-8 is Latin-1: numbers are the same in both."""
    assert isinstance(problem, UnicodeDecodeError)
    return problem.object[problem.start : problem.end].decode("latin-1"), problem.end


codecs.register_error("kalmanq_latin_1", _latin_1)


def _encoding(source: Source, head: bytes, known: str) -> tuple[str, str]:
    for mark, name in ((codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
                       (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")):
        if head.startswith(mark):
            return name, "strict"
    if b"\0" in head:
        raise TableError(source, f"is not text, or in UTF-16 without a mark at its beginning: kalmanq reads {known}; save text as UTF-8")
    is_markup = XML.match(head)
    if is_markup or any(byte < 32 and byte not in b"\t\n\v\f\r\x1a\x1b" for byte in head):
        raise TableError(source, f"is {'XML or HTML' if is_markup else 'not text'}: kalmanq reads {known}")
    return "utf-8-sig", "kalmanq_latin_1"


@contextmanager
def opened(source: Source, known: str = "CSV") -> Iterator[TextIO]:
    """Its text, read once from the beginning to the end; known: formats, for a file that is no text"""
    try:
        raw: Any = sys.stdin.buffer if source.is_standard_input else open(source.path, "rb")
    except FileNotFoundError:
        raise TableError(source, "no such file") from None
    except IsADirectoryError:
        raise TableError(source, "is a folder") from None
    try:
        text = io.TextIOWrapper(raw, *_encoding(source, raw.peek(HEAD), known), newline="")
        try:
            yield text
        finally:
            text.detach()
    except UnicodeDecodeError as problem:
        raise TableError(source, f"is not {problem.encoding.upper()} text") from problem
    finally:
        if not source.is_standard_input:
            raw.close()
