"""Bodies that deform and swing, or hang: bars, rods and sheets against elastic theory."""
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, Case, cases, experiment
from validate.scenes import G, block, scene

from .soft import uniaxial_press
from .thin import end_speed, rope_over

LONG, YOUNG, DENSE = 1.0, 1e6, 1000.0


def bar(seconds, dt, damping):
    """A bar that hangs from its upper face, straight down, without Poisson's effect."""
    step = 0.1
    return scene([{"kind": "finite_elements", "name": "bar", "shape": box_of(0.2, 0.2, LONG + step), "lattice_spacing": step, "density": DENSE,
                   "young_modulus": YOUNG, "poisson_ratio": 0.0, "transform": {"position": [0, 0, -0.5 * (LONG - step)]},
                   "stiffness_damping": damping,
                   "constraints": [{"select": {"kind": "plane", "point": [0, 0, -1e-6], "normal": [0, 0, -1]}}]}], seconds, dt=dt)


def box_of(*size):
    return {"kind": "box", "size": list(size)}


def drop_of_end(run, name):
    return run.lowest(name)[0] - run.lowest(name)


@experiment(law="δ = ρ g L² / (2 E)", source="Hooke, its weight spread along it", unit="m", tolerance=0.03, theory=DENSE * G * LONG**2 / (2 * YOUNG), fast=True,
            cases=cases(dt=(1 / 60,)), measure=lambda c, r: drop_of_end(r, "bar")[-10:].mean())
def bar_hangs(case):
    """A bar of 1 m hangs from one end: by how much it is longer."""
    return bar(2.0, case.dt, 0.02)


@experiment(law="T = 4 L √(ρ/E)", source="standing wave of a bar with one end free", unit="s", tolerance=0.03, study="dt",
            theory=4 * LONG * math.sqrt(DENSE / YOUNG), cases=cases(dt=(1 / 480, 1 / 960)),
            measure=lambda c, r: fits.period(r.time, drop_of_end(r, "bar")),
            curve=lambda c, r: (r.time, drop_of_end(r, "bar")), axes=("t [s]", "longer by [m]"))
def bar_rings(case):
    """The same bar is let go unstretched, and swings up and down."""
    return bar(0.6, case.dt, 0.0)


@experiment(law="f = 1.8751² / (2π L²) √(E I / λ)", source="Euler and Bernoulli, first mode of a clamped rod", unit="s", tolerance=0.03, study="segments",
            fast=True, theory=2 * math.pi / (1.8751**2 * math.sqrt(10.0 / 0.1)), cases=cases(segments=(10, 20)),
            measure=lambda c, r: fits.period(r.time, r.nodes("rod")[0][:, -1, 2]),
            curve=lambda c, r: (r.time, r.nodes("rod")[0][:, -1, 2]), axes=("t [s]", "tip [m]"))
def rod_rings(case):
    """A rod of 1 m, clamped in its first segment, is let go straight and swings under its weight, without damping."""
    d = 1.0 / (case.segments - 0.5)  # the middle of the first segment, about which it is clamped, lies at 0
    return scene([{"kind": "rod", "name": "rod", "points": [[-0.5 * d, 0, 0], [1.0, 0, 0]], "segments": case.segments, "radius": 0.01,
                   "stretch_stiffness": 1e5, "bend_stiffness": 10.0, "linear_density": 0.1, "stiffness_damping": 0.0,
                   "constraints": [{"select": {"kind": "plane", "point": [0.6 * d, 0, 0], "normal": [1, 0, 0]}}]}], 1.5, dt=1 / 960)


@experiment(law="widening over shortening is ν", source="Hooke", unit="-", tolerance=0.05, scale=0.3, theory=lambda c: c.poisson,
            cases=cases(response=("penalty",), poisson=(0.3, 0.45)) + cases(response=("constraint",), poisson=(0.3,)),
            measure=lambda c, r: widening(r))
def press_widens(case):
    """The cube of uniaxial_press: what it grows by across, over what it is shortened by."""
    return uniaxial_press(Case(case, young=2e5))


