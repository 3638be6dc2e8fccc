"""Sheets and lines."""
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, cases, experiment
from validate.scenes import G, about, box, floor, scene


@experiment(law="s = 8 f²/3 l of a shallow chain; y = a cosh(x/a)", source="catenary", unit="m", tolerance=0.01, study="segments", fast=True,
            cases=cases(segments=(10, 20, 40)), theory=lambda c: catenary(1.6, 2.0),
            measure=lambda c, r: -r.positions("chain", r.frames - 1)[:, 2].min())
def rope_hangs(case):
    """A rope of 2 m hangs between two points 1.6 m apart: its sag."""
    n = case.segments
    # Laid out as a V whose length is that of the rope.
    return scene([{"kind": "rod", "name": "chain", "points": [[-0.8, 0, 0], [0, 0, -0.6], [0.8, 0, 0]], "segments": n, "radius": 0.02,
                   "stretch_stiffness": 1e5, "bend_stiffness": 0, "rests_straight": True, "linear_density": 0.1, "mass_damping": 2.0,
                   "constraints": [{"select": {"kind": "sphere", "center": [x, 0, 0], "radius": 0.01}} for x in (-0.8, 0.8)]}], 6.0)


def catenary(span, length):
    """Sag of a chain. span = 2 a sinh^-1(length / 2a), by bisection."""
    lo, hi = 1e-2, 1e3
    for _ in range(200):
        a = 0.5 * (lo + hi)
        lo, hi = (a, hi) if 2 * a * math.sinh(span / (2 * a)) > length else (lo, a)
    return a * (math.cosh(span / (2 * a)) - 1)


@experiment(law="w = q L⁴ / (8 E I)", source="Euler and Bernoulli", unit="m", tolerance=0.01, fast=True, study="segments",
            cases=cases(segments=(10, 20)), theory=lambda c: 0.1 * G / (8 * 10.0),
            measure=lambda c, r: -r.positions("rod", r.frames - 1)[-1, 2])
def rod_cantilever(case):
    """A rod of 1 m, clamped in its first segment, sags under its weight."""
    d = 1.0 / (case.segments - 0.5)  # the middle of the first segment, about which it is clamped, lies at 0
    return scene([{"kind": "rod", "name": "rod", "points": [[-0.5 * d, 0, 0], [1.0, 0, 0]], "segments": case.segments, "radius": 0.01,
                   "stretch_stiffness": 1e5, "bend_stiffness": 10.0, "linear_density": 0.1, "stiffness_damping": 0.05,
                   "constraints": [{"select": {"kind": "plane", "point": [0.6 * d, 0, 0], "normal": [1, 0, 0]}}]}], 4.0)


def end_speed(run):
    """Mean speed of the two ends of the rope, [m/s]"""
    v = np.linalg.norm(run.nodes("rope")[1], axis=2)
    return 0.5 * (v[:, 0] + v[:, -1])


MU, POST, THICK = 0.3, 0.2, 0.02


def rope_over(case, ends, *, rope=0.5, segments=60):
    """A rope over a post, its ends hanging down by so many metres; friction MU."""
    R = POST + THICK
    arc = [[-R * math.cos(t), 0, R * math.sin(t)] for t in np.linspace(0, math.pi, 17)]
    points = [[-R, 0, -ends[0]]] + arc + [[R, 0, -ends[1]]]
    return scene([{"kind": "obstacle", "name": "post", "voxel_size": 0.02, "shape": {"kind": "capsule", "radius": POST, "length": 0.6},
                   "transform": {"rotation": {"axis": [1, 0, 0], "degrees": 90}}},
                  {"kind": "rod", "name": "rope", "points": points, "segments": segments, "radius": THICK, "linear_density": rope,
                   "stretch_stiffness": 2e4, "bend_stiffness": 1e-4, "rests_straight": True, "stiffness_damping": 0.01}],
                 0.5, friction=MU, response=case.response)


