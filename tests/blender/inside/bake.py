# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the floor of the Cornell box and write what came out."""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

SIDE = 32


def baked(obj, kind, **options):
    """Pixels (H, W, 4) of a picture that one bake filled."""
    picture = bpy.data.images.new(kind, SIDE, SIDE, alpha=True, float_buffer=True)
    tree = obj.active_material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, tree.nodes.active = picture, node
    bpy.ops.object.bake(type=kind, margin=0, **options)
    tree.nodes.remove(node)
    return np.array(picture.pixels[:]).reshape(SIDE, SIDE, 4)


scene = bpy.context.scene
scene.render.engine = "ZRAKA"
scene.zraka.samples = 64
for other in bpy.context.selected_objects:
    other.select_set(False)
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.2)
ball = bpy.context.object
ball.matrix_world = bpy.data.objects["Tall box"].matrix_world
bpy.data.objects["Tall box"].hide_render = True
ball.data.materials.append(bpy.data.objects["Tall box"].active_material.copy())
pictures = {
    "normal": baked(ball, "NORMAL", normal_space="OBJECT"),
    "color": baked(ball, "DIFFUSE", pass_filter={"COLOR"}),
    "light": baked(ball, "COMBINED"),
    "occlusion": baked(ball, "AO"),
}
covered = pictures["color"][..., 3] > 0
found = {name: picture[covered][:, :3].mean(axis=0).tolist() for name, picture in pictures.items()}
found["covered"] = float(covered.mean())
n = 2 * pictures["normal"][covered][:, :3] - 1
found["length"] = [float(np.linalg.norm(n, axis=1).min()), float(np.linalg.norm(n, axis=1).max())]
Path(sys.argv[sys.argv.index("--") + 1]).write_text(json.dumps(found), encoding="utf-8")
