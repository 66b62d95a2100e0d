#!/usr/bin/env python3
"""Checks the words of headers, pages and messages: words.py [ROOT].

Phrases that point at a thing in the place of its name are in none of them, nor are old names of things (OLD has the word for
each).  Of the sentences of headers, and of pages, at most LONG in 100 have more than WORDS words.  Answers 0 where that holds;
prints the shares, and how easy it is to read: Flesch's figure (60 to 70 is plain English; 30 is a paper).
"""
import ast
import pathlib
import re
import sys

POINTING = ("that of", "those of", "of its own", "is told", "is none", "as ever", "at a desk")
OLD = {
    "at a desk|the desk": "host tools, on the host", "out of the numbers|beyond the numbers|no number": "overflow; NaN or infinite",
    "words? of q31|q31'?s words?|very words?": "raw value", "very bits|word for word": "bit-identical",
    "known sizes": "compile-time sizes", "settling|calm|held gain": "steady-state detection, frozen gain",
    "sharp(er|ly)?|careful(ly)?|blunt|faint": "low-noise", "misfits?": "range error", "(is|are|was|were) held": "saturated, fixed",
    "unknown starts?": "diffuse start", "fade[sd]?|fading": "forget, decay", "tally": "compensated sum",
    "KQ_EVENT_FLOOR|KQ_EVENT_RESOLUTION": "redundant measurement, precision lost, contradiction",
    "told|asked": "reported, option, method", "doors?": "range check, entry", "24 bits do": "float rounding",
    "beside (long )?double": "compared with double", r"points?\.h": "instant.h, sigma_points.h",
    "mean_low": "low part of the mean",  # kq_mean_low is a name
    "(lean|each|every|[Bb]oth|which|A) ways?(?! is down| to run)|ways? (to|of) (use|using|linearis)": "method, form"}
WORDS, LONG = 30, 3.0
LEFT_OUT = ("CHANGELOG.md",)  # what was


def headers(root):
    for path in sorted((root / "include").rglob("*.h")):
        comments = re.findall(r"/\*\*?(.*?)\*/", path.read_text(encoding="utf-8"), re.S)
        yield path, "\n\n".join(re.sub(r"^ *\* ?", "", one, flags=re.M) for one in comments)


def pages(root):
    for path in sorted(root.rglob("*.md")):
        name = str(path.relative_to(root))
        if not name.startswith((".", "build")) and "/." not in name and name not in LEFT_OUT:
            yield path, re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.S | re.M)


C_TEXT = re.compile(r"[{};]\n|->|#include|^\S*$")  # what the package writes into C files, and names


def messages(root):
    """Texts of the package that are no docstrings, and no C"""
    for path in sorted((root / "tools" / "kalmanq").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        notes = {id(one.body[0].value) for one in ast.walk(tree) if isinstance(one, (ast.Module, ast.ClassDef, ast.FunctionDef))
                 and one.body and isinstance(one.body[0], ast.Expr)}
        yield path, "\n\n".join(one.value for one in ast.walk(tree)
                                if isinstance(one, ast.Constant) and isinstance(one.value, str) and id(one) not in notes
                                and not C_TEXT.search(one.value))


def sentences(text):
    """Of running text: no tables, no code, no lists of parameters or errors"""
    lines = [line for line in text.split("\n") if not line.startswith((" ", "|", "#", "<", "    "))]
    for part in re.split(r"\n\s*\n|(?<=[:;])\s+(?=[A-Z])|(?<![ (]al)(?<![ (]ch)(?<=[.?!])(?:\*\*)?\s+(?=\S)|\n- ", "\n".join(lines)):
        words = re.findall(r"[A-Za-z][\w'-]*", re.sub(r"`[^`]*`|\[([^\]]*)\]\([^)]*\)", r"\1 x", part))
        if len(words) > 2 and part.count("KQ_ERR_") < 3:  # a list of errors is none
            yield " ".join(part.split()), len(words)


def ease(count, words, syllables):
    """Flesch, J. Applied Psychology 32 (1948); a group of vowels is a syllable, but an e at the end"""
    return 206.835 - 1.015 * words / count - 84.6 * syllables / words


def syllables(sentence):
    return sum(max(1, len(re.findall(r"[aeiouy]+", word.lower().removesuffix("e")))) for word in re.findall(r"[A-Za-z]{2,}", sentence))


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    faults = []
    for kind, texts in (("headers", headers), ("pages", pages), ("messages", messages)):
        read = []
        for path, text in texts(root):
            flat = " ".join(re.sub(r"`[^`]*`", "`x`", text).split())
            for phrase, better in {**dict.fromkeys(POINTING, "name the thing"), **OLD}.items():
                faults += [f"{path.relative_to(root)}: {flat[max(0, at.start() - 40):at.end() + 20]!r}: {better}"
                           for at in re.finditer(rf"\b({phrase})\b", flat)]
            read += sentences(text) if kind != "messages" else []
        if read:
            share = 100 * sum(words > WORDS for _, words in read) / len(read)
            spoken = [re.sub(r"`[^`]*`|\[([^\]]*)\]\([^)]*\)", r"\1", text) for text, _ in read]
            easy = ease(len(read), sum(len(re.findall(r"[A-Za-z]{2,}", one)) for one in spoken), sum(map(syllables, spoken)))
            print(f"{kind}: {share:.1f} % of {len(read)} sentences have more than {WORDS} words; reading ease {easy:.0f}")
            if share > LONG:
                faults.append(f"{kind}: {share:.1f} % of the sentences have more than {WORDS} words; at most {LONG:g}")
    print(*faults, f"{len(faults)} faults", sep="\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
