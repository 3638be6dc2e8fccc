"""Solids that deform: spin, slides, presses, beams."""
import math

import numpy as np

from validate import fits
from validate.experiment import BOTH, Case, cases, experiment
from validate.scenes import G, SOFT, about, ball, block, box, floor, on_slope, placed, scene, slope

from .rigid import along_slope, slide_law

SOLIDS = ("finite_elements", "mass_spring", "meshless", "soft_image")


def spin_kept(case, run):
    x, v = run.nodes("body")
    return fits.mean_spin(x[-1], v[-1])[2] / fits.mean_spin(x[0], v[0])[2]


@experiment(law="angular momentum is kept", source="Newton", unit="-", tolerance=0.02, fast=True, theory=1.0, measure=spin_kept,
            cases=cases(kind=("finite_elements", "mass_spring", "cloth", "rod"), dt=(1 / 60, 1 / 240)))
def free_spin(case):
    """A body of each kind, stiff enough to keep its shape, spins freely at 6 rad/s for 2 s: the share of its mean spin that is left.
    Momenta themselves are held to 1e-10 by the tests (`tests/body/spin_test.cpp`)."""
    if case.kind == "rod":
        body = {"kind": "rod", "name": "body", "points": [[-0.5, 0, 0], [0.5, 0, 0]], "segments": 10, "radius": 0.02,
                "angular_velocity": [0, 0, 6.0]}
    else:
        body = block(case.kind, "body", (0, 0, 0), young=1e6, spin=(0, 0, 6.0))
    return scene([body], 2.0, dt=case.dt, gravity=[0, 0, 0])


@experiment(law="a = g (sin θ − μ cos θ)", source="Coulomb", unit="m/s²", tolerance=0.05, theory=slide_law,
            cases=cases(response=BOTH, kind=SOFT, angle=(20,), friction=(0.0, 0.2)),
            measure=lambda c, r: fits.acceleration(*along_slope(c, r, "body"), start=0.3))
def soft_slide(case):
    """A block, sheet or layer of grains (that do not turn) of each kind slides down a plane."""
    return scene([slope(case.angle, 0.025), block(case.kind, "body", (0, 0, 0), degrees=case.angle)], 0.9, friction=case.friction,
                 response=case.response)


@experiment(law="a = g (sin θ − μ cos θ)", source="Coulomb", unit="m/s²", tolerance=0.05, theory=slide_law,
            cases=cases(response=BOTH, kind=SOFT, board=("jointed", "lies"), angle=(20,), friction=(0.2,)),
            measure=lambda c, r: fits.acceleration(*along_slope(c, r, "body"), start=0.3))
def slides_on_a_board(case):
    """A block, sheet or layer of grains of each kind slides down an image of a board that can move: a joint holds it, or it lies on a rough plane."""
    size, h = 0.2, 0.025
    board = {"kind": "image_volume", "name": "board", "shape": box(2.0, 0.6, size), "image_spacing": 0.5 * h, "voxel_size": h,
             "density": 1000, "transform": placed(case.angle, -0.5 * size, along=0.6)}
    s = scene([board, block(case.kind, "body", (0, 0, 0), degrees=case.angle)], 0.9, friction=case.friction, response=case.response)
    if case.board == "jointed":
        s["joints"] = [{"name": "hold", "body": "board", "kind": "fixed", "position": on_slope(case.angle, 0.6, -0.5 * size)}]
    else:
        s["bodies"].insert(0, slope(case.angle, h, material="rough"))
        s["bodies"][0]["transform"]["position"] = on_slope(case.angle, 0, -size)
        s["materials"]["rough"] = {"friction": 1.0}
        s["pairs"] = [{"materials": ["rough", "default"], "friction": 1.0}]
    return s


@experiment(law="no motion below the angle of friction", source="Coulomb", unit="m/s", tolerance=1.0, scale=1e-3, theory=0.0,
            cases=cases(response=BOTH, kind=SOFT, friction=(0.55,), angle=(25,)),
            measure=lambda c, r: fits.slope_of(r.time[r.at(0.75):], (r.center("body") @ np.array(
                [math.cos(math.radians(c.angle)), 0, -math.sin(math.radians(c.angle))]))[r.at(0.75):]))
