# SPDX-License-Identifier: GPL-3.0-or-later
"""Give the Cornell box a second view layer, without its boxes, and let both be written into one EXR."""

import bpy

scene = bpy.context.scene
scene.view_layers[0].name = "All"
boxes = bpy.data.collections.new("Boxes")
scene.collection.children.link(boxes)
for name in ("Short box", "Tall box"):
    thing = bpy.data.objects[name]
    for collection in list(thing.users_collection):
        collection.objects.unlink(thing)
    boxes.objects.link(thing)
scene.view_layers.new("Empty").layer_collection.children["Boxes"].exclude = True

image = scene.render.image_settings
if hasattr(image, "media_type"):  # Blender 5
    image.media_type = "MULTI_LAYER_IMAGE"
    image.use_exr_interleave = True
image.file_format = "OPEN_EXR_MULTILAYER"
