#!/usr/bin/env python3
"""What levels of detail do to contact: one stack of scenes/levels.json at levels 0 to 3, averaged and sampled.

  tools/levels_table.py [--write]     prints the table; --write puts it into docs/levels.md

Place and normals of the last frame, contact nodes of it, processor time of contact and of all, over the run. Needs h5py and NumPy.
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys

import with_numpy

with_numpy.need("numpy", "h5py")
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
import h5py  # noqa: E402
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/levels.md"
BODIES = ("block", "gear", "image")
CONTACT = ("presence", "refine", "rasterize", "detect", "respond", "solve_contact")


def scene(level, reduce):
    made = json.loads((ROOT / "scenes/levels.json").read_text())
    del made["expect"], made["$schema"]
    made["duration"] = 1.0
    made["world"]["levels"] = {"bodies": {name: level for name in BODIES}, "reduce": reduce}
    for body in made["bodies"]:
        body.pop("repeat", None)
    return made


def measure(brim, folder, level, reduce):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{reduce}_{level}.json"
    path.write_text(json.dumps(scene(level, reduce)))
    run = folder / f"{reduce}_{level}"
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([brim, "run", path, "-o", run, "--force", "--quiet", "--threads", "1"], check=True,
                   stdout=subprocess.DEVNULL)
    spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    summary = json.loads((run / "summary.json").read_text())
    with h5py.File(run / "run.h5") as file:
        last = int(file["frames/count"][0]) - 1
        names = [n.decode().rstrip("\0") for n in file["bodies/name"][:]]
        height = {n: file["motion/center"][last, i, 2] for i, n in enumerate(names)}
        begin, end = file["contacts/offset"][last:last + 2]
        force = file["contacts/force"][begin:end].astype(float)
        size = np.linalg.norm(force, axis=1)
        held = size > 1e-6 * size.max()
        angle = np.degrees(np.arccos(np.clip(np.abs(force[held, 2]) / size[held], 0, 1)))
        normals = float((angle * size[held]).sum() / size[held].sum())
    seconds = summary["seconds"]
    # Solve's own time holds that of its contact.
    total = sum(v for k, v in seconds.items() if k != "solve_contact") + summary["build_seconds"]
    # Shares by the clock of the run, times by the processor: other work shares the machine.
    scale = 1e3 * spent / total / summary["steps"]
    return {"height": height, "normals": normals, "contacts": len(force), "overlap": summary["worst_overlap"]["voxels"],
            "contact": scale * sum(seconds[k] for k in CONTACT), "raster": scale * seconds["rasterize"],
            "total": scale * (total - summary["build_seconds"])}


def table(brim):
    lines = ["| level | reduced by | block, gear, image above level 0 [mm] | normals off vertical | contact nodes | worst overlap [its voxels] | "
             "contact [ms a step] | of it rasterizing | all |", "|---|---|---|---|---|---|---|---|---|"]
    base = None
    for level in range(4):
        for reduce in ("average", "sample") if level else ("average",):
            m = measure(brim, ROOT / "out/levels_table", level, reduce)
            base = base or m
            place = ", ".join(f"{1e3 * (m['height'][b] - base['height'][b]):+.1f}" for b in BODIES)
            lines.append(f"| {level} | {reduce if level else '-'} | {place} | {m['normals']:.2f}° | {m['contacts']} | {m['overlap']:.2f} | "
                         f"{m['contact']:.1f} | {m['raster']:.1f} | {m['total']:.1f} |")
    return "\n".join(lines) + "\n"


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--brim", default=ROOT / "build/release/brim", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args(arguments)
    text = table(options.brim)
    print(text, end="")
    if options.write:
        begin, end = "<!-- tools/levels_table.py -->\n", "<!-- end of levels -->"
        head, rest = PAGE.read_text(encoding="utf-8").split(begin)
        PAGE.write_text(head + begin + text + end + rest.split(end, 1)[1], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