def soft_stick(case):
    """A body of each kind rests on a plane well inside the cone of friction: its creep, promised below 1 mm/s."""
    return scene([slope(case.angle, 0.025), block(case.kind, "body", (0, 0, 0), degrees=case.angle)], 1.5, friction=case.friction,
                 response=case.response)


@experiment(law="F = m g", source="statics", unit="N", tolerance=0.005, theory=lambda c: 1.0, fast=True,
            cases=cases(response=BOTH, kind=SOFT), measure=lambda c, r: -np.mean(r.force("plane")[-30:, 2]) / (r.mass("body") * G))
def soft_weight(case):
    """A body of each kind lies on a floor: the load that this carries, over the weight."""
    return scene([floor(0.025), block(case.kind, "body", (0, 0, 0))], 1.0, response=case.response)


def plates(gap, speed, depth, h, size=1.0):
    """A fixed plate below and one above that comes down by `depth` and stays."""
    time = depth / speed
    return [{"kind": "obstacle", "name": "below", "voxel_size": h, "shape": box(size, size, 0.1), "transform": {"position": [0, 0, -0.05]}},
            {"kind": "obstacle", "name": "above", "voxel_size": h, "shape": box(size, size, 0.1), "transform": {"position": [0, 0, gap + 0.05]},
             "keyframes": [{"time": 0, "offset": [0, 0, 0]}, {"time": time, "offset": [0, 0, -depth]}]}]


RADIUS, PRESSED = 0.1, 0.01


SINKS = ("contact at 20 E is a layer in series that takes 8 % of the force of a patch 1.3 voxels wide; stiffer contact gives -9.5 % (60 E) and -6.8 % (200 E), "
         "but four solves then do not find the slip of what spreads (numerics, Stiffness)")


def hertz(young, poisson, radius, approach):
    """Force of a ball pressed between two rigid plates that have come nearer by `approach`: half of it at each."""
    return 4 / 3 * young / (1 - poisson**2) * math.sqrt(radius) * (0.5 * approach) ** 1.5


@experiment(law="F = 4/3 E/(1 − ν²) √R (δ/2)^(3/2)", source="Hertz 1882; Johnson, Contact Mechanics, § 4.2", unit="N", tolerance=0.10,
            cases=cases(response=BOTH, young=(2e4, 2e5, 2e6), cells=(6, 10)), theory=lambda c: hertz(c.young, 0.3, RADIUS, PRESSED),
            measure=lambda c, r: np.mean(r.force("above")[-10:, 2]), study="cells",
            misses={f"response penalty, young {young}, cells 6": SINKS for young in ("2e+06", "200000", "20000")},
            curve=lambda c, r: (r.time, r.force("above")[:, 2]), axes=("t [s]", "force [N]"))
def hertz_press(case):
    """A soft ball of 0.1 m is pressed by 5 % between two plates without friction or weight, so many voxels to its radius."""
    h = RADIUS / case.cells
    return scene(plates(2 * RADIUS, 0.02, PRESSED, h) + [
        {"kind": "finite_elements", "name": "ball", "shape": ball(RADIUS), "lattice_spacing": 2 * h, "voxel_size": h, "density": 1000,
         "young_modulus": case.young, "transform": {"position": [0, 0, RADIUS]}, "stiffness_damping": 0.02}],
        1.6, friction=0.0, gravity=[0, 0, 0], response=case.response)


@experiment(law="F = E A δ / L without friction", source="Hooke", unit="N", tolerance=0.05,
            cases=cases(response=BOTH, poisson=(0.3, 0.45), young=(2e5,)), theory=lambda c: c.young * 0.04 * 0.05,
            measure=lambda c, r: np.mean(r.force("above")[-10:, 2]))
