# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees to flat graphs."""

from __future__ import annotations

import warnings

import bpy
import pytest

from zraka.addon.export.material import export_material
from zraka.core.diagnostics import Diagnostics
from zraka.core.scene import Link

RED = (0.9, 0.3, 0.0, 1.0)


@pytest.fixture(autouse=True)
def fresh_file():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


class Tree:
    """A material with an output, and short words to build its graph."""

    def __init__(self, name="Test"):
        self.material = bpy.data.materials.new(name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.surface = self.output.inputs["Surface"]
        self.diagnostics = Diagnostics()

    def add(self, name, tree=None):
        return (tree or self.tree).nodes.new(name)

    def link(self, source, target, tree=None):
        return (tree or self.tree).links.new(source, target)

    def rgb(self, color=RED):
        node = self.add("ShaderNodeRGB")
        node.outputs[0].default_value = color
        return node.outputs[0]

    def emission(self):
        node = self.add("ShaderNodeEmission")
        self.link(node.outputs[0], self.surface)
        return node

    def export(self):
        return export_material(self.material, lambda image, user: image.name, self.diagnostics)

    def root(self):
        material = self.export()
        return material.nodes[material.surface]


def new_group(*sockets):
    """A node group with (name, direction, type) sockets; its tree, input and output node."""
    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    for name, direction, kind in sockets:
        group.interface.new_socket(name, in_out=direction, socket_type=f"NodeSocket{kind}")
    return group, group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")


def close(color):
    return pytest.approx(color, rel=1e-6)


def test_principled_by_the_cores_names():
    t = Tree()
    node = t.add("ShaderNodeBsdfPrincipled")
    node.distribution = "GGX"
    node.inputs["Base Color"].default_value = RED
    t.link(node.outputs[0], t.surface)
    root = t.root()
    assert root.op == "principled"
    assert root.properties["distribution"] == "GGX"
    assert root.inputs["base_color"] == close(RED[:3])
    names = (
        "metallic roughness ior alpha specular_ior_level specular_tint transmission_weight emission_color "
        "emission_strength coat_weight coat_roughness coat_ior coat_tint sheen_weight sheen_roughness sheen_tint "
        "subsurface_weight subsurface_radius subsurface_scale anisotropic anisotropic_rotation thin_film_thickness"
    ).split()
    assert set(names) <= set(root.inputs)
    assert not {"normal", "tangent", "coat_normal", "weight"} & set(root.inputs)


CLOSURES = {
    "ShaderNodeBsdfDiffuse": ("diffuse", {"color", "roughness"}),
    "ShaderNodeBsdfAnisotropic": ("glossy", {"color", "roughness", "anisotropy", "rotation"}),
    "ShaderNodeBsdfGlossy": ("glossy", {"color", "roughness", "anisotropy", "rotation"}),
    "ShaderNodeBsdfGlass": ("glass", {"color", "roughness", "ior"}),
    "ShaderNodeBsdfRefraction": ("refraction", {"color", "roughness", "ior"}),
    "ShaderNodeBsdfTranslucent": ("translucent", {"color"}),
    "ShaderNodeBsdfTransparent": ("transparent", {"color"}),
    "ShaderNodeEmission": ("emission", {"color", "strength"}),
    "ShaderNodeHoldout": ("holdout", set()),
}


@pytest.mark.parametrize("name", CLOSURES)
def test_closures(name):
    t = Tree()
    t.link(t.add(name).outputs[0], t.surface)
    root = t.root()
    op, inputs = CLOSURES[name]
    assert root.op == op
    assert inputs <= set(root.inputs)


def test_mix_and_add_shaders():
    t = Tree()
    mix, add, a, b = (t.add(f"ShaderNode{n}") for n in ("MixShader", "AddShader", "BsdfDiffuse", "Emission"))
    mix.inputs[0].default_value = 0.25
    t.link(a.outputs[0], mix.inputs[1])
    t.link(add.outputs[0], mix.inputs[2])
    t.link(a.outputs[0], add.inputs[0])
    t.link(b.outputs[0], add.inputs[1])
    t.link(mix.outputs[0], t.surface)
    material = t.export()
    root = material.nodes[material.surface]
    assert root.op == "mix_shader"
    assert root.inputs["fac"] == 0.25
    assert material.nodes[root.inputs["a"].node].op == "diffuse"
    added = material.nodes[root.inputs["b"].node]
    assert added.op == "add_shader"
    assert added.inputs["a"] == root.inputs["a"]  # a shared node is written once
    assert added.inputs["b"].output == "bsdf"
    assert len(material.nodes) == 4
    for number, node in enumerate(material.nodes):  # each after those that it reads
        assert all(v.node < number for v in node.inputs.values() if isinstance(v, Link))


def test_image_and_uv_map():
    t = Tree()
    image, uv, emission = t.add("ShaderNodeTexImage"), t.add("ShaderNodeUVMap"), t.emission()
    image.image = bpy.data.images.new("Picture", 2, 2)
    image.interpolation, image.extension = "Closest", "CLIP"
    uv.uv_map = "Second"
    t.link(uv.outputs[0], image.inputs["Vector"])
    t.link(image.outputs["Color"], emission.inputs["Color"])
    t.link(image.outputs["Alpha"], emission.inputs["Strength"])
    material = t.export()
    root = material.nodes[material.surface]
    texture = material.nodes[root.inputs["color"].node]
    assert root.inputs["color"].output == "color"
    assert root.inputs["strength"] == Link(root.inputs["color"].node, "alpha")
    assert texture.properties == {
        "image": "Picture",
        "interpolation": "Closest",
        "projection": "FLAT",
        "projection_blend": 0.0,
        "extension": "CLIP",
    }
    coordinates = texture.inputs["vector"]
    assert coordinates.output == "uv"
    assert material.nodes[coordinates.node].properties["uv_map"] == "Second"
    image.texture_mapping.scale = (2, 3, 4)
    material = t.export()
    texture = next(node for node in material.nodes if node.op == "image")
    mapping = material.nodes[texture.inputs["vector"].node]
    assert mapping.op == "texture_mapping"
    assert [mapping.inputs[axis] for axis in "xyz"] == [(2, 0, 0), (0, 3, 0), (0, 0, 4)]
    assert material.nodes[mapping.inputs["vector"].node].properties["uv_map"] == "Second"
    assert t.diagnostics.messages() == []


def test_checker_and_coordinates():
    t = Tree()
    checker, coordinates, emission = t.add("ShaderNodeTexChecker"), t.add("ShaderNodeTexCoord"), t.emission()
    t.link(coordinates.outputs["Generated"], checker.inputs["Vector"])
    t.link(checker.outputs["Fac"], emission.inputs["Strength"])
    material = t.export()
    strength = material.nodes[material.surface].inputs["strength"]
    assert strength.output == "fac"
    node = material.nodes[strength.node]
    assert node.op == "checker"
    assert set(node.inputs) == {"vector", "color1", "color2", "scale"}
    assert node.inputs["vector"].output == "generated"
    assert t.diagnostics.messages() == []
    coordinates.object = bpy.data.objects.new("Empty", None)
    (found,) = (n for n in t.export().nodes if n.op == "tex_coord")
    assert sum(found.properties["matrix"]) == 4 and t.diagnostics.messages() == []


def test_nested_groups_reroutes_and_constants():
    inner, inner_in, inner_out = new_group(("Tint", "INPUT", "Color"), ("Shader", "OUTPUT", "Shader"))
    diffuse = inner.nodes.new("ShaderNodeBsdfDiffuse")
    inner.links.new(inner_in.outputs["Tint"], diffuse.inputs["Color"])
    inner.links.new(diffuse.outputs[0], inner_out.inputs["Shader"])
    outer, outer_in, outer_out = new_group(("Paint", "INPUT", "Color"), ("Shader", "OUTPUT", "Shader"))
    node = outer.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    outer.links.new(outer_in.outputs["Paint"], node.inputs["Tint"])
    outer.links.new(node.outputs[0], outer_out.inputs["Shader"])

    t = Tree()
    frame, reroute, mix = t.add("NodeFrame"), t.add("NodeReroute"), t.add("ShaderNodeMixShader")
    first, second = t.add("ShaderNodeGroup"), t.add("ShaderNodeGroup")
    first.node_tree = second.node_tree = outer
    first.parent = frame
    t.link(t.rgb(), reroute.inputs[0])
    t.link(reroute.outputs[0], first.inputs["Paint"])
    second.inputs["Paint"].default_value = (0.1, 0.2, 0.3, 1)
    t.link(first.outputs[0], mix.inputs[1])
    t.link(second.outputs[0], mix.inputs[2])
    t.link(mix.outputs[0], t.surface)
    material = t.export()
    root = material.nodes[material.surface]
    a, b = (material.nodes[root.inputs[name].node] for name in "ab")
    assert (a.op, b.op) == ("diffuse", "diffuse")
    assert a.inputs["color"] == close(RED[:3])
    assert b.inputs["color"] == close((0.1, 0.2, 0.3))  # the same tree, read once more for another group node
    assert len(material.nodes) == 3
    assert t.diagnostics.messages() == []


def test_a_group_output_without_link_shows_its_own_value():
    group, _, group_out = new_group(("Level", "OUTPUT", "Float"))
    group_out.inputs["Level"].default_value = 0.75
    t = Tree()
    node, emission = t.add("ShaderNodeGroup"), t.emission()
    node.node_tree = group
    t.link(node.outputs[0], emission.inputs["Strength"])
    assert t.root().inputs["strength"] == 0.75


def test_muted_nodes_pass_on_or_vanish():
    t = Tree()
    emission, gamma = t.emission(), t.add("ShaderNodeGamma")
    emission.inputs["Color"].default_value = (0, 0, 0.25, 1)
    gamma.inputs["Color"].default_value = (1, 1, 1, 1)
    t.link(gamma.outputs[0], emission.inputs["Color"])
    gamma.mute = True
    # Blender removes a link from a muted node whose own input is unlinked (Cycles renders 0, 0, 0.25 here).
    assert t.root().inputs["color"] == (0, 0, 0.25)
    t.link(t.rgb(), gamma.inputs["Color"])
    assert t.root().inputs["color"] == close(RED[:3])
    gamma.mute = False
    assert [n.op for n in t.export().nodes] == ["gamma", "emission"]


def test_muted_links_and_loose_reroutes_do_not_count():
    t = Tree()
    emission, reroute = t.emission(), t.add("NodeReroute")
    emission.inputs["Color"].default_value = (0, 0, 0.25, 1)
    t.link(t.rgb(), emission.inputs["Color"]).is_muted = True
    assert t.root().inputs["color"] == (0, 0, 0.25)
    t.link(reroute.outputs[0], emission.inputs["Color"])
    assert t.root().inputs["color"] == (0, 0, 0.25)


def test_conversions_of_constants():
    t = Tree()
    emission = t.emission()
    t.link(t.rgb(), emission.inputs["Strength"])
    assert t.root().inputs["strength"] == pytest.approx(0.2126 * 0.9 + 0.7152 * 0.3)
    value = t.add("ShaderNodeValue")
    value.outputs[0].default_value = 2.5
    t.link(value.outputs[0], emission.inputs["Color"])
    assert t.root().inputs["color"] == (2.5, 2.5, 2.5)


def through_a_grey_socket(kind):
    """A material whose colour enters a group as a number, and the link that arrives in its emission."""
    group, group_in, group_out = new_group(("Grey", "INPUT", "Float"), ("Color", "OUTPUT", "Color"))
    group.links.new(group_in.outputs["Grey"], group_out.inputs["Color"])
    t = Tree()
    node, emission, source = t.add("ShaderNodeGroup"), t.emission(), t.add(kind)
    node.node_tree = group
    t.link(source.outputs["Color"], node.inputs["Grey"])
    t.link(node.outputs[0], emission.inputs["Color"])
    material = t.export()
    return material, material.nodes[material.surface].inputs["color"]


def test_conversion_on_the_way_through_a_group_counts():
    material, color = through_a_grey_socket("ShaderNodeGamma")
    to_color = material.nodes[color.node]
    assert (to_color.op, to_color.properties) == ("convert", {"from": "float", "to": "color"})
    to_float = material.nodes[to_color.inputs["value"].node]
    assert (to_float.op, to_float.properties) == ("convert", {"from": "color", "to": "float"})
    assert material.nodes[to_float.inputs["value"].node].op == "gamma"


def test_a_value_as_surface_glows():
    t = Tree()
    t.link(t.rgb(), t.surface)
    root = t.root()
    assert root.op == "emission"
    assert root.inputs == {"color": close(RED[:3])}
    checker = t.add("ShaderNodeTexChecker")
    t.link(checker.outputs["Fac"], t.surface)
    assert t.root().inputs["strength"].output == "fac"


def test_a_closure_is_no_value():
    t = Tree()
    emission, other = t.emission(), t.add("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0, 0, 0.25, 1)
    t.link(other.outputs[0], emission.inputs["Color"])
    assert t.root().inputs["color"] == (0, 0, 0.25)


def test_unknown_nodes_are_named():
    t = Tree()
    unknown, emission = t.add("ShaderNodeShaderToRGB"), t.emission()
    t.link(unknown.outputs["Color"], emission.inputs["Color"])
    node = t.export().nodes[0]
    assert node.op == "unsupported"
    assert node.properties["label"] == "Shader to RGB"
    assert node.properties["type"] == "ShaderNodeShaderToRGB"
    assert node.properties["outputs"]["color"] == "color"


def test_loops_are_cut_and_said():
    t = Tree()
    a, b = t.add("ShaderNodeAddShader"), t.add("ShaderNodeAddShader")
    t.link(a.outputs[0], b.inputs[0])
    t.link(b.outputs[0], a.inputs[0])
    t.link(a.outputs[0], t.surface)
    material = t.export()
    assert [n.op for n in material.nodes] == ["add_shader", "add_shader"]
    assert "a" not in material.nodes[0].inputs
    assert "loop" in t.diagnostics.messages()[0]


def test_loops_of_reroutes_are_cut():
    t = Tree()
    a, b = t.add("NodeReroute"), t.add("NodeReroute")
    t.link(a.outputs[0], b.inputs[0])
    t.link(b.outputs[0], a.inputs[0])
    t.link(a.outputs[0], t.surface)
    assert t.export().surface is None
    assert "loop" in t.diagnostics.messages()[0]


def test_two_thousand_nodes_deep():
    # A group of two groups of two groups ...: building a flat chain through bpy takes half a minute.
    group = None
    for _ in range(12):
        inner, (group, start, end) = group, new_group(("In", "INPUT", "Shader"), ("Out", "OUTPUT", "Shader"))
        output = start.outputs["In"]
        for _ in range(2 if inner else 1):
            node = group.nodes.new("ShaderNodeGroup" if inner else "ShaderNodeAddShader")
            if inner:
                node.node_tree = inner
            group.links.new(output, node.inputs[0])
            output = node.outputs[0]
        group.links.new(output, end.inputs["Out"])
    t = Tree()
    node = t.add("ShaderNodeGroup")
    node.node_tree = group
    t.link(t.add("ShaderNodeBsdfDiffuse").outputs[0], node.inputs["In"])
    t.link(node.outputs["Out"], t.surface)
    material = t.export()
    assert [n.op for n in material.nodes] == ["diffuse"] + ["add_shader"] * 2048
    assert all(node.inputs["a"] == Link(number, "bsdf") for number, node in enumerate(material.nodes[1:]))


def test_outputs():
    t = Tree()
    t.link(t.add("ShaderNodeBsdfDiffuse").outputs[0], t.surface)
    second = t.add("ShaderNodeOutputMaterial")
    t.link(t.add("ShaderNodeEmission").outputs[0], second.inputs["Surface"])
    t.output.is_active_output = False
    second.is_active_output = True
    assert t.root().op == "emission"
    t.output.is_active_output = True
    assert t.root().op == "diffuse"
    displacement = t.add("ShaderNodeDisplacement")
    t.link(displacement.outputs[0], t.output.inputs["Displacement"])
    exported = t.export()
    assert exported.nodes[exported.displacement.node].op == "displacement" and t.diagnostics.messages() == []
    t.material.displacement_method = "BOTH"
    t.export()
    assert "true displacement is not rendered yet" in t.diagnostics.messages()[0]
    t.tree.nodes.clear()
    assert t.export().surface is None


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="materials always have nodes since 5.0")
def test_a_material_without_nodes_has_its_viewport_colour():
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = RED
    exported = export_material(material, None, Diagnostics())
    assert exported.nodes[0].op == "diffuse"
    assert exported.nodes[0].inputs["color"] == close(RED[:3])
