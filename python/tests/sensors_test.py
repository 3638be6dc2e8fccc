"""Sensors and events from Python."""

import csv
import tempfile
import unittest
from pathlib import Path

import numpy as np

import brim
from world_test import ball_world


class Sensors(unittest.TestCase):
    def test_a_plate_reads_the_weight_and_the_run_holds_it(self):
        world, ball = ball_world(height=0.2)
        plate = world.sensor("force", world.bodies[1 - ball.number], name="plate", sample="step")
        chart = world.sensor("pressure", "floor", name="map",
                             grid={"origin": (-1, -1, 0), "x": (2, 0, 0), "y": (0, 2, 0), "cells": (10, 10)})
        self.assertIsNone(plate.map)
        with tempfile.TemporaryDirectory() as folder:
            world.run(frames=60, record=folder + "/run").all()
            weight = 9.81 * ball.mass
            self.assertAlmostEqual(plate["force_z"] / -weight, 1, places=2)
            self.assertEqual(plate["force"].shape, (3,))
            self.assertEqual(plate.read()["force_z"], plate["force_z"])
            self.assertEqual(chart.map.shape, (10, 10))
            self.assertAlmostEqual(chart.map.sum() * 0.04 / weight, 1, places=2)
            with self.assertRaises(KeyError):
                plate["colour"]
            run = brim.Run(folder + "/run")
            self.assertEqual([s.name for s in run.sensors], ["plate", "map"])
            recorded = run.sensor("plate")
            self.assertEqual(recorded["force"].shape, (61, 3))
            self.assertEqual(recorded["force_z"][-1], plate["force_z"])
            times, values = recorded.steps
            self.assertEqual(values.shape, (60, len(recorded.units)))
            np.testing.assert_allclose(times, run.times[1:])
            np.testing.assert_array_equal(run.sensor("map").map(-1), chart.map.astype(np.float32))
            with open(Path(folder) / "run/sensors.csv", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(float(rows[-1]["plate.force_z [N]"]), plate["force_z"])

    def test_events_are_told_and_recorded(self):
        world, ball = ball_world(height=0.5)
        touch = world.sensor("contact", ball, gap=0.2)
        heard = []
        touch.on_event(heard.append)
        with tempfile.TemporaryDirectory() as folder:
            world.run(frames=60, record=folder + "/run").all()
            self.assertGreaterEqual(len(heard), 1)
            self.assertTrue(heard[0].began)
            self.assertEqual((heard[0].body, heard[0].other), (ball.name, "floor"))
            # Free fall by 0.3 m.
            self.assertAlmostEqual(heard[0].time, np.sqrt(2 * 0.3 / 9.81), delta=0.03)
            recorded = brim.Run(folder + "/run").events
            self.assertEqual([e.time for e in recorded], [e.time for e in heard])

    def test_what_a_callback_raises_reaches_the_caller(self):
        world, ball = ball_world(height=0.21)

        @world.sensor("contact", ball).on_event
        def angry(event):
            raise LookupError(event.body)

        with self.assertRaises(LookupError):
            world.run(frames=30).all()

    def test_mistakes_are_said_in_the_words_of_scenes(self):
        world, ball = ball_world()
        with self.assertRaisesRegex(brim.InputError, "nobody"):
            world.sensor("force", "nobody")
        with self.assertRaisesRegex(brim.InputError, "colour"):
            world.sensor("force", ball, colour="red")
        self.assertEqual(world.sensors, [])

    def test_a_saved_scene_has_its_sensors(self):
        world, ball = ball_world()
        world.sensor("motion", ball, name="probe")
        with tempfile.TemporaryDirectory() as folder:
            world.save_scene(folder + "/scene.json", frames=3)
            again = brim.load(folder + "/scene.json")
            self.assertEqual([s.name for s in again.sensors], ["probe"])
            again.step()
            self.assertAlmostEqual(again.sensors[0]["velocity_z"], -9.81 / 60, places=6)


if __name__ == "__main__":
    unittest.main()
