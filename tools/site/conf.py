"""Sphinx: the documentation as a site (tools/site/build.py stages the pages beside this file)."""
import os
import pathlib

project = "brim"
author = "the brim authors"
version = release = os.environ.get("BRIM_VERSION", "")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
root_doc = "docs/index"
exclude_patterns = ["build"]
html_theme = "furo"
html_title = "brim"
html_static_path = ["_static"] if os.path.isdir(os.path.join(os.path.dirname(__file__), "_static")) else []
html_copy_source = False
# Debian's MathJax, copied into the site: formulas need no network.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
# MyST marks whole pages to be left alone, and what it means as maths with the class "math"; told to MathJax 2 here (MyST knows 3 only).
mathjax2_config = {"tex2jax": {"inlineMath": [["\\(", "\\)"]], "processClass": "math"}, "messageStyle": "none"}
myst_update_mathjax = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
highlight_language = "none"
# Keys of scenes and tables of the C++ reference are no pages; pages of the project link to files that are downloads.
suppress_warnings = ["myst.header", "misc.highlighting_failure"]


def field_of_raises(app, what, name, obj, options, lines):
    """Docstrings end in "@raises Kind when": made a field, in its own paragraph, with the lines that follow it."""
    out, inside = [], False
    for line in lines:
        before, raises, after = line.partition("@raises ")
        inside = inside and bool(line.strip())
        if not raises:
            out.append(f"    {line.strip()}" if inside else line)
            continue
        kind, _, when = after.partition(" ")
        out += [before.rstrip()] if before.strip() else []
        out += ["", f":raises {kind}: {when}".rstrip()]
        inside = True
    lines[:] = out


def join_parts_of_theme(app, error):
    """Debian's furo imports a script as if it were none of a module, which no browser runs, and a style sheet from the root of a
    server that has Debian's: each is put in its place, so that the table of contents follows the page and nothing is missing."""
    static = pathlib.Path(app.outdir) / "_static"
    for file, line, part in (
            ("scripts/furo.js", 'import Gumshoe from "./gumshoe-patched.js";', static / "scripts/gumshoe-patched.js"),
            ("styles/furo.css", "@import url(/javascript/normalize.css/normalize.css);", pathlib.Path("/usr/share/javascript/normalize.css/normalize.css"))):
        into = static / file
        if error is None and into.exists() and part.exists() and line in (text := into.read_text()):
            into.write_text(text.replace(line, part.read_text()))


def setup(app):
    app.connect("autodoc-process-docstring", field_of_raises)
    app.connect("build-finished", join_parts_of_theme)
