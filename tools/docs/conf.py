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
include_patterns = ["*.md", "include/*.md", "src/*.md", "port/*.md", "port/*/*.md", "tests/*.md", "tests/vectors/*.md", "tools/*.md", "tools/*/*.md", "tools/examples/boards/*.md",
                    "tools/examples/boards/*/*.md",
                    "tools/docs/*.md", "tools/docs/*/*.md", "tools/docs/made/headers/*.md"]
exclude_patterns = ["build", ".deps", "tools/docs/_*"]
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure"]  # links to files of the source, which the test of pages looks at
breathe_projects = {"kalmanq": str(ROOT / "build/docs/doxygen/xml")}
breathe_default_project = "kalmanq"
breathe_domain_by_extension = {"h": "c"}
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "undoc-members": False}
highlight_language = "text"
smartquotes = False  # two hyphens begin an option
html_theme = "furo"
html_title = "kalmanq"
html_theme_options = {"navigation_with_keys": True}


def as_text(app, what, name, obj, options, lines):
    """Docstrings are text in columns, which stays as it is"""
    text = list(lines)
    while text and not text[-1].strip():
        text.pop()
    lines[:] = ["::", "", *(f"    {line}" for line in text), ""] if len(text) > 1 else [f"``{line}``" for line in text]


def parameters_first(app, doctree):
    """Behind the sentence that says what a function does come its parameters, then the rest"""
    for content in doctree.findall(addnodes.desc_content):
        fields = [one for one in content if isinstance(one, nodes.field_list)]
        first = next((k for k, one in enumerate(content) if isinstance(one, nodes.paragraph)), None)
        if fields and first is not None:
            for one in fields:
                content.remove(one)
            content[first + 1:first + 1] = fields


def setup(app):
    app.connect("doctree-read", parameters_first)
    app.connect("autodoc-process-docstring", as_text)
