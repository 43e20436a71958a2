# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender without a window: open a file, export its scene, write a picture.

Blender is imported by `load_blender`, not before, so that the command line refuses wrong arguments without it.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import signal
import sys
import threading
from pathlib import Path

import numpy as np

from ..core.diagnostics import SceneError

FORMATS = {".png": "PNG", ".exr": "OPEN_EXR"}


def load_blender():
    """Import Blender and add Zraka to it.

    Raises
    ------
    SceneError
        Where it is not installed.
    """
    try:
        with _ctrl_c_held_back(), quiet():
            import bpy
    except ImportError as error:
        raise SceneError(f"Blender's Python module is missing ({error}); pip install 'zraka[blender]'") from error
    from . import register

    register()
    return bpy


def open_scene(bpy, args):
    """Open the file and make the scene what the arguments say.

    Raises
    ------
    SceneError
    """
    try:
        with quiet():
            bpy.ops.wm.open_mainfile(filepath=str(args.file.absolute()), load_ui=False)
    except RuntimeError as error:
        raise SceneError(f"{args.file} cannot be opened: {_one_line(error)}") from error
    scene = bpy.context.scene
    if args.frame is not None:
        scene.frame_set(args.frame)
    if args.camera is not None:
        camera = scene.objects.get(args.camera)
        if camera is None or camera.type != "CAMERA":
            names = ", ".join(o.name for o in scene.objects if o.type == "CAMERA") or "none"
            raise SceneError(f"{args.file} has no camera named {args.camera!r}; its cameras: {names}")
        scene.camera = camera
        for marker in scene.timeline_markers:
            marker.camera = None  # Blender would turn back to the camera of the frame's marker.
    if scene.camera is None:
        raise SceneError(f"{args.file} has no camera; set one in the scene or name one with --camera")
    return scene


def export(bpy, scene, args):
    """Export by way of an engine that does nothing else: only an engine is given what is seen in renders.

    Tracing then happens outside of Blender's render operator, where Ctrl-C is ours.
    """
    from . import takeover
    from .engine import ZrakaRenderEngine

    chosen = {name: getattr(args, name) for name in ("method", "samples", "depth", "threads", "seed", "time_limit")}
    said = takeover.first_use(scene)
    layers = [layer.name for layer in scene.view_layers if layer.use] or [scene.view_layers[0].name]
    composited = scene.render.use_compositing and _has_compositing(scene)
    drawn = scene.render.use_freestyle
    scene.render.use_compositing = scene.render.use_sequencer = False
    try:
        with quiet():
            job = export_layer(bpy, scene, layers[0], size=args.size, **chosen)
    finally:
        scene.render.engine = ZrakaRenderEngine.bl_idname
    if said:
        job.diagnostics.warn(said)
    if scene.render.use_multiview:
        job.diagnostics.warn("the command line renders the view of the one camera, no stereo views")
    if len(layers) > 1:
        job.diagnostics.warn(f"the command line renders the view layer {layers[0]!r} only")
    if drawn:
        job.diagnostics.warn("the command line does not draw Freestyle's lines")
    if composited:
        job.diagnostics.warn("the command line does not run the compositor")
    return job


def export_layer(bpy, scene, layer, **chosen):
    """Export a view layer as it is seen in renders; the scene's engine is another one meanwhile.

    Parameters
    ----------
    bpy : module
    scene : bpy.types.Scene
    layer : str
        Name of the view layer.
    **chosen
        As of `session.export_job`.

    Returns
    -------
    session.Job

    Raises
    ------
    SceneError
    """
    from . import session

    outcome = []

    class ExportEngine(bpy.types.RenderEngine):
        bl_idname = "ZRAKA_EXPORT"
        bl_label = "Zraka's export"

        def update(self, data, depsgraph):
            try:
                outcome.append(session.export_job(depsgraph, frame_set=self.frame_set, **chosen))
            except BaseException as error:
                outcome.append(error)  # Blender would swallow it.

        def render(self, depsgraph):
            """Without this method Blender does not call `update`."""

    render = scene.render
    before = render.engine, render.use_compositing, render.use_sequencer, render.use_freestyle
    bpy.utils.register_class(ExportEngine)
    try:
        render.engine, render.use_compositing, render.use_sequencer = ExportEngine.bl_idname, False, False
        render.use_freestyle = False  # over a picture that is not there, Blender crashes
        bpy.ops.render.render(scene=scene.name, layer=layer)
    except RuntimeError as error:
        raise SceneError(_one_line(error)) from error
    finally:
        render.engine, render.use_compositing, render.use_sequencer, render.use_freestyle = before
        bpy.utils.unregister_class(ExportEngine)
    if not outcome:
        raise SceneError("Blender rendered nothing; look at the scene's size, border and view layers")
    if isinstance(outcome[0], BaseException):
        raise outcome[0]
    return outcome[0]


