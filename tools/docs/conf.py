"""The documentation site: the pages of the repository, the headers by Doxygen and Breathe, the package by autodoc."""

import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx import addnodes

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

project = "kalmanq"
release = version = ".".join(re.findall(r"#define KQ_VERSION_\w+ (\d+)", (ROOT / "include/kalmanq/version.h").read_text())[:3])
copyright = "the kalmanq authors"
root_doc = "tools/docs/index"
include_patterns = ["*.md", "include/*.md", "src/*.md", "port/*.md", "port/*/*.md", "port/*/*/*.md", "tests/*.md", "tests/vectors/*.md", "tools/*.md", "tools/*/*.md", "tools/examples/boards/*.md",
                    "tools/examples/boards/*/*.md",
                    "tools/docs/*.md", "tools/docs/*/*.md", "tools/docs/made/*/*.md"]
exclude_patterns = ["build", ".deps", "tools/docs/_*"]
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon", "sphinx_copybutton", "sphinx_design"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure"]  # links to files of the source, which the test of pages looks at
breathe_projects = {"kalmanq": str(ROOT / "build/docs/doxygen/xml")}
breathe_default_project = "kalmanq"
breathe_domain_by_extension = {"h": "c"}
default_role = "code"
napoleon_use_ivar = True  # attributes are objects already
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "undoc-members": False}
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}
autodoc_preserve_defaults = True
autosummary_generate = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 90
toc_object_entries_show_parents = "hide"
highlight_language = "text"
smartquotes = False  # two hyphens begin an option
html_theme = "furo"
html_title = "kalmanq"
html_theme_options = {"navigation_with_keys": True}
html_static_path = html_css_files = ["site.css"]


def as_text(app, what, name, obj, options, lines):
    """A docstring begins with a sentence; text in columns stays as it is, and so do parameters that napoleon has taken"""
    if any(line.startswith((":", "..")) for line in lines):
        return
    text = "\n".join(lines).strip("\n").split("\n")
    end = text.index("") if "" in text else len(text)
    said = " ".join(text[:end]) if not any(line.startswith(" ") or "   " in line for line in text[:end]) else ""
    code = [re.sub(r"([\\*_|])", r"\\\1", part) if k % 2 == 0 else f"\\ ``{part}``\\ " for k, part in enumerate(said.split("`"))]
    rest = text[end:] if said else text
    lines[:] = ["".join(code), "", *(["::", "", *(f"    {line}" for line in rest), ""] if any(rest) else [])]


def attributes_apart(app, what, name, obj, options, lines):
    """napoleon splits `a, b : text` of parameters, but not of attributes"""
    if "Attributes" in lines:
        first = lines.index("Attributes") + 2
        end = next((k for k in range(first, len(lines)) if not lines[k]), len(lines))
        for k in reversed(range(first, end)):
            names, colon, said = lines[k].partition(" : ")
            if re.fullmatch(r"\w+(, \w+)+", names):
                lines[k:k + 1] = [f"{one}{colon}{said}" for one in names.split(", ")]


def aliases_by_name(app, what, name, obj, options, signature, answers):
    return tuple(one and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", one) for one in (signature, answers))


def parameters_first(app, doctree):
    """Behind the sentence that says what a function does come its parameters, then the rest"""
    for content in doctree.findall(addnodes.desc_content):
        fields = [one for one in content if isinstance(one, nodes.field_list)]
        first = next((k for k, one in enumerate(content) if isinstance(one, nodes.paragraph)), None)
        if fields and first is not None:
            for one in fields:
                content.remove(one)
            content[first + 1:first + 1] = fields


def twins_folded(app, doctree):
    """A function whose comment is the one of a function above it is a line of that one"""
    first = {}
    for one in list(doctree.findall(addnodes.desc)):
        lines = [line for line in one if isinstance(line, addnodes.desc_signature) and line["ids"]]
        shared = re.fullmatch(r"(As|See) (kq_\w+)\(\)\.\s*", one[-1].astext())
        above = first.get(f"c.{shared[2]}") if shared else None
        if above:
            for line in lines:
                if shared[1] == "As" or line["ids"][0].endswith("_f64"):
                    line["_toc_name"] = ""
                above.insert(len(above) - 1, line)
            at = one.parent.index(one) - 1
            if isinstance(one.parent[at], addnodes.index):
                entries = one.parent.pop(at)
                above.parent.insert(above.parent.index(above), entries)
            one.parent.remove(one)
        first.update({line["ids"][0]: above or one for line in lines})


def boards_below(app, name, source):
    """The examples stand below their table, whose page has no list of them"""
    if name == "tools/examples/boards/README":
        source[0] += "\n```{toctree}\n:hidden:\n:glob:\n\n*/README\n```\n"


def objects_linked(app, name, source):
    """The table of objects leads to the page of each"""
    if name == "tools/docs/reference/python":
        import kalmanq

        of = {one: f"{{py:obj}}`{one} <kalmanq.{one}>`" for one in kalmanq.__all__}
        source[0] = re.sub(r"^\| (.*?) \|", lambda row: re.sub(r"`(\w+)`", lambda code: of.get(code[1], code[0]), row[0]), source[0], flags=re.M)


def first_page(app, failure):
    """At the root of the site"""
    if not failure and app.builder.format == "html":
        page = f"{root_doc}.html"
        (Path(app.outdir) / "index.html").write_text(
            f'<!doctype html><meta charset="utf-8"><title>kalmanq</title><link rel="canonical" href="{page}">'
            f'<meta http-equiv="refresh" content="0; url={page}"><a href="{page}">kalmanq</a>\n', encoding="utf-8")


def setup(app):
    app.connect("autodoc-process-signature", aliases_by_name)
    app.connect("source-read", boards_below)
    app.connect("source-read", objects_linked)
    app.connect("doctree-read", twins_folded, priority=100)  # before the list of what is on the page
    app.connect("build-finished", first_page)
    app.connect("doctree-read", parameters_first)
    app.connect("autodoc-process-docstring", attributes_apart, priority=100)  # before napoleon
    app.connect("autodoc-process-docstring", as_text)
