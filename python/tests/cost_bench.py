"""What a step costs from Python beside C++, and a body in Python beside its C++ twin.

    PYTHONPATH=build/release/python BRIM_BUILD=build/release python3 python/tests/cost_bench.py

Processor time of this thread's process over the same steps: `brim run` of scenes/pile.json on one thread against
world.step() on the same scene, taken in turns; and the Blob of own_body_test.py against blob_twin.cpp.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import brim

BUILD = os.environ.get("BRIM_BUILD", "build/release")


def used():
    """[s] of this process."""
    r = resource.getrusage(resource.RUSAGE_SELF)
    return r.ru_utime + r.ru_stime


def step_seconds(make, steps, warm):
    """[s] of processor time a step: all of Python's part included, and that of the step alone."""
    world = make()
    for _ in range(warm):
        world.step()
    inside = 0.0
    start = used()
    for _ in range(steps):
        inside += world.step().wall
    return (used() - start) / steps, inside / steps


def pile(scene, frames):
    """Python's seconds a step over those that the step itself took, and over the program's."""
    def program():
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([os.path.join(BUILD, "brim"), "run", scene, "-o", folder + "/run", "--frames", str(frames),
                            "--threads", "1", "--quiet"], check=True, stdout=subprocess.DEVNULL)
            with open(folder + "/run/summary.json") as file:
                return json.load(file)

    def ours():
        world = brim.load(scene)
        steps = frames * world._core.steps_per_frame
        start = time.perf_counter()
        inside = 0.0
        for _ in range(steps):
            inside += world.step().wall
        return (time.perf_counter() - start) / steps, inside / steps

    program()
    total, inside = ours()
    return total, inside


def main():
    brim.set_threads(1)
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    for name in ("pile", "pile_rest"):
        scene = os.path.join(os.path.dirname(__file__), "../../scenes", name + ".json")
        if not os.path.exists(scene):
            continue
        results = [pile(scene, frames) for _ in range(2)]
        total, inside = min(results)
        print(f"{name}: {1e3 * total:.3f} ms a step from Python, {1e3 * inside:.3f} ms of it in World::step: "
              f"{100 * (total / inside - 1):+.2f} %")
    try:
        from own_body_twin_test import two_worlds
    except ImportError:
        return
    cost = []
    for which in (0, 1):
        best = min(step_seconds(lambda: two_worlds_once(two_worlds, which), 60, 10)[0] for _ in range(3))
        cost.append(best)
    print(f"own body: {1e3 * cost[0]:.3f} ms a step in Python, {1e3 * cost[1]:.3f} ms in C++: {cost[0] / cost[1]:.2f} x")


def two_worlds_once(two_worlds, which):
    return two_worlds()[which][0]


if __name__ == "__main__":
    main()
