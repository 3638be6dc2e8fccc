"""Frame rate, camera, light and ground that suit a run: the same view as the viewer's, in a pale studio."""

import math

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import looks

FIELD_OF_VIEW = math.radians(32)  # vertical
AZIMUTH, ELEVATION = -62.0, 20.0  # [degrees], as viewer/src/scene/stage.ts
BACKDROP = "#e6eaec"


def diagonal(box):
    return float(np.linalg.norm(box[1] - box[0]))


def union(a, b):
    return np.array([np.fmin(a[0], b[0]), np.fmax(a[1], b[1])])


def framing(source, frames):
    """Box to look at, (2, 3): what moves in these frames; of what is still all if it is small, else the part near by.

    A moving body that has flown far away does not count (viewer/src/scene/bounds.ts has the same rule).
    """
    box = None
    for frame in frames:
        boxes = source.boxes(frame)
        seen = boxes[~source.still & np.isfinite(boxes).all(axis=(1, 2))]
        if not len(seen):
            continue
        moving = np.array([seen[:, 0].min(axis=0), seen[:, 1].max(axis=0)])
        if box is None or diagonal(union(box, moving)) < 4 * diagonal(box):
            box = moving if box is None else union(box, moving)
    fixed = [b for b in source.boxes(0)[source.still] if np.isfinite(b).all()]
    if box is None:
        return np.array([np.min(fixed, axis=0)[0], np.max(fixed, axis=0)[1]]) if fixed else np.array([[-1.0] * 3, [1.0] * 3])
    scale, seen = diagonal(box), box.copy()
    for still in fixed:
        if diagonal(still) < scale:
            seen = union(seen, still)
            continue
        near = np.array([np.maximum(still[0], box[0] - 0.06 * scale), np.minimum(still[1], box[1] + 0.06 * scale)])
        if (near[0] <= near[1]).all():
            seen = union(seen, near)
    return seen


def camera_matrix(box, aspect, azimuth, elevation, distance=None):
    """Matrix of a camera that looks at the middle of a box; without a distance [m] from as far as shows all of it."""
    a, e = math.radians(azimuth), math.radians(elevation)
    back = Vector((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))
    right = Vector((0, 0, 1)).cross(back).normalized()
    up = back.cross(right)
    center = Vector(box.mean(axis=0))
    if distance is None:
        tan_up = 0.94 * math.tan(FIELD_OF_VIEW / 2)
        corners = [Vector([box[i >> k & 1][k] for k in range(3)]) - center for i in range(8)]
        distance = max(p.dot(back) + max(abs(p.dot(right)) / (tan_up * aspect), abs(p.dot(up)) / tan_up) for p in corners)
    place = Matrix((right, up, back)).transposed().to_4x4()
    place.translation = center + distance * back
    return place


