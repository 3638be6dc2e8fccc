"""Balls and cylinders that roll, and discs that spin."""
import functools
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, Case, cases, experiment
from validate.scenes import G, about, ball, box, cylinder, floor, lone_link, on_slope, placed, rigid, scene, slope

from .rigid import along_slope


@experiment(law="a = 5/7 g sin θ", source="rolling without slip", unit="m/s²", tolerance=0.005, study="h",
            cases=cases(response=BOTH, h=(0.125, 0.0625), angle=(15,)), theory=lambda c: 5 / 7 * G * math.sin(math.radians(c.angle)),
            measure=lambda c, r: fits.acceleration(*along_slope(c, r, "ball"), start=0.5))
def sphere_rolls(case):
    """A ball of 1 m rolls down a plane, friction 0.5."""
    return scene([slope(case.angle, case.h), rigid("ball", ball(0.5), placed(case.angle, 0.5), case.h)], 2.0, response=case.response)


@experiment(law="a = 2/3 g sin θ", source="rolling without slip", unit="m/s²", tolerance=0.005, study="h",
            cases=cases(response=BOTH, h=(0.125, 0.0625), angle=(15,)), theory=lambda c: 2 / 3 * G * math.sin(math.radians(c.angle)),
            measure=lambda c, r: fits.acceleration(*along_slope(c, r, "roll"), start=0.5))
def cylinder_rolls(case):
    """A cylinder of 1 m rolls down a plane, friction 0.5."""
    at = {"position": on_slope(case.angle, 0, 0.5), "rotation": about((1, 0, 0), 90)}
    return scene([slope(case.angle, case.h), rigid("roll", cylinder(0.5, 0.5), at, case.h)], 2.0, response=case.response)


@experiment(law="a = 5/7 g sin θ of a ball, 2/3 g sin θ of a cylinder", source="rolling without slip", unit="m/s²", tolerance=0.005, study="h",
            cases=cases(response=BOTH, shape=("ball", "cylinder"), h=(0.125, 0.0625)),
            theory=lambda c: (5 / 7 if c.shape == "ball" else 2 / 3) * G * math.sin(math.radians(15)),
            measure=lambda c, r: fits.acceleration(*along_slope(Case(angle=15), r, "roll"), start=0.5))
def link_rolls(case):
    """A ball or cylinder of 1 m that is the link of an articulated body rolls down a plane of 15°, friction 0.5."""
    shape, turn = (ball(0.5), 0) if case.shape == "ball" else (cylinder(0.5, 0.5), 90)
    at = {"position": on_slope(15, 0, 0.5), "rotation": about((1, 0, 0), turn)}
    return scene([slope(15, case.h), lone_link("roll", shape, at, case.h)], 2.0, response=case.response)


def roller_of_triangles(sides, radius, length):
    """A prism about y as text of an OBJ file."""
    places = [(radius * math.cos(t), y, radius * math.sin(t)) for t in (2 * math.pi * (k + 0.5) / sides for k in range(sides)) for y in (-0.5 * length, 0.5 * length)]
    places += [(0, -0.5 * length, 0), (0, 0.5 * length, 0)]
    faces = []
    for k in range(sides):
        a, b = 2 * k, 2 * ((k + 1) % sides)
        faces += [(a, a + 1, b), (b, a + 1, b + 1), (2 * sides, a, b), (2 * sides + 1, b + 1, a + 1)]
    return "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in places) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)


@experiment(law="a = 2/3 g sin θ", source="rolling without slip, of the cylinder around it", unit="m/s²", tolerance=0.03, fast=True,
            cases=cases(response=BOTH, sides=(128,), dt=(1 / 60, 1 / 240)) + cases(response=BOTH, sides=(64,), dt=(1 / 60,)),
            theory=2 / 3 * G * math.sin(math.radians(10)), measure=lambda c, r: fits.acceleration(*along_slope(Case(angle=10), r, "roll"), start=0.3))
