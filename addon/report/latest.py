# SPDX-License-Identifier: GPL-3.0-or-later
"""A page of one render of Blender's: its picture, how large its error is and where, and how it fell."""

from __future__ import annotations

import contextlib
import datetime
import math
import struct
import tempfile
import zlib
from dataclasses import fields
from pathlib import Path

import numpy as np

from ...core.diagnostics import SceneError
from ...core.report.table import number
from .. import machine
from ..progress import ends_text, error_text, percent, reaches
from ..properties import METHODS
from . import page
from .chart import error_chart
from .svg import svg

_NAMES = {identifier.lower(): label for identifier, label, _ in METHODS}
_LEFT_OUT = {"guides", "border", "width", "height"}
_BRIGHTEST = 0.99  # of the pixels are less than white in the picture of where the error is


def write_report(path, scene, record):
    """Write the page.

    Parameters
    ----------
    path : Path
    scene : bpy.types.Scene
        The record's.
    record : monitor.Record

    Raises
    ------
    SceneError
        If it cannot be written.
    """
    machine.make_folder(path.parent)
    title = f"{record.shot.scene}, frame {record.shot.frame}: error over time"
    chart = error_chart(record, None, 720, 420)
    parts = [page.paragraph(_summary(record)), svg(chart) if chart else page.paragraph("No error is known.")]
    parts += [page.heading("Pictures"), _pictures(scene, record)]
    if found := reaches(record):
        rows = [(f"{error:.0%}", number(seconds) + "*" * foretold) for error, seconds, foretold in found]
        parts += [page.heading("Seconds to an error"), page.table(["error", "seconds"], rows)]
        parts.append(page.paragraph("An asterisk marks what is foretold by the slope of the curve.", "note"))
    parts += [page.heading("After each pass"), page.table(["samples", "seconds", "error %"], _steps(record))]
    parts.append(page.paragraph(_METHOD, "note"))
    parts += [page.heading("Settings"), page.terms(_settings(record))]
    parts += [page.heading("Machine"), page.terms(_machine(record))]
    parts += [page.heading("Diagnostics"), page.items(record.messages) or page.paragraph("None.")]
    try:
        path.write_text(page.page(title, *parts), encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{path} cannot be written: {error.strerror or error}") from error


_METHOD = (
    "The error is the relative RMSE of the picture, |I - R|² / (|R|² + (0.1 mean)²) by pixel without the thousandth "
    "that err most, estimated from what doublings of the samples changed, without a reference R. It says nothing of "
    "what the method leaves out."
)


def _summary(record):
    stats = record.stats
    return (
        f"{_NAMES[record.settings.method]}: {record.samples} samples in {number(stats['seconds'])} s, "
        f"{record.rays / 1e6:.2f} M rays/s, estimated error {error_text(record)}. {ends_text(record.settings)}."
    )


def _steps(record):
    return [
        (f"{step.samples:.0f}", f"{step.seconds:.3f}", 100 * step.error if math.isfinite(step.error) else None)
        for step in record.history
    ]


def _settings(record):
    settings = record.settings
    named = [("Picture", f"{settings.width} × {settings.height} pixels"), ("View layer", record.place)]
    for field in fields(settings):
        value = getattr(settings, field.name)
        if field.name not in _LEFT_OUT and value is not None:
            shown = f"{value:g}" if isinstance(value, float) else str(value)
            named.append((field.name.replace("_", " ").capitalize(), shown))
    return named


def _machine(record):
    import bpy

    found = machine.machine()
    return [
        ("Processor", f"{found['processor']}, {found['processors']} processors, {record.stats['threads']} threads"),
        ("System", found["system"]),
        ("Load", ", ".join(f"{x:.1f}" for x in found["load"]) or "unknown"),
        ("Versions", ", ".join(f"{name} {version}" for name, version in machine.versions(bpy).items())),
        ("Date", datetime.datetime.now().astimezone().isoformat(timespec="minutes")),
    ]


# -- pictures ----------------------------------------------------------------------------------------------------------


def _pictures(scene, record):
    shown = []
    picture = rendered_jpeg(scene)
    if picture is not None:
        shown.append(("image/jpeg", picture, f"{record.samples} samples, error {error_text(record)}"))
    if record.where is not None:
        most = max(float(np.quantile(record.where, _BRIGHTEST)), 1e-3)
        caption = f"Where it errs: black 0, white {percent(most)} of the brightness and more"
        shown.append(("image/png", png(heat(record.where[::-1], most)), caption))
    return page.figures(shown) if shown else page.paragraph("There is none.")


def rendered_jpeg(scene):
    """The render result as Blender shows it, the bytes of a JPEG; None where there is none to be had."""
    import bpy

    result = bpy.data.images.get("Render Result")
    if result is None:
        return None
    with tempfile.TemporaryDirectory() as folder, _written_as_jpeg(scene.render.image_settings):
        path = Path(folder) / "picture.jpg"
        try:
            result.save_render(str(path), scene=scene)
        except RuntimeError:  # of another scene, or of none
            return None
        return path.read_bytes() if path.is_file() else None


@contextlib.contextmanager
def _written_as_jpeg(kind):
    """Let pictures be written so meanwhile, whatever the scene's own format is."""
    chosen = {"media_type": "IMAGE", "file_format": "JPEG", "color_mode": "RGB", "quality": 90}
    names = [
        name for name in ("media_type", "file_format", "color_mode", "color_depth", "quality") if hasattr(kind, name)
    ]
    before = {name: getattr(kind, name) for name in names}
    try:
        for name in names:
            if name in chosen:
                setattr(kind, name, chosen[name])
        yield
    finally:
        for name, value in before.items():
            setattr(kind, name, value)


def heat(relative, most):
    """Relative errors (H, W) in black, red, yellow and, from `most` on, white: (H, W, 3) uint8."""
    ramp = relative[..., None] / most * 3 - np.arange(3, dtype=np.float32)
    return np.round(255 * np.clip(ramp, 0, 1)).astype(np.uint8)


def png(picture):
    """A picture (H, W, 3) uint8 as the bytes of a PNG file; Blender 4.2 has no library for it.

    Source: the PNG specification, https://www.w3.org/TR/png-3/.
    """
    height, width = picture.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with the number of its filter
    rows[:, 1:] = picture.reshape(height, -1)

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 6)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
