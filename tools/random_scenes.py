#!/usr/bin/env python3
"""Random mixed scenes against laws that hold in every scene: random_scenes.py [SEED or FIRST:LAST ...].

    tools/random_scenes.py 1:100                        a hundred scenes, three to six bodies each
    tools/random_scenes.py 1:20 --response constraint   all of them under rows
    tools/random_scenes.py 1:20 --pool particles        the pit holds water, of particles or on a grid (--pool grid)
    tools/random_scenes.py 1:20 --links                 each body hangs on the one before, by a rope or a bar
    tools/random_scenes.py 7 --keep out/random          one scene; its file and its run stay

Bodies of random kinds (those of scenes/pairs/kinds.json, and rigid shapes) fall, turned and thrown at random, into a pit of four walls,
under a random friction, restitution, response and time step. All else is as brim chooses. Held to:

  energy   motion, height and deformation together never gain more than 1 % of what the scene has to lose
  pit      no centre of mass leaves the pit
  solves   no sub-step fails, and no response gives up
  rest     in the last fifth of a second nothing moves faster on average than after a fall of 2 mm (frictionless scenes,
           what rolls, hangs or floats are left out)

Prints a line for each scene, and how many keep each law. Exit code 1 where a run does not end.
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import with_numpy

with_numpy.need("numpy", "h5py")
import h5py
import numpy as np

from scene_file import read_scene

ROOT = pathlib.Path(__file__).resolve().parent.parent
HALF_PIT = 0.45  # [m]
DURATION = 3.0  # [s]
GRAVITY = 9.81  # [m/s²]
SHAPES = {
    "box": {"kind": "box", "size": [0.2, 0.16, 0.12]},
    "capsule": {"kind": "capsule", "radius": 0.06, "length": 0.2},
    "cylinder": {"kind": "cylinder", "radius": 0.08, "length": 0.1},
    "star": {"kind": "star", "points": 5, "outer": 0.16, "inner": 0.1, "thickness": 0.1},
    "torus": {"kind": "torus", "radius": 0.12, "tube": 0.05},
}
ROLLS = {"capsule", "cylinder", "torus", "points", "rod", "rigid", "rigid_image", "articulated", "water"}
LEFT_OUT = {"plane", "mesh", "grid_fluid", "particle_fluid", "user_body"}
LAWS = ("energy", "pit", "solves", "rest")


def kinds():
    """{name: entry of a body}, in a fixed order."""
    table = read_scene(ROOT / "scenes" / "pairs" / "kinds.json")
    found = {k["name"]: k["body"] for k in table["kinds"] if k["name"] not in LEFT_OUT}
    return found | {name: {"kind": "rigid", "density": 800, "shape": shape} for name, shape in SHAPES.items()}


def pit():
    walls = [([-1, 0, 0], [0, 1, 0], 90), ([1, 0, 0], [0, 1, 0], -90), ([0, -1, 0], [1, 0, 0], -90), ([0, 1, 0], [1, 0, 0], 90)]
    planes = [{"name": "floor"}] + [
        {"name": f"wall_{i}", "transform": {"position": [HALF_PIT * x for x in side], "rotation": {"axis": axis, "degrees": degrees}}}
        for i, (side, axis, degrees) in enumerate(walls)]
    return [{"kind": "obstacle", "material": "all", "shape": {"kind": "plane"}} | plane for plane in planes]


def pool(kind, draw):
    """Water that fills the pit to a random height below the bodies."""
    depth = draw.uniform(0.08, 0.2)
    if kind == "grid":
        side = HALF_PIT
        return {"kind": "grid_fluid", "cell_size": 0.03, "voxel_size": 0.02, "box": {"lo": [-side, -side, 0], "hi": [side, side, 0.9]},
                "fill": [{"kind": "box", "lo": [-side, -side, 0], "hi": [side, side, depth]}]}
    return {"kind": "particle_fluid", "spacing": 0.03, "shape": {"kind": "box", "size": [2 * HALF_PIT, 2 * HALF_PIT, depth]},
            "transform": {"position": [0, 0, depth / 2]}}


def links(bodies, draw):
    """Each body tied to the one before it, middle to middle."""
    ties = []
    for a, b in zip(bodies, bodies[1:]):
        ends = [x["transform"]["position"] for x in (a, b)]
        ties.append({"name": f"tie_{b['name']}", "body": b["name"], "to": a["name"], "point": ends[1], "to_point": ends[0],
                     "length": math.dist(*ends), "pulls_only": draw.choice([True, False])})
    return ties


def random_scene(seed, options):
    """The scene of a seed, the same wherever it is made."""
    draw = random.Random(seed)
    entries = kinds()
    bodies = pit()
    for i in range(draw.randint(3, 6)):
        name = draw.choice(sorted(entries))
        where = [draw.uniform(-0.12, 0.12), draw.uniform(-0.12, 0.12), 0.3 + 0.3 * i]
        turn = {"axis": [draw.gauss(0, 1) for _ in range(3)], "degrees": draw.uniform(0, 180)}
        thrown = [draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5), draw.uniform(-2, 0)]
        bodies.append(entries[name] | {"name": f"{name}_{i}", "material": "all", "velocity": thrown,
                                       "transform": {"position": where, "rotation": turn}})
    chosen = draw.choice(["penalty", "constraint", "automatic"])
    step = draw.choice([1 / 60, 1 / 120])
    material = {"friction": draw.choice([0, 0.3, 0.6]), "restitution": draw.choice([0, 0, 0, 0.5])}
    scene = {"brim": 1, "name": f"random_{seed}", "duration": DURATION, "steps_per_frame": round(1 / 60 / step),
             "world": {"time_step": step, "voxel_size": 0.02, "response": options.response or chosen}, "materials": {"all": material},
             "bodies": bodies}
    if options.links:
        scene["attachments"] = links(bodies[5:], draw)
    if options.pool:
        bodies.append(pool(options.pool, draw) | {"name": "water_pool"})
    return scene


def judge(scene, folder):
    """{law: (kept or not, figure)} of a run."""
    with h5py.File(folder / "run.h5") as run:
        series = {key: run["series"][key][1:] for key in run["series"]}
        centres = run["motion"]["center"][:, 5:]
        masses = run["bodies"]["mass"][5:]
    energy = series["kinetic_energy"] + series["potential_energy"]
    gain = float(np.max(energy - np.minimum.accumulate(energy)) / (energy[0] - energy.min()))
    outside = max(float(np.abs(centres[..., :2]).max()) - HALF_PIT, -float(centres[..., 2].min()))
    at_end = float(series["kinetic_energy"][-12:].mean())
    rolls = scene["materials"]["all"]["friction"] == 0 or "attachments" in scene or any(b["name"].rsplit("_", 1)[0] in ROLLS for b in scene["bodies"][5:])
    height = at_end / (GRAVITY * float(masses.sum()))
    failed = int(np.sum(series["ok"] == 0))
    return {"energy": (gain <= 0.01, f"{100 * gain:.1f} %"), "pit": (outside <= 0, f"{1000 * outside:.0f} mm"),
            "solves": (failed == 0, f"{failed}"), "rest": (rolls or height <= 0.002, f"{1000 * height:.2f} mm")}


def run_one(seed, options):
    scene = random_scene(seed, options)
    for change in options.set:
        key, value = change.split("=", 1)
        scene["world"][key] = json.loads(value)
    with tempfile.TemporaryDirectory() as passing:
        home = (options.keep or pathlib.Path(passing)) / f"random_{seed}"
        home.mkdir(parents=True, exist_ok=True)
        file = home / "scene.json"
        file.write_text(json.dumps(scene, indent=1))
        start = time.monotonic()
        command = [options.brim, "run", str(file), "-o", str(home / "run"), "--force", "--quiet", "--threads", "1"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=options.limit)
        except subprocess.TimeoutExpired:
            return scene, None, options.limit, "not done in time"
        seconds = time.monotonic() - start
        if done.returncode != 0:
            return scene, None, seconds, (done.stderr.strip().splitlines() or [f"ended with {done.returncode}"])[-1]
        return scene, judge(scene, home / "run"), seconds, ""


def line(seed, scene, laws, seconds, trouble):
    world, material = scene["world"], scene["materials"]["all"]
    names = " ".join(b["name"].rsplit("_", 1)[0] for b in scene["bodies"][5:])
    about = f"{seed:4} {world['response']:10} 1/{round(1 / world['time_step'])} μ {material['friction']} e {material['restitution']} {seconds:6.1f} s"
    said = trouble or "  ".join(f"{law} {figure}{'' if kept else ' ✗'}" for law, (kept, figure) in laws.items())
    return f"{about}  {said}  [{names}]"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", default=["1:20"], help="seeds, or FIRST:LAST with both included")
    parser.add_argument("--strict", action="store_true", help="exit code 1 also where a law is broken")
    parser.add_argument("--brim", default=str(ROOT / "build" / "release" / "brim"))
    parser.add_argument("--response", choices=["penalty", "constraint", "automatic"], help="instead of a random one")
    parser.add_argument("--pool", choices=["particles", "grid"], help="water in the pit")
    parser.add_argument("--links", action="store_true", help="the bodies are tied to each other")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of the world, as JSON; repeatable")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for scenes and runs; otherwise they are removed")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=math.inf, metavar="SECONDS", help="of a run")
    options = parser.parse_args()
    options.limit = None if math.isinf(options.limit) else options.limit
    seeds = []
    for given in options.seeds:
        first, _, last = given.partition(":")
        seeds += range(int(first), int(last or first) + 1)

    results = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for seed, result in zip(seeds, pool.map(lambda s: run_one(s, options), seeds)):
            print(line(seed, *result), flush=True)
            results.append(result[1])
    ended = [r for r in results if r]
    print(f"{len(ended)} of {len(results)} ended; " +
          ", ".join(f"{law} kept in {sum(r[law][0] for r in ended)}" for law in LAWS))
    kept = all(kept for r in ended for kept, _ in r.values()) or not options.strict
    return 0 if kept and len(ended) == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())
