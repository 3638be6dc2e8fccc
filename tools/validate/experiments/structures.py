"""Structures without mortar: what stands by its weight alone."""
import math

import numpy as np

from validate.experiment import BOTH, ROWS, cases, experiment
from validate.scenes import about, box, floor, rigid, scene

# --- blocks that overhang ---

REACHES = [0.94 + 0.01 * i for i in range(13)]  # of the most that the law allows
LONG, HIGH, BLOCKS = 1.0, 0.2, 5


def first_to_fall(values, name, run):
    """Between the first of several structures whose last part falls and the one before it."""
    step = values[1] - values[0]
    fallen = [v for i, v in enumerate(values) if run.lowest(name(i)).min() < run.lowest(name(i))[0] - 0.05]
    return min(fallen) - 0.5 * step if fallen else values[-1] + 0.5 * step


@experiment(law="reach = (L/2)(1 + 1/2 + 1/3 + 1/4)", source="statics, e.g. Johnson 1955", unit="-", tolerance=0.03, cases=cases(response=BOTH), theory=1.0,
            misses={"response penalty": "the weight of what overhangs stands on an edge, and penalties need a voxel or so of face around it to carry it: 0.6 voxel is left at 0.97"},
            measure=lambda c, r: first_to_fall(REACHES, lambda i: f"stack{i}.0", r))
def overhang(case):
    """Thirteen stacks of five blocks, each block reaching out over the one below it by 0.94 to 1.06 times as much as it may: the first that falls."""
    bodies = [floor(0.025)]
    for i, reach in enumerate(REACHES):
        x = 0.0
        for k in range(BLOCKS):  # from the top
            x -= reach * LONG / (2 * k) if k else 0.0
            bodies.append(rigid(f"stack{i}.{k}", box(LONG, 0.5, HIGH), (x, 3.0 * i, HIGH * (BLOCKS - k - 0.5)), 0.025, density=600))
    return scene(bodies, 2.0, friction=0.6, response=case.response)


# --- an arch ---

STONES = 15
THICK = [0.0925 + 0.0025 * i for i in range(17)]  # [m] of arches of 1 m, to the middle of the stones


def fits(thickness, stones=STONES):
    """True where a line of thrust lies within all joints of a half-round arch of radius 1: rho = (M + W x) / (H cos + W sin) at the joint at an angle from the crown,
    with W and x the weight of what lies above it and its middle, H and M thrust and moment at the crown. For given H that is an interval of M."""
    inner, outer = 1 - 0.5 * thickness, 1 + 0.5 * thickness
    angle = (np.arange((stones + 1) // 2) + 0.5) * math.pi / stones
    weight = 0.5 * (outer**2 - inner**2) * angle
    moment = (outer**3 - inner**3) / 3 * (1 - np.cos(angle))  # W x
    best = -np.inf
    for thrust in np.linspace(0.2, 2.0, 4000) * weight[-1]:
        along = thrust * np.cos(angle) + weight * np.sin(angle)
        best = max(best, np.min(outer * along - moment) - np.max(inner * along - moment))
    return best >= 0


def thinnest():
    low, high = 0.05, 0.2
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return 0.5 * (low + high)


def stone(thickness, depth=0.3, arcs=6):
    """A wedge of an arch about the y axis, its middle above the origin, as text of an OBJ file."""
    lines = []
    half = 0.5 * math.pi / STONES
    turns = [-half + 2 * half * k / arcs for k in range(arcs + 1)]
    for y in (-0.5 * depth, 0.5 * depth):
        for r in (1 - 0.5 * thickness, 1 + 0.5 * thickness):
            lines += [f"v {r * math.sin(t):.9f} {y:.9f} {r * math.cos(t):.9f}" for t in turns]

    def at(side, rim, k):
        return (2 * side + rim) * (arcs + 1) + k + 1

    def quad(*corners):
        lines.append("f " + " ".join(map(str, corners)))

    for k in range(arcs):
        quad(at(0, 0, k), at(0, 0, k + 1), at(0, 1, k + 1), at(0, 1, k))
        quad(at(1, 0, k), at(1, 1, k), at(1, 1, k + 1), at(1, 0, k + 1))
        quad(at(0, 1, k), at(0, 1, k + 1), at(1, 1, k + 1), at(1, 1, k))
        quad(at(0, 0, k), at(1, 0, k), at(1, 0, k + 1), at(0, 0, k + 1))
    for k in (0, arcs):
        corners = [at(0, 0, k), at(0, 1, k), at(1, 1, k), at(1, 0, k)]
        quad(*(corners if k == 0 else reversed(corners)))
    return "\n".join(lines) + "\n"


@experiment(law="thickness / radius at which the line of thrust touches both faces", source="Milankovitch 1907, Heyman 1969; joints of 15 stones", unit="-", tolerance=0.03,
            cases=cases(response=(ROWS,)), theory=lambda c: thinnest(),
            measure=lambda c, r: thinnest_that_stands(r))
def thin_arch(case):
    """Seventeen half-round arches of fifteen stones, 0.0925 to 0.1325 as thick as their radius (rows): between the last that falls and the next."""
    bodies = [floor(0.0125)]
    for i, t in enumerate(THICK):
        for k in range(STONES):
            turn = -90 + 180 / STONES * (k + 0.5)
            bodies.append(rigid(f"arch{i}.{k}", {"kind": "mesh", "file": f"stone_{1e4 * t:.0f}.obj"},
                                {"position": [0, 3.0 * i, 0], "rotation": about((0, 1, 0), turn)}, t / 8, density=2200))
    return scene(bodies, 2.0, friction=0.8, response=case.response, files={f"stone_{1e4 * t:.0f}.obj": stone(t) for t in THICK})


def thinnest_that_stands(run):
    key = [f"arch{i}.{STONES // 2}" for i in range(len(THICK))]
    fallen = [t for t, name in zip(THICK, key) if run.lowest(name).min() < run.lowest(name)[0] - 0.05]
    return max(fallen) + 0.00125 if fallen else THICK[0] - 0.00125
