"""Materials, and the geometry nodes that give particles and lines their thickness."""

import bpy

FLUIDS = ("particle_fluid", "grid_fluid")
WATER = "#a9d3e6"  # of fluids that let light through


def linear(colour):
    """sRGB as in "#rrggbb" to linear red, green, blue and 1."""
    parts = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts] + [1.0]


def material_of(name, colour, water=False):
    """A material of a colour, slightly glossy; as water it lets light through."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = linear(colour)
    shader = material.node_tree.nodes["Principled BSDF"].inputs
    shader["Base Color"].default_value = linear(colour)
    shader["Roughness"].default_value = 0.05 if water else 0.45
    if water:
        shader["Transmission" if "Transmission" in shader else "Transmission Weight"].default_value = 0.85
        shader["IOR"].default_value = 1.33
        _let_light_through(material.node_tree, linear(colour))
    return material


def _let_light_through(tree, tint):
    """Makes shadows tinted light: what lies under water would be black, since Cycles finds few paths through it to a lamp."""
    path, clear, mix = (tree.nodes.new("ShaderNode" + kind) for kind in ("LightPath", "BsdfTransparent", "MixShader"))
    clear.inputs["Color"].default_value = tint
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def node_group(name, *steps):
    """Geometry nodes in one chain; each step is (type, values of inputs by name, attributes of the node).

    A value may be a function that makes other nodes in the group and returns the socket to take it from.
    """
    group = bpy.data.node_groups.new(name, "GeometryNodeTree")
    if hasattr(group, "interface"):  # Blender 4
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "Geometry")
        group.outputs.new("NodeSocketGeometry", "Geometry")
    output = group.nodes.new("NodeGroupInput").outputs[0]
    for k, (kind, values, attributes) in enumerate(steps):
        node = group.nodes.new(kind)
        node.location = (200 * (k + 1), 0)
        for attribute, value in attributes.items():
            setattr(node, attribute, value)
        for socket, value in values.items():
            for entry in node.inputs:
                if entry.name != socket or not entry.enabled:
                    continue
                if callable(value):
                    group.links.new(value(group), entry)
                else:
                    entry.default_value = value
        group.links.new(output, node.inputs[0])
        output = node.outputs[0]
    end = group.nodes.new("NodeGroupOutput")
    end.location = (200 * (len(steps) + 1), 0)
    group.links.new(output, end.inputs[0])
    return group


def _sphere(radius):
    def make(group):
        ball, smooth = group.nodes.new("GeometryNodeMeshIcoSphere"), group.nodes.new("GeometryNodeSetShadeSmooth")
        ball.location, smooth.location = (-200, -200), (0, -200)
        ball.inputs["Radius"].default_value = radius
        ball.inputs["Subdivisions"].default_value = 3
        group.links.new(ball.outputs["Mesh"], smooth.inputs["Geometry"])
        return smooth.outputs["Geometry"]
    return make


def _circle(radius):
    def make(group):
        circle = group.nodes.new("GeometryNodeCurvePrimitiveCircle")
        circle.location = (0, -200)
        circle.inputs["Resolution"].default_value = 16
        circle.inputs["Radius"].default_value = radius
        return circle.outputs["Curve"]
    return make


def spheres(name, radius, material):
    """Every vertex as a sphere."""
    return node_group(name,
                      ("GeometryNodeMeshToPoints", {}, {}),
                      ("GeometryNodeInstanceOnPoints", {"Instance": _sphere(radius)}, {}),
                      ("GeometryNodeSetMaterial", {"Material": material}, {}))


def tubes(name, radius, material):
    """Every edge as a round tube."""
    return node_group(name,
                      ("GeometryNodeMeshToCurve", {}, {}),
                      ("GeometryNodeCurveToMesh", {"Profile Curve": _circle(radius), "Fill Caps": True}, {}),
                      ("GeometryNodeSetShadeSmooth", {}, {}),
                      ("GeometryNodeSetMaterial", {"Material": material}, {}))


def surface(name, radius, material):
    """A closed surface around the vertices, which lie about two radii apart."""
    voxel, reach = 0.7 * radius, 2.0 * radius
    return node_group(name,
                      ("GeometryNodeMeshToPoints", {"Radius": reach}, {}),
                      ("GeometryNodePointsToVolume", {"Density": 1.0, "Voxel Size": voxel, "Radius": reach},
                       {"resolution_mode": "VOXEL_SIZE"}),
                      ("GeometryNodeVolumeToMesh", {"Voxel Size": voxel, "Threshold": 0.3}, {"resolution_mode": "VOXEL_SIZE"}),
                      ("GeometryNodeSetShadeSmooth", {}, {}),
                      ("GeometryNodeSetMaterial", {"Material": material}, {}))