def uniaxial_press(case):
    """A cube of 0.2 m is pressed by 5 % between two plates without friction."""
    return scene(plates(0.2, 0.02, 0.01, 0.0125, 0.6) + [
        {"kind": "finite_elements", "name": "cube", "shape": box(0.2, 0.2, 0.2), "lattice_spacing": 0.05, "voxel_size": 0.0125,
         "young_modulus": case.young, "poisson_ratio": case.poisson, "transform": {"position": [0, 0, 0.1]}, "stiffness_damping": 0.02}],
        1.2, friction=0.0, gravity=[0, 0, 0], response=case.response)


LONG, HIGH, DENSE = 1.0, 0.2, 1000.0


def sag(young):
    """Of a cantilever under its weight: bending and shear (Timoshenko, κ = 5/6), ν = 0."""
    q = DENSE * HIGH * HIGH * G
    inertia, area = HIGH**4 / 12, HIGH * HIGH
    return q * LONG**4 / (8 * young * inertia) + q * LONG**2 / (2 * (5 / 6) * 0.5 * young * area)


def beam(kind, cells, young):
    step = HIGH / cells
    common = {"name": "beam", "shape": box(LONG + 2 * step, HIGH, HIGH), "density": DENSE, "young_modulus": young, "poisson_ratio": 0.0,
              "transform": {"position": [0.5 * LONG - step, 0, 0]}, "stiffness_damping": 0.05,
              "constraints": [{"select": {"kind": "plane", "point": [1e-6, 0, 0], "normal": [1, 0, 0]}}]}
    for prefix, share in (("linear_", 0), ("averaged_", 0.9)):
        if kind.startswith(prefix):
            common["averaging"], kind = share, kind.removeprefix(prefix)
    if kind == "finite_elements":
        return {"kind": kind, "lattice_spacing": step, **common}
    if kind == "meshless":
        return {"kind": kind, "frame_spacing": step, "voxel_size": 0.5 * step, **common}
    return {"kind": "image_volume", "motion": "deformable", "image_spacing": 0.25 * step, "lattice_spacing": step, **common}


LOCKS = ("without the averaging that a bar of so few elements has unless its scene says otherwise: linear elements of edge a lock in bending, those across a beam of "
         "height H bend as if it were stiffer by 0.94 (a/H)², by 24 and 5.8 % with 2 and 4 of them")
COUNTS = ("without the averaging that a bar of so few elements has unless its scene says otherwise: elements lock as those of finite elements do, which bend 0.81 of "
          "theory, and matter in one counts wherever it lies in it")
BEFORE = ("the nodes that are held lie up to half a spacing of the lattice before the clamp, 19 mm here: a beam that is clamped there sags 7.6 % more; "
          "it bends as it should (beam_bends)")


@experiment(law="w = q L⁴ / (8 E I) + q L² / (2 κ G A)", source="Timoshenko's beam", unit="m", tolerance=0.05, study="cells",
            cases=cases(kind=("finite_elements", "linear_finite_elements", "meshless", "soft_image", "linear_soft_image", "averaged_soft_image"), cells=(2, 4)), theory=lambda c: sag(2e7),
            measure=lambda c, r: float(r.positions("beam", 0)[:, 2][tip(r)].mean() - r.positions("beam", r.frames - 1)[:, 2][tip(r)].mean()),
            misses={"kind linear_finite_elements": LOCKS, "kind linear_soft_image, cells 2": COUNTS, "kind averaged_soft_image, cells 4": BEFORE})
def cantilever(case):
    """A beam of 1 x 0.2 x 0.2 m, clamped at one end, sags under its weight, so many cells across."""
    return scene([beam(case.kind, case.cells, 2e7)], 2.5)


@experiment(law="w'' = q (L − x)² / (2 E I) + q / (κ G A)", source="Timoshenko's beam", unit="-", tolerance=0.05, study="cells",
            cases=cases(kind=("finite_elements", "linear_finite_elements", "meshless", "soft_image", "linear_soft_image", "averaged_soft_image"), cells=(2, 4)), theory=1.0,
            measure=lambda c, r: bending(r),
            misses={"kind linear_finite_elements": LOCKS, "kind linear_soft_image, cells 2": COUNTS})
