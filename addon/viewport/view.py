# SPDX-License-Identifier: GPL-3.0-or-later
"""What a region of a 3D viewport looks at."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from ...core.camera_description import Panorama, ThinLens
from ...core.diagnostics import Diagnostics
from ...core.scene import Camera
from ..export.camera import camera_window, export_camera, frame_size


@dataclass(frozen=True)
class View:
    """A camera and a region of pixels; equal views show the same.

    `transform` is the camera's matrix, row by row; `window` what the whole region spans (see `core.scene.Camera`);
    `border` the pixels (x0, y0, x1, y1) that are wanted, all when None, none of them when x0 = x1 or y0 = y1.
    """

    transform: tuple[float, ...]
    window: tuple[float, float, float, float]
    projection: str
    clip_start: float
    clip_end: float
    width: int
    height: int
    border: tuple[int, int, int, int] | None = None
    lens: ThinLens | None = None
    panorama: Panorama = field(default_factory=Panorama)

    @property
    def is_empty(self):
        """Whether no pixel is wanted."""
        x0, y0, x1, y1 = self.border or (0, 0, self.width, self.height)
        return x0 >= x1 or y0 >= y1

    def camera(self, divider=1):
        """The `core.scene.Camera` of pixels that are `divider` pixels wide; the last ones may reach over the edge."""
        left, right, bottom, top = self.window
        width, height = self.size(divider)
        right = left + (right - left) * width * divider / self.width
        top = bottom + (top - bottom) * height * divider / self.height
        transform = np.array(self.transform, np.float64).reshape(4, 4)
        window = left, right, bottom, top
        lens, panorama = self.lens, self.panorama
        return Camera(transform, window, self.projection, self.clip_start, self.clip_end, lens=lens, panorama=panorama)

    def size(self, divider=1):
        """(width, height) in pixels that are `divider` pixels wide."""
        return -(-self.width // divider), -(-self.height // divider)

    def frame(self, divider=1):
        """Width, height and border, as `core.settings.Settings` wants them."""
        width, height = self.size(divider)
        border = self.border
        if border is not None:
            x0, y0, x1, y1 = border
            border = x0 // divider, y0 // divider, -(-x1 // divider), -(-y1 // divider)
        return {"width": width, "height": height, "border": border}


def view_of(context, depsgraph):
    """The `View` of the region that is drawn.

    A panoramic camera's picture fills the camera's frame, which Blender draws as if it saw in perspective.
    """
    region, space, region_data = context.region, context.space_data, context.region_data
    scene = depsgraph.scene_eval
    projection = np.array(region_data.window_matrix, np.float64)
    perspective = bool(region_data.is_perspective)
    through_camera = region_data.view_perspective == "CAMERA"
    camera = _camera_of(space, depsgraph) if through_camera else None
    window = window_of(projection, perspective)
    clip = camera or space
    near, far = (clip.clip_start, clip.clip_end) if perspective else _depths(projection)
    panoramic = camera is not None and camera.projection == "PANORAMIC"
    if panoramic:
        frame = _drawn_frame(space, scene)
        border = _in_region(scene.render, frame, window)
        window = _exchanged(window, frame, camera.window)
    elif through_camera:
        border = _in_region(scene.render, camera.window, window) if camera and scene.render.use_border else None
    else:
        border = _borders(space, "render_border") if space.use_render_border else None
    view = np.linalg.inv(np.array(region_data.view_matrix, np.float64))
    return View(
        transform=tuple(view.ravel().tolist()),
        window=window,
        projection="PANORAMIC" if panoramic else "PERSPECTIVE" if perspective else "ORTHOGRAPHIC",
        clip_start=near,
        clip_end=far,
        width=region.width,
        height=region.height,
        border=None if border is None else _pixels(border, region.width, region.height),
        lens=camera.lens if camera else None,
        panorama=camera.panorama if panoramic else Panorama(),
    )


def window_of(projection, perspective):
    """Edges (left, right, bottom, top) of what a projection matrix (4, 4) maps to the region."""
    if perspective:
        (sx, sy), (x, y) = projection.diagonal()[:2], projection[:2, 2]
    else:
        (sx, sy), (x, y) = projection.diagonal()[:2], -projection[:2, 3]
    return tuple(float(edge) for edge in ((x - 1) / sx, (x + 1) / sx, (y - 1) / sy, (y + 1) / sy))


def _depths(projection):
    """Distances of the clipping planes of an orthographic matrix; the near one may lie behind the viewer."""
    scale, offset = projection[2, 2], projection[2, 3]
    return float((offset + 1) / scale), float((offset - 1) / scale)


def _camera_of(space, depsgraph):
    """The `core.scene.Camera` looked through, None where it is an object of another kind."""
    obj = space.camera if space.use_local_camera else depsgraph.scene_eval.camera
    if obj is None or not isinstance(obj.data, bpy.types.Camera):
        return None
    return export_camera(depsgraph, Diagnostics(), camera=obj)


def _drawn_frame(space, scene):
    """Edges of the frame that Blender draws for the panoramic camera that is looked through."""
    data = (space.camera if space.use_local_camera else scene.camera).data
    return camera_window(data, scene.render, "PERSPECTIVE", frame_size(scene), data.shift_x)


def _exchanged(window, frame, other):
    """What a region spans where its part `frame` spans `other`; all are (left, right, bottom, top)."""
    window, frame, other = (np.reshape(edges, (2, 2)) for edges in (window, frame, other))
    share = (window - frame[:, :1]) / np.diff(frame)
    return tuple((other[:, :1] + share * np.diff(other)).ravel().tolist())


def _borders(owner, name):
    """(x0, y0, x1, y1) of a border in Blender, parts of what it belongs to."""
    return np.array([getattr(owner, f"{name}_{end}_{axis}") for end in ("min", "max") for axis in "xy"])


def _in_region(render, frame, window):
    """The camera's border, or else its frame, as parts of the region.

    `frame` and `window` are what the camera and the region see.
    """
    left, right, bottom, top = frame
    border = _borders(render, "border") if render.use_border else np.array((0, 0, 1, 1))
    edges = (left, bottom, left, bottom) + border * np.tile((right - left, top - bottom), 2)
    left, right, bottom, top = window
    return (edges - (left, bottom, left, bottom)) / np.tile((right - left, top - bottom), 2)


def _pixels(border, width, height):
    """The pixels (x0, y0, x1, y1) of a border given in parts of the region."""
    edges = np.rint(np.clip(border, 0, 1) * (width, height, width, height))
    return tuple(int(edge) for edge in edges)
