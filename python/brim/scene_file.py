"""Entries of scenes: arrays in them go to the world by name, and to files when the scene is saved."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from . import _core

FOLDER = "arrays"
"""Beside a saved scene, where its arrays lie."""

_PATHS = ("file", "mesh", "tet_mesh", "urdf")


def take_arrays(core: _core.Session, name: str, keys: dict[str, Any]) -> dict[str, Any]:
    """The keys of an entry as a scene file would have them: arrays of meshes and volumes are handed to the world under a
    name that stands where a file's would; paths become absolute."""
    keys = dict(keys)
    base = _free_token(core, name)
    _take_mesh(core, base, keys, shape=False)
    if "intensities" in keys:
        spacing = keys.pop("spacing", None)
        if spacing is None:
            raise _core.InputError("spacing: is missing; intensities need the steps between voxels, (dx, dy, dz) [m]")
        token = f"{base}.nrrd"
        core.give_volume(token, keys.pop("intensities"), spacing)
        keys["file"] = token
        keys["unit"] = 1.0
    _take_shapes(core, base, keys)
    return keys


def _free_token(core: _core.Session, name: str) -> str:
    """Where the arrays of an entry go: a name of a file that no other entry's arrays have, nor begin with."""
    safe = re.sub(r"[^A-Za-z0-9_-]", "_", name)
    taken = {token.split(".")[0] for token in core.given_names()}
    base, number = f"{FOLDER}/{safe}", 2
    while base in taken:
        base, number = f"{FOLDER}/{safe}-{number}", number + 1
    return base


def _take_mesh(core: _core.Session, token: str, keys: dict[str, Any], *, shape: bool) -> None:
    if "vertices" not in keys:
        return
    vertices = keys.pop("vertices")
    if "tetrahedra" in keys:
        core.give_tets(f"{token}.vtk", vertices, keys.pop("tetrahedra"))
        keys["tet_mesh"] = f"{token}.vtk"
    elif "triangles" in keys:
        core.give_surface(f"{token}.ply", vertices, keys.pop("triangles"))
        keys["file" if shape else "mesh"] = f"{token}.ply"
    else:
        raise _core.InputError("triangles: are missing; vertices need triangles (m, 3) or tetrahedra (m, 4)")


def _take_shapes(core: _core.Session, token: str, keys: dict[str, Any]) -> None:
    """Goes through nested dicts and lists (shape, links/0/shape, ...)."""
    for key, value in keys.items():
        if isinstance(value, dict):
            keys[key] = _taken(core, token, value)
        elif isinstance(value, (list, tuple)) and any(isinstance(item, dict) for item in value):
            keys[key] = [_taken(core, f"{token}.{i}", item) if isinstance(item, dict) else item
                         for i, item in enumerate(value)]
        elif key in _PATHS and isinstance(value, (str, os.PathLike)):
            path = os.fspath(value)
            keys[key] = path if path.startswith((f"{FOLDER}/", "${")) else os.path.abspath(path)


def _taken(core: _core.Session, token: str, value: dict[str, Any]) -> dict[str, Any]:
    value = dict(value)
    if value.get("kind") == "mesh":
        _take_mesh(core, token, value, shape=True)
    _take_shapes(core, token, value)
    return value


def scene_text(core: _core.Session, name: str, frames: int) -> str:
    """The JSON text of the world's scene. It names arrays as files, which write_arrays makes."""
    scene: dict[str, Any] = {"brim": 1, **core.head()}
    scene["name"] = name
    scene.pop("duration", None)
    scene["frames"] = frames
    scene["bodies"] = [_with_paths(core, entry) for entry in core.entries()]
    return json.dumps(scene, indent=1, ensure_ascii=False) + "\n"


def _with_paths(core: _core.Session, value: Any) -> Any:
    """The same with paths of files absolute."""
    if isinstance(value, list):
        return [_with_paths(core, item) for item in value]
    if not isinstance(value, dict):
        return value
    out = {}
    for key, item in value.items():
        if key in _PATHS and isinstance(item, str):
            given = item in core.given_names()
            out[key] = item if given or item.startswith("${") else os.path.abspath(os.path.join(core.folder, item))
        else:
            out[key] = _with_paths(core, item)
    return out


def write_arrays(core: _core.Session, folder: Path) -> None:
    """Writes the arrays that a scene in this folder names."""
    text = json.dumps(core.entries())
    for token in core.given_names():
        if json.dumps(token) not in text:
            continue  # of an entry that was refused
        path = folder / token
        path.parent.mkdir(parents=True, exist_ok=True)
        if token.endswith(".ply"):
            _write_ply(path, *core.given_surface(token))
        elif token.endswith(".vtk"):
            _write_vtk(path, *core.given_tets(token))
        else:
            _write_nrrd(path, *core.given_volume(token))


def _write_ply(path: Path, vertices: Any, triangles: Any) -> None:
    faces = np.empty(len(triangles), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    faces["n"] = 3
    faces["corners"] = triangles
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def _write_vtk(path: Path, vertices: Any, tetrahedra: Any) -> None:
    lines = ["# vtk DataFile Version 3.0", "tetrahedra", "ASCII", "DATASET UNSTRUCTURED_GRID",
             f"POINTS {len(vertices)} double"]
    lines += ["%r %r %r" % tuple(x) for x in vertices.tolist()]
    lines.append(f"CELLS {len(tetrahedra)} {5 * len(tetrahedra)}")
    lines += ["4 %d %d %d %d" % tuple(t) for t in tetrahedra.tolist()]
    lines.append(f"CELL_TYPES {len(tetrahedra)}")
    lines += ["10"] * len(tetrahedra)
    path.write_text("\n".join(lines) + "\n")


def _write_nrrd(path: Path, values: Any, spacing: Any) -> None:
    nz, ny, nx = values.shape
    header = ("NRRD0004\ntype: float\ndimension: 3\nendian: little\nencoding: raw\n"
              f"sizes: {nx} {ny} {nz}\nspacings: {' '.join(repr(float(s)) for s in spacing)}\n\n")
    path.write_bytes(header.encode() + values.astype("<f4").tobytes())