def beam_bends(case):
    """The line into which the cantilever sags beyond 0.2 m, without the place and the slope that the clamp gives it: how much it is bent."""
    return scene([beam(case.kind, case.cells, 2e7)], 2.5)


def bending(run):
    """Share of theory's deflection in that of the nodes, beside a straight line, by least squares."""
    x = run.nodes("beam")[0]
    beyond = (x[0, :, 0] > 0.2) & (x[0, :, 0] < LONG)
    at, sunk = x[0, beyond, 0], x[0, beyond, 2] - x[-1, beyond, 2]
    q, inertia, area, young = DENSE * HIGH * HIGH * G, HIGH**4 / 12, HIGH * HIGH, 2e7
    line = q * at**2 * (6 * LONG**2 - 4 * LONG * at + at**2) / (24 * young * inertia) + q * (LONG * at - at**2 / 2) / ((5 / 6) * 0.5 * young * area)
    return np.linalg.lstsq(np.stack([np.ones_like(at), at, line], 1), sunk, rcond=None)[0][2]


def tip(run):
    x = run.positions("beam", 0)[:, 0]
    return np.flatnonzero(x > x.max() - 0.02)


@experiment(law="F = E A δ / L for each in series", source="Hooke", unit="N", tolerance=0.05, theory=lambda c: 1.0,
            cases=cases(response=BOTH), measure=lambda c, r: np.mean(r.force("above")[-10:, 2]) / -np.mean(r.force("below")[-10:, 2]))
def press_balance(case):
    """The same press: what the upper plate feels over what the lower one does."""
    return uniaxial_press(Case(response=case.response, poisson=0.3, young=2e5))


PAD = 0.1


@experiment(law="F = (4/3) E/(1 − ν²) √R δ^(3/2) (1 + 1.15 χ ...), χ = √(R δ)/h", unit="N", tolerance=0.15,
            source="Dimitriadis et al. 2002, Biophys. J. 82, equation 12 (bonded layer)",
            cases=cases(response=BOTH), theory=lambda c: pad_force(2e5, 0.3, 0.2, 0.015, PAD),
            measure=lambda c, r: np.mean(r.force("ball")[-10:, 2]))
def pad(case):
    """A rigid ball of 0.2 m radius is pressed by 15 mm into an elastic layer 0.1 m thick that is bonded below."""
    h = 0.0125
    return scene([{"kind": "finite_elements", "name": "pad", "shape": box(0.5, 0.5, PAD), "lattice_spacing": 0.025, "voxel_size": h,
                   "young_modulus": 2e5, "poisson_ratio": 0.3, "transform": {"position": [0, 0, 0.5 * PAD]}, "stiffness_damping": 0.02,
                   "constraints": [{"select": {"kind": "plane", "point": [0, 0, 1e-4], "normal": [0, 0, 1]}}]},
                  {"kind": "obstacle", "name": "ball", "voxel_size": h, "shape": ball(0.2), "transform": {"position": [0, 0, PAD + 0.2]},
                   "keyframes": [{"time": 0, "offset": [0, 0, 0]}, {"time": 0.6, "offset": [0, 0, -0.015]}]}],
                 1.2, friction=0.0, gravity=[0, 0, 0], response=case.response)


def pad_force(young, poisson, radius, depth, thickness):
    """Equation 12 of the source, for any Poisson's ratio, of a layer bonded to its ground."""
    a = -(1.2876 - 1.4678 * poisson + 1.3442 * poisson**2) / (1 - poisson)
    b = (0.6387 - 1.0277 * poisson + 1.5164 * poisson**2) / (1 - poisson)
    x = math.sqrt(radius * depth) / thickness
    series = (1 - 2 * a / math.pi * x + 4 * a**2 / math.pi**2 * x**2 - 8 / math.pi**3 * (a**3 + 4 * math.pi**2 / 15 * b) * x**3
              + 16 * a / math.pi**4 * (a**3 + 3 * math.pi**2 / 5 * b) * x**4)
    return 4 / 3 * young / (1 - poisson**2) * math.sqrt(radius) * depth**1.5 * series
