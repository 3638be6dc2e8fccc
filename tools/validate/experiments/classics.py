"""Textbook problems of contact: bodies that leave each other, strike, buckle or precess."""
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, ROWS, cases, experiment
from validate.scenes import G, about, ball, cylinder, floor, rigid, scene

HILL, BALL, AT = 1.0, 0.1, 5.0  # [m], [m], [degrees] where it starts


def leaving(roll):
    """[m/s] Horizontal speed of a ball that has left a fixed ball where gravity no longer holds it there."""
    c = (10 / 17 if roll else 2 / 3) * math.cos(math.radians(AT))
    return math.sqrt(G * (HILL + BALL)) * c**1.5


@experiment(law="leaves where cos θ = 2/3 cos θ₀ (10/17 if it rolls)", source="energy, and no pull at the contact", unit="m/s", tolerance=0.02,
            cases=cases(response=BOTH, friction=(0.0, 2.0)), theory=lambda c: leaving(c.friction > 0),
            measure=lambda c, r: r.velocity("ball")[-1, 0], curve=lambda c, r: (r.time, r.velocity("ball")[:, 0]), axes=("t [s]", "v_x [m/s]"))
def leaves_a_hill(case):
    """A ball of 0.1 m slides or rolls down a fixed ball of 1 m from 5 degrees beside its top: its horizontal speed once it flies."""
    t = math.radians(AT)
    return scene([{"kind": "obstacle", "name": "hill", "voxel_size": 0.05, "shape": ball(HILL)},
                  rigid("ball", ball(BALL), ((HILL + BALL) * math.sin(t), 0, (HILL + BALL) * math.cos(t)), 0.05)],
                 1.9 if case.friction == 0 else 2.2, dt=1 / 240, friction=case.friction, response=case.response, frame=4)


LADDER, THIN, LEAN = 1.0, 0.05, 70.0


def capsule_inertia(length, r):
    """[m²] squared radius of gyration of a capsule about an axis across it."""
    rod, cap = length, 4 * r / 3  # volumes over π r²
    across_rod = length**2 / 12 + r**2 / 4
    half = length / 2 + 3 * r / 8
    across_cap = (2 / 5 - (3 / 8)**2) * r**2 + half**2
    return (rod * across_rod + cap * across_cap) / (rod + cap)


@experiment(law="leaves the wall where sin θ = 2/3 sin θ₀", source="energy; the wall's force ends where the horizontal speed is largest", unit="m/s",
            tolerance=0.02, cases=cases(response=BOTH, h=(0.025, 0.0125)), theory=lambda c: ladder_speed(), study="h",
            misses={"response penalty, h 0.025": "a capsule of two voxels in radius is pushed off the wall by single nodes, whose loads swing by half; it leaves too early"},
            measure=lambda c, r: np.abs(r.velocity("ladder")[:, 0]).max(),
            curve=lambda c, r: (r.time, r.velocity("ladder")[:, 0]), axes=("t [s]", "v_x [m/s]"))
def ladder(case):
    """A capsule of 50 mm in radius leans steeply against a wall and slides down, without friction, in voxels of h: its largest horizontal speed."""
    t = math.radians(LEAN)
    return scene([floor(case.h), {"kind": "obstacle", "name": "wall", "voxel_size": case.h, "shape": {"kind": "plane", "display_size": 1},
                                 "transform": {"rotation": about((0, 1, 0), 90)}},
                  rigid("ladder", {"kind": "capsule", "radius": THIN, "length": LADDER},
                        {"position": [THIN + 0.5 * LADDER * math.cos(t), 0, THIN + 0.5 * LADDER * math.sin(t)],
                         "rotation": about((0, 1, 0), -(90 - LEAN))}, case.h)],
                 0.75, dt=1 / 240, friction=0.0, response=case.response, frame=4)


def ladder_speed():
    s, k = math.sin(math.radians(LEAN)), capsule_inertia(LADDER, THIN) / (LADDER / 2)**2
    return LADDER / 3 * s * math.sqrt(4 * G / (LADDER * (1 + k)) * s / 3)


@experiment(law="v = (3 M − m) / (M + m) v₀", source="two blows of e = 1, one after the other", unit="m/s", tolerance=0.02, cases=cases(ratio=(1.0, 3.0, 10.0), gap=(0.0, 0.002)),
            theory=lambda c: (3 * c.ratio - 1) / (c.ratio + 1) * math.sqrt(2 * G * 0.5), measure=lambda c, r: thrown(r))
