"""Shapes: what a body's key "shape" may be. Each function gives the dict that a scene file would hold; lengths in [m]."""

from __future__ import annotations

from typing import Any, Sequence

Shape = dict[str, Any]


def _shape(kind: str, **keys: Any) -> Shape:
    return {"kind": kind, **{key: value for key, value in keys.items() if value is not None}}


def plane(display_size: float | None = None) -> Shape:
    """Half space below z = 0 of its own frame, for obstacles; display_size is the side of the square that is shown."""
    return _shape("plane", display_size=display_size)


def box(size: Sequence[float]) -> Shape:
    """Box about the origin. size: full extents (x, y, z)."""
    return _shape("box", size=size)


def sphere(radius: float) -> Shape:
    """Ball about the origin."""
    return _shape("sphere", radius=radius)


def capsule(radius: float, length: float) -> Shape:
    """Cylinder along z between two half balls. length: of the straight part."""
    return _shape("capsule", radius=radius, length=length)


def cylinder(radius: float, length: float) -> Shape:
    """Cylinder along z about the origin."""
    return _shape("cylinder", radius=radius, length=length)


def torus(radius: float, tube: float) -> Shape:
    """Ring around z. radius: of the ring; tube: radius of the tube."""
    return _shape("torus", radius=radius, tube=tube)


def gear(teeth: int, outer: float, root: float, thickness: float, bore: float | None = None) -> Shape:
    """Spur gear around z. outer, root, bore: radii of tips, gaps and hole."""
    return _shape("gear", teeth=teeth, outer=outer, root=root, thickness=thickness, bore=bore)


def star(points: int, outer: float, inner: float, thickness: float) -> Shape:
    """Star, extruded along z. outer, inner: radii."""
    return _shape("star", points=points, outer=outer, inner=inner, thickness=thickness)


def blob(radius: float, seed: int | None = None) -> Shape:
    """Potato with smooth lumps and dents. seed: another number, another potato."""
    return _shape("blob", radius=radius, seed=seed)


def bowl(radius: float, thickness: float) -> Shape:
    """Half-sphere shell, open towards +z."""
    return _shape("bowl", radius=radius, thickness=thickness)


def cup(radius: float, height: float, thickness: float) -> Shape:
    """Beaker with a floor, open towards +z, standing on z = 0."""
    return _shape("cup", radius=radius, height=height, thickness=thickness)


def l_profile(leg_x: float, leg_y: float, width: float, length: float) -> Shape:
    """L-shaped bar, legs along +x and +y, extruded along z."""
    return _shape("l_profile", leg_x=leg_x, leg_y=leg_y, width=width, length=length)


def u_profile(outer: float, height: float, thickness: float, length: float) -> Shape:
    """U-shaped bar, open towards +y, extruded along z."""
    return _shape("u_profile", outer=outer, height=height, thickness=thickness, length=length)


def mesh(file: Any = None, *, vertices: Any = None, triangles: Any = None, treatment: str | None = None,
         thickness: float | None = None, fit: float | None = None, center: bool | None = None,
         up: str | None = None) -> Shape:
    """Triangles: of a file (OBJ, STL, PLY, OFF, glTF, GLB), or of two arrays.

    vertices: (n, 3) [m], kept in single precision; vertices at equal positions become one.
    triangles: (m, 3) whole numbers, corners counter-clockwise seen from outside.
    treatment: "closed", "winding_number" or "thickness" (a sheet of that thickness), as in scene files.
    """
    if (file is None) == (vertices is None):
        raise ValueError("mesh: give either a file, or vertices and triangles")
    return _shape("mesh", file=file, vertices=vertices, triangles=triangles, treatment=treatment,
                  thickness=thickness, fit=fit, center=center, up=up)
