"""Rigid bodies that meet, carry each other or fly: blows of two balls, planks, belts, grooves."""
import math

import numpy as np

from validate import fits
from validate.domino_theory import Row
from validate.experiment import BOTH, ROWS, cases, experiment
from validate.scenes import G, about, ball, box, floor, rigid, scene


@experiment(law="x = v_x t, z = v_z t − g t²/2", source="free flight", unit="m", tolerance=0.01, fast=True,
            cases=cases(dt=(1 / 60, 1 / 240)), theory=lambda c: 5.0 - 0.5 * G, scale=5.0, measure=lambda c, r: r.center("ball")[r.at(1.0), 2])
def throw(case):
    """A ball is thrown upwards at 5 m/s: its height after a second."""
    return scene([rigid("ball", ball(0.1), (0, 0, 0), 0.05, velocity=[3, 0, 5])], 1.0, dt=case.dt)


def two_balls(velocity, place, e, densities=(1000, 1000), dt=1 / 240):
    return scene([rigid("one", ball(0.2), (-0.6, 0, 0), 0.05, velocity=velocity, density=densities[0]),
                  rigid("two", ball(0.2), place, 0.05, density=densities[1])],
                 0.5, dt=dt, friction=0.0, restitution=e, response=ROWS, gravity=[0, 0, 0])


@experiment(law="v₂' = (1 + e) m₁ v₁ / (m₁ + m₂)", source="Newton", unit="m/s", tolerance=0.02, fast=True,
            cases=cases(e=(0.0, 0.5, 1.0), ratio=(1, 4)), theory=lambda c: (1 + c.e) * 2.0 * c.ratio / (c.ratio + 1),
            measure=lambda c, r: r.velocity("two")[-1, 0])
def head_on(case):
    """A ball, so many times as heavy as the other, hits it in the middle at 2 m/s (rows): the speed of the other."""
    return two_balls([2, 0, 0], (0, 0, 0), case.e, (1000 * case.ratio, 1000))


@experiment(law="equal balls part at a right angle", source="conservation of momentum and energy, e = 1", unit="degrees", tolerance=0.03,
            cases=cases(offset=(0.1, 0.2, 0.3)), theory=90.0, measure=lambda c, r: angle_between(r.velocity("one")[-1], r.velocity("two")[-1]))
def billiards(case):
    """A ball hits an equal one at rest beside its middle, by so many metres of the 0.4 m between their centres (rows)."""
    return two_balls([2, 0, 0], (0, case.offset, 0), 1.0)


STRIKER, STARTS = 2.0, (0.1, 0.111, 0.122)


def beside_middle(case):
    """Three such pairs far apart, whose gaps close at other moments of a step."""
    bodies = []
    for i, ahead in enumerate(STARTS):
        x, y = 0.4 * math.sqrt(1 - case.aside**2) + ahead, 2.0 * i
        bodies += [rigid(f"one{i}", ball(0.2), (-x, y, 0), 0.05, velocity=[STRIKER, 0, 0]), rigid(f"two{i}", ball(0.2), (0, y - 0.4 * case.aside, 0), 0.05)]
    return scene(bodies, 0.4, dt=case.dt, friction=0.0, restitution=case.e, response=ROWS, gravity=[0, 0, 0])


def farthest(values, theory):
    return max(values, key=lambda v: abs(v - theory))


def struck(run):
    """[m/s] the balls that were at rest, (starts, 2)"""
    return [run.velocity(f"two{i}")[-1, :2] for i in range(len(STARTS))]


BESIDE = cases(e=(0.0, 0.5, 1.0), aside=(0.0, 0.3, 0.6, 0.9), dt=(1 / 60, 1 / 240))


def struck_angle(case):
    return math.degrees(math.asin(case.aside))


