#!/usr/bin/env python3
"""What contact costs: a scene run whole, and each of its bodies run apart from all others, in one go.

    tools/cost_apart.py scenes/mixed_stack.json --frames 60 [--brim build/release/brim] [--threads N]

Prints the seconds of the steps (files and start-up left out), the share of each phase, and the ratio of the whole to the
sum of the bodies apart. Bodies apart fall freely: they are never deformed as the pile deforms them, and one sub-step a
frame does for them. A second ratio gives them as many sub-steps as the whole took on average.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

CONTACT = ("presence", "refine", "rasterize", "detect", "respond", "solve_contact")


def read_scene(path: pathlib.Path) -> dict:
    """A scene file is JSON with // comments on lines of their own or after a value."""
    text = re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m.group(1) or "", path.read_text())
    return json.loads(text)


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

    substeps = max(1, round(whole["substeps"] / max(1, whole["steps"])))
    apart = {1: 0.0, substeps: 0.0}
    for body in scene["bodies"]:
        if body["kind"] == "obstacle":
            continue
        count = 1
        if "repeat" in body:
            for n in body["repeat"]["count"]:
                count *= n
        for pieces in apart:
            alone = {**scene, "bodies": [{k: v for k, v in body.items() if k != "repeat"}]}
            alone["world"] = {**scene.get("world", {}), "min_substeps": pieces}
            seconds = step_seconds(measure(options.brim, alone, home, options.frames, options.threads))
            apart[pieces] += count * seconds
            print(f"apart, {pieces} sub-steps: {count} x {body['name']}: {count * seconds:.2f} s")
    for pieces, seconds in apart.items():
        print(f"ratio of the whole to its bodies apart, {pieces} sub-steps a frame: {total / seconds:.2f}")


if __name__ == "__main__":
    main()
