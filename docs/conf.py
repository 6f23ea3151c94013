"""How Sphinx makes a site of the documents; `python docs site` gathers them, and those that are made of the code."""

import re
from typing import Any

import llf_teacher
from llf_teacher.theme import properties, sentence_style

project = "llf-teacher"
author = "the llf-teacher authors"
release = version = llf_teacher.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
root_doc = "index"
exclude_patterns: list[str] = ["changes/*.*.md", "examples"]
html_theme = "furo"
html_theme_options = {
    f"{name}_css_variables": colours
    | {
        "color-background-primary": colours["page"],
        "color-background-secondary": colours["stripe"],
        "color-brand-content": colours["link"],
        "color-brand-primary": colours["link"],
        "color-foreground-muted": colours["muted"],
        "color-foreground-primary": colours["ink"],
        "color-foreground-secondary": colours["muted"],
        "color-sidebar-background": colours["stripe"],
        "font-stack": colours["sans"],
        "font-stack--monospace": colours["mono"],
    }
    for name, colours in (("light", properties(dark=False)), ("dark", properties(dark=True)))
}
"""The colours, sizes, spaces and fonts of reports and pages, and Furo's own names of them."""
html_title = f"llf-teacher {release}"
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["ref.python"]  # a name such as `text` may be that of several
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # signatures show them
napoleon_use_rtype = False
python_use_unqualified_type_names = True


def _before(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Our docstrings are Google's in structure and Markdown in their words: single backticks are code.

    Of an attribute napoleon would take what is before a colon for its type.
    """
    for i, line in enumerate(lines):
        code = _CODE.sub(lambda match: f"``{match[1]}``" + "\\ " * bool(match[2]), line)
        lines[i] = code.replace(":", _COLON) if what in ("attribute", "data", "property") else code


def _after(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """What is indented further stands apart, and stars and bars are no marks."""
    shown: list[str] = []
    depth = 0
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if shown and shown[-1].strip() and line.strip() and indent < depth:
            shown.append("")
        depth = indent if line.strip() else depth
        parts = line.replace(_COLON, ":").split("``")
        parts[::2] = [part if part.lstrip()[:1] == ":" else _MARKS.sub(r"\\\1", part) for part in parts[::2]]
        shown.append("``".join(parts))
    lines[:] = shown


_COLON = "\ue000"
_CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)(?=(\w)?)")
_MARKS = re.compile(r"(?<![\\*])([*|])(?!\*)")


def _style(app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Headings and sentences look as they do in reports."""
    context["metatags"] = f"{context.get('metatags', '')}<style>{_HEADINGS}{sentence_style()}</style>"


_HEADINGS = """h1 { font-size: var(--title) } h2 { font-size: var(--head) } h3 { font-size: var(--large) }
@media (max-width: 40rem) { h1 { font-size: 1.7rem } h2 { font-size: 1.35rem } }"""


def setup(app: Any) -> None:
    """Called by Sphinx: before and after napoleon, which comes at 500."""
    app.connect("html-page-context", _style)
    app.connect("autodoc-process-docstring", _before, priority=400)
    app.connect("autodoc-process-docstring", _after, priority=600)