@experiment(law="what is struck leaves along the line of centres of the impact, at asin (b / 2 R)", source="no friction", unit="degrees", tolerance=0.0005, scale=90.0, fast=True,
            cases=BESIDE, theory=struck_angle, measure=lambda c, r: farthest([-math.degrees(math.atan2(v[1], v[0])) for v in struck(r)], struck_angle(c)))
def line_of_centres(case):
    """A ball at 2 m/s hits an equal one beside its middle, by a share `aside` of the sum of their radii, with restitution and without, in steps in which they turn about each other by up to four degrees before they touch, at three moments of the step: the direction of the struck one, where it is farthest off."""
    return beside_middle(case)


def struck_speed(case):
    return 0.5 * (1 + case.e) * STRIKER * math.sqrt(1 - case.aside**2)


@experiment(law="v₂' = (1 + e) v₁ cos α / 2 along it, sin α = b / 2 R", source="Newton", unit="m/s", tolerance=0.001, scale=STRIKER, fast=True,
            cases=BESIDE, theory=struck_speed, measure=lambda c, r: farthest([np.hypot(*v) for v in struck(r)], struck_speed(c)))
def blow_beside_middle(case):
    """The speed of the struck ball in the same blows, where it is farthest off."""
    return beside_middle(case)


def lost_angular_momentum(run):
    """Largest change from the first step on, over what there is, of two equal balls."""
    total = []
    for name in ("one", "two"):
        mass, inertia = run.mass(name), 0.4 * run.mass(name) * 0.2**2
        total.append(mass * np.cross(run.q(name)[:, :3], run.v(name)[:, :3]) + inertia * run.v(name)[:, 3:])
    whole = sum(total)[1:]
    return np.linalg.norm(whole - whole[0], axis=1).max() / np.linalg.norm(whole[0])


@experiment(law="nothing is lost", source="conservation of angular momentum", unit="of what there is", tolerance=1e-6, scale=1.0,
            cases=cases(response=BOTH, e=(0.0,), friction=(0.0, 0.5)) + cases(response=[ROWS], e=(0.5, 1.0), friction=(0.0, 0.5)), theory=0.0, fast=True,
            measure=lambda c, r: lost_angular_momentum(r))
def spinning_blow(case):
    """Two equal balls, one of which spins at 13 rad/s, meet at 2 m/s, a quarter of their diameter beside the middle: angular momentum that is lost."""
    s = two_balls([1, 0, 0], (0.0, 0.1, 0.03), case.e, dt=1 / 60)
    s["bodies"][0].update(angular_velocity=[0, 9, -9])
    s["bodies"][1].update(velocity=[-1, 0, 0])
    s["materials"] = {"default": {"friction": case.friction, "restitution": case.e}}
    s["world"]["response"] = case.response
    return s


def angle_between(a, b):
    return math.degrees(math.acos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)))


@experiment(law="v = (5 v₀ − 2 R ω₀) / 7 once it rolls", source="angular momentum about the contact", unit="m/s", tolerance=0.02, scale=1.0,
            cases=cases(response=BOTH, spin=(10.0, 30.0)), theory=lambda c: (5 * 2.0 - 2 * 0.2 * c.spin) / 7,
            measure=lambda c, r: r.velocity("ball")[r.at(1.4), 0])
def backspin(case):
    """A ball of 0.4 m slides at 2 m/s and spins backwards; spun fast it returns."""
    return scene([floor(0.05), rigid("ball", ball(0.2), (0, 0, 0.2), 0.05, velocity=[2, 0, 0], angular_velocity=[0, -case.spin, 0])],
                 1.5, friction=0.3, response=case.response)


@experiment(law="N = m g / (2 sin α) on each side", source="statics", unit="-", tolerance=0.01, cases=cases(response=BOTH, angle=(30, 45)),
            theory=lambda c: 0.5 / math.cos(math.radians(c.angle)), measure=lambda c, r: groove_load(r))
