#!/usr/bin/env python3
"""What contact between bodies costs: a scene run whole, and each of its bodies alone on the same floor, in one go.

    tools/cost_apart.py scenes/mixed_stack.json --frames 60 [--brim build/release/brim] [--threads N]

Prints the seconds of the steps (files and start-up left out), the share of each phase, and the ratio of the whole to the
sum of the bodies alone (bound: 1.5). A body alone has all obstacles of the scene for company and starts as low as the scene's
lowest body, so that it lies and is pressed by its own weight for most of the run; of copies one is run and counted
as many times. Alone it may take fewer sub-steps than the whole does: a second ratio is per sub-step.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from scene_file import read_scene

CONTACT = ("presence", "refine", "rasterize", "detect", "respond", "solve_contact")


def measure(brim: str, scene: dict, home: pathlib.Path, frames: int, threads: int) -> dict:
    """Summary of a run; its "seconds" are those of each phase, summed over the run."""
    with tempfile.TemporaryDirectory() as folder:
        # Beside the original, so that relative paths of meshes still lead somewhere.
        with tempfile.NamedTemporaryFile("w", suffix=".json", dir=home, delete=True) as file:
            json.dump(scene, file)
            file.flush()
            command = [brim, "run", file.name, "-o", f"{folder}/run", "--frames", str(frames), "--quiet"]
            command += ["--threads", str(threads)] if threads else []
            done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(done.stderr)
        return json.loads(pathlib.Path(folder, "run", "summary.json").read_text())


def step_seconds(summary: dict) -> float:
    seconds = summary["seconds"]
    return sum(v for phase, v in seconds.items() if phase not in ("record", "solve_contact"))


def height(body: dict) -> float:
    """[m] at which the body's own frame starts."""
    return body.get("transform", {}).get("position", [0, 0, 0])[2]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--brim", default="build/release/brim")
    parser.add_argument("--threads", type=int, default=0, help="0: all cores")
    options = parser.parse_args()

    scene = read_scene(options.scene)
    scene.pop("$schema", None)
    scene["expect"] = []
    home = options.scene.resolve().parent
    whole = measure(options.brim, scene, home, options.frames, options.threads)
    total = step_seconds(whole)
    print(f"whole: {total:.2f} s; contact {sum(whole['seconds'][p] for p in CONTACT) / total:.2f} of it")
    for phase, seconds in whole["seconds"].items():
        print(f"  {phase:14s} {seconds:8.2f} s")

    movable = [b for b in scene["bodies"] if b["kind"] != "obstacle"]
    obstacles = [b for b in scene["bodies"] if b["kind"] == "obstacle"]
    lowest = min(height(b) for b in movable)
    alone = per_substep = 0.0
    for body in movable:
        count = 1
        for n in body.get("repeat", {}).get("count", []):
            count *= n
        count *= body.get("repeat", {}).get("around", {}).get("count", 1)
        one = {k: v for k, v in body.items() if k != "repeat"}
        place = dict(one.get("transform", {}))
        place["position"] = [*place.get("position", [0, 0, 0])[:2], lowest]
        one["transform"] = place
        summary = measure(options.brim, {**scene, "bodies": obstacles + [one]}, home, options.frames, options.threads)
        seconds = count * step_seconds(summary)
        alone += seconds
        per_substep += seconds / max(1, summary["substeps"])
        print(f"alone: {count} x {body['name']}: {seconds:.2f} s, {summary['substeps']} sub-steps")
    print(f"ratio of the whole to its bodies alone on the same floor: {total / alone:.2f} (bound 1.5)")
    print(f"the same per sub-step: {total / max(1, whole['substeps']) / per_substep:.2f}")


if __name__ == "__main__":
    main()
