"""Runs inside Blender for tools/blender_test.py: holds what Blender shows of a run to the numbers in run.h5.

    blender --background --python tools/blender/check_import.py -- import RUN ADDON.zip OUT.blend
    blender --background OUT.blend --python tools/blender/check_import.py -- play RUN

The first installs the add-on, imports the run by its operator and saves the scene; the second opens that scene again.
"""

import os
import sys

import bpy
import numpy as np

kRounding = 1e-6  # of places: Blender keeps them as float32 positions, turns and scales


def world_positions(thing):
    """Vertices (n, 3) of an object's own mesh in the world."""
    x = np.empty(3 * len(thing.data.vertices), np.float32)
    thing.data.vertices.foreach_get("co", x)
    place = np.array(thing.matrix_world)
    return x.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3]


def shown(body, things):
    """Positions of a body as its objects show them, one after another."""
    return np.concatenate([world_positions(o) for o in things[body.index]])


def objects_by_body(source):
    things = {}
    for thing in bpy.data.objects:
        if "brim_piece" in thing:
            things.setdefault(int(source.piece_body[thing["brim_piece"]]), []).append(thing)
        elif "brim_body" in thing:
            things.setdefault(thing["brim_body"], []).append(thing)
    return {b: sorted(list_, key=lambda o: o.get("brim_piece", 0)) for b, list_ in things.items()}


def check_frames(source):
    """Every body in several frames, out of order; what deforms or changes bit for bit."""
    scene, things = bpy.context.scene, objects_by_body(source)
    assert sorted(things) == list(range(len(source.bodies))), "every body has an object"
    last = source.frames - 1
    for frame in (last, 0, last // 2, 1):
        scene.frame_set(frame)
        for body in source.bodies:
            x, truth = shown(body, things), source.run.positions(body, frame)
            if len(source.pieces(body)):
                np.testing.assert_allclose(x, truth, rtol=0, atol=kRounding * (1 + np.abs(truth).max()), err_msg=body.name)
            else:
                np.testing.assert_array_equal(x, truth, err_msg=f"{body.name} in frame {frame}")
            if body.changing:
                corners = np.empty(3 * len(things[body.index][0].data.polygons), np.int32)
                things[body.index][0].data.loops.foreach_get("vertex_index", corners)
                np.testing.assert_array_equal(corners.reshape(-1, 3), source.run.triangles(body, frame))


def check_between_frames(source):
    """Half way between two frames lies the middle of both: exact for what deforms, and for how far a piece has moved."""
    bpy.context.scene.frame_set(1, subframe=0.5)
    things = objects_by_body(source)
    for body in source.bodies:
        if body.changing:
            continue
        middle = 0.5 * (source.run.positions(body, 1) + source.run.positions(body, 2))
        if not len(source.pieces(body)):
            np.testing.assert_allclose(shown(body, things), middle, rtol=0, atol=1e-7 * (1 + np.abs(middle).max()))
            continue
        poses = [source.poses(frame)[1] for frame in (1, 2)]
        for thing in things[body.index]:
            piece = thing["brim_piece"]
            np.testing.assert_allclose(thing.matrix_world.translation, 0.5 * (poses[0][piece] + poses[1][piece]), rtol=0, atol=1e-6)


def check_particles(source):
    """Points are instances, one a particle; lines have thickness; of a body that was removed nothing is left."""
    graph = bpy.context.evaluated_depsgraph_get()
    for body in source.bodies:
        gone = np.ptp(source.run.positions(body, source.frames - 1), axis=0).max() == 0 if not body.changing else False
        if body.display == "points":
            count = sum(1 for i in graph.object_instances if i.is_instance and i.parent.name == body.name)
            assert count == (0 if gone else body.attrs["vertices"]), f"{body.name}: {count} instances"
        if body.display == "lines" and not gone:
            mesh = bpy.data.objects[body.name].evaluated_get(graph).to_mesh()
            low, high = np.array([v.co for v in mesh.vertices]).min(axis=0), np.array([v.co for v in mesh.vertices]).max(axis=0)
            thin = source.run.positions(body, source.frames - 1)
            assert (low[2] < thin[:, 2].min() - 0.5 * body.attrs["radius"]) and high[2] > thin[:, 2].max(), body.name


def check_scene(source):
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end) == (0, source.frames - 1)
    assert abs(scene.render.fps / scene.render.fps_base * source.frame_time - 1) < 1e-6
    assert scene.camera and any(o.type == "LIGHT" for o in scene.objects)
    colours = [tuple(o.material_slots[0].material.diffuse_color) for o in scene.objects if "brim_piece" in o or "brim_body" in o]
    assert len(set(colours)) == min(9, len(source.bodies)), "bodies are told apart"


def main(what, run, addon=None, out=None):
    if what == "import":
        bpy.ops.preferences.addon_install(filepath=addon)
        bpy.ops.preferences.addon_enable(module="brim_import")
        assert bpy.ops.import_scene.brim(filepath=os.path.join(run, "run.h5")) == {"FINISHED"}
    else:
        bpy.ops.preferences.addon_enable(module="brim_import")
    from brim_import.source import Source  # the installed one
    source = Source(run)
    check_frames(source)
    check_between_frames(source)
    bpy.context.scene.frame_set(source.frames - 1)
    check_particles(source)
    if what == "import":
        check_scene(source)
        bpy.ops.wm.save_as_mainfile(filepath=out)


main(*sys.argv[sys.argv.index("--") + 1:])