def widening(run):
    first, last = (run.positions("cube", f) for f in (0, run.frames - 1))
    size = [np.ptp(x, axis=0) for x in (first, last)]
    strain = size[1] / size[0] - 1
    return -0.5 * (strain[0] + strain[1]) / strain[2]


@experiment(law="v = g t", source="free fall", unit="m/s", tolerance=1e-6, theory=0.3 * G, fast=True,
            cases=cases(kind=("finite_elements", "mass_spring", "meshless", "soft_image", "cloth", "points")),
            measure=lambda c, r: -r.velocity("body")[r.at(0.3), 2])
def soft_falls(case):
    """A body of each kind falls freely while it turns: the speed of its centre of mass after 0.3 s."""
    return scene([block(case.kind, "body", (0, 0, 0), spin=(0, 2, 0))], 0.3)


def speed_of_slip(case, t):
    """What hangs over grows as it slides: x'' = 2 g x / L about the place where both ends hang alike."""
    length = case.heavy + case.light + math.pi * 0.22
    rate = math.sqrt(2 * G / length)
    return G * (case.heavy - case.light) / length * np.sinh(rate * t) / rate


@experiment(law="v = g (l₂ − l₁) sinh(k t) / (k L),  k² = 2 g / L,  L = l₁ + l₂ + π R", source="Atwood's machine, of a rope alone", unit="m/s²",
            tolerance=0.03, cases=cases(response=BOTH, light=(0.4,), heavy=(0.8, 1.6)),
            theory=lambda c: speed_of_slip(c, 0.1) / 0.1, measure=lambda c, r: end_speed(r)[r.at(0.1)] / 0.1,
            curve=lambda c, r: (r.time, end_speed(r)), ideal=speed_of_slip, axes=("t [s]", "speed [m/s]"))
def rope_slips(case):
    """A rope over a post without friction, its ends of unequal length: its mean acceleration in the first tenth of a second."""
    s = rope_over(case, (case.light, case.heavy))
    s["materials"]["default"]["friction"] = 0.0
    return s


SHEET_YOUNG = 1000.0  # [N/m], the default of a sheet


@experiment(law="x = H s/K + (H/w) asinh(w s/H), y = w s²/2K + √(H² + w² s²)/w", source="elastic catenary; Irvine, Cable Structures, § 1.3", unit="m", tolerance=0.02,
            theory=lambda c: elastic_catenary(1.6, 2.0, G, SHEET_YOUNG), cases=cases(cells=(16, 32)), study="cells", fast=True,
            measure=lambda c, r: -r.positions("sheet", r.frames - 1)[:, 2].min())
def cloth_hangs(case):
    """A sheet of 2 m, stretched by its weight by 0.8 %, hangs between two edges that come nearer, to 1.6 m: its sag."""
    move = [{"select": {"kind": "box", "lo": [s * 1.0 - 0.01, -1, -1], "hi": [s * 1.0 + 0.01, 1, 1]},
             "keyframes": [{"time": 0, "offset": [0, 0, 0]}, {"time": 1, "offset": [-0.2 * s, 0, 0]}]} for s in (-1, 1)]
    return scene([{"kind": "cloth", "name": "sheet", "grid": {"size": [2.0, 0.25], "cells": [case.cells, 2]}, "areal_density": 1.0, "thickness": 0.02,
                   "stretch_stiffness": SHEET_YOUNG, "bend_stiffness": 0.0, "mass_damping": 1.5, "constraints": move}], 5.0)


def elastic_catenary(span, length, weight, stiffness):
    """Sag of a chain that stretches. @param weight of a metre unstretched, stiffness: tension over strain"""
    s = 0.5 * length
    reach = lambda pull: pull * s / stiffness + pull / weight * math.asinh(weight * s / pull)  # noqa: E731
    lo, hi = 1e-3 * weight * length, 1e3 * weight * length
    for _ in range(200):
        pull = 0.5 * (lo + hi)
        lo, hi = (pull, hi) if reach(pull) < 0.5 * span else (lo, pull)
    return weight * s**2 / (2 * stiffness) + (math.hypot(pull, weight * s) - pull) / weight
