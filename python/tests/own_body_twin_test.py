"""A body in Python and its twin in C++ move alike."""

import ctypes
import os
import sys
import time
import unittest

import numpy as np

import brim
from own_body_test import Blob


def two_worlds():
    brim.load_plugin(os.path.join(os.environ["BRIM_BUILD"], "python", "tests", "blob_twin.so"))
    worlds = []
    for add in (lambda w: w.add(Blob(surface=brim.sphere(0.3), name="blob")),
                lambda w: w.add("blob_twin", name="blob", transform={"position": (0, 0, 0.35)})):
        world = brim.World(voxel_size=0.05)
        world.add("obstacle", name="floor", shape=brim.plane())
        world.add("rigid", name="box", shape=brim.box((0.2, 0.2, 0.2)), transform={"position": (0.1, 0, 0.8)})
        worlds.append((world, add(world)))
    return worlds


class Twins(unittest.TestCase):
    def test_python_and_cpp_agree_to_1e_12_through_contact(self):
        (world, blob), (twin_world, twin) = two_worlds()
        for step in range(40):
            world.step(), twin_world.step()
            np.testing.assert_allclose(blob.q, twin.q, rtol=0, atol=1e-12, err_msg=f"step {step}")
            np.testing.assert_allclose(world["box"].q, twin_world["box"].q, rtol=0, atol=1e-12)
        self.assertGreater(len(world.contacts), 0)


if __name__ == "__main__":
    unittest.main()
