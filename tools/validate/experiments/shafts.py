"""What turns in the hollow of another: wheels on shafts, nuts on bolts."""
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, cases, experiment
from validate.scenes import G, about, cylinder, rigid, scene


@experiment(law="the spin stays", source="no moment without friction", unit="rad/s", tolerance=0.05, scale=5.0,
            cases=cases(response=BOTH, clearance=(0.1, 0.4)) + cases(response=("penalty",), clearance=(0.1, 0.4), radius=(6,)), theory=5.0, measure=lambda c, r: r.spin("wheel")[r.at(0.5), 1],
            misses={"response constraint, clearance 0.4": "half of it is lost in the first step, when the wheel settles; the rest as normals at corners of the arc are wrong by up to a "
                    "hundredth"},
            curve=lambda c, r: (r.time, r.spin("wheel")[:, 1]), ideal=lambda c, t: 5.0, axes=("t [s]", "spin [rad/s]"))
def turns_on_a_shaft(case):
    """A gear wheel of triangles hangs on a shaft without friction and spins at 5 rad/s; clearance in voxels, of which the shaft's radius has eight, or as many as said."""
    h = 0.1 / case.get("radius", 8)
    room = case.clearance * h
    return scene([{"kind": "obstacle", "name": "shaft", "voxel_size": h, "shape": cylinder(0.1 - room, 0.6), "transform": {"rotation": about((1, 0, 0), 90)}},
                  rigid("wheel", {"kind": "gear", "teeth": 24, "outer": 0.2, "root": 0.17, "thickness": 0.1, "bore": 0.1},
                        {"position": [0, 0, -room], "rotation": about((1, 0, 0), 90)}, h, density=2000, angular_velocity=[0, 5, 0])],
                 1.0, friction=0.0, response=case.response)


# --- a nut on a bolt ---

PITCH, DEEP = 0.06, 0.015  # [m] of the thread, whose outline is a sine


def threaded(radius, length, sides, rows, outside=None):
    """A bolt, or where there is an outside the nut around it, as text of an OBJ file; and its volume and squared radius of gyration about its axis."""
    places = []
    for k in range(rows + 1):
        z = length * (k / rows - 0.5)
        for j in range(sides):
            turn = 2 * math.pi * j / sides
            r = radius + DEEP * math.cos(2 * math.pi * z / PITCH - turn)
            places.append((r * math.cos(turn), r * math.sin(turn), z))
    faces = []
    for k in range(rows):
        for j in range(sides):
            a, b = k * sides + j, k * sides + (j + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    if outside is None:
        n = len(places)
        places += [(0, 0, -0.5 * length), (0, 0, 0.5 * length)]
        for j in range(sides):
            faces += [(n, (j + 1) % sides, j), (n + 1, rows * sides + j, rows * sides + (j + 1) % sides)]
    else:
        faces = [(a, c, b) for a, b, c in faces]
        n = len(places)
        for z in (-0.5 * length, 0.5 * length):
            for j in range(sides):
                turn = 2 * math.pi * j / sides
                flat = (turn + math.pi / 6) % (math.pi / 3) - math.pi / 6
                r = outside * math.cos(math.pi / 6) / math.cos(flat)
                places.append((r * math.cos(turn), r * math.sin(turn), z))
        for j in range(sides):
            k, top = (j + 1) % sides, rows * sides
            faces += [(n + j, n + k, n + sides + k), (n + j, n + sides + k, n + sides + j), (j, n + k, n + j), (j, k, n + k),
                      (top + j, n + sides + j, n + sides + k), (top + j, n + sides + k, top + k)]
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in places] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
    a, b, c = (np.array(places)[np.array(faces)[:, i]] for i in range(3))
    six = np.einsum("ij,ij->i", a, np.cross(b, c))
    squares = sum(np.sum(six * (a[:, i]**2 + b[:, i]**2 + c[:, i]**2 + a[:, i] * b[:, i] + b[:, i] * c[:, i] + c[:, i] * a[:, i])) / 60 for i in (0, 1))
    return "\n".join(lines) + "\n", squares / (np.sum(six) / 6)


def nut():
    return threaded(0.106, 0.12, 96, 40, outside=0.19)


def down_the_thread():
    """[m/s²]"""
    return -G / (1 + nut()[1] * (2 * math.pi / PITCH)**2)


@experiment(law="a = g / (1 + (2π k / p)²)", source="energy: k radius of gyration, p pitch", unit="m/s²", tolerance=0.1, cases=cases(response=BOTH),
            theory=lambda c: down_the_thread(), measure=lambda c, r: fits.acceleration(r.time, r.velocity("nut")[:, 2], 0.4, 1.5),
            curve=lambda c, r: (r.time, r.velocity("nut")[:, 2]), ideal=lambda c, t: down_the_thread() * t, axes=("t [s]", "speed [m/s]"))
def nut_on_a_bolt(case):
    """A nut spins down a bolt by its weight, without friction: a thread of 60 mm pitch and 30 mm depth in voxels of 6 mm."""
    return scene([{"kind": "obstacle", "name": "bolt", "voxel_size": 0.006, "shape": {"kind": "mesh", "file": "bolt.obj"}},
                  rigid("nut", {"kind": "mesh", "file": "nut.obj"}, (0, 0, 0.12), 0.006, density=2000)], 1.6, friction=0.0, response=case.response,
                 files={"bolt.obj": threaded(0.1, 0.6, 96, 160)[0], "nut.obj": nut()[0]})