def mesh_rolls(case):
    """A cylinder of triangles, 0.2 m thick and 0.3 m long, rolls down a plane of 10°, friction 0.6; its mesh has so many sides, and its voxels are an eighth of it."""
    name = f"roll_{case.sides}.obj"
    return scene([slope(10, 0.025), rigid("roll", {"kind": "mesh", "file": name}, {"position": on_slope(10, 0, 0.1)}, 0.025)], 1.5, dt=case.dt,
                 friction=0.6, response=case.response, files={name: roller_of_triangles(case.sides, 0.1, 0.3)})


@experiment(law="a = g sin θ / (1 + I/m R²)", source="rolling without slip", unit="m/s²", tolerance=0.03, fast=True, study="h",
            cases=cases(response=BOTH, shape=("ball", "cylinder"), h=(0.025, 0.0125)),
            theory=lambda c: (5 / 7 if c.shape == "ball" else 2 / 3) * G * math.sin(math.radians(10)),
            measure=lambda c, r: fits.acceleration(*along_slope(Case(angle=10), r, "roll"), start=0.3))
def image_rolls(case):
    """The image of a ball or cylinder of 0.2 m, its own voxels half as wide as those of contact, rolls down a plane of 10°, friction 0.6."""
    at = {"position": on_slope(10, 0, 0.1)} | ({"rotation": about((1, 0, 0), 90)} if case.shape == "cylinder" else {})
    image = {"kind": "image_volume", "name": "roll", "shape": ball(0.1) if case.shape == "ball" else cylinder(0.1, 0.3), "image_spacing": case.h / 2,
             "voxel_size": case.h, "transform": at}
    return scene([slope(10, case.h), image], 1.5, friction=0.6, response=case.response)


CHASSIS, WHEEL = 20.0, 2.0  # [kg]


@experiment(law="a = g sin θ (M + 4 m) / (M + 4 m + 2 m)", source="rolling without slip, I = m r²/2", unit="m/s²", tolerance=0.005, study="h", fast=True,
            cases=cases(response=BOTH, h=(0.0375, 0.01875)),
            theory=lambda c: G * math.sin(math.radians(5)) * (CHASSIS + 4 * WHEEL) / (CHASSIS + 6 * WHEEL),
            measure=lambda c, r: fits.acceleration(*along_slope(Case(angle=5), r, "cart"), start=0.5))
def cart_rolls(case):
    """A box of 20 kg on four wheels of 2 kg and 0.3 m, cylinders on hinges, rolls down a plane of 5°, friction 0.8."""
    links = [{"name": "chassis", "shape": box(1.0, 0.4, 0.1), "mass": CHASSIS, "voxel_size": 0.0125}]
    links += [{"name": f"wheel{i}", "parent": "chassis", "joint": {"kind": "revolute", "axis": [0, 1, 0], "position": [x, y, 0]},
               "shape": cylinder(0.15, 0.08), "transform": {"rotation": about((1, 0, 0), 90)}, "mass": WHEEL, "voxel_size": case.h}
              for i, (x, y) in enumerate(((0.4, 0.3), (0.4, -0.3), (-0.4, 0.3), (-0.4, -0.3)))]
    cart = {"kind": "articulated", "name": "cart", "base": "free", "transform": placed(5, 0.15, across=0.007), "links": links}
    return scene([slope(5, case.h), cart], 2.0, friction=0.8, response=case.response)


@experiment(law="a ball rolls without loss", source="rigid rolling", unit="-", tolerance=0.005, cases=cases(response=BOTH, h=(0.125, 0.0625)),
            study="h", theory=1.0, measure=lambda c, r: r.velocity("ball")[-1, 0] / 2.1)
def level_roll(case):
    """A ball of 1 m rolls on a floor at 2.1 m/s: the share of its speed that is left after 2.2 s."""
    return scene([floor(case.h), rigid("ball", ball(0.5), (-3, 0.03, 0.5), case.h, velocity=[2.1, 0, 0], angular_velocity=[0, 4.2, 0])],
                 2.2, response=case.response)


