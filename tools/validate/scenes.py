"""Bodies and scenes in a few words. Angles in degrees, lengths in metres."""
import math

G = 9.81
UP = (0.0, 0.0, 1.0)


def scene(bodies, duration, *, dt=1 / 60, friction=0.5, restitution=0.0, response="penalty", frame=1, files=None, **world):
    """A scene of one material. files: text by name, which the runner writes beside the scene."""
    return {"files": files or {}, "brim": 1, "name": "experiment", "duration": duration, "steps_per_frame": frame,
            "world": {"time_step": dt, "response": response, **world},
            "materials": {"default": {"friction": friction, "restitution": restitution}}, "bodies": bodies}


def about(axis, degrees):
    return {"axis": list(axis), "degrees": degrees}


def quaternion_of(rotation):
    """[w, x, y, z] of a rotation in a scene."""
    if "quaternion" in rotation:
        return rotation["quaternion"]
    half = math.radians(0.5 * rotation["degrees"])
    length = math.sqrt(sum(x * x for x in rotation["axis"]))
    return [math.cos(half), *(math.sin(half) * x / length for x in rotation["axis"])]


def turned_in_grid(whole, degrees):
    """The same scene, turned about the vertical: all of it lies differently in the grid."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    half_c, half_s = math.cos(math.radians(0.5 * degrees)), math.sin(math.radians(0.5 * degrees))
    for body in whole["bodies"]:
        place = dict(body.get("transform", {}))
        x, y, z = place.get("position", (0.0, 0.0, 0.0))
        w, i, j, k = quaternion_of(place.get("rotation", about((0, 0, 1), 0.0)))
        place["position"] = [c * x - s * y, s * x + c * y, z]
        place["rotation"] = {"quaternion": [half_c * w - half_s * k, half_c * i - half_s * j, half_c * j + half_s * i, half_c * k + half_s * w]}
        body["transform"] = place
    return whole


def slope(degrees, h, **more):
    """A plane through the origin that falls towards +x."""
    return {"kind": "obstacle", "name": "plane", "voxel_size": h, "shape": {"kind": "plane", "display_size": 1},
            "transform": {"rotation": about((0, 1, 0), degrees)}, **more}


def floor(h, **more):
    return slope(0.0, h, **more)


def on_slope(degrees, along, above, across=0.0):
    """A place relative to the slope: along its fall, above it."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    return [along * c + above * s, across, -along * s + above * c]


def placed(degrees, above, along=0.0, across=0.0):
    return {"position": on_slope(degrees, along, above, across), "rotation": about((0, 1, 0), degrees)}


def box(*size):
    return {"kind": "box", "size": list(size)}


def ball(radius):
    return {"kind": "sphere", "radius": radius}


def cylinder(radius, length):
    return {"kind": "cylinder", "radius": radius, "length": length}


def rigid(name, shape, at, h, **more):
    transform = at if isinstance(at, dict) else {"position": list(at)}
    return {"kind": "rigid", "name": name, "shape": shape, "voxel_size": h, "transform": transform, **more}


def lone_link(name, shape, at, h, **more):
    """An articulated body of one link: what a rigid body is, in the coordinates of a tree."""
    transform = at if isinstance(at, dict) else {"position": list(at)}
    return {"kind": "articulated", "name": name, "base": "free", "voxel_size": h, "transform": transform,
            "links": [{"name": "link", "shape": shape}], **more}


# One small block of each kind that deforms, 0.3 x 0.3 m and about 0.15 m high, lying on z = 0 of its own frame.
SOFT = ("finite_elements", "mass_spring", "meshless", "soft_image", "cloth", "points")


def block(kind, name, at, *, degrees=0.0, size=(0.3, 0.3, 0.15), cells=3, young=2e5, velocity=(0, 0, 0), spin=(0, 0, 0),
          damping=0.005):
    """A body of the kind, as large as `size` where it has a height, whose lower face lies at `at`, tilted as a slope."""
    step = min(size) / cells
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    lift = 0.5 * size[2]
    common = {"name": name, "velocity": list(velocity), "angular_velocity": list(spin)}
    transform = {"rotation": about((0, 1, 0), degrees)}

    def raised(z):
        transform["position"] = [at[0] + s * z, at[1], at[2] + c * z]
        return transform

    elastic = {"young_modulus": young, "stiffness_damping": damping}
    if kind == "finite_elements":
        return {"kind": kind, **common, "shape": box(*size), "lattice_spacing": step, "transform": raised(lift), **elastic}
    if kind == "meshless":
        return {"kind": kind, **common, "shape": box(*size), "frame_spacing": 2 * step, "voxel_size": 0.5 * step,
                "transform": raised(lift), **elastic}
    if kind == "soft_image":
        return {"kind": "image_volume", **common, "shape": box(*size), "image_spacing": 0.25 * step, "motion": "deformable",
                "lattice_spacing": step, "voxel_size": 0.5 * step, "transform": raised(lift), **elastic}
    if kind == "mass_spring":
        return {"kind": kind, **common, "shape": box(*size), "lattice_spacing": step, "transform": raised(lift),
                "stiffness": young, "stiffness_damping": damping}
    if kind == "cloth":
        return {"kind": kind, **common, "grid": {"size": list(size[:2]), "cells": [8, 8]}, "thickness": 0.03,
                "voxel_size": 0.015, "areal_density": 1.0, "transform": raised(0.015), "stiffness_damping": damping}
    if kind == "points":
        common.pop("angular_velocity")
        return {"kind": kind, **common, "grid": {"count": [5, 5, 1], "spacing": 0.06}, "radius": 0.02, "turn": False,
                "transform": raised(0.02)}
    raise ValueError(kind)
