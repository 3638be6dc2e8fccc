"""Moves what has been imported: at each change of Blender's frame, places and positions are read from run.h5.

Blender's frame f is frame f of the run. A run's collection knows the file ("brim_run"), an object the piece ("brim_piece") or
the body ("brim_body") that it shows, so that a saved .blend file plays wherever this add-on is installed and the run is found.
"""

import bpy
import numpy as np
from bpy.app.handlers import persistent
from mathutils import Matrix

RUN, PIECE, BODY = "brim_run", "brim_piece", "brim_body"
NODES = "brim"  # modifier that gives particles and lines their thickness

_sources = {}  # path: Source


def source_of(collection):
    from .source import Source  # needs h5py, which an add-on that is only switched on does without
    path = bpy.path.abspath(collection[RUN])
    if path not in _sources:
        _sources[path] = Source(path)
    return _sources[path]


def forget():
    """Closes all runs; each is opened again when a frame of it is asked for."""
    for source in _sources.values():
        source.close()
    _sources.clear()


def matrix_of(rotation, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return Matrix(matrix)


def place_pieces(objects, source, moment):
    before, after, weight = source.around(moment)
    rotation, translation = source.poses(before)
    later = source.poses(after) if weight else None
    for thing in objects:
        piece = thing[PIECE]
        matrix = matrix_of(rotation[piece], translation[piece])
        if later:
            matrix = matrix.lerp(matrix_of(later[0][piece], later[1][piece]), weight)
        thing.matrix_world = matrix


def fill_mesh(mesh, positions, triangles):
    """Makes a mesh anew of triangles with smooth normals; its materials stay."""
    mesh.clear_geometry()
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
    count = len(triangles)
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(triangles, np.int32).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    if bpy.app.version < (4, 0, 0):
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.update(calc_edges=True)


def reshape(thing, source, moment):
    body, mesh = source.bodies[thing[BODY]], thing.data
    positions = source.positions(body, moment)
    if body.changing:
        fill_mesh(mesh, positions, source.triangles(body, moment))
    elif len(positions) == len(mesh.vertices):  # edited by hand otherwise
        mesh.vertices.foreach_set("co", np.ascontiguousarray(positions).ravel())
        mesh.update()
        for nodes in (m for m in thing.modifiers if m.type == "NODES" and m.name == NODES):
            nodes.show_render = nodes.show_viewport = not removed(positions)


def removed(positions):
    """True of a body that was taken out of the world: all of it is recorded at one point, where it shall show nothing."""
    return len(positions) > 1 and bool((positions == positions[0]).all())


def show(collection, moment):
    """Brings all objects of a run to a moment [frames]."""
    source = source_of(collection)
    pieces = [o for o in collection.all_objects if PIECE in o and not source.still[source.piece_body[o[PIECE]]]]
    if pieces:
        place_pieces(pieces, source, moment)
    for thing in collection.all_objects:
        if BODY in thing and not source.still[thing[BODY]]:
            reshape(thing, source, moment)


@persistent
def on_frame(scene, _graph=None):
    moment = scene.frame_current_final
    for collection in bpy.data.collections:
        if RUN not in collection or collection.library:
            continue
        try:
            show(collection, moment)
        except (OSError, KeyError, ImportError) as error:
            print(f"brim: {collection[RUN]} cannot be read: {error}")


@persistent
def on_load(*_unused):
    forget()


def register():
    bpy.app.handlers.frame_change_pre.append(on_frame)
    bpy.app.handlers.load_pre.append(on_load)


def unregister():
    bpy.app.handlers.load_pre.remove(on_load)
    bpy.app.handlers.frame_change_pre.remove(on_frame)
    forget()