def stacked_drop(case):
    """Two balls above each other fall by half a metre, the lower one so many times as heavy (rows, e = 1): the speed of the upper one."""
    return scene([floor(0.04), rigid("lower", ball(0.1), (0, 0, 0.6), 0.04, density=1000 * case.ratio),
                  rigid("upper", ball(0.1), (0, 0, 0.8 + case.gap), 0.04, density=1000)], 0.5, dt=1 / 960, friction=0.0, restitution=1.0, response=ROWS, frame=4)


def thrown(run):
    """[m/s] Speed at the blow of what flies up afterwards, from the energy of its last frame."""
    v, z = run.velocity("upper")[-1, 2], run.center("upper")[-1, 2]
    return math.sqrt(max(0.0, v * abs(v) + 2 * G * (z - 0.3)))


@experiment(law="ω = (1 + e) v x / (k² + x²), x = L/2 cos θ", source="impulse at the end of a rod", unit="rad/s", tolerance=0.02,
            cases=cases(response=(ROWS,), e=(0.0, 0.5, 1.0), angle=(30.0, 60.0)) + cases(response=("penalty",), e=(0.0,), angle=(30.0, 60.0)),
            misses={"response penalty": "penalties have no restitution: the struck end leaves with 0.35 to 0.4 of its speed; with 24 times the damping "
                                        "(damping_steps 48) with 0.19"},
            theory=lambda c: strike(c), measure=lambda c, r: np.abs(r.spin("rod")[:, 1]).max())
def rod_strikes(case):
    """A capsule that is tilted flies at 2 m/s, without weight and friction, with one end against a wall: the spin that it gets."""
    t = math.radians(case.angle)
    return scene([floor(0.025), rigid("rod", {"kind": "capsule", "radius": 0.05, "length": 1.0},
                                      {"position": [0, 0, 0.5 * math.sin(t) + 0.05 + 0.11], "rotation": about((0, 1, 0), 90 - case.angle)}, 0.025, velocity=[0, 0, -2])],
                 0.12, dt=1 / 960, friction=0.0, restitution=case.e, response=case.response, gravity=[0, 0, 0])


def strike(case):
    x, k2 = 0.5 * math.cos(math.radians(case.angle)), capsule_inertia(1.0, 0.05)
    return (1 + case.e) * 2.0 * x / (k2 + x * x)


BEND, LINE = 1.0, 0.5  # [N m²], [kg/m]
LENGTHS = np.linspace(0.9, 1.1, 11)


def greenhill():
    """[m] Length up to which an upright rod that is clamped below carries itself."""
    return (7.8373 * BEND / (LINE * G))**(1 / 3)


@experiment(law="L = (7.8373 E I / λ g)^(1/3)", source="Greenhill 1881", unit="of it", tolerance=0.03, cases=cases(segments=(10, 20)), study="segments",
            theory=1.0, measure=lambda c, r: first_to_buckle(r))
def buckles(case):
    """Eleven upright rods, clamped below, from 0.9 to 1.1 of the length that carries its own weight, pushed aside by a thousandth of it: the first to fall."""
    rods = []
    for i, share in enumerate(LENGTHS):
        length = share * greenhill()
        d = length / (case.segments - 0.5)
        rods.append({"kind": "rod", "name": f"rod {i}", "points": [[0, 0.2 * i, -0.5 * d], [0, 0.2 * i, length]], "segments": case.segments, "radius": 0.01,
                     "stretch_stiffness": 1e5, "bend_stiffness": BEND, "linear_density": LINE, "stiffness_damping": 0.02,
                     "constraints": [{"select": {"kind": "plane", "point": [0, 0, 0.6 * d], "normal": [0, 0, 1]}}]})
    return scene(rods, 20.0, gravity=[1e-3 * G, 0, -G], frame=6)


def first_to_buckle(run):
    """Half way between the longest rod that has not bent by a quarter of its length and the next."""
    bent = [np.abs(run.nodes(f"rod {i}")[0][-1, -1, 0]) > 0.25 * share * greenhill() for i, share in enumerate(LENGTHS)]
    k = int(np.argmax(bent)) if any(bent) else len(LENGTHS) - 1
    return 0.5 * (LENGTHS[max(k, 1) - 1] + LENGTHS[k])


TOP_SPIN, TIP, STICK, DISC, THICK, LEANS = 100.0, 0.02, 0.2, 0.15, 0.02, 20.0