@experiment(law="a cylinder rolls without loss", source="rigid rolling", unit="-", tolerance=0.005, cases=cases(response=BOTH, h=(0.125, 0.0625)),
            study="h", theory=1.0, measure=lambda c, r: r.velocity("roll")[-1, 0] / 2.1)
def level_cylinder(case):
    """A cylinder of 1 m, half as long, rolls on a floor at 2.1 m/s: the share of its speed that is left after 2.2 s."""
    at = {"position": (-3, 0.03, 0.5), "rotation": about((1, 0, 0), 90)}
    return scene([floor(case.h), rigid("roll", cylinder(0.5, 0.5), at, case.h, velocity=[2.1, 0, 0], angular_velocity=[0, 4.2, 0])],
                 2.2, response=case.response)


@experiment(law="a = −b g / (R (1 + I/m R²))", source="Hibbeler, Statics, rolling resistance", unit="m/s²", tolerance=0.005,
            cases=cases(response=BOTH, shape=("ball", "cylinder")), theory=lambda c: -0.02 * G / 0.2 / (1.4 if c.shape == "ball" else 1.5),
            measure=lambda c, r: fits.acceleration(r.time, r.velocity("roll")[:, 0], 0.2, 1.2),
            curve=lambda c, r: (r.time, r.velocity("roll")[:, 0]), axes=("t [s]", "speed [m/s]"))
def rolls_out(case):
    """A ball or cylinder of 0.4 m rolls on a floor at 1 m/s against a rolling resistance b of 0.02 m, and stops."""
    return rolling_against_resistance(case, 0.0, 1.0)


@experiment(law="it does not roll: tan θ < b / R", source="Hibbeler, Statics, rolling resistance", unit="m/s", tolerance=1.0, scale=1e-3, theory=0.0,
            cases=cases(response=BOTH, shape=("ball", "cylinder")), measure=lambda c, r: r.velocity("roll")[-1, 0])
def held_on_a_slope(case):
    """The same on a plane whose slope is four fifths of b / R, let go: its speed after 2 s."""
    return rolling_against_resistance(case, math.atan(0.8 * 0.02 / 0.2), 0.0)


def rolling_against_resistance(case, slope, speed):
    shape, turn = (ball(0.2), 0) if case.shape == "ball" else (cylinder(0.2, 0.2), 90)
    at = {"position": (0, 0.01, 0.2), "rotation": about((1, 0, 0), turn)}
    s = scene([floor(0.05), rigid("roll", shape, at, 0.05, velocity=[speed, 0, 0], angular_velocity=[0, speed / 0.2, 0])], 2.0, response=case.response,
              gravity=[G * math.sin(slope), 0, -G * math.cos(slope)])
    s["materials"]["default"]["rolling_resistance"] = 0.02
    return s


@experiment(law="v = 5/7 v₀ once it rolls", source="angular momentum about the contact", unit="m/s", tolerance=0.005,
            cases=cases(response=BOTH), theory=5 / 7 * 2.0, measure=lambda c, r: r.velocity("ball")[r.at(1.0), 0],
            curve=lambda c, r: (r.time, r.velocity("ball")[:, 0]), ideal=lambda c, t: max(5 / 7 * 2, 2 - 0.3 * G * t), axes=("t [s]", "speed [m/s]"))
def slip_to_roll(case):
    """A ball of 0.4 m slides at 2 m/s without spin, friction 0.3, until it rolls."""
    return scene([floor(0.05), rigid("ball", ball(0.2), (0, 0, 0.2), 0.05, velocity=[2, 0, 0])], 1.2, friction=0.3, response=case.response)


@experiment(law="ω = v / R once it rolls", source="rolling without slip", unit="rad/s", tolerance=0.005,
            cases=cases(response=BOTH), theory=5 / 7 * 2.0 / 0.2, measure=lambda c, r: r.spin("ball")[r.at(1.0), 1])
def slip_to_roll_spin(case):
    """The spin of the same ball."""
    return slip_to_roll(case)