def groove(case):
    """A ball lies in a groove of two planes without friction, each so steep: the load on one of them, over the weight."""
    sides = [{"kind": "obstacle", "name": name, "voxel_size": 0.025, "shape": {"kind": "plane", "display_size": 1},
              "transform": {"rotation": about((0, 1, 0), sign * case.angle)}} for name, sign in (("left", 1), ("right", -1))]
    return scene(sides + [rigid("ball", ball(0.2), (0, 0, 0.2 / math.cos(math.radians(case.angle))), 0.025)], 1.0, friction=0.0,
                 response=case.response)


def groove_load(run):
    return np.linalg.norm(run.force("left")[-20:].mean(0)) / (G * run.mass("ball"))


@experiment(law="v = μ g t until it moves with the belt", source="Coulomb", unit="m/s", tolerance=0.03, cases=cases(response=BOTH),
            theory=0.2 * G * 0.4, measure=lambda c, r: fits.acceleration(r.time, r.velocity("box")[:, 0], 0.05, 0.45) * 0.4,
            curve=lambda c, r: (r.time, r.velocity("box")[:, 0]), ideal=lambda c, t: min(1.0, 0.2 * G * t), axes=("t [s]", "speed [m/s]"))
def belt(case):
    """A box is put on a belt that moves at 1 m/s, friction 0.2: its speed after 0.4 s."""
    return scene([{"kind": "obstacle", "name": "belt", "voxel_size": 0.05, "shape": box(6, 1, 0.2),
                   "transform": {"position": [0, 0, -0.1]}, "velocity": [1, 0, 0]},
                  rigid("box", box(0.4, 0.4, 0.4), (0, 0, 0.2), 0.05)], 1.0, friction=0.2, response=case.response)


@experiment(law="v = m₁ v₁ / (m₁ + m₂)", source="conservation of momentum", unit="m/s", tolerance=0.02, cases=cases(response=BOTH),
            theory=0.5, measure=lambda c, r: r.velocity("plank")[-1, 0],
            curve=lambda c, r: (r.time, r.velocity("plank")[:, 0]), axes=("t [s]", "speed [m/s]"))
def plank(case):
    """A box slides at 1 m/s onto a plank as heavy as itself, which lies on ice, until both move as one."""
    s = scene([floor(0.05, material="ice"), rigid("plank", box(1.6, 0.4, 0.1), (0, 0, 0.05), 0.05, material="wood"),
               rigid("box", box(0.4, 0.4, 0.4), (-0.5, 0, 0.3), 0.05, material="wood", velocity=[1, 0, 0])], 1.2, response=case.response)
    s["materials"] = {"ice": {"friction": 0.0}, "wood": {"friction": 0.3}}
    return s


FLAT = {"gear": ({"kind": "gear", "teeth": 8, "outer": 0.2, "root": 0.14, "thickness": 0.12, "bore": 0.05}, 0.06),
        "star": ({"kind": "star", "points": 5, "outer": 0.21, "inner": 0.11, "thickness": 0.12}, 0.06),
        "cup": ({"kind": "cup", "radius": 0.15, "height": 0.3, "thickness": 0.05}, 0.0),
        "torus": ({"kind": "torus", "radius": 0.14, "tube": 0.055}, 0.055)}


@experiment(law="what lands flat stays flat", source="symmetry", unit="degrees", tolerance=1.0, scale=1.0,
            cases=cases(response=BOTH, shape=tuple(FLAT)), theory=0.0, measure=lambda c, r: r.tilt("body").max(),
            misses={"response penalty, shape torus": "a ring's line of contact is a node or two wide: what they say varies around it, and so does the blow"})
def lands_flat(case):
    """A sampled solid falls by half a metre, flat, on a floor: how far it is tilted at most, then or later."""
    shape, half = FLAT[case.shape]
    return scene([floor(0.02), rigid("body", shape, {"position": [0.003, 0.007, 0.5 + half], "rotation": about((0, 0, 1), 17)}, 0.02)], 1.0,
                 friction=0.4, response=case.response)


TALL, THICK, ROW, SPIN = 1.0, 0.15, 14, 2.0


