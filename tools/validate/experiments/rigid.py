"""Rigid bodies without rolling: slides, impacts, tops, towers."""
import functools
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, ROWS, Case, cases, experiment
from validate.scenes import G, about, ball, box, cylinder, floor, placed, rigid, scene, slope, turned_in_grid


def along_slope(case, run, name="box"):
    """Speed down the slope over time."""
    a = math.radians(case.angle)
    return run.time, run.velocity(name) @ np.array([math.cos(a), 0, -math.sin(a)])


def slide_law(case):
    a = math.radians(case.angle)
    return G * max(0.0, math.sin(a) - case.friction * math.cos(a))


def sliding_box(case, duration=1.5, size=1.0, **world):
    return scene([slope(case.angle, case.get("h", 0.125)),
                  rigid("box", box(size, size, size), placed(case.angle, 0.5 * size), case.get("h", 0.125))],
                 duration, friction=case.friction, response=case.response, **world)


@experiment(law="a = g (sin θ − μ cos θ)", source="Coulomb", unit="m/s²", tolerance=0.05, fast=True,
            cases=cases(response=BOTH, angle=(20, 30), friction=(0.0, 0.2)), theory=slide_law,
            measure=lambda c, r: fits.acceleration(*along_slope(c, r), start=0.5),
            curve=along_slope, ideal=lambda c, t: slide_law(c) * t, axes=("t [s]", "speed [m/s]"))
def incline_slide(case):
    """A box of 1 m, eight voxels wide, slides down a plane."""
    return sliding_box(case)


@experiment(law="a = g (sin θ − μ cos θ), a small difference", source="Coulomb", unit="m/s²", tolerance=0.05, scale=G * 0.05,
            cases=cases(response=BOTH, angle=(20, 25, 30), friction=(0.97,)),
            theory=lambda c: slide_law(critical(c)), measure=lambda c, r: fits.acceleration(*along_slope(c, r), start=1.0))
def incline_critical(case):
    """A box on a plane whose tangent is 3 % above the friction (friction 0.97 of it) slides slowly away."""
    return sliding_box(critical(case), 3.0)


def critical(case):
    return Case(case, friction=case.friction * math.tan(math.radians(case.angle)))


@experiment(law="no motion below the angle of friction", source="Coulomb", unit="m/s", tolerance=1.0, scale=1e-3, fast=True,
            cases=cases(response=BOTH, angle=(20, 25, 30), friction=(0.6,)), theory=0.0,
            measure=lambda c, r: fits.slope_of(r.time[r.at(1):], np.linalg.norm(r.center("box")[r.at(1):] - r.center("box")[0], axis=1)))
def incline_stick(case):
    """A box on a plane rests well inside the cone of friction: its creep, promised below 1 mm/s."""
    return sliding_box(case, 2.0)

@experiment(law="a = g (1 − 2 μ F / m g), and none above 1", source="Coulomb", unit="m/s²", tolerance=0.02, scale=G, fast=True,
            cases=cases(response=BOTH, plate=("joint", "tree"), held=(0.6, 0.8, 1.2)), theory=lambda c: G * max(0.0, 1.0 - c.held),
            measure=lambda c, r: -fits.slope_of(r.time, r.velocity("box")[:, 2]))
def pinched_box(case):
    """A box of 2 kg between a wall and a plate of 0.5 kg, which slides on a prismatic joint or is the link of a tree with one, and is pressed so that friction on both sides holds this
    share of the weight."""
    press = case.held * 2.0 * G / (2 * 0.4)
    plate = {"voxel_size": 0.0125, "transform": {"position": [0.125, 0, 0]}}
    if case.plate == "joint":
        plate |= {"kind": "rigid", "shape": box(0.05, 0.2, 0.2), "mass": 0.5}
    else:
        plate["links"] = [{"name": "link", "joint": {"kind": "prismatic", "axis": [1, 0, 0], "drive": {"stiffness": 0.001, "damping": 0, "target": -1000 * press}},
                           "shape": box(0.05, 0.2, 0.2), "mass": 0.5, "voxel_size": plate.pop("voxel_size")}]
        plate["kind"] = "articulated"
    pressed = scene([{**slope(90, 0.025), "transform": {"position": [-0.1, 0, 0], "rotation": about((0, 1, 0), 90)}},
                     rigid("box", box(0.2, 0.2, 0.2), (0, 0, 0), 0.025, mass=2.0), {"name": "plate", **plate}], 0.2, dt=1 / 240, friction=0.4, response=case.response)
    if case.plate == "joint":
        pressed["forces"] = [{"name": "press", "bodies": ["plate"], "force": [-press, 0, 0]}]
        pressed["joints"] = [{"name": "rail", "body": "plate", "kind": "prismatic", "position": [0.15, 0, 0], "axis": [1, 0, 0]}]
    return pressed


