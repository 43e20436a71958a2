# SPDX-License-Identifier: GPL-3.0-or-later
"""A button that sets up the compositor's Denoise node, so that denoising needs no library of Zraka's own."""

from __future__ import annotations

import bpy

NODE = "Zraka Denoise"
"""Name of the node, by which it is found again."""


class ZRAKA_OT_denoise(bpy.types.Operator):
    """Denoise renders in the compositor, told of surfaces by the Denoising Data passes."""

    bl_idname = "zraka.denoise"
    bl_label = "Denoise in Compositor"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - Blender's own name and type

    @classmethod
    def poll(cls, context):
        """Offer it where there is a view layer."""
        return context.view_layer is not None

    def execute(self, context):
        """Add the nodes, unless they are there."""
        set_up(context.scene, context.view_layer)
        return {"FINISHED"}


def set_up(scene, view_layer):
    """Put a Denoise node between the render layer `view_layer` and what reads its picture.

    Returns
    -------
    bpy.types.Node
        The node; doing it again changes nothing.
    """
    view_layer.zraka.use_pass_denoising = True
    view_layer.update_render_passes()
    tree, output = _tree_of(scene)
    scene.render.use_compositing = True
    layers = _layers_of(tree, scene, view_layer)
    known = tree.nodes.get(f"{NODE} {view_layer.name}")
    if known is not None:
        return known
    node = tree.nodes.new("CompositorNodeDenoise")
    node.name = node.label = f"{NODE} {view_layer.name}"
    node.location = layers.location.x + 300, layers.location.y
    readers = [link.to_socket for link in layers.outputs["Image"].links]
    for name, output_name in (("Image", "Image"), ("Albedo", "Denoising Albedo"), ("Normal", "Denoising Normal")):
        tree.links.new(layers.outputs[output_name], node.inputs[name])
    for socket in readers or ([output] if not output.is_linked else []):
        tree.links.new(node.outputs["Image"], socket)
    return node


def _tree_of(scene):
    """The scene's compositor tree, made where there is none, and the socket that takes its picture."""
    if not hasattr(scene, "compositing_node_group"):  # before 5.0
        scene.use_nodes = True
        tree = scene.node_tree
        node = next((n for n in tree.nodes if n.bl_idname == "CompositorNodeComposite"), None)
        node = node or tree.nodes.new("CompositorNodeComposite")
        return tree, node.inputs["Image"]
    tree = scene.compositing_node_group
    if tree is None:
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Compositor Nodes", "CompositorNodeTree")
    sockets = [item for item in tree.interface.items_tree if getattr(item, "in_out", "") == "OUTPUT"]
    if not sockets:
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    node = next((n for n in tree.nodes if n.bl_idname == "NodeGroupOutput"), None)
    if node is None:
        node = tree.nodes.new("NodeGroupOutput")
        node.location = 600, 0
    return tree, node.inputs[0]


def _layers_of(tree, scene, view_layer):
    """The node that brings in `view_layer`, made where there is none."""
    for node in tree.nodes:
        if node.bl_idname == "CompositorNodeRLayers" and node.layer == view_layer.name and node.scene == scene:
            return node
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene, node.layer = scene, view_layer.name
    return node


def register():
    """Add the operator."""
    bpy.utils.register_class(ZRAKA_OT_denoise)


def unregister():
    """Remove it."""
    bpy.utils.unregister_class(ZRAKA_OT_denoise)
