#!/usr/bin/env python3
"""Runs scenes with contact by penalty, by constraints and as chosen, and prints what each costs and how well it rests.

    tools/compare_responses.py [--brim build/release/brim] [--frames N] [--responses penalty,automatic] scenes/box_stack.json ...

What the scene says of the world's response is replaced; what pairs and bodies say stays. Times are processor time of one
thread, that of building and recording the first frame taken off. "Late" is the last fifth of the run.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile

from scene_file import read_scene


def run(brim, scene, folder, frames=0):
    """@return (processor seconds, summary)"""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = os.path.join(folder, "out")
    done = subprocess.run([brim, "run", scene, "-o", out, "--force", "--quiet", "--check", "--threads", "1",
                           *(["--frames", str(frames)] if frames else [])], capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    summary = os.path.join(out, "summary.json")
    if not os.path.exists(summary):
        sys.exit(done.stderr)
    with open(summary, encoding="utf-8") as f:
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, json.load(f)


def measure(brim, path, response, frames):
    scene = read_scene(path)
    scene.setdefault("world", {})["response"] = response
    step = 1.0 / scene.get("frame_rate", 60)
    frames = frames or round(scene["duration"] / scene["world"].get("time_step", step))
    scene["duration"] = frames * scene["world"].get("time_step", step)
    late = 0.8 * scene["duration"]
    in_time = [e for e in scene.get("expect", []) if max(e.get("from", 0), e.get("to", 0)) <= scene["duration"]]
    scene["expect"] = in_time + [{"metric": "worst_overlap", "from": late, "max": 1e9},
                                 {"metric": "max_speed", "from": late, "max": 1e9}]
    scene.pop("$schema", None)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(os.path.dirname(os.path.abspath(path)), ".compare_%d.json" % os.getpid())
        try:
            with open(file, "w", encoding="utf-8") as f:
                json.dump(scene, f)
            first, _ = run(brim, file, folder, 1)
            all_, summary = run(brim, file, folder)
        finally:
            os.remove(file)
    own, (overlap, speed) = summary["expect"][:-2], summary["expect"][-2:]
    warnings = ", ".join("%s %d" % i for i in summary["warnings"]["codes"].items()) or "none"
    return (1e3 * (all_ - first) / max(1, frames - 1), summary["worst_overlap"]["voxels"],
            overlap["value"], speed["value"],
            "%d of %d" % (sum(e["ok"] for e in own), len(own)), warnings)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--brim", default="build/release/brim")
    parser.add_argument("--frames", type=int, default=0, help="default: what the scene says")
    parser.add_argument("--responses", default="penalty,constraint", help="default: %(default)s; or automatic")
    arguments = parser.parse_args()
    print("| scene | response | ms a step | worst overlap [voxels] | late | fastest late [m/s] | bounds met | warnings |")
    print("|---|---|---|---|---|---|---|---|")
    for path in arguments.scenes:
        for response in arguments.responses.split(","):
            row = measure(arguments.brim, path, response, arguments.frames)
            print("| %s | %s | %.1f | %.3f | %.3f | %.4f | %s | %s |" % (
                (os.path.basename(path)[:-5], response) + row), flush=True)


if __name__ == "__main__":
    main()