def amplitude(run, name, start, end):
    """Largest |x| within a time that holds half a swing, [m]"""
    return np.abs(run.center(name)[run.at(start):run.at(end), 0]).max()


@experiment(law="the amplitude stays", source="energy", unit="-", tolerance=0.005, cases=cases(response=BOTH), theory=1.0,
            measure=lambda c, r: amplitude(r, "ball", 3.7, 5.0) / amplitude(r, "ball", 0.0, 1.3),
            curve=lambda c, r: (r.time, r.center("ball")[:, 0]), axes=("t [s]", "x [m]"))
def bowl(case):
    """A ball of 0.2 m rolls to and fro in a bowl of 1 m radius: the share of the amplitude after 5 s."""
    a = math.radians(25)
    h = 0.025
    return scene([{"kind": "obstacle", "name": "bowl", "shape": {"kind": "bowl", "radius": 1.1, "thickness": 0.1}, "voxel_size": h,
                   "transform": {"position": [0, 0, 0]}},
                  rigid("ball", ball(0.1), (-0.9 * math.sin(a), 0, -0.9 * math.cos(a)), h)], 5.0, friction=0.8, response=case.response)

DISC, DISC_SPEED, DISC_SPIN, DISC_FRICTION, DISC_TIME = 0.3, 1.0, 6.0, 0.2, 0.6


@functools.cache
def disc_law():
    """Speed and spin after DISC_TIME of a disc under Coulomb friction at an even pressure, by midpoint steps over rings and sectors of equal area."""
    rings, sectors, steps = 60, 120, 600
    r = DISC * np.sqrt((np.arange(rings) + 0.5) / rings)[:, None]
    a = 2 * math.pi * (np.arange(sectors) + 0.5)[None, :] / sectors
    x, y = r * np.cos(a), r * np.sin(a)

    def rates(v, w):
        ux, uy = v - w * y, w * x
        size = np.hypot(ux, uy)
        pull = DISC_FRICTION * G
        return -pull * np.mean(ux / size), -pull * np.mean((x * uy - y * ux) / size) / (0.5 * DISC**2)

    v, w, dt = DISC_SPEED, DISC_SPIN, DISC_TIME / steps
    for _ in range(steps):
        dv, dw = rates(v, w)
        dv, dw = rates(v + 0.5 * dt * dv, w + 0.5 * dt * dw)
        v, w = v + dt * dv, w + dt * dw
    return v, w


def spinning_disc(case):
    return scene([floor(0.01), rigid("disc", cylinder(DISC, 0.02), {"position": [0, 0, 0.01], "rotation": about((0, 0, 1), case.turn)}, 0.01,
                                     velocity=[DISC_SPEED, 0, 0], angular_velocity=[0, 0, DISC_SPIN])],
                 DISC_TIME, dt=1 / 240, friction=DISC_FRICTION, response=case.response)


@experiment(law="m v' = −μ p ∫ u/|u| dA, u = v + ω × r", source="Coulomb at an even pressure, integrated", unit="m/s", tolerance=0.05, scale=DISC_SPEED, fast=True,
            cases=cases(response=BOTH, turn=(0, 17)), theory=lambda c: disc_law()[0], measure=lambda c, r: r.velocity("disc")[-1, 0])
def sliding_disc(case):
    """A flat disc slides at 1 m/s and spins at 6 rad/s: its speed after 0.6 s, of which spin leaves more than sliding alone would."""
    return spinning_disc(case)


@experiment(law="a disc that spins slides straight on", source="symmetry", unit="m", tolerance=0.02, scale=DISC_SPEED, fast=True,
            cases=cases(response=BOTH, turn=(0, 17)), theory=0.0, measure=lambda c, r: r.center("disc")[-1, 1])
def straight_disc(case):
    """The same: how far it goes aside on a way of 0.4 m."""
    return spinning_disc(case)


TABLE, AWAY = 2.0, 0.8  # [rad/s], [m]


