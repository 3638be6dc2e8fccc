"""Makes Blender's objects of a run: one for each rigid piece, meshes shared; one for each body that deforms or changes."""

import math

import bpy
import numpy as np

from . import looks, playback
from .source import Source, run_path

CREASE = math.radians(38)  # edges sharper than this stay sharp, as in the viewer


def triangle_mesh(name, positions, triangles):
    mesh = bpy.data.meshes.new(name)
    playback.fill_mesh(mesh, positions, triangles)
    if hasattr(mesh, "use_auto_smooth"):  # until Blender 4.0
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, CREASE
    return mesh


def open_mesh(name, positions, edges):
    """Vertices, and edges (m, 2) between them if there are any."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", np.ascontiguousarray(edges, np.int32).ravel())
    mesh.update()
    return mesh


def add_pieces(collection, source, body, material, meshes):
    """Objects of a rigid body; a material belongs to the object, so that equal pieces share a mesh whatever their colours."""
    pieces = source.pieces(body)
    rotation, translation = source.poses(0)
    for k, piece in enumerate(pieces):
        number = int(source.piece_mesh[piece])
        if number not in meshes:
            meshes[number] = triangle_mesh(f"{source.name} mesh {number}", *source.mesh(number))
            meshes[number].materials.append(None)
        thing = bpy.data.objects.new(body.name if len(pieces) == 1 else f"{body.name} piece {k}", meshes[number])
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = material
        thing.matrix_world = playback.matrix_of(rotation[piece], translation[piece])
        thing[playback.PIECE] = int(piece)
        collection.objects.link(thing)


def add_body(collection, source, body, material, surface):
    """The object of a body without rigid pieces."""
    positions = source.positions(body, 0)
    if body.display == "triangles":
        mesh = triangle_mesh(body.name, positions, source.triangles(body, 0))
    else:
        mesh = open_mesh(body.name, positions, body.cells if body.display == "lines" else np.zeros((0, 2), int))
    mesh.materials.append(material)
    thing = bpy.data.objects.new(body.name, mesh)
    thing[playback.BODY] = body.index
    collection.objects.link(thing)
    if body.display == "triangles":
        return
    make = looks.tubes if body.display == "lines" else looks.surface if surface else looks.spheres
    nodes = thing.modifiers.new(playback.NODES, "NODES")
    nodes.node_group = make(f"brim {body.name}", float(body.attrs["radius"]), material)
    if make is looks.surface:
        smooth = thing.modifiers.new("smooth", "SMOOTH")  # evens out single particles
        smooth.factor, smooth.iterations = 0.5, 12


def chosen_colour(name, colours):
    """The colour given for a body or for all of its numbered copies ("gear" means gear, gear.2, ...); None without."""
    stem, _, number = name.rpartition(".")
    return colours.get(name, colours.get(stem) if number.isdigit() else None)


def import_run(path, surface=False, colours=None):
    """Adds a run to the scene as a collection and shows frame 0.

    path: a run's folder or its run.h5. surface: fluids as the surface around their particles. colours: {name: "#rrggbb"}, as in
    chosen_colour. Raises OSError or KeyError where the file cannot be read.
    """
    path = run_path(path)
    source = Source(path)
    collection = bpy.data.collections.new(source.name)
    collection[playback.RUN] = path
    bpy.context.scene.collection.children.link(collection)
    meshes = {}
    for body, colour in zip(source.bodies, source.colours()):
        flowing = body.kind in looks.FLUIDS
        water = flowing and (surface or body.changing)
        colour = chosen_colour(body.name, colours or {}) or (looks.WATER if water else colour)
        material = looks.material_of(body.name, colour, water)
        if len(source.pieces(body)):
            add_pieces(collection, source, body, material, meshes)
        else:
            add_body(collection, source, body, material, surface and flowing)
    source.close()
    playback.on_frame(bpy.context.scene)
    return collection