def top_rate():
    """Slow root of I₃ ω Ω − I₁ Ω² cos θ = M g l, I₁ about the centre of mass, which stays above one place as nothing pushes it aside."""
    spin, across, c = 0.5 * DISC**2, 0.25 * DISC**2 + THICK**2 / 12, math.cos(math.radians(LEANS))
    return (spin * TOP_SPIN - math.sqrt((spin * TOP_SPIN)**2 - 4 * across * c * G * STICK)) / (2 * across * c)


@experiment(law="I₃ ω Ω − I₁ Ω² cos θ = M g l", source="Euler's equations, steady precession of a top on ice", unit="rad/s", tolerance=0.02, cases=cases(response=BOTH),
            theory=lambda c: top_rate(), measure=lambda c, r: fits.slope_of(r.time, heading(r)), curve=lambda c, r: (r.time, heading(r)),
            ideal=lambda c, t: top_rate() * t, axes=("t [s]", "heading [rad]"))
def top_on_ice(case):
    """A disc on a ball of 20 mm spins fast, leans by 20 degrees on a floor without friction and goes around: how fast."""
    t = math.radians(LEANS)
    axis, rate = np.array([math.sin(t), 0, math.cos(t)]), top_rate()
    turn = rate * np.array([0, 0, 1]) + (TOP_SPIN - rate * math.cos(t)) * axis
    slide = np.cross(turn, -STICK * axis)  # of the ball, about the centre of mass
    return scene([floor(0.01), {"kind": "articulated", "name": "top", "base": "free", "self_collision": False, "velocity": list(slide), "angular_velocity": list(turn),
                                "transform": {"position": [0, 0, TIP], "rotation": about((0, 1, 0), LEANS)},
                                "links": [{"name": "tip", "shape": ball(TIP), "mass": 1e-4, "voxel_size": 0.01},
                                          {"name": "disc", "parent": "tip", "shape": cylinder(DISC, THICK), "mass": 1.0, "voxel_size": 0.02, "joint": {"kind": "fixed"},
                                           "transform": {"position": [0, 0, STICK]}}]}], 1.0, dt=1 / 960, friction=0.0, response=case.response, frame=8)


def heading(run):
    """[rad] where the top leans to, over time."""
    w, x, y, z = run.q("top")[:, 3:7].T
    return np.unwrap(np.arctan2(2 * (y * z - w * x), 2 * (x * z + w * y)))


LOOSE = {
    "net": {"kind": "mass_spring", "grid": {"size": [0.6, 0.5], "cells": [8, 8]}, "form": "net", "density": 0.1, "thickness": 0.02, "stiffness": 1e4,
            "angular_velocity": [1, 2, 3]},
    "ring": {"kind": "rod", "points": [[0.3 * math.cos(t), 0.3 * math.sin(t), 0] for t in np.linspace(0, 2 * math.pi, 25)[:-1]], "closed": True,
             "segments": 24, "radius": 0.02, "angular_velocity": [1, 2, 3]},
    "bow": {"kind": "rod", "points": [[s, 0, 0.04 * (0.25 - s * s)] for s in np.linspace(-0.5, 0.5, 21)], "segments": 20, "radius": 0.02,
            "angular_velocity": [0.5, 1, 3]},
    "string": {"kind": "rod", "points": [[s, 0, 0.04 * (0.25 - s * s)] for s in np.linspace(-0.5, 0.5, 21)], "segments": 20, "radius": 0.02,
               "bend_stiffness": 0.0, "angular_velocity": [0.5, 1, 3]},
}


def largest_energy(run):
    energy = run.series("kinetic_energy") + run.series("potential_energy")
    return energy.max() / energy[0]


@experiment(law="E ≤ E₀", source="nothing acts on it, and its forces are those of an energy", unit="-", tolerance=1e-6, theory=1.0, fast=True,
            cases=cases(body=tuple(LOOSE), dt=(1 / 60, 1 / 240)), measure=lambda c, r: largest_energy(r),
            curve=lambda c, r: (r.time, r.series("kinetic_energy") + r.series("potential_energy")), axes=("t [s]", "energy [J]"))
def loose_spins(case):
    """A net of springs, a ring, a rod bent by a hundredth and a string spin freely for 4 s: their largest energy over that of the start."""
    return scene([{**LOOSE[case.body], "name": "loose"}], 4.0, dt=case.dt, frame=round(1 / (60 * case.dt)), gravity=[0, 0, 0])
