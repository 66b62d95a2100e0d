"""The pages: their programs compile, clean, and print what is said; links lead somewhere; names are there.

usage: check_readme.py PAGE... SOURCE LIBRARY WORK
       check_readme.py --onefile PAGE... FOLDER LIBRARY WORK     the programs alone, with FOLDER's kalmanq.h
"""
import functools
import pathlib
import re
import subprocess
import sys


def programs(text: str) -> list[tuple[str, str]]:
    """Each C program with the text block behind it."""
    return re.findall(r"^```c\n(.*?)^```\n+```text\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def run(program: str, include: str, library: str, folder: pathlib.Path) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "example.c").write_text(program, encoding="utf-8")
    subprocess.run(
        ["cc", "-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
         f"-I{include}", str(folder / "example.c"), library, "-lm", "-o",
         str(folder / "example")],
        check=True)
    return subprocess.run([str(folder / "example")], check=True, capture_output=True,
                          text=True).stdout


def dead_links(page: pathlib.Path, text: str) -> list[str]:
    """Those within the source tree that lead to no file, or to no title of it."""
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in link:
            continue
        name, _, title = link.partition("#")
        target = page.parent / name if name else page
        if target.parent.name == "made":  # when the site is built
            target, title = target.parents[1] / "make_pages.py", ""
        if not target.is_file() or (title and title not in titles(target)):
            dead.append(link)
    return dead


def titles(page: pathlib.Path) -> set[str]:
    """As GitHub makes anchors of them."""
    found = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in found}


@functools.lru_cache(maxsize=None)
def library_names(source: pathlib.Path) -> set[str]:
    """With _<T> and without"""
    code = "\n".join(path.read_text(encoding="utf-8") for folder in ("include", "src")
                     for path in sorted((source / folder).rglob("*.[hc]")))
    known = set(re.findall(r"\b(?:kq|KQ)_\w+", code))
    return known | {re.sub(r"_(f32|f64|q31|F32|F64|Q31)$", "", name) for name in known}


@functools.lru_cache(maxsize=None)
def words_of(source: pathlib.Path) -> set[str]:
    """All that stands in the project's own code"""
    words: set[str] = set()
    paths = [source / "CMakeLists.txt"]
    for folder in ("include", "src", "port", "tests", "tools"):
        paths += (source / folder).rglob("*")
    for path in paths:
        if path.suffix in (".h", ".hpp", ".c", ".cpp", ".rs", ".sh", ".py", ".cmake", ".txt"):
            words |= set(re.findall(r"\w+", path.read_text(encoding="utf-8", errors="replace")))
    return words


def unknown_names(text: str, source: pathlib.Path) -> list[str]:
    """Names of the library in the page that no header and no source has."""
    known = library_names(source)
    used = set(re.findall(r"`[^`\n]*?\b((?:kq|KQ)_\w*\w)\b", text))
    files = {path.stem for path in (source / "src").rglob("*.[hc]")}
    files |= {re.sub(r"_(f32|f64|q31)$", "", stem) for stem in files}
    prefixes = {name for name in used if name.startswith("KQ_") and name.endswith("_")}  # KQ_..._<T>
    return sorted(name for name in used - prefixes if name.rstrip("_") not in known | files)


def missing(page: pathlib.Path, text: str, source: pathlib.Path) -> list[str]:
    """Files and functions that the page tells of and that are not there (but for q15 and NAMEs, which
    stand for others).  A file without its folder may be in any of src/."""
    folders = ("src", "src/*", "include", "include/kalmanq", "tests")
    places = [page.parent, source, *(place for folder in folders for place in source.glob(folder))]
    words, faults = words_of(source), []
    for name in sorted(set(re.findall(r"`([^`\n]+)`", text))):
        if re.search(r"q15|_[A-Z]+\.|^x[._]|^walk[._]", name):
            continue
        if re.fullmatch(r"[\w/<>*-]+\.(h|c|cpp|py|sh|cmake)", name):
            pattern = re.sub("<[^>]*>", "*", name)
            if not any(any(place.glob(pattern)) for place in places):
                faults.append(name)
        elif re.fullmatch(r"[a-z]\w*_\w+", name) and name not in words and not name.startswith("kq_"):
            faults.append(name)
    return faults


def stale_copies(text: str, source: pathlib.Path) -> list[str]:
    """Files of src/ that are shown whole and are another text"""
    shown = re.findall(r"All of `(\w+\.c)`:\n\n```c\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [name for name, copy in shown
            if copy != (source / "src" / name).read_text(encoding="utf-8")]


def main(pages: list[str], source: str, library: str, work: str) -> None:
    number, faults = 0, []
    for page in map(pathlib.Path, pages):
        text = page.read_text(encoding="utf-8")
        faults += [f"{page}: {link} leads nowhere" for link in dead_links(page, text)]
        faults += [f"{page}: {name} is another text"
                   for name in stale_copies(text, pathlib.Path(source))]
        faults += [f"{page}: {line}: without -fdata-sections tables of functions keep what is not called" for line in text.splitlines()
                   if "-ffunction-sections" in line and "-fdata-sections" not in line]
        if page.name != "CHANGELOG.md":  # it tells of names that are gone
            faults += [f"{page}: what is {name}?"
                       for name in unknown_names(text, pathlib.Path(source))]
        if page.name not in ("CHANGELOG.md", "coming_from.md"):  # which tells of other libraries
            faults += [f"{page}: {name} is not there"
                       for name in missing(page, text, pathlib.Path(source))]
        for program, expected in programs(text):
            printed = run(program, f"{source}/include", library, pathlib.Path(work) / str(number))
            number += 1
            print(printed, end="")
            if printed != expected:
                faults.append(f"{page}: a program prints something else")
    if number < 2:
        faults.append("there should be a program in float and one in q31, with what they print")
    sys.exit("\n".join(faults) or 0)


def main_onefile(pages: list[str], folder: str, library: str, work: str) -> None:
    """What prepares tables on the host is not in it."""
    tried = [(program, expected) for page in pages for program, expected in programs(pathlib.Path(page).read_text(encoding="utf-8"))
             if "prepare" not in program]
    wrong = [expected for k, (program, expected) in enumerate(tried) if run(program, folder, library, pathlib.Path(work) / str(k)) != expected]
    print(f"{len(tried)} programs with one file")
    sys.exit("\n".join(wrong) or (0 if tried else "no program"))


if __name__ == "__main__":
    if sys.argv[1] == "--onefile":
        main_onefile(sys.argv[2:-3], *sys.argv[-3:])
    main(sys.argv[1:-3], *sys.argv[-3:])
