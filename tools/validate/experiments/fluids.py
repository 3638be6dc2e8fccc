"""Fluids."""
import numpy as np

from fluid_measures import Grid, Particles, immersed_in_basin
from validate import fits
from validate.experiment import cases, experiment
from validate.scenes import G, about, ball, box, rigid, scene

SIDE, DEPTH = 0.5, 0.3


def basin(h, side=SIDE):
    """Five planes around the water."""
    half = 0.5 * side
    turns = [None, ([0, 1, 0], 90), ([0, 1, 0], -90), ([1, 0, 0], -90), ([1, 0, 0], 90)]
    places = [[half, half, 0], [0, half, half], [side, half, half], [half, 0, half], [half, side, half]]
    bodies = []
    for name, place, turn in zip(["floor", "west", "east", "south", "north"], places, turns):
        at = {"position": place}
        if turn:
            at["rotation"] = {"axis": turn[0], "degrees": turn[1]}
        bodies.append({"kind": "obstacle", "name": name, "voxel_size": h, "shape": {"kind": "plane", "display_size": 0.01}, "transform": at})
    return bodies


def pool(spacing, seconds, more=(), **world):
    h = 0.5 * spacing
    return scene(basin(h) + list(more) + [
        {"kind": "particle_fluid", "name": "water", "spacing": spacing, "viscosity": 1.0, "voxel_size": h, "shape": box(SIDE, SIDE, DEPTH),
         "transform": {"position": [SIDE / 2, SIDE / 2, DEPTH / 2]}}], seconds, dt=0.005, friction=0.0, frame=4, **world)


@experiment(law="F = ρ g V", source="hydrostatics", unit="N", tolerance=0.02, theory=lambda c: 1000 * G * SIDE * SIDE * DEPTH, fast=True,
            cases=cases(spacing=(0.05,)), measure=lambda c, r: -np.mean(r.force("floor")[-20:, 2]))
def water_on_floor(case):
    """Water in a basin of frictionless planes: the load on the floor, mean over the last 0.4 s."""
    return pool(case.spacing, 2.0)


@experiment(law="F = ½ ρ g H² b", source="hydrostatics", unit="N", tolerance=0.05, theory=lambda c: 0.5 * 1000 * G * DEPTH**2 * SIDE,
            cases=cases(wall=("west", "east", "south", "north")), fast=True,
            measure=lambda c, r: np.mean(np.abs(r.force(c.wall)[-20:]).max(1)))
def water_on_walls(case):
    """The same: the load on each wall."""
    return pool(0.05, 2.0)


@experiment(law="a still pool is still", source="hydrostatics", unit="m/s", tolerance=1.0, scale=1e-2, theory=0.0,
            cases=cases(start=("lattice", "jitter 1", "jitter 2", "jitter 3"), spacing=(0.05,)),
            measure=lambda c, r: np.sqrt((r.nodes("water")[1][-10:] ** 2).sum(2).mean()),
            misses={"start lattice": "the lattice of the start settles for several seconds"})
def still_pool(case):
    """The same: the mean speed that is left after 4 s, of particles that start on a lattice, and beside it by up to a tenth of their spacing."""
    still = pool(case.spacing, 4.0)
    if case.start != "lattice":
        still["bodies"][-1] |= {"jitter": 0.1, "seed": int(case.start.split()[1])}
    return still


@experiment(law="half of it is under water", source="Archimedes", unit="-", tolerance=0.10, theory=0.5,
            cases=cases(shape=("box", "sphere"), cells=(2.4, 3.6, 5.2)), measure=lambda c, r: share_under_water(c, r))
def floats(case):
    """A cube or ball half as dense as water floats in a pool of particles, so many spacings wide: the share of it that is under the surface,
    mean over the last 0.6 s. The surface is where the water's volume fills the basin around the body."""
    size = SPACING * case.cells
    body = box(size, size, size) if case.shape == "box" else ball(0.5 * size)
    return pool(SPACING, 3.0, [rigid("body", body, (SIDE / 2, SIDE / 2, DEPTH + 0.5 * size), 0.5 * SPACING, density=500)])


SPACING = 0.05
TANK = {"lo": [-0.4, -0.4, 0], "hi": [0.4, 0.4, 0.9]}


@experiment(law="half of it is under water", source="Archimedes", unit="-", tolerance=0.10, theory=0.5,
            cases=cases(ramp=(1.5, 3), shape=("box", "sphere"), cells=(2.4, 3.6, 5.2), place=(0.002, 0.027)), measure=lambda c, r: share_in_tank(c, r))
