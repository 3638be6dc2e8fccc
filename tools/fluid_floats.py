#!/usr/bin/python3
"""Archimedes by size: what floats in a pool of particles, half as dense as water, cubes and balls of a few spacings.

    tools/fluid_floats.py [--brim build/release/brim] [--out /tmp/fluid_floats] [--seconds 5] [--sizes 2.4 3.6 5.2]

Each body is let go above a pool of 0.7 x 0.7 x 0.4 m, spacing 0.05 m. The share of it under the surface is the mean over
the last fifth of the run, seen from the pose of the body, which may turn, and from the volume of the water;
Archimedes has 0.5. Also the speed that is left. Needs h5py.
"""
import argparse
import json
import os
import subprocess
import sys

import with_numpy

with_numpy.need("numpy", "h5py")
import numpy as np  # noqa: E402

from fluid_measures import Particles, immersed_in_basin  # noqa: E402
from run_file import RunFile  # noqa: E402

SPACING, SIDE, DEPTH = 0.05, 0.7, 0.4


def scene(kind, cells, seconds):
    """A pool between five planes and a body above it."""
    size = SPACING * cells
    shape = {"kind": "box", "size": [size] * 3} if kind == "box" else {"kind": "sphere", "radius": 0.5 * size}
    common = {"material": "water", "voxel_size": 0.5 * SPACING}
    bodies = []
    turns = [None, ([0, 1, 0], 90), ([0, 1, 0], -90), ([1, 0, 0], -90), ([1, 0, 0], 90)]
    half = 0.5 * SIDE
    places = [[half, half, 0], [0, half, half], [SIDE, half, half], [half, 0, half], [half, SIDE, half]]
    for name, place, turn in zip(["floor", "west", "east", "south", "north"], places, turns):
        transform = {"position": place}
        if turn:
            transform["rotation"] = {"axis": turn[0], "degrees": turn[1]}
        bodies.append({"kind": "obstacle", "name": name, "shape": {"kind": "plane", "display_size": 0.01},
                       "transform": transform, **common})
    bodies.append({"kind": "rigid", "name": "body", "density": 500, "shape": shape,
                   "transform": {"position": [half, half, DEPTH + 0.5 * size + 0.03]}, **common})
    bodies.append({"kind": "particle_fluid", "name": "water", "material": "water", "spacing": SPACING, "viscosity": 1.0,
                   "shape": {"kind": "box", "size": [SIDE, SIDE, DEPTH]},
                   "transform": {"position": [half, half, 0.5 * DEPTH]}})
    return {"brim": 1, "name": f"{kind}_{cells}", "duration": seconds, "steps_per_frame": 4,
            "world": {"time_step": 0.005, "voxel_size": 0.5 * SPACING}, "materials": {"water": {"friction": 0}},
            "bodies": bodies}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--brim", default="build/release/brim")
    parser.add_argument("--out", default="/tmp/fluid_floats")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--sizes", type=float, nargs="+", default=[2.4, 3.6, 5.2])
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    for kind in ("box", "sphere"):
        for cells in options.sizes:
            made = scene(kind, cells, options.seconds)
            path = os.path.join(options.out, made["name"])
            with open(path + ".json", "w", encoding="utf-8") as f:
                json.dump(made, f)
            done = subprocess.run([options.brim, "run", path + ".json", "-o", path, "--force", "--quiet"],
                                  stdout=subprocess.DEVNULL, check=False)
            if done.returncode:
                sys.exit(f"{path}.json: brim run failed")
            run = RunFile(os.path.join(path, "run.h5"))
            names = [b.name for b in run.bodies]
            body, water = names.index("body"), names.index("water")
            fluid = Particles(run, water, made["bodies"][-1])
            last = range(run.frames - run.frames // 5, run.frames)
            share = np.mean([immersed_in_basin(run, fluid, body, f, kind, SIDE**2) for f in last])
            first, size = int(run.bodies[water].attrs["v_offset"]), int(run.bodies[water].attrs["v_size"])
            speed = np.sqrt(3 * (run.file["frames/v"][last[0]:last[-1] + 1, first:first + size]**2).mean())
            print(f"{kind} of {cells} spacings: {share:.3f} under water, Archimedes 0.5 ({100 * (share / 0.5 - 1):+.1f} %); "
                  f"speed left {speed:.3f} m/s")


if __name__ == "__main__":
    main()
