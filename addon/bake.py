# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's bake operator: for each texel it tells a triangle and a place in it, and takes a colour.

Which texels belong to which object, margins, cages, the space of normals and where the picture goes is Blender's.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..core.bake import Bake, Viewer, bake, points_of
from ..core.compile import compile_scene
from ..core.diagnostics import Diagnostics
from ..core.scene import Camera
from ..core.settings import Guides
from . import properties
from .export.cache import ExportCache
from .export.scene import export_scene
from .progress import progress_line
from .session import reported

_PARTS = {
    name.lower(): bpy.types.BakeSettings.bl_rna.properties["pass_filter"].enum_items[name].value
    for name in ("EMIT", "DIRECT", "INDIRECT", "COLOR", "DIFFUSE", "GLOSSY", "TRANSMISSION")
}
_SEEN = {"combined", "diffuse", "glossy", "transmission", "emit"}  # what looks different from elsewhere
_LAYER = "bake"  # Blender wants some name


class Baker:
    """Bakes one object for one call of the operator, picture after picture: the scene is compiled once."""

    def __init__(self):
        self._compiled = self._settings = None
        self._diagnostics = Diagnostics()
        self._said = set()

    def bake(self, engine, depsgraph, obj, pass_type, pass_filter, size):
        """Fill a picture of `size` (width, height) texels; the operator calls once for each image."""
        with reported(engine):
            kind = pass_type.lower()
            if pass_type not in {item[0] for item in properties.BAKES}:
                engine.report({"ERROR"}, f"Zraka does not bake {kind}")
                return
            if self._compiled is None:
                self._compile(engine, depsgraph, kind)
            number = _instance_of(obj, self._compiled.described)
            if number is None:
                engine.report({"WARNING"}, f"object '{obj.name}' is not rendered; nothing was baked on it")
                return
            plan = _plan(depsgraph, kind, pass_filter, self._compiled)
            try:
                self._fill(engine, plan, number, size)
            finally:
                self._warn(engine)

    def _compile(self, engine, depsgraph, kind):
        engine.update_stats("", "Exporting")
        scene = depsgraph.scene_eval
        self._settings = properties.settings_of(
            scene, width=1, height=1, guides=Guides(names=frozenset({"uv"} if kind == "uv" else ()))
        )
        cache = ExportCache()
        cache.follow(depsgraph)
        camera = engine.camera_override or scene.camera
        if camera is None:  # only some nodes ask for it
            camera = Camera(transform=np.eye(4))
        described = export_scene(depsgraph, self._diagnostics, camera, (1, 1), cache=cache)
        engine.update_stats("", "Compiling")
        self._compiled = compile_scene(described, self._settings, self._diagnostics)

    def _fill(self, engine, plan, number, size):
        result = engine.begin_result(0, 0, *size, layer=_LAYER, view="")
        try:
            layer = result.layers[0]
            triangle, u, v, du, dv = _texels(layer)
            points, found = points_of(self._compiled, number, triangle, u, v, du, dv)
            if plan.traces_paths and self._settings.method != "pathtrace":
                self._diagnostics.warn("light is baked by path tracing, whatever the method")

            def on_pass(film, progress):
                engine.update_progress(progress)
                engine.update_stats("", progress_line(film, self._settings))

            values, _ = bake(self._compiled, points, plan, self._settings, on_pass, engine.test_break)
            picture = np.zeros((found.size, 4), np.float32)
            picture[found] = values
            _pass(layer, "Combined").rect.foreach_set(picture.reshape(-1))
        finally:
            engine.end_result(result)

    def _warn(self, engine):
        for message in self._diagnostics.messages():
            if message not in self._said:
                self._said.add(message)
                engine.report({"WARNING"}, message)


def _plan(depsgraph, kind, pass_filter, compiled):
    """`core.bake.Bake` of the operator's arguments and the scene's bake settings."""
    scene = depsgraph.scene_eval
    world = getattr(depsgraph.view_layer_eval, "world_override", None) or scene.world
    from_camera = scene.camera is not None and scene.render.bake.view_from == "ACTIVE_CAMERA" and kind in _SEEN
    return Bake(
        kind,
        parts=frozenset(name for name, bit in _PARTS.items() if pass_filter & bit),
        distance=world.light_settings.distance if world is not None else Bake.distance,
        view=Viewer.of(compiled.described.camera, compiled.geometry.origin) if from_camera else None,
    )


def _instance_of(obj, described):
    """Number of the instance that `obj` is itself, not one that others make of it; None where there is none."""
    own = np.array(obj.matrix_world, np.float64)
    apart = [
        (np.abs(x.transform - own).max(), number) for number, x in enumerate(described.instances) if x.name == obj.name
    ]
    return min(apart)[1] if apart else None


def _texels(layer):
    """Of each texel its triangle (P,) in the object's mesh, -1 without one, and `u`, `v`, `du`, `dv` of `BakePoints`.

    Blender's two numbers belong to the first and the second corner, Zraka's to the second and the third.
    """
    primitive, change = _read(layer, "BakePrimitive"), _read(layer, "BakeDifferential")
    # Before Blender 4.5 a seed and the triangle came first; both are integers in the place of numbers.
    triangle, first = (primitive[2], 0) if len(primitive) == 3 else (primitive[1], 2)
    triangle = triangle.view(np.int32)
    # Where there is no triangle Blender leaves what was in its memory.
    numbers = np.where(triangle >= 0, [*primitive[first : first + 2], *change[:4]], np.float32(0))
    (a, b), da, db = numbers[:2], numbers[2:4], numbers[4:]
    return triangle, b, 1 - a - b, db, -da - db


def _read(layer, name):
    """Channels (C, P) float32 of a pass, each contiguous."""
    source = _pass(layer, name)
    values = np.zeros(len(source.rect) * source.channels, np.float32)
    source.rect.foreach_get(values)
    return np.ascontiguousarray(values.reshape(-1, source.channels).T)


def _pass(layer, name):
    return next(p for p in layer.passes if p.name == name)
