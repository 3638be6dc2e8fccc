#!/usr/bin/env python3
"""Builds the documentation as a site: ./dev docs.

  build.py OUT [--no-notebooks] [--no-cpp]

Pages are docs/*.md as they are, with README, CONTRIBUTING, CHANGELOG and third-party notices; the front page's sections become the
contents at the side. Added are the notebooks (examples/python, run), every public name of the Python module (from its docstrings), and the
C++ reference (Doxygen). OUT/index.html is the front page; nothing in the site needs a network.

Needs (Debian): python3-sphinx python3-myst-parser furo doxygen libjs-mathjax python3-nbclient python3-ipykernel, and the module brim on
PYTHONPATH."""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))
import notebooks  # noqa: E402

SIDE_TITLES = {"../README": "Build and run"}  # at the side, where the page's own heading is the project's name
TOP = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "THIRD_PARTY.md"]
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\]\()([^)\s#]+)((?:#[^)]*)?\))")
FENCES = re.compile(r"^```(layers|third-party)$", re.M)  # blocks that tools read; no language
MATHJAX = Path("/usr/share/javascript/mathjax")
MATHJAX_PARTS = ["MathJax.js", "config/TeX-AMS_SVG.js", "config/TeX-AMS_SVG-full.js", "extensions", "jax/input/TeX", "jax/element",
                 "jax/output/SVG"]


def stage_page(path, source):
    """Copies a page, and the files that it leads to; links to folders become words."""
    text = path.read_text(encoding="utf-8")

    def follow(match):
        target = match[2]
        if "://" in target or target.startswith("mailto:"):
            return match[0]
        there = (path.parent / target).resolve()
        if there.is_dir() or ROOT not in there.parents:
            return match[1].lstrip("![").rstrip("(").rstrip("]")
        if there.suffix != ".md" and there.is_file():
            copy = source / there.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(there, copy)
        if there.name == "LICENSE":
            return match[1].lstrip("[").rstrip("(").rstrip("]")
        return match[0]

    fenced = re.split(r"(^```.*?^```[ ]*$)", text, flags=re.M | re.S)
    fenced[::2] = [LINK.sub(follow, part) for part in fenced[::2]]
    copy = source / path.relative_to(ROOT)
    copy.parent.mkdir(parents=True, exist_ok=True)
    copy.write_text(FENCES.sub("```text", "".join(fenced)), encoding="utf-8")


def contents(front, books):
    """Hidden tables of contents, one for each section of the front page, which the theme shows at the side."""
    used, out = set(), []
    for section in re.split(r"^## ", front, flags=re.M)[1:]:
        title, _, body = section.partition("\n")
        pages = []
        for target in re.findall(r"\]\(([^)#\s]+\.md)", body):
            if target not in used and "://" not in target:
                used.add(target)
                page = target.removesuffix(".md")
                pages.append(f"{SIDE_TITLES[page]} <{page}>" if page in SIDE_TITLES else page)
        if pages:
            out.append(f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(pages) + "\n```\n")
    return "\n".join(out)


def python_reference():
    """Every public name of the module, from its docstrings."""
    import brim

    lines = ["# Python reference", "", "The module `brim`; [its tutorial](../python.md).", ""]
    kinds = {"classes": [], "functions": [], "the rest": []}
    for name in brim.__all__:
        value = getattr(brim, name)
        kinds["classes" if isinstance(value, type) else "functions" if callable(value) else "the rest"].append(name)
    for title, names in kinds.items():
        lines += [f"## {title.capitalize()}", ""]
        for name in sorted(names):
            what = "autoclass" if title == "classes" else "autofunction" if title == "functions" else "autodata"
            lines += ["```{eval-rst}", f".. {what}:: brim.{name}"]
            lines += ["   :members:", "   :undoc-members:", "   :show-inheritance:"] if what == "autoclass" else []
            lines += ["```", ""]
    return "\n".join(lines)


def titles(folder, names):
    return [(name, (folder / f"{name}.md").read_text(encoding="utf-8").splitlines()[0].lstrip("# ")) for name in names]


def build(out, with_notebooks=True, with_cpp=True):
    source = out / "source"
    site = out / "html"
    shutil.rmtree(out, ignore_errors=True)
    for page in [ROOT / name for name in TOP] + sorted((ROOT / "docs").rglob("*.md")):
        stage_page(page, source)
    shutil.copyfile(HERE / "conf.py", source / "conf.py")
    books = []
    if with_notebooks:
        notebooks.make(source / "docs/notebooks", [])
        books = sorted(p.stem for p in (source / "docs/notebooks").glob("*.ipynb"))
        for page in books:
            shutil.copyfile(ROOT / "examples/python" / f"{page}.py", copied(source / "examples/python" / f"{page}.py"))
    (source / "docs" / "api").mkdir()
    (source / "docs" / "api" / "python.md").write_text(python_reference(), encoding="utf-8")
    front = (source / "docs/index.md").read_text(encoding="utf-8")
    added = ""
    if books:
        added += "## Notebooks\n\n" + "".join(f"- [{title}](notebooks/{name}.md)\n" for name, title in
                                               titles(source / "docs/notebooks", books)) + "\n"
    added += "## Reference\n\n- [Python: every public name](api/python.md)\n"
    if with_cpp:
        added += "- <a href=\"../api/cpp/annotated.html\">C++: every class</a>, <a href=\"../api/cpp/globals.html\">function</a> and " \
                 "<a href=\"../api/cpp/files.html\">header</a>\n"
    front = front.replace("## Bodies\n", added + "\n## Bodies\n", 1)
    (source / "docs/index.md").write_text(front + "\n" + contents(front, books), encoding="utf-8")
    subprocess.run([sys.executable, "-m", "sphinx", "-q", "-b", "html", "-d", str(out / "trees"), "-w", str(out / "warnings.txt"), str(source),
                    str(site)], check=True)
    for part in MATHJAX_PARTS:
        there = MATHJAX / part
        if there.is_dir():
            shutil.copytree(there, site / "_static/mathjax" / part, symlinks=False)
        elif there.is_file():
            shutil.copyfile(there, copied(site / "_static/mathjax" / part))
    if with_cpp:
        (site / "api").mkdir(exist_ok=True)
        settings = (HERE / "Doxyfile").read_text() + f"\nOUTPUT_DIRECTORY = {site / 'api'}\nHTML_OUTPUT = cpp\n"
        subprocess.run(["doxygen", "-"], input=settings, text=True, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    (site / "index.html").write_text('<!doctype html><meta http-equiv="refresh" content="0; url=docs/index.html"><a href="docs/index.html">brim</a>\n')
    return site


def copied(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def problems(site, out):
    """What a reader would miss: links that lead nowhere, names that the references leave out."""
    import brim

    for page in sorted((site / "docs").rglob("*.html")):
        for target in re.findall(r'(?:href|src)="([^"#?]+)', page.read_text(encoding="utf-8")):
            if "://" not in target and not target.startswith(("mailto:", "data:", "file:")) and not (page.parent / target).exists():
                yield f"{page.relative_to(site)}: {target} is not there"
    for page in sorted((site / "docs").rglob("*.html")):
        if "$$" in page.read_text(encoding="utf-8"):
            yield f"{page.relative_to(site)}: $$ is left where a formula should be"
    text = (site / "docs/api/python.html").read_text(encoding="utf-8")
    for name in brim.__all__:
        if f'id="brim.{name}"' not in text:
            yield f"the Python reference leaves out {name}"
    if (site / "api/cpp").exists():
        files = (site / "api/cpp/files.html").read_text(encoding="utf-8")
        for header in sorted((ROOT / "src/brim").rglob("*.h")):
            if header.name not in files:
                yield f"the C++ reference leaves out {header.relative_to(ROOT)}"
    for line in (out / "warnings.txt").read_text(encoding="utf-8").splitlines():
        if "WARNING" in line or "ERROR" in line:
            yield line


def main():
    out = Path(sys.argv[1]).resolve()
    site = build(out, "--no-notebooks" not in sys.argv, "--no-cpp" not in sys.argv)
    found = list(problems(site, out))
    for problem in found:
        print(f"docs: {problem}")
    if found:
        sys.exit(1)
    print(f"docs: {site / 'index.html'}")


if __name__ == "__main__":
    os.environ.setdefault("BRIM_VERSION", re.search(r"VERSION (\d+\.\d+\.\d+)", (ROOT / "CMakeLists.txt").read_text())[1])
    main()
