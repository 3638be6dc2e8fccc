"""What Python adds to a step, and a body in Python beside its C++ twin.

    PYTHONPATH=build/release/python:python/tests BRIM_BUILD=build/release /usr/bin/python3 python/tests/cost_bench.py

Processor time on one thread. The cost of a step is that of world.step() from Python over what World::step itself took in it
(StepReport.wall), with nothing looked at, and with q and v of all bodies held as arrays; on scenes/pile.json. The Blob
of own_body_test.py is stepped in turns with blob_twin.cpp, by differences and with its formulas.
"""

import os
import resource
import sys
import time

import brim
from own_body_test import ExactBlob
from own_body_twin_test import two_worlds


def used():
    """[s] of processor time of this process."""
    r = resource.getrusage(resource.RUSAGE_SELF)
    return r.ru_utime + r.ru_stime


def added_by_python(world, steps):
    """(share of the step's own time that Python adds, [s] a step)"""
    inside, start = 0.0, time.perf_counter()
    for _ in range(steps):
        inside += world.step().wall
    total = time.perf_counter() - start
    return total / inside - 1, inside / steps


def main():
    brim.set_threads(1)
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/pile.json")
    for what in ("nothing held", "q and v of all bodies held"):
        world = brim.load(scene)
        held = [] if what.startswith("nothing") else [(body.q, body.v) for body in world]
        added, step = added_by_python(world, steps)
        print(f"pile, {len(world)} bodies, {what}: {1e3 * step:.2f} ms a step, Python adds {100 * added:.2f} %", flush=True)
        del held

    (ours, blob), (twin, _) = two_worlds()
    exact = brim.World(voxel_size=0.05)
    exact.add("obstacle", name="floor", shape=brim.plane())
    exact.add("rigid", name="box", shape=brim.box((0.2, 0.2, 0.2)), transform={"position": (0.1, 0, 0.8)})
    exact.add(ExactBlob(surface=brim.sphere(0.3), name="blob"))
    cost = {"differences": 0.0, "formulas": 0.0, "twin": 0.0}
    for _ in range(steps):
        for name, world in (("differences", ours), ("formulas", exact), ("twin", twin)):
            start = used()
            world.step()
            cost[name] += used() - start
    print(f"own body: C++ {1e3 * cost['twin'] / steps:.2f} ms a step; Python by differences "
          f"{cost['differences'] / cost['twin']:.2f} x, with formulas {cost['formulas'] / cost['twin']:.2f} x")


if __name__ == "__main__":
    main()
