# SPDX-License-Identifier: GPL-3.0-or-later
"""The views of a stereo or multi-view render, and what each looks through."""

from __future__ import annotations

from ..core.diagnostics import Diagnostics


def view_names(scene):
    """Names of the views that are rendered, [] where *Stereoscopy* is off."""
    render = scene.render
    if not render.use_multiview:
        return []
    views = render.stereo_views if render.views_format == "STEREO_3D" else render.views
    return [view.name for view in views if view.use]


def view_camera(engine, depsgraph, name, diagnostics):
    """The `core.scene.Camera` of a view.

    Blender moves the camera by half the interocular distance and shifts its window so that both windows meet in the
    plane of convergence; where each view has a camera of its own, `camera_override` is that one.
    """
    from .export.camera import export_camera

    engine.active_view_set(name)
    camera = engine.camera_override
    if engine.use_spherical_stereo(camera):
        diagnostics.warn("spherical stereo is not rendered; each eye sees from one point", f"camera '{camera.name}'")
    eye = engine.camera_model_matrix(camera), engine.camera_shift_x(camera)
    # What else there is to say of the camera was said when the scene was exported.
    return export_camera(depsgraph, Diagnostics(), camera=camera, eye=eye)