def tower(case):
    """Blocks beside each other, each on a slope of its own: which is the first that falls over?"""
    width, h = 0.25, 0.25 / case.voxels
    bodies = []
    for i, angle in enumerate(ANGLES):
        y = 3.0 * i + case.place * h
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        size = [1.0, 1.0, 0.2]
        turn = about((0, 1, 0), angle)
        shift = np.array([0.37, 0.0, 0.21]) * h * case.place
        bodies.append({"kind": "obstacle", "name": f"plate{i}", "voxel_size": h, "shape": box(*size),
                       "transform": {"position": list(np.array([-0.1 * s, y, -0.1 * c]) + shift), "rotation": turn}})
        place = {"position": list(np.array([width * s, y, width * c]) + shift), "rotation": turn}
        if case.solid == "image":
            bodies.append({"kind": "image_volume", "name": f"box{i}", "shape": box(width, width, 2 * width), "image_spacing": h / 2, "voxel_size": h, "transform": place})
        else:
            bodies.append(rigid(f"box{i}", *SOLIDS[case.solid](width, place), h))
    return scene(bodies, 2.5, friction=2.0, response=case.response)


ANGLES = [a for a in np.arange(20.0, 29.1, 0.5)]


def star_block(width, place, notch):
    """The same block as triangles: a star of four points, turned by 45 degrees, whose notches have this depth in the sides of a square [share of its width]."""
    half, eighth = math.radians(0.5 * place["rotation"]["degrees"]), math.radians(22.5)
    turn = [math.cos(half) * math.cos(eighth), math.sin(half) * math.sin(eighth), math.sin(half) * math.cos(eighth), math.cos(half) * math.sin(eighth)]
    return {"kind": "star", "points": 4, "outer": width / math.sqrt(2), "inner": (0.5 - notch) * width, "thickness": 2 * width}, {**place, "rotation": {"quaternion": turn}}


SOLIDS = {"box": lambda width, place: (box(width, width, 2 * width), place), 
          "mesh": lambda width, place: star_block(width, place, 0.0),
          "sampled": lambda width, place: star_block(width, place, 0.0005)}  # not convex


def first_to_fall(case, run):
    fallen = [a for i, a in enumerate(ANGLES) if run.tilt(f"box{i}").max() > 8.0]
    return min(fallen) - 0.25 if fallen else ANGLES[-1] + 0.25


@experiment(law="tan θ = width / height", source="statics", unit="degrees", tolerance=0.028, study="voxels",
            cases=cases(response=BOTH, solid=tuple(SOLIDS), voxels=(4, 8, 16), place=(0.0, 0.4)), theory=math.degrees(math.atan(0.5)),
            measure=first_to_fall)
def topple(case):
    """A block half as wide as high, a box, triangles that form a convex solid, or triangles that do not and are sampled, so many voxels wide, on slopes from 20 to 29 degrees in steps of a half: the first that
    falls over. Within half a degree, and a quarter for the steps."""
    return tower(case)


@experiment(law="tan θ = width / height", source="statics", unit="degrees", tolerance=0.028, study="voxels",
            cases=cases(response=BOTH, solid=("box", "sampled"), turn=(20, 45), voxels=(4, 8, 16)), theory=math.degrees(math.atan(0.5)),
            misses={f"response penalty, solid {n}": "the row of points at the edge bears the whole block, sinks in by a hundredth of a voxel and lets it lean by half a degree; with four voxels, samples of half a "
                    "voxel round the edge as well; with sixteen it rocks on the edge, and points that differ by hundredths of a voxel decide between 25.25 and 26.25 degrees" for n in ("sampled, turn 45, voxels 4", "sampled, turn 45, voxels 16")},
            measure=first_to_fall)