def faded(material, center, reach):
    """Lets a ground end in nothing far from the scene, so that its edge does not show."""
    tree = material.node_tree
    new, link = tree.nodes.new, tree.links.new
    place, away, fade = new("ShaderNodeNewGeometry"), new("ShaderNodeVectorMath"), new("ShaderNodeMapRange")
    clear, mix = new("ShaderNodeBsdfTransparent"), new("ShaderNodeMixShader")
    away.operation, away.inputs[1].default_value = "DISTANCE", center
    fade.interpolation_type = "SMOOTHSTEP"
    fade.inputs["From Min"].default_value, fade.inputs["From Max"].default_value = 0.25 * reach, reach
    link(place.outputs["Position"], away.inputs[0])
    link(away.outputs["Value"], fade.inputs["Value"])
    link(fade.outputs["Result"], mix.inputs[0])
    link(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    link(clear.outputs[0], mix.inputs[2])
    link(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    material.blend_method = "BLEND"


def world_light(world):
    """A bright room: pale where the camera sees it, a little bluer as light."""
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    new, link = tree.nodes.new, tree.links.new
    path, mix, out = new("ShaderNodeLightPath"), new("ShaderNodeMixShader"), new("ShaderNodeOutputWorld")
    light, seen = new("ShaderNodeBackground"), new("ShaderNodeBackground")
    light.inputs["Color"].default_value, light.inputs["Strength"].default_value = looks.linear("#dfe8f2"), 0.65
    seen.inputs["Color"].default_value, seen.inputs["Strength"].default_value = looks.linear(BACKDROP), 1.0
    link(path.outputs["Is Camera Ray"], mix.inputs[0])
    link(light.outputs[0], mix.inputs[1])
    link(seen.outputs[0], mix.inputs[2])
    link(mix.outputs[0], out.inputs["Surface"])


def add_sun(collection, name, towards, strength, angle, colour):
    sun = bpy.data.lights.new(name, "SUN")
    sun.energy, sun.angle, sun.color = strength, math.radians(angle), looks.linear(colour)[:3]
    thing = bpy.data.objects.new(name, sun)
    thing.rotation_euler = Vector(towards).to_track_quat("Z", "Y").to_euler()
    collection.objects.link(thing)


def ground_height(source, box):
    """Height of the ground, and whether the run has a flat floor there: the highest still level plate that is wide enough."""
    floors = [b[1][2] for b in source.boxes(0)[source.still]
              if b[1][2] - b[0][2] < 1e-6 and min(b[1][:2] - b[0][:2]) > 0.5 * diagonal(box) and b[1][2] <= box[1][2]]
    return (max(floors), True) if floors else (box[0][2], False)


def add_ground(collection, source, box):
    """A wide ground that fades out, a little below the run's own floor or under everything."""
    height, own = ground_height(source, box)
    radius = 0.5 * diagonal(box)
    center = Vector((*box.mean(axis=0)[:2], height - (0.001 if own else 0.002) * radius))
    mesh = bpy.data.meshes.new("brim ground")
    mesh.from_pydata([(x * 20 * radius, y * 20 * radius, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], [],
                     [(0, 1, 2, 3)])
    material = looks.material_of("brim ground", "#cfd4d7")
    material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.9
    faded(material, center, 18 * radius)
    mesh.materials.append(material)
    ground = bpy.data.objects.new("brim ground", mesh)
    ground.location = center
    collection.objects.link(ground)
    if own:  # the floor itself would show its edge; the ground stands for it
        for thing in bpy.data.objects:
            if thing.get("brim_piece") is None or not source.still[source.piece_body[thing["brim_piece"]]]:
                continue
            if thing.dimensions.z < 1e-6 and abs(thing.matrix_world.translation.z - height) < 1e-6:
                thing.hide_render = True


def set_stage(scene, source, size=None, pose=(AZIMUTH, ELEVATION), frames=None):
    """Sets a scene up for a run. size: picture in pixels; pose: azimuth, elevation [degrees] and maybe distance [m];
    frames: those whose bodies the camera should show, without it the first, the middle and the last."""
    render = scene.render
    if size:
        render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
    scene.frame_start, scene.frame_end = 0, source.frames - 1
    rate = max(1, round(1 / source.frame_time))
    render.fps, render.fps_base = rate, rate * source.frame_time
    render.use_lock_interface = True  # the handler changes meshes; the window must not draw them meanwhile
    scene.view_settings.view_transform = "Standard"

    stage = bpy.data.collections.new("brim stage")
    scene.collection.children.link(stage)
    box = framing(source, frames or sorted({0, (source.frames - 1) // 2, source.frames - 1}))
    camera = bpy.data.cameras.new("brim camera")
    camera.sensor_fit, camera.angle = "VERTICAL", FIELD_OF_VIEW
    radius = max(0.5 * diagonal(box), 1e-6)
    camera.clip_start, camera.clip_end = radius / 200, 200 * radius
    eye = bpy.data.objects.new("brim camera", camera)
    eye.matrix_world = camera_matrix(box, render.resolution_x / render.resolution_y, *pose)
    stage.objects.link(eye)
    scene.camera = eye
    add_sun(stage, "brim key", (-0.62, -0.55, 0.85), 2.6, 8, "#fff2e2")
    add_sun(stage, "brim fill", (0.8, -0.5, 0.35), 0.5, 30, "#dfeaff")
    scene.world = bpy.data.worlds.new("brim world")
    world_light(scene.world)
    add_ground(stage, source, box)