def rope_acceleration(case):
    """dT/dφ = μ (T − λ R a_n...) with weight: integrated over the half turn while it slides, by bisection over the acceleration."""
    R, lam = POST + THICK, 0.5

    def misfit(a):
        # Tension at the light end's top, then along the arc towards the heavy end; friction against the motion.
        tension = lam * case.light * (G + a)
        n = 4000
        for i in range(n):
            phi = (i + 0.5) / n * math.pi  # from the light side (0) over the top to the heavy one
            ds = math.pi / n * R
            along = G * math.cos(phi)      # weight along the motion: rising first, then falling
            press = tension / R + lam * G * math.sin(phi)
            tension += (lam * (a + along) + MU * POST / R * press) * ds  # friction acts at the post's face
        return tension - lam * case.heavy * (G - a)

    if misfit(0.0) > 0:
        return 0.0
    lo, hi = 0.0, G
    for _ in range(60):
        a = 0.5 * (lo + hi)
        lo, hi = (a, hi) if misfit(a) < 0 else (lo, a)
    return a


@experiment(law="dT/dφ = μ r/R (T + λ R g sin φ) + λ R (a + g cos φ)", unit="m/s²",
            source="Euler and Eytelwein, with the weight of the arc; friction acts at the post's radius r, tension at the rope's axis R",
            tolerance=0.05, scale=0.4 * G,  # what friction takes from the rope
            cases=cases(response=BOTH, light=(0.4,), heavy=(1.2, 2.0, 2.8)), theory=rope_acceleration,
            measure=lambda c, r: end_speed(r)[r.at(0.1)] / 0.1,
            curve=lambda c, r: (r.time, end_speed(r)), ideal=lambda c, t: rope_acceleration(c) * t, axes=("t [s]", "speed [m/s]"))
def capstan(case):
    """A rope over a post, its ends of unequal length: the acceleration with which it starts to slide."""
    return rope_over(case, (case.light, case.heavy))


LIGHT, HEAVY, WHEEL = 1.0, 1.2, 0.1  # [kg, kg, m]


def pulley_acceleration(case):
    """The wheel, a cylinder, turns with the axis of the rope, at the radius WHEEL + THICK / 2."""
    axis = WHEEL + 0.5 * THICK
    moved = LIGHT + HEAVY + 0.02 * (1.6 + math.pi * axis) + 0.5 * case.wheel * (WHEEL / axis)**2
    return (HEAVY - LIGHT) * G / moved


@experiment(law="a = (m₂ − m₁) g / (m₁ + m₂ + m_rope + I/r²)", source="Atwood, with a wheel that the rope turns", unit="m/s²", tolerance=0.05, study="dt", fast=True,
            cases=cases(response=BOTH, wheel=(1.0,), dt=(1 / 60, 1 / 240)), theory=pulley_acceleration,
            measure=lambda c, r: fits.acceleration(r.time, r.velocity("light")[:, 2], start=0.15),
            curve=lambda c, r: (r.time, r.velocity("light")[:, 2]), ideal=lambda c, t: pulley_acceleration(c) * t, axes=("t [s]", "speed [m/s]"))
def pulley(case):
    """Weights of 1 and 1.2 kg on a rope over a wheel that turns on a joint: their acceleration."""
    axis, end = WHEEL + 0.5 * THICK, 0.8
    arc = [[-axis * math.cos(t), 0, axis * math.sin(t)] for t in np.linspace(0, math.pi, 17)]
    weights = [{"kind": "rigid", "name": name, "mass": mass, "shape": box(0.1, 0.1, 0.1), "transform": {"position": [x, 0, -end - 0.05]}}
               for name, mass, x in (("light", LIGHT, -axis), ("heavy", HEAVY, axis))]
    whole = scene([{"kind": "rigid", "name": "wheel", "mass": case.wheel, "shape": {"kind": "cylinder", "radius": WHEEL, "length": 0.1},
                    "transform": {"rotation": about((1, 0, 0), 90)}},
                   {"kind": "rod", "name": "rope", "points": [[-axis, 0, -end]] + arc + [[axis, 0, -end]], "segments": 100, "radius": 0.5 * THICK,
                    "linear_density": 0.02, "stretch_stiffness": 2e4, "bend_stiffness": 1e-4, "rests_straight": True}] + weights,
                  0.6, dt=case.dt, friction=1.0, response=case.response)
    whole["joints"] = [{"name": "axle", "body": "wheel", "kind": "revolute", "position": [0, 0, 0], "axis": [0, 1, 0]}]
    whole["attachments"] = [{"name": f"knot_{name}", "body": "rope", "to": name, "point": [x, 0, -end], "touch": False}
                            for name, x in (("light", -axis), ("heavy", axis))]
    return whole