def topple_turned(case):
    """The same with blocks and slopes turned about the vertical, so that no edge of a base lies along the grid."""
    return turned_in_grid(tower(Case(case, place=0.0)), case.turn)


@experiment(law="tan θ = width / height", source="statics", unit="degrees", tolerance=0.028, study="voxels", cases=cases(response=BOTH, voxels=(8, 16)),
            misses={"": "the ball of two voxels that tells the surface of an image rounds its edges: the base is smaller by as much"}, theory=math.degrees(math.atan(0.5)),
            measure=first_to_fall)
def image_topples(case):
    """The same with the image of a box, its own voxels half as wide as those of contact."""
    return tower(Case(case, solid="image", place=0.4))


@experiment(law="ω' = −(4/3) μ g / R for an even pressure", source="Coulomb, integrated over the disc", unit="rad/s²", tolerance=0.05,
            cases=cases(response=BOTH, friction=(0.3,)), theory=lambda c: 4 / 3 * c.friction * G / 0.5,
            measure=lambda c, r: -fits.acceleration(r.time, r.spin("disc")[:, 2], 0.1, 0.7),
            curve=lambda c, r: (r.time, r.spin("disc")[:, 2]), ideal=lambda c, t: max(0.0, 8 - 4 / 3 * c.friction * G / 0.5 * t),
            axes=("t [s]", "spin [rad/s]"))
def disc_torsion(case):
    """A disc of 1 m spins on its face at 8 rad/s, and friction stops it."""
    h = 1 / 16
    return scene([floor(h), rigid("disc", cylinder(0.5, 0.2), (0, 0, 0.1), h, angular_velocity=[0, 0, 8])], 1.5,
                 friction=case.friction, response=case.response)


SQUARE = 0.3825978  # mean distance from the middle of the unit square


@experiment(law="ω' = −μ m g r̄ / I, r̄ = 0.3826 a", source="Coulomb, integrated over the square", unit="rad/s²", tolerance=0.05,
            cases=cases(response=BOTH, friction=(0.3,)), theory=lambda c: 6 * c.friction * G * SQUARE,
            measure=lambda c, r: -fits.acceleration(r.time, r.spin("box")[:, 2], 0.1, 0.7))
def box_torsion(case):
    """A flat box of 1 m spins on its face at 8 rad/s, and friction stops it."""
    h = 1 / 16
    return scene([floor(h), rigid("box", box(1, 1, 0.2), (0, 0, 0.1), h, angular_velocity=[0, 0, 8])], 1.5,
                 friction=case.friction, response=case.response)


@experiment(law="h' = e² h", source="Newton", unit="m", tolerance=0.03, fast=True, cases=cases(e=(0.3, 0.6, 0.9)),
            theory=lambda c: c.e**2,
            measure=lambda c, r: max(r.lowest("ball")[r.at(0.46):r.at(0.46 + 2 * c.e * 0.4515 - 0.02)]),
            curve=lambda c, r: (r.time, r.lowest("ball")), axes=("t [s]", "height [m]"))
def bounce(case):
    """A ball falls by one metre and returns (rows)."""
    return scene([floor(0.05), rigid("ball", ball(0.2), (0, 0, 1.2), 0.05)], 1.4, dt=1 / 240, restitution=case.e, response=ROWS)


@experiment(law="v_x' = v_x − μ (1 + e) v_z while it slips", source="Coulomb and Newton; e.g. Stronge 2000", unit="m/s", tolerance=0.03,
            cases=cases(e=(0.0, 0.5, 1.0), friction=(0.1, 0.2)), theory=lambda c: 4.0 - c.friction * (1 + c.e) * 2.0, fast=True,
            measure=lambda c, r: r.velocity("ball")[-1, 0])
def oblique_blow(case):
    """A ball without weight hits a wall at 2 m/s, and flies along it at 4 m/s (rows)."""
    return scene([floor(0.05), rigid("ball", ball(0.2), (0, 0, 0.3), 0.05, velocity=[4, 0, -2])], 0.3, dt=1 / 240,
                 friction=case.friction, restitution=case.e, response=ROWS, gravity=[0, 0, 0])


@experiment(law="ω' = (5/2) μ (1 + e) v_z / R while it slips", source="Coulomb and Newton; e.g. Stronge 2000", unit="rad/s", tolerance=0.03,
            cases=cases(e=(0.0, 0.5), friction=(0.1,)), theory=lambda c: 2.5 * c.friction * (1 + c.e) * 2.0 / 0.2, fast=True,
            measure=lambda c, r: r.spin("ball")[-1, 1])