def floats_on_a_grid(case):
    """A cube or ball half as dense as water falls into a grid fluid and floats, so many cells wide, in the middle of a cell or at its side, seen in
    ramps of so many cells: the share of it that is under the surface, mean from 1.5 to 3 s. The surface is where the water's volume fills the tank
    around the body."""
    size = SPACING * case.cells
    body = box(size, size, size) if case.shape == "box" else ball(0.5 * size)
    water = {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": TANK, "fill": [{"kind": "plane", "point": [0, 0, 0.5], "normal": [0, 0, 1]}]}
    return scene([water, rigid("body", body, (case.place, 0.5 * case.place, 0.52 + 0.5 * size), SPACING * case.ramp / 3, density=500)], 3.0, dt=0.01,
                 friction=0.0, frame=10)


def share_in_tank(case, run):
    fluid = Grid(run.file, run.number("water"), {"cell_size": SPACING, "box": TANK})
    return np.mean([immersed_in_basin(run.file, fluid, run.number("body"), f, case.shape, 0.64) for f in range(run.at(1.5), run.frames)])


def share_under_water(case, run):
    number = run.number("water")
    fluid = Particles(run.file, number, {"spacing": SPACING})
    return np.mean([immersed_in_basin(run.file, fluid, run.number("body"), f, case.shape, SIDE**2) for f in range(run.frames - 30, run.frames, 3)])


@experiment(law="F = ρ g V", source="Archimedes", unit="N", tolerance=0.03, cases=cases(ramp=(1.5, 3), shape=("box", "sphere"), cells=(2.5, 4, 6)),
            theory=lambda c: 1000 * G * (SPACING * c.cells) ** 3 * (1 if c.shape == "box" else np.pi / 6),
            measure=lambda c, r: np.mean(r.force("body")[r.at(0.5):, 2]))
def lift_on_a_grid(case):
    """A cube or ball, so many cells wide, is held in the middle of a grid fluid, and seen in ramps of so many cells: what the still water lifts it with."""
    size = SPACING * case.cells
    body = rigid("body", box(size, size, size) if case.shape == "box" else ball(0.5 * size), (0.41, 0.405, 0.36), SPACING * case.ramp / 3, density=500)
    hole = {"kind": "box", "lo": [p - 0.5 * size for p in (0.41, 0.405, 0.36)], "hi": [p + 0.5 * size for p in (0.41, 0.405, 0.36)]} if case.shape == "box" else {
        "kind": "sphere", "center": [0.41, 0.405, 0.36], "radius": 0.5 * size}
    water = {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": {"lo": [0, 0, 0], "hi": [0.8, 0.8, 1.0]},
             "fill": [{"kind": "plane", "point": [0, 0, 0.7], "normal": [0, 0, 1]}], "carve": [hole]}
    s = scene([body, water], 1.0, dt=0.005, friction=0.0, frame=4)
    s["timeline"] = [{"at": 0, "freeze": "body"}]
    return s


@experiment(law="F = ρ g V / 2", source="Archimedes", unit="N", tolerance=0.03, cases=cases(shape=("box", "sphere"), cells=(2.4, 4, 5.2), place=(0.41, 0.427)),
            theory=lambda c: 1000 * G * 0.5 * volume_of(c), measure=lambda c, r: np.mean(r.force("body")[r.at(1.5):, 2]))
def lift_of_what_is_half_in(case):
    """A cube or ball, so many cells wide, in two places of the grid, is held with half of it under the level of a grid fluid, which rises by what that half displaces."""
    size = SPACING * case.cells
    at = (case.place, 0.5 * case.place + 0.2, 0.5 + 0.5 * volume_of(case) / 0.64)
    body = rigid("body", box(size, size, size) if case.shape == "box" else ball(0.5 * size), at, SPACING, density=500)
    water = {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": {"lo": [0, 0, 0], "hi": [0.8, 0.8, 0.8]},
             "fill": [{"kind": "plane", "point": [0, 0, 0.5], "normal": [0, 0, 1]}]}
    s = scene([body, water], 3.0, dt=0.01, friction=0.0, frame=5)
    s["timeline"] = [{"at": 0, "freeze": "body"}]
    return s


def thin_volume(case):
    d = SPACING * case.cells
    return {"ball": np.pi / 6 * d**3, "bar": 0.4 * d * d, "rod": 0.4 * np.pi / 4 * d * d + np.pi / 6 * d**3}[case.shape]


@experiment(law="F = ρ g V", source="Archimedes", unit="N", tolerance=0.1,
            cases=cases(shape=("rod", "bar", "ball"), cells=(0.4, 0.75, 1.25), place=(0.0, 0.0125, 0.0335), turn=(0, 23)),
            theory=lambda c: 1000 * G * thin_volume(c), measure=lambda c, r: np.mean(r.force("body")[r.at(0.3):, 2]))
def lift_of_thin_matter(case):
    """A rod or bar of 0.4 m, or a ball, less than 1.5 cells thick, is held in a grid fluid, in three places and two directions: what the still water lifts it with."""
    d = SPACING * case.cells
    x = np.array([0.4 + case.place, 0.4 + 0.3 * case.place, 0.35 + 0.6 * case.place])
    angle = np.radians(case.turn)
    along = np.array([np.cos(angle), 0.8 * np.sin(angle), 0.6 * np.sin(angle)])
    if case.shape == "rod":
        body = {"kind": "rod", "name": "body", "points": [list(x - 0.2 * along), list(x + 0.2 * along)], "segments": 16, "radius": 0.5 * d}
    else:
        place = {"position": list(x), "rotation": about((0, -0.6, 0.8), case.turn)}
        body = rigid("body", box(0.4, d, d) if case.shape == "bar" else ball(0.5 * d), place, 0.25 * d, density=500)
    water = {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": {"lo": [0, 0, 0], "hi": [0.8, 0.8, 0.8]},
             "fill": [{"kind": "plane", "point": [0, 0, 0.6], "normal": [0, 0, 1]}]}
    s = scene([body, water], 0.6, dt=0.01, friction=0.0, frame=5)
    s["timeline"] = [{"at": 0, "freeze": "body"}]
    return s


def volume_of(case):
    return (SPACING * case.cells) ** 3 * (1 if case.shape == "box" else np.pi / 6)


WIDTH, POOL = 0.8, 1.6  # [m] of the pool in which balls sink and rise


def fall(case, first, last):
    """Mean velocity of a ball between two times: weight less lift, half the displaced mass dragged along, Newton's drag."""
    d, v, sum = SPACING * case.cells, 0.0, 0.0
    for step in range(round(1000 * last)):
        v += 1e-3 * (abs(case.density / 1000 - 1) * G - 0.75 * 0.44 * v * v / d) / (case.density / 1000 + 0.5)
        sum += v if step >= 1000 * first else 0.0
    return sum / (1000 * (last - first))


@experiment(law="v = ∫ (|ρ_s/ρ − 1| g − 0.33 v²/d) / (ρ_s/ρ + 1/2) dt", source="Newton's drag, C_d = 0.44 (Schiller and Naumann 1933); half the displaced mass is dragged along", unit="m/s",
            tolerance=0.2, cases=cases(cells=(0.4, 0.8, 1.2, 2.0), density=(2000, 400), place=(0.0, 0.0125)),
            theory=lambda c: fall(c, 0.5, 0.7), measure=lambda c, r: abs(np.mean(r.velocity("ball")[r.at(0.5):, 2])),
            curve=lambda c, r: (r.time, np.abs(r.velocity("ball")[:, 2])), axes=("t [s]", "speed [m/s]"))
def sinks_and_rises_in_a_grid(case):
    """A ball, so many cells wide, sinks or rises in a pool that is a grid fluid, in two places of the grid: its speed from 0.5 to 0.7 s, when it hardly changes any more."""
    d = SPACING * case.cells
    at = (0.5 * WIDTH + case.place, 0.5 * WIDTH + 0.8 * case.place, POOL - 0.2 if case.density > 1000 else 0.2)
    water = {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": {"lo": [0, 0, 0], "hi": [WIDTH, WIDTH, POOL + 0.2]},
             "fill": [{"kind": "plane", "point": [0, 0, POOL], "normal": [0, 0, 1]}]}
    return scene([water, rigid("ball", ball(0.5 * d), at, 0.25 * d, density=case.density)], 0.7, dt=0.01, friction=0.0, frame=2)


@experiment(law="v = (ρ_s − ρ) g d² / (18 η (1 + 0.15 Re^0.687))", source="Stokes 1851; Schiller and Naumann 1933", unit="m/s", tolerance=0.1,
            cases=cases(kind=("points", "rigid"), viscosity=(1.0, 10.0)), theory=lambda c: creep(c.viscosity),
            measure=lambda c, r: abs(np.mean(r.velocity("grain")[r.at(0.3):, 2])))
def grain_in_oil(case):
    """A grain of 20 mm, 0.4 cells wide, sinks in a viscous grid fluid: its speed from 0.3 s on."""
    fluid = {"kind": "grid_fluid", "name": "oil", "cell_size": SPACING, "viscosity": case.viscosity, "box": {"lo": [0, 0, 0], "hi": [WIDTH, WIDTH, 1.0]},
             "fill": [{"kind": "plane", "point": [0, 0, 0.8], "normal": [0, 0, 1]}]}
    at = [0.41, 0.39, 0.6]
    grain = {"kind": "points", "name": "grain", "density": 2500, "radius": 0.01, "positions": [at]} if case.kind == "points" else rigid("grain", ball(0.01), at, 0.005, density=2500)
    return scene([fluid, grain], 0.6, dt=0.01, friction=0.0, frame=2)


def creep(viscosity, d=0.02):
    v = 0.0
    for _ in range(200):
        v += 0.2 * (1500 * G * d * d / (18 * viscosity * (1 + 0.15 * (1000 * v * d / viscosity) ** 0.687)) - v)
    return v


HELD = {"particles": 4.0, "grid": 1.0}  # [s] particles take longer to calm down


BALL, WIDE, DEEP, PLACE = 0.1, 0.8, 0.7, 0.35  # [m] radius; width and depth of the water; height of the ball


def dragged_share():
    """Mass of water that the ball drags, over what it displaces: 1/2, and what walls, floor and surface change, by the dipoles that mirror
    it (walls and floor let nothing through, the surface has no pressure): 1/2 (1 - 3 u / U), u what they move the water by at its place."""
    u = 0.0
    for k in range(-10, 11):
        for up, sign in ((2 * DEEP * k, 1 - 2 * (k % 2)), (2 * DEEP * k - 2 * PLACE, 2 * (k % 2) - 1)):
            x, y = np.meshgrid(WIDE * np.arange(-10, 11), WIDE * np.arange(-10, 11))
            r2 = x**2 + y**2 + up**2
            far = r2 > 0
            u += sign * (0.5 * BALL**3 * (3 * up**2 / r2[far] - 1) / r2[far] ** 1.5).sum()
    return 0.5 * (1 - 3 * u)


@experiment(law="a = g (ρ − ρ_ball) / (ρ_ball + 0.513 ρ)",
            source="Lamb, Hydrodynamics, § 92: a ball drags half the mass of the fluid that it displaces; § 99: images in walls, floor and surface, four radii away, add 2.6 %",
            unit="m/s²", tolerance=0.10, cases=cases(fluid=("particles", "grid"), density=(250, 2000)),
            theory=lambda c: G * (1000 - c.density) / (c.density + 1000 * dragged_share()), measure=lambda c, r: first_acceleration(c, r),
            misses={"fluid particles": "its first step is right (3.91 for 3.90 m/s² where it sinks); then it is braked by some 100 N s/m, half of it with half the step: around "
                                       "a ball two spacings large single particles jump past each other (docs/bodies/particle_fluid.md, limits)"},
            curve=lambda c, r: let_go(c, r), axes=("t [s]", "speed [m/s]"))
def added_mass(case):
    """A ball of 0.2 m that is held in the middle of still water is let go: its acceleration in the first 0.05 s."""
    held = HELD[case.fluid]
    side, depth = WIDE, DEEP
    solid = rigid("ball", ball(BALL), (side / 2, side / 2, PLACE), 0.025, density=case.density)
    size, place = [side, side, depth], [side / 2, side / 2, depth / 2]
    if case.fluid == "particles":
        bodies = basin(0.025, side) + [solid, {"kind": "particle_fluid", "name": "water", "spacing": SPACING, "viscosity": 1.0, "voxel_size": 0.025,
                                               "shape": box(*size), "carve": [{"kind": "sphere", "center": [0, 0, PLACE - depth / 2], "radius": BALL}],
                                               "transform": {"position": place}}]
    else:
        bodies = [solid, {"kind": "grid_fluid", "name": "water", "cell_size": SPACING, "box": {"lo": [0, 0, 0], "hi": [side, side, 1.0]},
                          "fill": [{"kind": "plane", "point": [0, 0, depth], "normal": [0, 0, 1]}],
                          "carve": [{"kind": "sphere", "center": [side / 2, side / 2, PLACE], "radius": BALL}]}]
    s = scene(bodies, held + 0.2, dt=0.005, friction=0.0, frame=1)
    s["timeline"] = [{"at": 0, "freeze": "ball"}, {"at": held, "thaw": "ball"}]
    return s


def first_acceleration(case, run):
    held = HELD[case.fluid]
    return fits.acceleration(run.time, run.velocity("ball")[:, 2], held, held + 0.05)


def let_go(case, run):
    window = slice(run.at(HELD[case.fluid] - 0.1), run.at(HELD[case.fluid] + 0.15))
    return run.time[window] - HELD[case.fluid], run.velocity("ball")[window, 2]