@experiment(law="J ω = (J + 1) ω' at each blow, energy between them", source="van Leeuwen 2010, The domino effect, without friction between dominoes",
            unit="m/s", tolerance=0.05, cases=cases(response=BOTH, gap=(0.3, 0.5)), theory=lambda c: wave_speed(c, Row(THICK, c.gap, G).times(ROW, SPIN)),
            measure=lambda c, r: wave_speed(c, [hit_time(r, i) for i in range(ROW)]),
            curve=lambda c, r: ([hit_time(r, i) for i in range(1, ROW)], [i * (c.gap + THICK) for i in range(1, ROW)]), axes=("t [s]", "front [m]"))
def dominoes(case):
    """Dominoes of 1 x 0.5 x 0.15 m topple in a row: the speed of the front from the seventh to the thirteenth."""
    pitch, h = case.gap + THICK, 0.05
    row = [rigid(f"domino{i}", box(THICK, 0.5, TALL), (i * pitch, 0, 0.5 * TALL), h, material="domino") for i in range(ROW)]
    # About its lower front edge.
    row[0].update(angular_velocity=[0, SPIN, 0], velocity=[0.5 * SPIN * TALL, 0, 0.5 * SPIN * THICK])
    s = scene([floor(h, material="table"), *row], 3.0, dt=1 / 240, response=case.response)
    s["materials"] = {"domino": {}, "table": {}}
    s["pairs"] = [{"materials": ["domino", "domino"], "friction": 0.0}, {"materials": ["domino", "table"], "friction": 2.0}]
    return s


def hit_time(run, number, degrees=1.0):
    """[s] when a domino leans by so much."""
    tilt = run.tilt(f"domino{number}")
    f = max(1, int(np.argmax(tilt > degrees)))
    return run.time[f] - (tilt[f] - degrees) / (tilt[f] - tilt[f - 1]) * (run.time[f] - run.time[f - 1])


def wave_speed(case, hits):
    first, last = 6, ROW - 2
    return (last - first) * (case.gap + THICK) / (hits[last] - hits[first])


def over_the_fall(run):
    """Energy of motion over that of the whole fall."""
    motion = run.series("kinetic_energy")
    return motion / (motion[1] + run.series("potential_energy")[1])


STIFF = {"finite_elements": {"lattice_spacing": 0.07}, "image_volume": {"motion": "deformable", "lattice_spacing": 0.07, "image_spacing": 0.02},
         "mass_spring": {"lattice_spacing": 0.07}}


@experiment(law="motion ≤ the fall's energy", source="energy; without restitution", unit="-", tolerance=0.1, fast=True, theory=0.0, scale=1.0,
            cases=cases(kind=("finite_elements",), young=(1e6, 1e8, 1e10, 2e11), shape=("bar", "cube")) + cases(kind=("image_volume", "mass_spring"), young=(1e8, 1e10), shape=("bar",)),
            measure=lambda c, r: max(over_the_fall(r).max() - 1.0, over_the_fall(r)[-1]),
            curve=lambda c, r: (r.time[1:], over_the_fall(r)[1:]), axes=("t [s]", "energy of motion over the fall's"))
def stiff_lands(case):
    """A bar of 0.5 x 0.25 x 0.08 m or a cube of 0.25 m, turned by 20°, falls half a metre on a floor at 60 steps a second: by how much its energy of motion passes that of the fall, or what of it is left after 0.8 s."""
    shape = box(0.5, 0.25, 0.08) if case.shape == "bar" else box(0.25, 0.25, 0.25)
    body = {"kind": case.kind, "name": "body", "shape": shape, "density": 500 if case.young < 1e11 else 7850, "stiffness" if case.kind == "mass_spring" else "young_modulus": case.young, **STIFF[case.kind],
            "transform": {"position": [0, 0, 0.5], "rotation": about((0, 1, 0), 20)}}
    return scene([{"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}, body], 0.8)