def oblique_spin(case):
    """The spin that the same blow gives."""
    return scene([floor(0.05), rigid("ball", ball(0.2), (0, 0, 0.3), 0.05, velocity=[4, 0, -2])], 0.3, dt=1 / 240,
                 friction=case.friction, restitution=case.e, response=ROWS, gravity=[0, 0, 0])


@experiment(law="the last ball leaves with the first one's speed", source="conservation of momentum and energy", unit="m/s", tolerance=0.02,
            cases=cases(gap=(0.02, 0.0)), theory=2.0, measure=lambda c, r: r.velocity("ball2")[-1, 0])
def cradle(case):
    """A ball hits the first of two at rest with 2 m/s, e = 1, with a gap between these or without (rows)."""
    at = [-0.6, 0.0, 0.4 + case.gap]
    return scene([rigid(f"ball{i}", ball(0.2), (x, 0, 0), 0.05, velocity=[2.0 if i == 0 else 0.0, 0, 0]) for i, x in enumerate(at)],
                 0.4, dt=1 / 480, friction=0.0, restitution=1.0, response=ROWS, gravity=[0, 0, 0])


@experiment(law="the turns about the axis of middle inertia repeat with T = 4 K(m) / rate", source="Landau and Lifshitz, Mechanics, § 37", unit="s",
            tolerance=0.02, cases=cases(dt=(1 / 60, 1 / 240, 1 / 960)), study="dt", theory=lambda c: nut_period(),
            measure=lambda c, r: nut_measured(r),
            curve=lambda c, r: (r.time, body_spin(r, "nut")[:, 0]), axes=("t [s]", "spin about its middle axis [rad/s]"))
def dzhanibekov(case):
    """A free box spins about its axis of middle inertia, a little disturbed, and turns over again and again."""
    return scene([rigid("nut", box(*NUT), (0, 0, 0), 0.05, angular_velocity=NUT_SPIN)], 40.0, dt=case.dt, gravity=[0, 0, 0])


NUT, NUT_SPIN = (0.4, 0.2, 0.6), [5.0, 0.05, 0.05]


def nut_inertia():
    a, b, c = (x * x for x in NUT)
    return np.array([b + c, a + c, a + b]) / 12


@functools.cache
def nut_period():
    """Of the spin, by quadrature of Euler's equations with a fine step (RK4)."""
    inertia = nut_inertia()
    w, dt, t = np.array(NUT_SPIN), 1e-3, 0.0
    def rate(w):
        return np.cross(inertia * w, w) / inertia
    middle = int(np.argsort(inertia)[1])
    times, values = [], []
    for _ in range(40000):
        a = rate(w); b = rate(w + dt / 2 * a); c = rate(w + dt / 2 * b); d = rate(w + dt * c)
        w, t = w + dt / 6 * (a + 2 * b + 2 * c + d), t + dt
        times.append(t), values.append(w[middle])
    return fits.period(np.array(times), np.array(values))


def rotations(run, name):
    """Matrices of a rigid body, from its quaternion (w, x, y, z) in q, (frames, 3, 3)"""
    w, x, y, z = run.q(name)[:, 3:7].T
    return np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
                     np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
                     np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)], 1)


def body_spin(run, name):
    return np.einsum("fji,fj->fi", rotations(run, name), run.spin(name))


def nut_measured(run):
    return fits.period(run.time, body_spin(run, "nut")[:, int(np.argsort(nut_inertia())[1])])


SPIN, WHEEL, ARM = 150.0, 0.2, 0.3  # [rad/s], [m], [m]


def precession():
    """Slow root of steady precession at a right angle: I₃ ω₃ Ω = m g l."""
    return G * ARM / (0.5 * WHEEL**2 * SPIN)


@experiment(law="Ω = g l / (½ R² ω)", source="Goldstein, Classical Mechanics, § 5.7", unit="rad/s", tolerance=0.01, fast=True,
            cases=cases(dt=(1 / 240, 1 / 960)), study="dt", theory=lambda c: precession(),
            measure=lambda c, r: fits.slope_of(r.time, r.q("top")[:, 0]),
            curve=lambda c, r: (r.time, r.q("top")[:, 0]), ideal=lambda c, t: precession() * t, axes=("t [s]", "angle [rad]"))