@experiment(law="F = m g", source="statics", unit="N", tolerance=0.01, cases=cases(response=("penalty",)), theory=lambda c: 0.25 * G * 1.0,
            measure=lambda c, r: np.mean(r.force("plane")[-20:, 2]) * -1)
def cloth_weight(case):
    """A sheet of 0.5 x 0.5 m and 1 kg/m² lies on a floor: the load that this carries."""
    return scene([floor(0.02), {"kind": "cloth", "name": "sheet", "grid": {"size": [0.5, 0.5], "cells": [12, 12]}, "areal_density": 1.0,
                                "thickness": 0.04, "voxel_size": 0.02, "transform": {"position": [0, 0, 0.03]}}], 1.5, response=case.response)


ROOF = 0.3  # [m] side of the box


def depth_in_roof(case, run):
    """How far the deepest vertex of the sheet has been inside the box, [voxels]"""
    x = run.nodes("sheet")[0]
    across, up = x[:, :, 0] / math.sqrt(2), x[:, :, 2] / math.sqrt(2)
    inside = np.minimum(0.5 * ROOF - np.maximum(np.abs(across - up), np.abs(across + up)), 0.1 - np.abs(x[:, :, 1]))
    return max(0.0, inside.max()) / case.h


@experiment(law="the middle of a sheet stays outside", source="the sheet is two voxels thick: they overlap by up to one", unit="voxels", tolerance=0.25, scale=1.0,
            cases=cases(h=(0.02, 0.0125), areal=(0.05, 0.3, 1.0)), theory=lambda c: 0.0, measure=depth_in_roof)
def sheet_on_a_ridge(case):
    """A sheet of 0.8 x 0.6 m falls by 4 cm onto the ridge of a box, 0.2 m long, and hangs from it: the depth of its deepest vertex."""
    return scene([{"kind": "obstacle", "name": "roof", "shape": box(ROOF, 0.2, ROOF), "transform": {"rotation": about((0, 1, 0), 45)}},
                  {"kind": "cloth", "name": "sheet", "preset": "cotton", "areal_density": case.areal, "grid": {"size": [0.8, 0.6], "cells": [20, 14]},
                   "thickness": 2 * case.h, "transform": {"position": [0, 0, ROOF / math.sqrt(2) + 0.04 + case.h]}}], 1.0, response="penalty")


AIR, WIND, AREAL = 1.2, 2.0, 0.2


def lean(run):
    """Angle by which the strip hangs from the vertical, [degrees]"""
    x = run.positions("strip", run.frames - 1)
    way = x[x[:, 2].argmin()] - x[x[:, 2].argmax()]
    return math.degrees(math.atan2(way[0], -way[2]))


@experiment(law="tan θ = ρ v² / (2 σ g)", source="moments about the edge, with a pressure ½ ρ v² cos θ along the normal", unit="degrees",
            tolerance=0.01, study="dt", fast=True, cases=cases(dt=(1 / 30, 1 / 60, 1 / 240)),
            theory=math.degrees(math.atan(AIR * WIND**2 / (2 * AREAL * G))), measure=lambda c, r: lean(r))
def strip_in_wind(case):
    """A light strip hangs from its edge in a steady wind: its angle when it has come to rest, whatever the step."""
    strip = {"kind": "cloth", "name": "strip", "grid": {"size": [1, 0.2], "cells": [25, 5]}, "areal_density": AREAL, "bend_stiffness": 1e-6,
             "stretch_stiffness": 500, "mass_damping": 0.5, "transform": {"rotation": {"axis": [0, 1, 0], "degrees": 90}},
             "constraints": [{"select": {"kind": "box", "lo": [-1, -1, 0.499], "hi": [1, 1, 0.6]}}]}
    made = scene([strip], 8.0, dt=case.dt)
    made["forces"] = [{"name": "wind", "bodies": ["strip"], "wind": {"velocity": [WIND, 0, 0], "density": AIR, "drag": 1.0, "lift": 1.0}}]
    return made
