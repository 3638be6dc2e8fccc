"""Steps leave no memory behind. BRIM_LEAK_STEPS=100000 python3 -m unittest memory_test is the long form."""

import os
import unittest

import numpy as np

import brim
from own_body_test import ExactBlob


def resident():
    """[bytes]"""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Memory(unittest.TestCase):
    def test_memory_stays_over_many_steps(self):
        steps = int(os.environ.get("BRIM_LEAK_STEPS", "4000"))
        world = brim.World(voxel_size=0.1)
        world.add("obstacle", name="floor", shape=brim.plane())
        ball = world.add("rigid", shape=brim.sphere(0.2), transform={"position": (0, 0, 0.2)})
        ball.force(lambda t, x, v: (0.0, 0.0, 0.0))

        def some(n):
            for i in range(n):
                world.step()
                ball.q, ball.v, ball.positions, world.contacts, world.pairs, world.force(ball, world["floor"])
                if i % 50 == 0:
                    world.restore(world.save())

        some(max(500, steps // 10))
        before = resident()
        some(steps)
        grown = resident() - before
        print(f"{grown / steps:.2f} bytes a step over {steps}", flush=True)
        self.assertLess(grown, max(4e6, 20.0 * steps))

    def test_worlds_and_python_bodies_are_given_back(self):
        def one():
            world = brim.World(voxel_size=0.1)
            blob = world.add(ExactBlob(surface=brim.sphere(0.3)))
            world.step()
            return blob.q.sum()

        for _ in range(10):
            one()
        before = resident()
        for _ in range(60):
            one()
        self.assertLess(resident() - before, 6e6)


if __name__ == "__main__":
    unittest.main()