def gyroscope(case):
    """A wheel spins fast at the end of a stick that may turn up, down and around, and goes around."""
    thin = {"shape": box(0.01, 0.01, 0.01), "mass": 1e-6, "voxel_size": 0.01}
    return scene([{"kind": "articulated", "name": "top", "base": "fixed", "self_collision": False, "links": [
        {"name": "yaw", "joint": {"kind": "revolute", "axis": [0, 0, 1], "start_velocity": precession()}, **thin},
        {"name": "pitch", "parent": "yaw", "joint": {"kind": "revolute", "axis": [0, 1, 0]}, **thin},
        {"name": "wheel", "parent": "pitch", "joint": {"kind": "revolute", "axis": [1, 0, 0], "start_velocity": SPIN},
         "shape": cylinder(WHEEL, 0.02), "mass": 2.0, "voxel_size": 0.02,
         "transform": {"position": [ARM, 0, 0], "rotation": about((0, 1, 0), 90)}}]}], 1.0, dt=case.dt)


@experiment(law="T = 2π √(2 L / 3 g) (1 + a²/16 + 11 a⁴/3072)", source="physical pendulum", unit="s", tolerance=0.01, fast=True,
            cases=cases(dt=(1 / 60, 1 / 120, 1 / 240)), study="dt",
            theory=lambda c: 2 * math.pi * math.sqrt(2 / 3 / G) * (1 + 0.3**2 / 16 + 11 * 0.3**4 / 3072),
            measure=lambda c, r: fits.period(r.time, r.center("rod")[:, 0]),
            curve=lambda c, r: (r.time, r.center("rod")[:, 0]), axes=("t [s]", "x [m]"))
def pendulum(case):
    """A rod of 1 m swings about its end from 0.3 rad."""
    return scene([{"kind": "articulated", "name": "rod", "base": "fixed", "links": [
        {"name": "rod", "joint": {"kind": "revolute", "axis": [0, 1, 0], "start": 0.3}, "shape": box(0.01, 0.01, 1.0),
         "transform": {"position": [0, 0, -0.5]}, "voxel_size": 0.05}]}], 6.0, dt=case.dt)


@experiment(law="F = m g", source="statics", unit="N", tolerance=0.001, fast=True, cases=cases(response=BOTH), theory=3 * 1000 * G,
            measure=lambda c, r: -r.force("plane")[-1, 2])
def weight(case):
    """Three boxes of 1 m stand on each other: what the floor carries."""
    return scene([floor(0.125)] + [rigid(f"box{i}", box(1, 1, 1), (0.02 * i, 0, 0.5 + i), 0.125) for i in range(3)], 2.0,
                 response=case.response)


@experiment(law="the lower of two is not crushed: sum of the weights", source="statics", unit="N", tolerance=0.001, fast=True,
            cases=cases(response=BOTH), theory=1001 * G, measure=lambda c, r: -np.mean(r.force("plane")[-60:, 2]))
def mass_ratio(case):
    """A box of 1000 kg on one of 1 kg."""
    return scene([floor(0.125), rigid("light", box(1, 1, 1), (0, 0, 0.5), 0.125, mass=1),
                  rigid("heavy", box(1, 1, 1), (0, 0, 1.5), 0.125, mass=1000)], 2.0, response=case.response)


@experiment(law="momentum is conserved", source="Newton", unit="kg m/s", tolerance=1e-9, scale=1000.0, fast=True, cases=cases(response=BOTH),
            theory=0.0, measure=lambda c, r: float(np.linalg.norm(sum(r.mass(f"box{i}") * (r.velocity(f"box{i}")[-1] - r.velocity(f"box{i}")[0]) for i in range(2)))))
def collision(case):
    """Two boxes collide obliquely without weight."""
    return scene([rigid("box0", box(1, 1, 1), (-0.8, 0.1, 0), 0.125, velocity=[1, 0, 0], angular_velocity=[0, 0, 1]),
                  rigid("box1", box(1, 1, 1), (0.8, -0.2, 0.1), 0.125, velocity=[-1, 0, 0])], 1.5, gravity=[0, 0, 0],
                 response=case.response)
