#!/usr/bin/python3
"""Exports a run in every format and has other programs read it back.

  tools/check_exports.py                 runs a small scene with a body of every display, then checks its exports
  tools/check_exports.py out/drape       checks the exports of this run (its first, middle and last frames)

Each reader compares what it finds with the numbers in run.h5. Readers that are not installed are skipped and named:
VTK (python3-vtk9), meshio (python3-meshio), Blender (blender), vdb_print (libopenvdb-tools), ParaView (pvpython, or the
command in BRIM_PVPYTHON), TinyUSDZ (`npm install tinyusdz` somewhere; BRIM_TINYUSDZ names node_modules/tinyusdz). Ends with 1 when one of them finds something else than was recorded. Needs h5py.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import check_exports_readers as readers

ROOT = pathlib.Path(__file__).resolve().parent.parent

SCENE = ROOT / "tools/every_display.json"


def main(arguments):
    parser = argparse.ArgumentParser(description="Has other programs read brim's exports back.")
    parser.add_argument("run", nargs="?", type=pathlib.Path, help="a run folder; default: of a small scene, made now")
    parser.add_argument("--brim", default=ROOT / "build/release/brim", type=pathlib.Path)
    parser.add_argument("--only", help="formats to check, separated by commas")
    options = parser.parse_args(arguments)
    brim = options.brim.resolve()
    failed = 0
    with tempfile.TemporaryDirectory(prefix="brim_exports_") as temporary:
        work = pathlib.Path(temporary)
        run = options.run
        if run is None:
            run = work / "run"
            subprocess.run([brim, "run", SCENE, "-o", run, "--quiet"], check=True)
        truth = readers.Truth(run)
        for reader in readers.READERS:
            if options.only and reader.format not in options.only.split(","):
                continue
            line = f"{reader.format:5} {reader.program:10}"
            if not reader.available():
                print(f"{line} skipped: not installed")
                continue
            folder = run if reader.format == "run" else work / reader.format
            try:
                if reader.format != "run" and not folder.exists():
                    subprocess.run([brim, "export", run, "--format", reader.format, "-o", folder, "--frames",
                                    truth.frame_range], check=True, stdout=subprocess.DEVNULL)
                print(f"{line} ok: {reader.check(folder, truth, work)}")
            except (AssertionError, subprocess.CalledProcessError) as error:
                failed += 1
                print(f"{line} FAILED: {error}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