def table(h, radius=1.5):
    return {"kind": "obstacle", "name": "table", "voxel_size": h, "shape": cylinder(radius, 0.3), "angular_velocity": [0, 0, TABLE],
            "transform": {"position": [0, 0, -0.15]}}


@experiment(law="r = r₀", source="sticking, μ g > ω² r", unit="m", tolerance=0.01, theory=AWAY, fast=True,
            cases=cases(response=BOTH, body=("box", "soft"), dt=(1 / 60, 1 / 240)),
            measure=lambda c, r: np.hypot(*r.center("body")[-1, :2]),
            misses={"response constraint, body soft": "rows let deformable bodies that stick creep, by 5 to 7 mm/s at 0.3 g, at any step"})
def turntable(case):
    """A box of 0.3 m stands on a table that turns at 2 rad/s: how far it is from the axis after 3 s, 0.8 m at first."""
    about_axis = {"velocity": [0, TABLE * AWAY, 0], "angular_velocity": [0, 0, TABLE]}
    body = rigid("body", box(0.3, 0.3, 0.3), (AWAY, 0, 0.15), 0.04, **about_axis) if case.body == "box" else {
        "kind": "finite_elements", "name": "body", "shape": box(0.3, 0.3, 0.3), "voxel_size": 0.04, "lattice_spacing": 0.08, "young_modulus": 1e5,
        "density": 500, "transform": {"position": [AWAY, 0, 0.15]}, **about_axis}
    return scene([table(0.04), body], 3.0, dt=case.dt, response=case.response, frame=round(1 / (60 * case.dt)))


@experiment(law="r = r₀", source="sticking", unit="m", tolerance=0.001, theory=AWAY, cases=cases(response=BOTH, dt=(1 / 60, 1 / 240)), fast=True,
            measure=lambda c, r: np.hypot(*r.center("load")[-1, :2]))
def carried_round(case):
    """A box of 0.1 m between two fingers of an arm that turns at 2 rad/s: how far it is from the axis after 2 s, 0.8 m at first."""
    def finger(name, y):
        joint = {"kind": "prismatic", "axis": [0, 1, 0], "position": [AWAY, y, 0],
                 "drive": {"stiffness": 2e4, "damping": 100, "target": math.copysign(0.003, -y)}}
        return {"name": name, "parent": "beam", "mass": 0.5, "shape": box(0.3, 0.04, 0.3), "joint": joint}

    turn = {"kind": "revolute", "axis": [0, 0, 1], "start_velocity": TABLE, "drive": {"damping": 1e4, "target_velocity": TABLE}}
    beam = {"name": "beam", "mass": 5, "shape": box(0.1, 0.1, 0.1), "joint": turn}
    arm = {"kind": "articulated", "name": "arm", "base": "fixed", "voxel_size": 0.02, "links": [beam, finger("left", 0.0705), finger("right", -0.0705)]}
    load = rigid("load", box(0.1, 0.1, 0.1), (AWAY, 0, 0), 0.02, velocity=[0, TABLE * AWAY, 0], angular_velocity=[0, 0, TABLE])
    return scene([arm, load], 2.0, dt=case.dt, response=case.response, frame=round(1 / (60 * case.dt)))


@experiment(law="v = v₀, round at 2/7 of the table's rate", source="Weltner 1979, Am. J. Phys. 47", unit="-", tolerance=0.005, theory=1.0,
            cases=cases(response=BOTH, h=(0.05, 0.025)), study="h", measure=lambda c, r: np.linalg.norm(r.velocity("ball")[-1, :2]) / 0.3)
def ball_on_turntable(case):
    """A ball of 0.2 m rolls at 0.3 m/s on a table that turns at 2 rad/s: its speed after 7 s, relative to that of the start."""
    spin = [(0.2 * TABLE - 0.3) / 0.1, 0, 0]  # so that it rolls
    return scene([table(case.h), rigid("ball", ball(0.1), (0.2, 0, 0.1), case.h, velocity=[0, 0.3, 0], angular_velocity=spin)], 7.0,
                 response=case.response)
