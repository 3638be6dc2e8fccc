"""Runs inside Blender for tools/check_exports.py: imports files and saves the vertices of every mesh at some times."""

import json
import os
import sys

import bpy
import numpy as np

job = json.load(open(sys.argv[sys.argv.index("--") + 1]))
if not hasattr(np, "bool"):
    np.bool, np.object = bool, object  # Debian's Blender 3.4 asks its newer NumPy for names that went away
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)

for path in job["files"]:
    if job["format"] == "obj":
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    elif job["format"] == "ply":
        bpy.ops.import_mesh.ply(filepath=path)
    elif job["format"] == "gltf":
        bpy.ops.import_scene.gltf(filepath=path)
    elif job["format"] == "vdb":
        bpy.ops.object.volume_import(filepath=path, files=[{"name": os.path.basename(path)}],
                                     directory=os.path.dirname(path))

scene, found, grids = bpy.context.scene, {}, []
for k, time in enumerate(job["times"]):
    at = time * scene.render.fps / scene.render.fps_base
    scene.frame_set(int(at), subframe=at - int(at))
    graph = bpy.context.evaluated_depsgraph_get()
    for thing in bpy.data.objects:
        if thing.type == "VOLUME":
            thing.data.grids.load()
            grids = [g.name for g in thing.data.grids]
        if thing.type != "MESH":
            continue
        shown = thing.evaluated_get(graph)
        mesh = shown.to_mesh()
        x = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", x)
        place = np.array(shown.matrix_world)
        found[f"{thing.name}@{k}"] = x.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3]
        found[f"{thing.name}#faces"] = len(mesh.polygons)
np.savez(job["out"], grids=np.array(grids, dtype=str), **found)
