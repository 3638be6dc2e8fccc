"""The viewer's page, served by the program `brim`."""

from __future__ import annotations

import os
import shutil
import subprocess
import weakref
from pathlib import Path


class View:
    """A page that shows a run until close(), or until this process ends. A notebook shows it as a frame."""

    def __init__(self, process: subprocess.Popen[str], url: str, height: int) -> None:
        self._process = process
        self.url = url
        self.height = height
        # Runs at the interpreter's end too, where __del__ of what lies in a cycle does not.
        self._end = weakref.finalize(self, _end, process)

    def close(self) -> None:
        self._end()

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" width="100%" height="{self.height}" style="border: 0"></iframe>'

    def __repr__(self) -> str:
        return f"<View {self.url}>"

    def __enter__(self) -> View:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is None:
        process.terminate()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


def program() -> str:
    """The program `brim`: $BRIM_PROGRAM, that of the build or installation this package lies in, or the one on the PATH.
    @raises FileNotFoundError"""
    here = Path(__file__).absolute().parent
    looked = [here / "bin" / "brim", here.parents[1] / "brim"]
    looked += [parent / "bin" / "brim" for parent in here.parents[2:5]]
    if "BRIM_PROGRAM" in os.environ:
        looked.insert(0, Path(os.environ["BRIM_PROGRAM"]))
    for path in looked:
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
    found = shutil.which("brim")
    if found is None:
        raise FileNotFoundError("the program brim is not there; set BRIM_PROGRAM to its path")
    return found


def view(folder: str | os.PathLike[str], *, height: int = 520) -> View:
    """Shows a recorded run, finished or growing. @raises RuntimeError when the page cannot be served"""
    process = subprocess.Popen([program(), "view", os.fspath(folder), "--port", "0"], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stderr is not None
    line = process.stdout.readline()
    if " at http" not in line:
        error = process.stderr.read().strip()
        process.wait()
        process.stdout.close()
        process.stderr.close()
        raise RuntimeError(error or "the viewer did not start")
    process.stderr.close()
    return View(process, line.split(" at ", 1)[1].split()[0], height)
