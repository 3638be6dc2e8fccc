#!/usr/bin/env python3
"""Turns the examples of examples/python (scripts in cells) into notebooks, runs them, and writes them as pages.

  notebooks.py FOLDER [NAME ...]    FOLDER gets NAME.ipynb, NAME.md and the pictures of each; all examples without a name

Needs nbformat, nbclient and ipykernel (Debian: python3-nbclient, python3-ipykernel) and the module brim on PYTHONPATH."""
import base64
import os
import re
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "python"
SECONDS = 900


def cells(text):
    """[("markdown" or "code", text)] of a script in cells ("# %% [markdown]", "# %%", "# %% a line above the code")."""
    found = []
    for part in re.split(r"^# %%", text, flags=re.M)[1:]:
        head, _, body = part.partition("\n")
        body = body.strip("\n")
        if head.strip() == "[markdown]":
            found.append(("markdown", re.sub(r"^# ?", "", body, flags=re.M)))
            continue
        if head.strip():
            found.append(("markdown", head.strip()))
        found.append(("code", body))
    return found


def notebook(path):
    """A notebook, not run. The first cell has a title."""
    import nbformat

    book = nbformat.v4.new_notebook()
    book.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    for i, (kind, text) in enumerate(cells(path.read_text(encoding="utf-8"))):
        if i == 0 and not text.startswith("# "):
            text = f"# {path.stem.replace('_', ' ').capitalize()}\n{text}"
        make = nbformat.v4.new_markdown_cell if kind == "markdown" else nbformat.v4.new_code_cell
        book.cells.append(make(text))
    nbformat.validate(book)
    return book


def run(book):
    """Runs all cells in an empty folder. @raises nbclient.exceptions.CellExecutionError"""
    import nbclient

    # The module is found from any folder.
    os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"  # of the kernel's debugger, which nobody asked for
    os.environ["PYTHONPATH"] = os.pathsep.join(os.path.abspath(p) for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p)
    with tempfile.TemporaryDirectory() as folder:
        nbclient.NotebookClient(book, timeout=SECONDS, resources={"metadata": {"path": folder}}).execute()


def page(book, name, folder):
    """Writes NAME.md: text, code, what it printed, and its pictures beside it."""
    out, pictures = [], 0
    for cell in book.cells:
        if cell.cell_type == "markdown":
            out.append(cell.source)
            continue
        out.append(f"```ipython3\n{cell.source}\n```")
        for output in cell.outputs:
            if output.output_type == "stream":
                out.append(f"```text\n{output.text.rstrip()}\n```")
            elif "image/png" in output.get("data", {}):
                pictures += 1
                picture = f"{name}_{pictures}.png"
                (folder / picture).write_bytes(base64.b64decode(output.data["image/png"]))
                out.append(f"![Picture {pictures} of {name.replace('_', ' ')}]({picture})")
            elif "text/plain" in output.get("data", {}):
                out.append(f"```text\n{output.data['text/plain'].rstrip()}\n```")
    out.append(f"[The notebook]({name}.ipynb) · [the script](../../examples/python/{name}.py)")
    (folder / f"{name}.md").write_text("\n\n".join(out) + "\n", encoding="utf-8")
    return pictures


def make(folder, names):
    import nbformat

    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(EXAMPLES.glob("*.py")):
        if names and path.stem not in names:
            continue
        book = notebook(path)
        run(book)
        nbformat.write(book, folder / f"{path.stem}.ipynb")
        print(f"{path.stem}: {page(book, path.stem, folder)} pictures", flush=True)


if __name__ == "__main__":
    make(Path(sys.argv[1]), sys.argv[2:])
