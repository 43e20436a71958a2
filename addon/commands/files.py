# SPDX-License-Identifier: GPL-3.0-or-later
"""Files named on the command line are found good before anything is computed."""

from __future__ import annotations

import gzip
import os

from ...core.diagnostics import SceneError
from .. import headless


def check_blend(path):
    """Refuse what is no .blend file; raises `SceneError`."""
    if not path.is_file():
        raise SceneError(f"no such file: {path}")
    try:
        with path.open("rb") as file:
            head = file.read(7)
        if head.startswith(b"\x1f\x8b"):
            with gzip.open(path) as file:
                head = file.read(7)
    except (OSError, EOFError) as error:
        raise SceneError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    zstandard = b"\x28\xb5\x2f\xfd"
    if head != b"BLENDER" and not head.startswith(zstandard):
        raise SceneError(f"{path} is not a .blend file")


def check_output(path):
    """Refuse a picture of no known format or that cannot be written; raises `SceneError`."""
    if path.suffix.lower() not in headless.FORMATS:
        raise SceneError(f"{path} cannot be written: the name of a picture ends in {' or '.join(headless.FORMATS)}")
    check_writable(path)


def check_writable(path):
    """Refuse a file that cannot be written; raises `SceneError`."""
    if not path.parent.is_dir():
        raise SceneError(f"{path} cannot be written: there is no folder {path.parent}")
    target = path if path.exists() else path.parent
    if path.is_dir() or not os.access(target, os.W_OK):
        raise SceneError(f"{path} cannot be written: {target} is {'a folder' if path.is_dir() else 'read-only'}")
    new = not path.exists()
    try:
        path.open("ab").close()  # Root may write everywhere, says os.access; some file systems say otherwise.
        if new:
            path.unlink()
    except OSError as error:
        raise SceneError(f"{path} cannot be written: {error.strerror or error}") from error


def check_distinct(paths):
    """Refuse to write two results into one file; raises `SceneError`."""
    seen = set()
    for path in paths:
        if path.absolute() in seen:
            raise SceneError(f"{path} cannot be written twice; give each result a name of its own")
        seen.add(path.absolute())