def _has_compositing(scene):
    """Tell whether the scene has compositor nodes; Blender 5 keeps them elsewhere."""
    if hasattr(scene, "compositing_node_group"):
        return scene.compositing_node_group is not None
    return scene.use_nodes


def scene_output(scene):
    """Where the scene itself would write, as a format of ours."""
    path = Path(scene.render.frame_path(frame=scene.frame_current))
    return path.with_suffix(".exr" if "EXR" in scene.render.image_settings.file_format else ".png")


def framed(image, settings, crop):
    """Put a border's picture into the whole frame, black and transparent around it, unless it is to be cropped."""
    if crop or settings.border is None:
        return image
    x0, y0, x1, y1 = settings.border
    frame = np.zeros((settings.height, settings.width, 4), np.float32)
    frame[y0:y1, x0:x1] = image
    return frame


def write_picture(bpy, scene, picture, path):
    """Save (H, W, 4) linear colours through Blender: EXR as they are, PNG through the scene's view transform."""
    height, width = picture.shape[:2]
    image = bpy.data.images.new("Zraka", width, height, alpha=True, float_buffer=True)
    image.pixels.foreach_set(np.ascontiguousarray(picture, np.float32).reshape(-1))
    kind = scene.render.image_settings
    if hasattr(kind, "media_type"):  # Blender 5
        kind.media_type = "IMAGE"
    kind.file_format = FORMATS[path.suffix.lower()]
    kind.color_mode = "RGBA"
    kind.color_depth = "32" if kind.file_format == "OPEN_EXR" else "8"
    try:
        with quiet():
            image.save_render(str(path), scene=scene)
            scarce = shutil.disk_usage(path.parent).free < picture.nbytes
    except (RuntimeError, OSError) as error:
        raise SceneError(f"{path} cannot be written: {_one_line(error)}") from error
    finally:
        bpy.data.images.remove(image)
    if scarce and not is_whole(path):
        raise SceneError(f"{path} cannot be written whole; is the disk full?")


def is_whole(path):
    """Tell whether a picture can be read again: what fails at the very end of writing, neither Blender nor OIIO tells.

    Blender itself crashes where it reads an EXR cut short. Without OIIO only an empty file is found.
    """
    try:
        import OpenImageIO as oiio
    except ImportError:
        return path.stat().st_size > 0
    image = oiio.ImageBuf(str(path))
    whole = image.read(force=True)
    image.geterror()  # else OIIO prints it
    return whole


@contextlib.contextmanager
def _ctrl_c_held_back():
    """Let Ctrl-C take effect afterwards only: Blender crashes where its start is interrupted."""
    if "bpy" in sys.modules or threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed = []
    before = signal.signal(signal.SIGINT, lambda *_: pressed.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before or signal.SIG_DFL)
    if pressed:
        signal.raise_signal(signal.SIGINT)


@contextlib.contextmanager
def quiet():
    """Keep Blender's own messages off the standard output; it prints through Python and through C."""
    libc = ctypes.CDLL(None if os.name == "posix" else "ucrtbase")
    sys.stdout.flush()
    kept = os.dup(1)
    with open(os.devnull, "w") as null, contextlib.redirect_stdout(null):
        os.dup2(null.fileno(), 1)
        try:
            yield
        finally:
            libc.fflush(None)
            os.dup2(kept, 1)
            os.close(kept)


def _one_line(error):
    return " ".join(str(error).removeprefix("Error: ").split())
