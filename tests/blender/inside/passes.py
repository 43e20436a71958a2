# SPDX-License-Identifier: GPL-3.0-or-later
"""Switch on every pass, and two shader AOVs, and let all be written into one EXR."""

import bpy

scene = bpy.context.scene
view_layer = scene.view_layers[0]
for name in dir(view_layer):
    if name.startswith("use_pass_"):
        setattr(view_layer, name, True)
for name, kind in (("Amount", "VALUE"), ("Tint", "COLOR")):
    aov = view_layer.aovs.add()
    aov.name, aov.type = name, kind
for material in bpy.data.materials:
    if material.node_tree:
        node = material.node_tree.nodes.new("ShaderNodeOutputAOV")
        node.aov_name, node.inputs["Value"].default_value = "Amount", 0.25

image = scene.render.image_settings
if hasattr(image, "media_type"):  # Blender 5
    image.media_type = "MULTI_LAYER_IMAGE"
    image.use_exr_interleave = True
image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
