# SPDX-License-Identifier: GPL-3.0-or-later
"""One node in Zraka beside the same node in Cycles: a plane that emits what a socket says.

The plane fills the picture of an orthographic camera; both engines look through the pixels' centres, so there is no
noise and any difference is the node's.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

import zraka
from zraka.addon.bench.engines import match, operate, watched

SIZE = 64


@dataclass(frozen=True)
class Case:
    """A node in one of its modes.

    Parameters
    ----------
    name : str
        ``"Node: mode"``; what stands before the colon groups cases in docs/nodes.md.
    build : callable
        ``build(tree, obj)`` adds nodes to an otherwise empty material tree of the plane `obj` and returns the output
        socket that is compared. It may also change the object, and `bpy.context.scene`, which is made anew for the
        next case.
    tolerance : float
        Largest absolute difference of a channel.
    share : float
        Share of pixels that may differ by more, e.g. at the edges of cells.
    known : tuple of str
        Parts of the warnings that the case may give; any other fails it.
    settings : mapping
        Of `scene.zraka` and `scene.cycles`, where both are to differ from the harness's.
    """

    name: str
    build: Callable
    tolerance: float = 1e-3
    share: float = 0.0
    known: tuple[str, ...] = ()
    settings: dict = field(default_factory=dict)

    @property
    def node(self):
        """The node's name."""
        return self.name.partition(":")[0]


def difference(case):
    """How far Zraka is from Cycles.

    Returns
    -------
    largest : float
        Largest absolute difference of a pixel's channels; inf where only one of the engines gives a number.
    share : float
        Share of pixels beyond the case's tolerance.
    """
    ours, theirs = pictures(case)
    return compare(ours, theirs, case.tolerance)


def compare(ours, theirs, tolerance):
    """(Largest difference, share of pixels beyond the tolerance) of two pictures."""
    finite = np.isfinite(ours) & np.isfinite(theirs)
    apart = np.where(finite, np.abs(np.where(finite, ours, 0.0) - np.where(finite, theirs, 0.0)), np.inf)
    apart[~np.isfinite(ours) & ~np.isfinite(theirs)] = 0
    worst = apart.max(axis=-1)
    return float(worst.max()), float((worst > tolerance).mean())


def pictures(case):
    """The case as Zraka and as Cycles render it, two (SIZE, SIZE, 3).

    Raises
    ------
    AssertionError
        Where Zraka says that it does not honour something that the case does not know of.
    """
    scene = fresh_scene()
    plane = add_plane(scene)
    show(plane, case.build)
    for name, value in case.settings.items():
        setattr(scene.zraka if hasattr(scene.zraka, name) else scene.cycles, name, value)
    with watched() as seen:
        ours, _ = operate(scene, "ZRAKA")
    unknown = [m for m in seen.messages if not any(part in m for part in case.known)]
    assert not unknown, f"{case.name}: {unknown}"
    theirs, _ = operate(scene, "CYCLES")
    return ours, theirs


def fresh_scene():
    """An empty scene with a camera that looks down at the square between (-1, -1) and (1, 1)."""
    zraka.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE
    render.threads_mode, render.threads = "FIXED", 1
    scene.view_settings.view_transform = "Raw"
    scene.zraka.samples = 1
    match(scene)
    scene.zraka.method = "RAYCAST"  # whose first sample is in the pixel's centre
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z, camera.data.type, camera.data.ortho_scale = 3.0, "ORTHO", 2.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene


def add_plane(scene):
    """The plane, from (-1, -1, 0) to (1, 1, 0), with UV coordinates from (0, 0) to (1, 1)."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(x, y, 0) for x, y in corners], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    for corner, (x, y) in zip(layer.uv, corners, strict=True):
        corner.vector = (x + 1) / 2, (y + 1) / 2
    plane = bpy.data.objects.new("Plane", mesh)
    scene.collection.objects.link(plane)
    return plane


def show(plane, build):
    """Make the plane emit what `build` returns."""
    material = bpy.data.materials.new("Nodes")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    plane.data.materials.append(material)
    socket = build(tree, plane)
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(socket, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])


# -- words to build cases with -----------------------------------------------------------------------------------------


def add(tree, kind, inputs=None, **properties):
    """A node ``ShaderNode<kind>`` with properties set first, then `inputs`.

    Parameters
    ----------
    inputs : mapping
        Name, identifier or number of an enabled input socket to a constant, or to the output socket that is linked to
        it. A number counts the enabled ones only, as the user sees them.
    """
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in properties.items():
        setattr(node, name, value)
    shown = [s for s in node.inputs if s.enabled]
    for key, value in (inputs or {}).items():
        socket = _find(shown, key)
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def output(node, key=0):
    """The enabled output socket of a node, by number or name."""
    return _find([s for s in node.outputs if s.enabled], key)


def _find(sockets, key):
    if isinstance(key, int):
        return sockets[key]
    found = [s for s in sockets if key in (s.name, s.identifier)]
    assert found, f"no socket {key!r} among {[s.name for s in sockets]}"
    return found[0]


def coordinates(tree, scale=(1.0, 1.0, 1.0), location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0)):
    """UV coordinates, mapped: a vector that varies over the picture. A rotation makes the third number vary too."""
    uv = add(tree, "UVMap")
    mapped = add(tree, "Mapping", {"Vector": output(uv), "Location": location, "Rotation": rotation, "Scale": scale})
    return output(mapped)


def signed(tree, socket, scale=0.25, shift=0.5):
    """`socket` times `scale` plus `shift`, so that negative values are seen and large ones stay comparable."""
    mapped = add(tree, "Mapping", {"Vector": socket, "Location": (shift,) * 3, "Scale": (scale,) * 3})
    return output(mapped)
